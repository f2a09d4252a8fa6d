// Names of scenarios from the framework, for the screens that list them and for the labeling screen: loaded once per
// page.
import * as api from "./api/calls.generated.ts";
import { className, type Framework, readFramework } from "./label/framework.ts";
import { type Bilingual, localized } from "./text/text.svelte.ts";

const loaded = $state<{ now: Framework | null }>({ now: null });
let asked: Promise<Framework> | null = null;

/** Loads the framework once. After a failure the next screen tries again. */
export function loadFramework(): Promise<Framework> {
  asked ??= api.getFramework().then(
    (view) => (loaded.now = readFramework(view)),
    (error: unknown) => {
      asked = null;
      throw error;
    },
  );
  return asked;
}

/** The localized name of a leaf or an L2; its id while names are not loaded, and for classes of another version. */
export function leafName(id: string): string {
  const name = loaded.now && className(loaded.now.leaves, id);
  return name ? localized(name) : id;
}

const SEPARATOR = " › ";

/** Names of the L1 and L2 of a leaf: `L1 › L2`; empty while they are unknown. */
export function groupName(id: string): string {
  const parts = id.split(".").slice(0, -1);
  const leaves = loaded.now?.leaves;
  const names = parts.flatMap((_, n) => (leaves ? [className(leaves, parts.slice(0, n + 1).join("."))] : []));
  return names.flatMap((name) => (name ? [localized(name)] : [])).join(SEPARATOR);
}

/** Name of the L2 of a leaf, or of the L1 of an L2; empty while it is unknown. */
export const parentName = (id: string): string => groupName(id).split(SEPARATOR).at(-1) ?? "";

/** The localized name of a reason of the safety filter. */
export function safetyReasonName(id: string): string {
  return localized(loaded.now?.safetyReasons.find((r) => r.id === id)?.name) || id;
}

export interface Group {
  id: string;
  name: Bilingual;
  groups: { id: string; name: Bilingual; leaves: { id: string; name: Bilingual }[] }[];
}

/** All leaves under their L2 and L1, in the framework's order. */
export function tree(): Group[] {
  const out: Group[] = [];
  for (const leaf of loaded.now?.leaves.values() ?? []) {
    const [one = "", two = ""] = leaf.id.split(".");
    const [oneName, twoName] = leaf.path;
    if (!oneName || !twoName) continue;
    let a = out.find((g) => g.id === one);
    if (!a) out.push((a = { id: one, name: oneName, groups: [] }));
    let b = a.groups.find((g) => g.id === `${one}.${two}`);
    if (!b) a.groups.push((b = { id: `${one}.${two}`, name: twoName, leaves: [] }));
    b.leaves.push({ id: leaf.id, name: leaf.name });
  }
  return out;
}
