// What each keyboard action does on the labeling screen.
import type { Handlers } from "../../keys/keys.svelte.ts";
import { pointers } from "../../label/field_pointers.ts";
import { addComponent, evidenceNow, removeComponent, setKeyRange, setKeyframe, setRange, toggleIn, toggleUncertainty } from "../../label/edits.ts";
import type { TaskEditor } from "../../label/task_editor.svelte.ts";
import { nextCamera } from "../../scene/cameras.ts";
import { trackPose } from "../../scene/motion.ts";
import { objectsAt } from "../../scene/objects.ts";
import { tick } from "svelte";
import { restAt, toComment, toComponent, toDirection, toField, toSection } from "./focus.ts";
import { saveViewSettings, viewSettings } from "./view_settings.svelte.ts";
import { undo, redo } from "./undo_actions.ts";

/** Actions that the screen itself implements. */
interface ScreenActions {
  advance: () => void;
  reject: () => void;
  sendBack: () => void;
  accept: () => void;
  answerSafe: () => void;
  skip: () => void;
  wrongClass: () => void;
}

/** Shows the selected object, or the rule's target, together with the ego. */
export function zoomToTarget(editor: TaskEditor): void {
  const id = editor.selected ?? editor.target;
  const track = editor.clip.scene?.tracks.find((candidate) => candidate.id === id);
  const pose = track && trackPose(track, editor.player.index, editor.player.share);
  if (pose) editor.camera.showTarget(pose, 20);
}

export function handlers(editor: TaskEditor, actions: ScreenActions): Handlers {
  const player = editor.player;

  function pickNext(by: 1 | -1): void {
    if (!editor.clip.scene) return;
    const ids = objectsAt(editor.clip.scene, player.index, editor.target).map((o) => o.id);
    if (ids.length === 0) return;
    const at = editor.selected === null ? -1 : ids.indexOf(editor.selected);
    const next = at < 0 ? (by > 0 ? 0 : ids.length - 1) : (at + by + ids.length) % ids.length;
    editor.selected = ids[next] ?? null;
  }

  async function add(): Promise<void> {
    const n = addComponent(editor, editor.selected);
    if (n === null) return;
    await tick();
    document.querySelector<HTMLElement>(`[data-component="${n}"] textarea`)?.focus();
  }

  async function remove(): Promise<void> {
    if (!editor.components[editor.currentComponent]) return;
    removeComponent(editor, editor.currentComponent);
    await tick();
    // Not into a text: who goes on with a key of the page would write there.
    if (editor.components.length > 0) restAt(pointers.component(editor.currentComponent));
    else toSection("components");
  }

  /** Goes to a section of the form; where the label is only read, to a comment on its fields. */
  function to(section: string, fields: readonly string[], enter: () => void): void {
    if (document.querySelector(`[data-section="${section}"]`)) enter();
    else if (editor.can("comment")) toComment(fields);
  }

  function scroll(by: number): void {
    const board = document.querySelector<HTMLElement>(".board .rows");
    board?.scrollBy({ top: by * Math.max(48, board.clientHeight * 0.6) });
  }

  async function ask(): Promise<void> {
    editor.asking = true;
    await tick();
    document.querySelector<HTMLElement>('[data-section="comments"] form textarea')?.focus();
  }

  function flip(layer: "names" | "occlusion" | "velocities" | "spec" | "spec2"): void {
    viewSettings[layer] = !viewSettings[layer];
    saveViewSettings();
  }

  function look(by: 1 | -1): void {
    viewSettings.camera = nextCamera(editor.clip.scene?.cameras ?? [], viewSettings.camera, by);
    saveViewSettings();
  }

  /**
   * Accepts the focused field, then goes to the next unaccepted one, then to the first error. Before the safety filter
   * is answered there is nothing else to do.
   */
  async function acceptField(): Promise<void> {
    if (editor.can("safety") && !editor.safe) return toSection("safety");
    const field = document.activeElement?.closest<HTMLElement>("[data-field]")?.dataset["field"];
    const before = editor.unaccepted;
    const at = before.indexOf(field ?? "");
    if (field !== undefined && !editor.isUnchosen(field)) editor.accept(field);
    await tick();
    const next = editor.unaccepted.find((p) => before.indexOf(p) > at) ?? editor.unaccepted[0];
    if (next !== undefined) toField(next);
    else if (editor.canEdit && editor.stage === "stage2") {
      const wrong = editor.draft.findings.find((f) => f.severity === "error");
      if (wrong) toField(wrong.pointer);
      else toSection("findings");
    }
  }

  return {
    leave: () => (document.activeElement instanceof HTMLElement ? document.activeElement.blur() : undefined),
    save: () => void editor.draft.flush(),
    undo: () => void undo(editor),
    redo: () => void redo(editor),
    acceptField: () => void acceptField(),
    advance: actions.advance,
    play: () => player.toggle(),
    back: () => player.step(-1),
    forward: () => player.step(1),
    back1: () => player.step(-Math.round(editor.clip.scene?.frame_rate ?? 10)),
    forward1: () => player.step(Math.round(editor.clip.scene?.frame_rate ?? 10)),
    first: () => player.seek(player.first),
    last: () => player.seek(player.end),
    toKeyframe: () => editor.seekKeyframe(),
    slower: () => player.faster(-1),
    faster: () => player.faster(1),
    loop: () => (player.loop = !player.loop),
    follow: () => editor.camera.toggleFollowing(),
    zoomIn: () => editor.camera.zoom(1.3),
    zoomOut: () => editor.camera.zoom(1 / 1.3),
    zoomToTarget: () => zoomToTarget(editor),
    velocities: () => flip("velocities"),
    ruler: () => (editor.ruler.active ? editor.ruler.stop() : editor.ruler.start()),
    nextObject: () => pickNext(1),
    previousObject: () => pickNext(-1),
    targetObject: () => (editor.selected = editor.target),
    findObject: () => document.querySelector<HTMLElement>("[data-find-object]")?.focus(),
    scrollDown: () => scroll(1),
    scrollUp: () => scroll(-1),
    names: () => flip("names"),
    occlusion: () => flip("occlusion"),
    nextCamera: () => look(1),
    previousCamera: () => look(-1),
    addComponent: () => void add(),
    linkObject: () => editor.selected !== null && toggleIn(editor, editor.currentComponent, "linked_objects", editor.selected),
    removeComponent: () => void remove(),
    evidence: () => evidenceNow(editor),
    uncertain: () => toggleUncertainty(editor, editor.currentComponent),
    keyframe: () => setKeyframe(editor, "keyframe"),
    keyframe2: () => setKeyframe(editor, "second_keyframe"),
    keyStart: () => setKeyRange(editor, "range_start"),
    keyEnd: () => setKeyRange(editor, "range_end"),
    rangeStart: () => setRange(editor, "start"),
    rangeEnd: () => setRange(editor, "end"),
    safe: () => editor.can("safety") && !editor.safe && actions.answerSafe(),
    reject: actions.reject,
    accept: actions.accept,
    askLead: () => editor.can("comment") && void ask(),
    sendBack: actions.sendBack,
    skip: actions.skip,
    wrongClass: actions.wrongClass,
    toComponents: () => to("components", [pointers.components], () => toComponent(editor.currentComponent)),
    toLongitudinal: () => to("decisions", [pointers.decisionOf("longitudinal")], () => toSection("decisions", "[data-choices=longitudinal]")),
    toLateral: () => to("decisions", [pointers.decisionOf("lateral")], () => toSection("decisions", "[data-choices=lateral]")),
    toDirection: () => to("decisions", [pointers.decisionOf("lateral")], toDirection),
    toCauses: () => to("causes", [pointers.causes], () => toSection("causes")),
    toTrace: () => to("trace", [pointers.trace], () => toSection("trace")),
    toRecords: () => to("records", [pointers.records], () => toSection("records")),
    toFindings: () => toSection("findings"),
    toComments: () => toSection("comments"),
    spec: () => flip(editor.stage === "stage1" ? "spec" : "spec2"),
  };
}
