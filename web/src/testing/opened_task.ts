// A task in an editor, without a service. Import it in a test file only: it closes the editors after each test.
import { afterEach } from "vitest";
import type { ClassChoices, SceneView, Task, User } from "../api/types.ts";
import { readFramework } from "../label/framework.ts";
import type { Json } from "../label/pointer.ts";
import { TaskEditor } from "../label/task_editor.svelte.ts";
import { clockOf } from "../label/times.ts";

const all: TaskEditor[] = [];
// An open draft tries to save for ever.
afterEach(() => all.splice(0).forEach((editor) => editor.draft.close()));

export const iso = (n: number): string => `2026-01-15T10:30:0${n}.000Z`;
const LEAF = "a.b.c";
const pair = (text: string): { zh: string; en: string } => ({ zh: text, en: text });

/** Decisions wait for this. */
export const SAFE = { safety_filter: { answer: "safe" } };

/** A task of ten frames a second apart, the keyframe at frame 4; two frames before the clip. */
export function opened(state: "stage1" | "stage2" | "rework", draft: Json): TaskEditor {
  localStorage.clear();
  const editor = new TaskEditor("t", { id: "anna" } as User);
  all.push(editor);
  const stage = state === "stage1" ? "stage1" : "stage2";
  const answered = stage === "stage1" ? draft : { ...(draft as object), ...SAFE };
  const task = { task: { id: "t", state, scenario_id: LEAF }, stage, draft: answered, version: 1, fence: 1, findings: [], comments: [], permissions: ["edit"] };
  editor.task = task as unknown as Task;
  const frames = [...Array(10).keys()];
  const scene = { times: frames.map(iso), t_s: frames.map((n) => n - 4), clip_frames: frames.map((n) => n - 2), keyframe_index: 4 };
  editor.clip.scene = scene as unknown as SceneView;
  editor.clip.clock = clockOf(editor.clip.scene);
  editor.player.load(scene.t_s);
  editor.framework = readFramework({
    taxonomy: [],
    decisions: {
      longitudinal: [{ id: "resume", name: pair("resume") }],
      lateral: [
        { id: "turn", name: pair("turn"), directions: ["left", "right", "uturn"] },
        { id: "lane_keeping", name: pair("keep") },
      ],
      null: { name: pair("none") },
    },
    categories: [{ id: "critical_objects", name: pair("objects") }],
    choices: {},
    impossible_pairs: [],
    safety_reasons: [],
    records: {},
    versions: {},
  });
  editor.draft.load(editor.task);
  return editor;
}

/** Gives the class of the task these lateral decisions, and no change along the path. */
export function inClass(editor: TaskEditor, lateral: ClassChoices["lateral"]): void {
  if (!editor.framework) return;
  const choices: ClassChoices = { longitudinal: [{ id: null, usual: true }], lateral, decides: false, reveals: false };
  const leaf = { id: LEAF, name: pair("leaf"), path: [], definition: null, condition: null, choices, decides: [] };
  editor.framework = { ...editor.framework, leaves: new Map([[LEAF, leaf]]) };
}
