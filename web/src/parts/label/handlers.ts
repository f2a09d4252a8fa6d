// What each action of the keyboard does on the labelling screen.
import type { Handlers } from "../../keys/keys.svelte.ts";
import { addComponent, evidenceNow, setKeyRange, setKeyframe, setRange, toggleIn, toggleUncertainty } from "../../label/edits.ts";
import type { Work } from "../../label/work.svelte.ts";
import { cameraBeside } from "../../scene/cameras.ts";
import { objectsAt } from "../../scene/objects.ts";
import { tick } from "svelte";
import { toField, toSection } from "./focus.ts";
import { keepLayers, layers } from "./layers.svelte.ts";
import { undo, redo } from "./undo.ts";

/** What the screen itself answers for. */
interface Deeds {
  advance: () => void;
  reject: () => void;
  sendBack: () => void;
}

export function handlers(work: Work, deeds: Deeds): Handlers {
  const player = work.player;

  function pickNext(by: 1 | -1): void {
    if (!work.scene) return;
    const ids = objectsAt(work.scene, player.index).map((o) => o.id);
    if (ids.length === 0) return;
    const at = work.picked === null ? -1 : ids.indexOf(work.picked);
    const next = at < 0 ? (by > 0 ? 0 : ids.length - 1) : (at + by + ids.length) % ids.length;
    work.picked = ids[next] ?? null;
  }

  async function add(): Promise<void> {
    const n = addComponent(work, work.picked);
    if (n === null) return;
    await tick();
    document.querySelector<HTMLElement>(`[data-component="${n}"] textarea`)?.focus();
  }

  function flip(layer: "names" | "occlusion" | "spec"): void {
    layers[layer] = !layers[layer];
    keepLayers();
  }

  function look(by: 1 | -1): void {
    layers.camera = cameraBeside(work.scene?.cameras ?? [], layers.camera, by);
    keepLayers();
  }

  /** What is in the focused field is good; on to the next that nobody has looked at, then to what has to be mended, at last to the safety filter. */
  async function acceptField(): Promise<void> {
    const field = document.activeElement?.closest<HTMLElement>("[data-field]")?.dataset["field"];
    const before = work.unaccepted;
    const at = before.indexOf(field ?? "");
    if (field !== undefined) work.accept(field);
    await tick();
    const next = work.unaccepted.find((p) => before.indexOf(p) > at) ?? work.unaccepted[0];
    if (next !== undefined) toField(next);
    else if (work.edits && work.stage === "stage2") {
      const wrong = work.draft.findings.find((f) => f.severity === "error");
      if (wrong) toField(wrong.pointer);
      else toSection("safety");
      // Words that have to be written anew: the first letter replaces them.
      if (wrong && work.mustRewrite(wrong.pointer) && document.activeElement instanceof HTMLTextAreaElement) document.activeElement.select();
    }
  }

  return {
    leave: () => (document.activeElement instanceof HTMLElement ? document.activeElement.blur() : undefined),
    save: () => void work.draft.flush(),
    undo: () => undo(work),
    redo: () => redo(work),
    acceptField: () => void acceptField(),
    advance: deeds.advance,
    play: () => player.toggle(),
    back: () => player.step(-1),
    forward: () => player.step(1),
    back1: () => player.step(-Math.round(work.scene?.frame_rate ?? 10)),
    forward1: () => player.step(Math.round(work.scene?.frame_rate ?? 10)),
    first: () => player.seek(player.first),
    last: () => player.seek(player.end),
    toKeyframe: () => player.seek(work.second(work.draft.at("/keyframe/timestamp")) ?? 0),
    slower: () => player.faster(-1),
    faster: () => player.faster(1),
    loop: () => (player.loop = !player.loop),
    follow: () => (layers.follow = !layers.follow),
    zoomIn: () => layers.zoom?.(1.3),
    zoomOut: () => layers.zoom?.(1 / 1.3),
    nextObject: () => pickNext(1),
    previousObject: () => pickNext(-1),
    targetObject: () => (work.picked = work.target),
    names: () => flip("names"),
    occlusion: () => flip("occlusion"),
    nextCamera: () => look(1),
    previousCamera: () => look(-1),
    addComponent: () => void add(),
    linkObject: () => work.picked !== null && toggleIn(work, work.current, "linked_objects", work.picked),
    evidence: () => evidenceNow(work),
    uncertain: () => toggleUncertainty(work, work.current),
    keyframe: () => setKeyframe(work, "keyframe"),
    keyframe2: () => setKeyframe(work, "second_keyframe"),
    keyStart: () => setKeyRange(work, "range_start"),
    keyEnd: () => setKeyRange(work, "range_end"),
    rangeStart: () => setRange(work, "start"),
    rangeEnd: () => setRange(work, "end"),
    safe: () => work.edits && work.stage === "stage2" && work.setSafe(!work.safe),
    reject: deeds.reject,
    sendBack: deeds.sendBack,
    toComponents: () => toSection("components"),
    toLongitudinal: () => toSection("decisions", "[data-choices=longitudinal]"),
    toLateral: () => toSection("decisions", "[data-choices=lateral]"),
    toCauses: () => toSection("causes"),
    toTrace: () => toSection("trace"),
    toRecords: () => toSection("records"),
    toFindings: () => toSection("findings"),
    toComments: () => toSection("comments"),
    spec: () => flip("spec"),
  };
}
