// What an edit of the label changes, and that a stage does not change the other's fields. Expected values by hand.
import assert from "node:assert/strict";
import { test } from "vitest";
import type { SceneView, Task } from "../api/types.ts";
import { inClass, iso, opened, SAFE } from "../testing/opened_task.ts";
import { addComponent, decide, dropLostCauses, evidenceNow, removeComponent, setKeyframe, setRange, stateUncertainty, toggleCause, toggleIn, toggleUncertainty } from "./edits.ts";
import type { Json } from "./pointer.ts";
import { clockOf } from "./times.ts";

test("a decision taken back takes its causes and its direction along, and undo brings all of it back", () => {
  const before = {
    driving_decision: { longitudinal: "resume", lateral: "turn", lateral_direction: "left" },
    causes: { lateral: { components: ["c1"] } },
  };
  const editor = opened("stage2", before);
  decide(editor, "lateral", null);
  assert.deepEqual(editor.draft.doc, { driving_decision: { longitudinal: "resume", lateral: null }, causes: {}, ...SAFE });
  editor.draft.undo();
  assert.deepEqual(editor.draft.doc, { ...before, ...SAFE });
  decide(editor, "lateral", "lane_keeping");
  assert.equal(editor.draft.at("/driving_decision/lateral_direction"), undefined, "keeping the lane has no direction");
  assert.deepEqual(editor.draft.at("/causes/lateral"), { components: ["c1"] }, "another decision keeps its causes");
});

test("the only direction that the class allows is set by itself", () => {
  const editor = opened("stage2", { driving_decision: { lateral: null } });
  inClass(editor, [{ id: "turn", direction: "left", usual: true }]);
  decide(editor, "lateral", "turn");
  assert.equal(editor.draft.at("/driving_decision/lateral_direction"), "left");
  // Where there is a choice, nobody makes it but the annotator; what they chose stays.
  const open = opened("stage2", { driving_decision: { lateral: null } });
  inClass(open, [{ id: "turn", direction: "left", usual: true }, { id: "turn", direction: "right", usual: true }]);
  decide(open, "lateral", "turn");
  assert.equal(open.draft.at("/driving_decision/lateral_direction"), undefined);
  open.draft.set("/driving_decision/lateral_direction", "uturn");
  decide(open, "lateral", "turn");
  assert.equal(open.draft.at("/driving_decision/lateral_direction"), "uturn");
});

test("a removed component is no cause any more", () => {
  const editor = opened("rework", {
    critical_components: [{ id: "c1" }, { id: "c2" }],
    causes: { longitudinal: { components: ["c1", "c2"] } },
  });
  removeComponent(editor, 0);
  assert.deepEqual(editor.draft.at("/critical_components"), [{ id: "c2" }]);
  assert.deepEqual(editor.draft.at("/causes/longitudinal/components"), ["c2"]);
  assert.equal(addComponent(editor, null), 1);
  assert.equal(editor.draft.at("/critical_components/1/id"), "c3", "an id is never used twice: c2 is taken, c1 is history");
});

test("times and frames go together; what lies outside the clip is no keyframe", () => {
  const editor = opened("stage2", { keyframe: { timestamp: iso(4), frame_idx: 2, type: "reactive" }, time_range: {} });
  setRange(editor, "end", 8);
  assert.deepEqual(editor.draft.at("/time_range"), { end_timestamp: iso(8), end_frame_idx: 6 });
  setKeyframe(editor, "keyframe", 1);
  assert.equal(editor.draft.at("/keyframe/frame_idx"), 2, "frame 1 is before the clip");
  setKeyframe(editor, "keyframe", 3);
  assert.deepEqual(editor.draft.at("/keyframe"), { timestamp: iso(3), frame_idx: 1, type: "reactive" });
});

test("a range that would begin after the keyframe begins at it, and one undo brings all of it back", () => {
  const before = {
    keyframe: { timestamp: iso(4), frame_idx: 2, type: "proactive", range_start: iso(4), range_end: iso(6) },
    time_range: { start_timestamp: iso(4), start_frame_idx: 2, end_timestamp: iso(8), end_frame_idx: 6 },
  };
  const editor = opened("stage2", before);
  setKeyframe(editor, "keyframe", 5);
  assert.equal(editor.draft.at("/keyframe/range_start"), iso(4), "a later keyframe leaves the ranges");
  assert.equal(editor.draft.at("/time_range/start_timestamp"), iso(4));
  editor.draft.undo();
  setKeyframe(editor, "keyframe", 3);
  assert.deepEqual(editor.draft.at("/keyframe"), { timestamp: iso(3), frame_idx: 1, type: "proactive", range_start: iso(3), range_end: iso(6) });
  assert.deepEqual(editor.draft.at("/time_range"), { start_timestamp: iso(3), start_frame_idx: 1, end_timestamp: iso(8), end_frame_idx: 6 });
  editor.draft.undo();
  assert.deepEqual(editor.draft.doc, { ...before, ...SAFE });
});

test("evidence at the keyframe goes with it, what was chosen stays", () => {
  const editor = opened("stage1", {
    critical_components: [{ id: "c1", evidence_times: [iso(2), iso(4)] }, { id: "c2", evidence_times: [iso(4)] }, { id: "c3" }],
    keyframe: { timestamp: iso(4), frame_idx: 2, type: "reactive" },
  });
  const before = editor.draft.doc;
  const evidence = (): unknown[] => editor.components.map((c) => c["evidence_times"]);
  setKeyframe(editor, "keyframe", 3);
  assert.deepEqual(evidence(), [[iso(2), iso(3)], [iso(3)], undefined]);
  editor.draft.undo();
  assert.deepEqual(editor.draft.doc, before, "one undo takes back both");
  const locked = opened("stage2", before);
  setKeyframe(locked, "keyframe", 3);
  assert.deepEqual(locked.draft.at("/critical_components"), (before as { critical_components: Json }).critical_components);
});

test("a restored draft is one step to undo, before the steps that made what it replaced", () => {
  const editor = opened("rework", { coc_trace: "old", records: { gap: 3 } });
  editor.draft.set("/coc_trace", "new");
  const before = editor.draft.doc;
  editor.draft.load({ ...editor.task, draft: { coc_trace: "old", ...SAFE } } as unknown as Task);
  editor.draft.discard();
  editor.draft.doc = { coc_trace: "old", ...SAFE };
  editor.draft.replaced(before);
  editor.draft.undo();
  assert.deepEqual(editor.draft.doc, { coc_trace: "new", records: { gap: 3 }, ...SAFE });
  editor.draft.undo();
  assert.equal(editor.draft.at("/coc_trace"), "old");
});

test("Stage I fills its fields only, Stage II leaves the components alone", () => {
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

test("nothing after the keyframe is evidence", () => {
  const editor = opened("rework", { critical_components: [{ id: "c1" }], keyframe: { timestamp: iso(4), frame_idx: 2, type: "reactive" } });
  editor.player.seek(2);
  evidenceNow(editor);
  assert.equal(editor.draft.at("/critical_components/0/evidence_times"), undefined);
  editor.player.seek(-1);
  evidenceNow(editor);
  assert.deepEqual(editor.draft.at("/critical_components/0/evidence_times"), [iso(3)]);
});

test("uncertainty goes between low and high, in Stage I and in rework only", () => {
  const components = [{ id: "c1", description: "lorry" }];
  const editor = opened("stage1", { critical_components: components });
  toggleUncertainty(editor, 0);
  assert.equal(editor.draft.at("/critical_components/0/uncertainty"), "high");
  toggleUncertainty(editor, 0);
  assert.equal(editor.draft.at("/critical_components/0/uncertainty"), "low");
  toggleUncertainty(editor, 3);
  assert.equal(editor.components.length, 1, "no component is made by it");
  const locked = opened("stage2", { critical_components: components });
  toggleUncertainty(locked, 0);
  assert.equal(locked.draft.at("/critical_components/0/uncertainty"), undefined);
});

test("a single component is linked to a decision by itself, and never in place of what was chosen", () => {
  const one = [{ id: "c1", description: "lead" }];
  const editor = opened("stage2", { critical_components: one, driving_decision: {} });
  decide(editor, "longitudinal", "resume");
  assert.deepEqual(editor.draft.at("/causes/longitudinal"), { components: ["c1"] });
  assert.deepEqual(editor.draft.undo() !== null && editor.draft.at("/causes"), undefined, "one undo takes back both");
  const chosen = opened("stage2", { critical_components: one, driving_decision: {}, causes: { longitudinal: { unobserved: "fog" } } });
  decide(chosen, "longitudinal", "resume");
  assert.deepEqual(chosen.draft.at("/causes/longitudinal"), { unobserved: "fog" });
  const two = opened("stage2", { critical_components: [...one, { id: "c2", description: "light" }], driving_decision: {} });
  decide(two, "longitudinal", "resume");
  assert.equal(two.draft.at("/causes/longitudinal"), undefined);
  toggleCause(two, "longitudinal", "c2");
  toggleCause(two, "longitudinal", "c1");
  toggleCause(two, "longitudinal", "c2");
  assert.deepEqual(two.draft.at("/causes/longitudinal"), { components: ["c1"] });
});

test("decisions, causes and trace wait for the safety filter", () => {
  const editor = opened("stage2", { driving_decision: { longitudinal: null, lateral: null } });
  assert.ok(editor.isEditable("/driving_decision/longitudinal") && editor.isEditable("/coc_trace"));
  editor.draft.doc = { driving_decision: { longitudinal: null, lateral: null } };
  for (const path of ["/driving_decision/longitudinal", "/causes/lateral", "/coc_trace"]) assert.equal(editor.isEditable(path), false, path);
  assert.ok(editor.isEditable("/records/gap"), "other fields do not wait");
  decide(editor, "longitudinal", "resume");
  assert.equal(editor.decision("longitudinal"), null);
});

test("the keyframe's own frame is evidence where the log's times are uneven", () => {
  const uneven = "2026-01-15T10:30:02.999900Z";
  const editor = opened("rework", { critical_components: [{ id: "c1" }], keyframe: { timestamp: uneven, frame_idx: 1, type: "reactive" } });
  const scene = { ...editor.clip.scene, times: [...Array(10).keys()].map((n) => (n === 3 ? uneven : iso(n))) };
  editor.clip.scene = scene as unknown as SceneView;
  editor.clip.clock = clockOf(editor.clip.scene);
  editor.player.seek(-1);
  evidenceNow(editor);
  assert.deepEqual(editor.draft.at("/critical_components/0/evidence_times"), [uneven]);
});

test("causes name only components that exist", () => {
  const before = {
    critical_components: [{ id: "c2", description: "bus" }],
    driving_decision: { longitudinal: "resume", lateral: "turn" },
    causes: { longitudinal: { components: ["c1"] }, lateral: { components: ["c1", "c2"] } },
  };
  const editor = opened("stage2", before);
  dropLostCauses(editor);
  // The only component is linked where none is left.
  assert.deepEqual(editor.draft.at("/causes"), { longitudinal: { components: ["c2"] }, lateral: { components: ["c2"] } });

  const two = { ...before, critical_components: [{ id: "c2" }, { id: "c3" }] };
  const other = opened("stage2", two);
  toggleCause(other, "longitudinal", "c3");
  assert.deepEqual(other.draft.at("/causes/longitudinal"), { components: ["c3"] });
  dropLostCauses(other);
  assert.deepEqual(other.draft.at("/causes"), { longitudinal: { components: ["c3"] }, lateral: { components: ["c2"] } });

  const chosen = opened("stage2", before);
  decide(chosen, "longitudinal", "resume");
  assert.deepEqual(chosen.draft.at("/causes/longitudinal"), { components: ["c2"] });
});

test("a component whose uncertainty nobody stated has a low one when Stage I is locked", () => {
  const editor = opened("stage1", { critical_components: [{ id: "c1", description: "car" }, { id: "c2", description: "bus", uncertainty: "high" }] });
  stateUncertainty(editor);
  assert.deepEqual(editor.components.map((c) => c["uncertainty"]), ["low", "high"]);
});
