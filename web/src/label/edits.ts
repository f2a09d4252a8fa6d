// What can be done to the label, the same for keyboard and pointer. Each asks `work.open` whether it may, and goes through
// the draft, so that it is saved and can be undone.
import type { Channel } from "./framework.ts";
import type { Json } from "./pointer.ts";
import type { KeyframeName, Work } from "./work.svelte.ts";

export function setKeyframe(work: Work, name: KeyframeName, frame = work.frame): void {
  const iso = work.clock?.iso[frame];
  const idx = work.clock?.frames[frame];
  if (!iso || idx === undefined || idx < 0 || !work.open(`/${name}`)) return;
  const before = work.draft.at(`/${name}`);
  const type = work.spec?.[name]?.type ?? "reactive";
  const old = typeof before === "object" && before !== null && !Array.isArray(before) ? before : { type };
  work.draft.set(`/${name}`, { ...old, timestamp: iso, frame_idx: idx });
}

export function setKeyRange(work: Work, end: "range_start" | "range_end", frame = work.frame): void {
  const iso = work.clock?.iso[frame];
  if (iso && work.open("/keyframe")) work.draft.set(`/keyframe/${end}`, iso);
}

export function setRange(work: Work, end: "start" | "end", frame = work.frame): void {
  const iso = work.clock?.iso[frame];
  const idx = work.clock?.frames[frame];
  if (!iso || idx === undefined || !work.open("/time_range")) return;
  work.draft.together(() => {
    work.draft.set(`/time_range/${end}_timestamp`, iso);
    work.draft.set(`/time_range/${end}_frame_idx`, idx < 0 ? undefined : idx);
  });
}

/** A new component, of the picked object where one is picked; its number. Null where none may be added. */
export function addComponent(work: Work, object: string | null): number | null {
  if (!work.open("/critical_components")) return null;
  const all = work.components;
  const used = new Set(all.map((c) => c["id"]));
  let n = all.length + 1;
  while (used.has(`c${n}`)) n++;
  const made: Record<string, Json> = { id: `c${n}`, description: "", uncertainty: "low" };
  if (object !== null) Object.assign(made, { category: objectCategory(work), linked_objects: [object] });
  const iso = work.clock?.iso[Math.min(work.frame, work.scene?.keyframe_index ?? 0)];
  if (iso) made["evidence_times"] = [iso];
  work.draft.set("/critical_components", [...all, made]);
  work.current = all.length;
  return all.length;
}

function objectCategory(work: Work): string {
  const known = work.framework?.categories ?? [];
  return (known.find((c) => c.id.includes("object")) ?? known[0])?.id ?? "critical_objects";
}

/** Takes a component away, and out of the causes that name it. */
export function removeComponent(work: Work, n: number): void {
  if (!work.open("/critical_components")) return;
  const gone = work.components[n]?.["id"];
  work.draft.together(() => {
    work.draft.set("/critical_components", work.components.filter((_, i) => i !== n));
    for (const channel of ["longitudinal", "lateral"] as const) {
      const path = `/causes/${channel}/components`;
      const named = work.draft.at(path);
      if (Array.isArray(named) && gone !== undefined && named.includes(gone)) work.draft.set(path, named.filter((c) => c !== gone));
    }
  });
  work.current = Math.max(0, Math.min(work.current, work.components.length - 1));
}

/** Adds to a list of a component, or takes away what is there. */
export function toggleIn(work: Work, n: number, list: "evidence_times" | "linked_objects", value: string): void {
  const path = `/critical_components/${n}/${list}`;
  if (!work.components[n] || !work.open(path)) return;
  const now = work.draft.at(path);
  const items = Array.isArray(now) ? now.map(String) : [];
  const next = items.includes(value) ? items.filter((i) => i !== value) : [...items, value];
  work.draft.set(path, next.length === 0 ? undefined : list === "evidence_times" ? next.sort() : next);
}

/** Uncertainty of component `n`: high where it was low or not said, else low. */
export function toggleUncertainty(work: Work, n: number): void {
  const path = `/critical_components/${n}/uncertainty`;
  if (work.components[n] && work.open(path)) work.draft.set(path, work.draft.at(path) === "high" ? "low" : "high");
}

/** Moment of evidence: now, but never after the keyframe. */
export function evidenceNow(work: Work): void {
  const keyframe = work.second(work.draft.at("/keyframe/timestamp")) ?? 0;
  const iso = work.clock?.iso[work.frame];
  if (iso && work.player.now <= keyframe + 1e-6) toggleIn(work, work.current, "evidence_times", iso);
}

/** Chooses a decision; what only went with the one before (causes, direction) goes with it. */
export function decide(work: Work, channel: Channel, value: string | null): void {
  if (!work.open("/driving_decision")) return;
  work.draft.together(() => {
    work.draft.set(`/driving_decision/${channel}`, value);
    if (value === null) work.draft.set(`/causes/${channel}`, undefined);
    if (channel !== "lateral") return;
    const allowed = work.framework?.lateral.find((d) => d.id === value)?.directions ?? [];
    const now = work.draft.at("/driving_decision/lateral_direction");
    const fits = typeof now === "string" && allowed.includes(now);
    if (!fits) work.draft.set("/driving_decision/lateral_direction", allowed.length === 1 ? allowed[0] : undefined);
  });
}
