// What a deed on the label changes, and that a stage keeps its hands off the other's fields. Expected values by hand.
import { storage } from "../testing.ts";
import assert from "node:assert/strict";
import { test } from "node:test";
import type { SceneView, Task, User } from "../api/types.ts";
import { addComponent, decide, evidenceNow, removeComponent, setKeyframe, setRange, toggleIn, toggleUncertainty } from "./edits.ts";
import { readFramework } from "./framework.ts";
import type { Json } from "./pointer.ts";
import { clockOf } from "./times.ts";
import { Work } from "./work.svelte.ts";

/** Opens tasks in `check`, and closes them after it: an open draft tries to save for ever. */
function deed(name: string, check: () => void): void {
  test(name, () => {
    try {
      check();
    } finally {
      for (const work of all.splice(0)) work.draft.close();
    }
  });
}
const all: Work[] = [];

const iso = (n: number): string => `2026-01-15T10:30:0${n}.000Z`;
const pair = (text: string): { zh: string; en: string } => ({ zh: text, en: text });

/** A task of ten frames a second apart, the keyframe at frame 4; two frames before the clip. */
function opened(state: "stage1" | "stage2" | "rework", draft: Json): Work {
  storage.clear();
  const work = new Work("t", { id: "anna" } as User);
  all.push(work);
  const stage = state === "stage1" ? "stage1" : "stage2";
  const task = { task: { id: "t", state }, stage, draft, version: 1, fence: 1, findings: [], comments: [], permissions: ["edit"] };
  work.task = task as unknown as Task;
  const frames = [...Array(10).keys()];
  const scene = { times: frames.map(iso), t_s: frames.map((n) => n - 4), clip_frames: frames.map((n) => n - 2), keyframe_index: 4 };
  work.scene = scene as unknown as SceneView;
  work.clock = clockOf(work.scene);
  work.player.load(scene.t_s);
  work.framework = readFramework({
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
    records: {},
    versions: {},
  });
  work.draft.load(work.task);
  return work;
}

deed("a decision taken back takes its causes and its direction along, and undo brings all of it back", () => {
  const before = {
    driving_decision: { longitudinal: "resume", lateral: "turn", lateral_direction: "left" },
    causes: { lateral: { components: ["c1"] } },
  };
  const work = opened("stage2", before);
  decide(work, "lateral", null);
  assert.deepEqual(work.draft.doc, { driving_decision: { longitudinal: "resume", lateral: null }, causes: {} });
  work.draft.undo();
  assert.deepEqual(work.draft.doc, before);
  decide(work, "lateral", "lane_keeping");
  assert.equal(work.draft.at("/driving_decision/lateral_direction"), undefined, "keeping the lane has no direction");
  assert.deepEqual(work.draft.at("/causes/lateral"), { components: ["c1"] }, "another decision keeps its causes");
});

deed("a removed component is no cause any more", () => {
  const work = opened("rework", {
    critical_components: [{ id: "c1" }, { id: "c2" }],
    causes: { longitudinal: { components: ["c1", "c2"] } },
  });
  removeComponent(work, 0);
  assert.deepEqual(work.draft.at("/critical_components"), [{ id: "c2" }]);
  assert.deepEqual(work.draft.at("/causes/longitudinal/components"), ["c2"]);
  assert.equal(addComponent(work, null), 1);
  assert.equal(work.draft.at("/critical_components/1/id"), "c3", "an id is never used twice: c2 is taken, c1 is history");
});

deed("times and frames go together; what lies outside the clip is no keyframe", () => {
  const work = opened("stage2", { keyframe: { timestamp: iso(4), frame_idx: 2, type: "reactive" }, time_range: {} });
  setRange(work, "end", 8);
  assert.deepEqual(work.draft.at("/time_range"), { end_timestamp: iso(8), end_frame_idx: 6 });
  setKeyframe(work, "keyframe", 1);
  assert.equal(work.draft.at("/keyframe/frame_idx"), 2, "frame 1 is before the clip");
  setKeyframe(work, "keyframe", 3);
  assert.deepEqual(work.draft.at("/keyframe"), { timestamp: iso(3), frame_idx: 1, type: "reactive" });
});

deed("Stage I fills its fields only, Stage II leaves the components alone", () => {
  const first = opened("stage1", { critical_components: [], keyframe: { timestamp: iso(4), frame_idx: 2, type: "reactive" } });
  setRange(first, "end", 8);
  decide(first, "longitudinal", "resume");
  assert.equal(addComponent(first, "t7"), 0);
  assert.deepEqual(first.draft.at("/critical_components"), [
    { id: "c1", description: "", uncertainty: "low", category: "critical_objects", linked_objects: ["t7"], evidence_times: [iso(4)] },
  ]);
  assert.deepEqual(Object.keys(first.draft.doc as object), ["critical_components", "keyframe"]);

  const second = opened("stage2", { critical_components: [{ id: "c1" }] });
  assert.equal(addComponent(second, null), null);
  removeComponent(second, 0);
  toggleIn(second, 0, "linked_objects", "t7");
  assert.deepEqual(second.draft.at("/critical_components"), [{ id: "c1" }]);
});

deed("nothing after the keyframe is evidence", () => {
  const work = opened("rework", { critical_components: [{ id: "c1" }], keyframe: { timestamp: iso(4), frame_idx: 2, type: "reactive" } });
  work.player.seek(2);
  evidenceNow(work);
  assert.equal(work.draft.at("/critical_components/0/evidence_times"), undefined);
  work.player.seek(-1);
  evidenceNow(work);
  assert.deepEqual(work.draft.at("/critical_components/0/evidence_times"), [iso(3)]);
});

deed("uncertainty goes between low and high, in Stage I and in rework only", () => {
  const components = [{ id: "c1", description: "lorry" }];
  const work = opened("stage1", { critical_components: components });
  toggleUncertainty(work, 0);
  assert.equal(work.draft.at("/critical_components/0/uncertainty"), "high");
  toggleUncertainty(work, 0);
  assert.equal(work.draft.at("/critical_components/0/uncertainty"), "low");
  toggleUncertainty(work, 3);
  assert.equal(work.components.length, 1, "no component is made by it");
  const locked = opened("stage2", { critical_components: components });
  toggleUncertainty(locked, 0);
  assert.equal(locked.draft.at("/critical_components/0/uncertainty"), undefined);
});
