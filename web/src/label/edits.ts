// Edits of the label, for keyboard and pointer alike. Each checks `isEditable` and goes through the draft, so that it
// is saved and can be undone.
import { type Channel, channels, directionsOf } from "./framework.ts";
import { type KeyframeName, pointers } from "./field_pointers.ts";
import { type Json, read } from "./pointer.ts";
import type { TaskEditor } from "./task_editor.svelte.ts";

/**
 * Sets a keyframe. A range that would begin after it begins at it: otherwise one move needs three. Evidence at the
 * keyframe, which nobody chose, stays at the keyframe.
 */
export function setKeyframe(editor: TaskEditor, name: KeyframeName, frame = editor.frame): void {
  const iso = editor.clip.clock?.iso[frame];
  const idx = editor.clip.clock?.frames[frame];
  if (!iso || idx === undefined || idx < 0 || !editor.isEditable(pointers.keyframeOf(name))) return;
  const before = editor.draft.at(pointers.keyframeOf(name));
  const type = editor.spec?.[name]?.type ?? "reactive";
  const old = typeof before === "object" && before !== null && !Array.isArray(before) ? before : { type };
  const isLater = (path: string): boolean => (editor.second(editor.draft.at(path)) ?? -Infinity) > (editor.second(iso) ?? Infinity);
  const was = editor.draft.at(pointers.keyframeTime(name));
  editor.draft.group(() => {
    if (name === "keyframe" && typeof was === "string") moveEvidence(editor, was, iso);
    const range: Record<string, Json> = name === "keyframe" && isLater(pointers.keyframeRange("range_start")) ? { range_start: iso } : {};
    editor.draft.set(pointers.keyframeOf(name), { ...old, timestamp: iso, frame_idx: idx, ...range });
    if (name === "keyframe" && isLater(pointers.rangeTime("start"))) setRange(editor, "start", frame);
  });
}

/** Uses the suggested keyframe again; evidence at the keyframe goes with it. */
export function adoptKeyframe(editor: TaskEditor, name: KeyframeName, suggested: Json): void {
  const [was, time] = [editor.draft.at(pointers.keyframeTime(name)), read(suggested, "/timestamp")];
  editor.draft.group(() => {
    if (name === "keyframe" && typeof was === "string" && typeof time === "string") moveEvidence(editor, was, time);
    editor.draft.set(pointers.keyframeOf(name), suggested);
  });
}

/** Moves the evidence at the moment `from` to the moment `to`. */
function moveEvidence(editor: TaskEditor, from: string, to: string): void {
  const at = editor.second(from);
  editor.components.forEach((component, n) => {
    const path = pointers.componentPart(n, "evidence_times");
    const times = component["evidence_times"];
    if (!Array.isArray(times) || at === null || !editor.isEditable(path)) return;
    const moved = times.map((time) => (editor.second(time) === at ? to : String(time)));
    if (moved.some((time, i) => time !== times[i])) editor.draft.set(path, [...new Set(moved)].sort());
  });
}

export function setKeyRange(editor: TaskEditor, end: "range_start" | "range_end", frame = editor.frame): void {
  const iso = editor.clip.clock?.iso[frame];
  if (iso && editor.isEditable(pointers.keyframe)) editor.draft.set(pointers.keyframeRange(end), iso);
}

export function setRange(editor: TaskEditor, end: "start" | "end", frame = editor.frame): void {
  const iso = editor.clip.clock?.iso[frame];
  const idx = editor.clip.clock?.frames[frame];
  if (!iso || idx === undefined || !editor.isEditable(pointers.timeRange)) return;
  editor.draft.group(() => {
    editor.draft.set(pointers.rangeTime(end), iso);
    editor.draft.set(pointers.rangeFrame(end), idx < 0 ? undefined : idx);
  });
}

/** Adds a component, of the selected object if any. Returns its number; null where none can be added. */
export function addComponent(editor: TaskEditor, object: string | null): number | null {
  if (!editor.isEditable(pointers.components)) return null;
  const all = editor.components;
  const used = new Set(all.map((c) => c["id"]));
  let n = all.length + 1;
  while (used.has(`c${n}`)) n++;
  const made: Record<string, Json> = { id: `c${n}`, description: "", uncertainty: "low" };
  if (object !== null) Object.assign(made, { category: objectCategory(editor), linked_objects: [object] });
  const iso = editor.clip.clock?.iso[Math.min(editor.frame, editor.clip.scene?.keyframe_index ?? 0)];
  if (iso) made["evidence_times"] = [iso];
  editor.draft.set(pointers.components, [...all, made]);
  editor.currentComponent = all.length;
  return all.length;
}

function objectCategory(editor: TaskEditor): string {
  const known = editor.framework?.categories ?? [];
  return (known.find((c) => c.id.includes("object")) ?? known[0])?.id ?? "critical_objects";
}

/** Removes a component, also from the causes that refer to it. */
export function removeComponent(editor: TaskEditor, n: number): void {
  if (!editor.isEditable(pointers.components)) return;
  const gone = editor.components[n]?.["id"];
  editor.draft.group(() => {
    editor.draft.set(pointers.components, editor.components.filter((_, i) => i !== n));
    for (const channel of ["longitudinal", "lateral"] as const) {
      const path = pointers.causeComponents(channel);
      const named = editor.draft.at(path);
      if (Array.isArray(named) && gone !== undefined && named.includes(gone)) editor.draft.set(path, named.filter((c) => c !== gone));
    }
  });
  editor.currentComponent = Math.max(0, Math.min(editor.currentComponent, editor.components.length - 1));
}

/** Adds a value to a list of a component, or removes it when present. */
export function toggleIn(editor: TaskEditor, n: number, list: "evidence_times" | "linked_objects", value: string): void {
  const path = pointers.componentPart(n, list);
  if (!editor.components[n] || !editor.isEditable(path)) return;
  const now = editor.draft.at(path);
  const items = Array.isArray(now) ? now.map(String) : [];
  const next = items.includes(value) ? items.filter((i) => i !== value) : [...items, value];
  editor.draft.set(path, next.length === 0 ? undefined : list === "evidence_times" ? next.sort() : next);
}

/** Components whose uncertainty nobody stated have a low one, as those that are added: the page shows it so. */
export function stateUncertainty(editor: TaskEditor): void {
  editor.draft.group(() => {
    editor.components.forEach((c, n) => {
      const path = pointers.componentPart(n, "uncertainty");
      if (c["uncertainty"] !== "low" && c["uncertainty"] !== "high" && editor.isEditable(path)) editor.draft.set(path, "low");
    });
  });
}

/** Uncertainty of component `n`: high where it was low or unset, else low. */
export function toggleUncertainty(editor: TaskEditor, n: number): void {
  const path = pointers.componentPart(n, "uncertainty");
  if (editor.components[n] && editor.isEditable(path)) editor.draft.set(path, editor.draft.at(path) === "high" ? "low" : "high");
}

/** Adds the current time as evidence, unless it is after the keyframe. */
export function evidenceNow(editor: TaskEditor): void {
  const keyframe = editor.second(editor.draft.at(pointers.keyframeTime("keyframe"))) ?? 0;
  const iso = editor.clip.clock?.iso[editor.frame];
  // By the frame's own time: the player's is rounded, and may come after that of the keyframe of the same frame.
  const at = editor.second(iso);
  if (iso && at !== null && at <= keyframe) toggleIn(editor, editor.currentComponent, "evidence_times", iso);
}

/** The components that a channel's causes name and that still exist; null where it names none. */
function livingCauses(editor: TaskEditor, channel: Channel): string[] | null {
  const named = editor.draft.at(pointers.causeComponents(channel));
  const known = new Set(editor.components.map((c) => c["id"]));
  return Array.isArray(named) ? named.map(String).filter((id) => known.has(id)) : null;
}

/** Removes from the causes the components that no longer exist: Stage I, which may remove some, does not see causes. */
export function dropLostCauses(editor: TaskEditor): void {
  if (!editor.isEditable(pointers.causes)) return;
  editor.draft.group(() => {
    for (const channel of channels) {
      const named = editor.draft.at(pointers.causeComponents(channel));
      const living = livingCauses(editor, channel);
      if (living === null || living.length === (named as Json[]).length) continue;
      editor.draft.set(pointers.causesOf(channel), { components: living });
      if (typeof editor.decision(channel) === "string") linkOnly(editor, channel);
    }
  });
}

/** The only component is the cause of a decision that has none yet. */
function linkOnly(editor: TaskEditor, channel: Channel): void {
  const id = editor.components[0]?.["id"];
  const now = editor.draft.at(pointers.causesOf(channel));
  const open = now === undefined || now === null || livingCauses(editor, channel)?.length === 0;
  if (editor.components.length === 1 && typeof id === "string" && open) editor.draft.set(pointers.causesOf(channel), { components: [id] });
}

/** Adds a component to the causes of a decision, or removes it: a cause is observed or not, so UNOBSERVED goes. */
export function toggleCause(editor: TaskEditor, channel: Channel, id: string): void {
  if (!editor.isEditable(pointers.causes)) return;
  const named = livingCauses(editor, channel) ?? [];
  editor.draft.set(pointers.causesOf(channel), { components: named.includes(id) ? named.filter((c) => c !== id) : [...named, id] });
}

/**
 * Chooses a decision; causes and direction that belong only to the previous one are removed. The only direction that
 * the class allows is set.
 */
export function decide(editor: TaskEditor, channel: Channel, value: string | null): void {
  if (!editor.isEditable(pointers.decision)) return;
  const before = editor.decision(channel);
  editor.draft.group(() => {
    editor.draft.set(pointers.decisionOf(channel), value);
    if (value === null) editor.draft.set(pointers.causesOf(channel), undefined);
    else linkOnly(editor, channel);
    if (channel !== "lateral") return;
    const possible = editor.framework?.lateral.find((d) => d.id === value)?.directions ?? [];
    const allowed = directionsOf(editor.leaf?.choices ?? null, value ?? "", possible);
    const now = editor.draft.at(pointers.lateralDirection);
    const fits = typeof now === "string" && (before === value ? possible : allowed).includes(now);
    if (!fits) editor.draft.set(pointers.lateralDirection, allowed.length === 1 ? allowed[0] : undefined);
  });
}
