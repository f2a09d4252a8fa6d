// Keyboard state: custom bindings (kept in this browser), and the handlers of the current screen.
import { actionOf, fieldKeeps, type ActionId, type Bindings, type Focus, keyOf, repeats, strokeName } from "./keymap.ts";

const KEY = "whyroad.keys";

function stored(): Bindings {
  try {
    const own: unknown = JSON.parse(localStorage.getItem(KEY) ?? "{}");
    return typeof own === "object" && own !== null ? (own as Bindings) : {};
  } catch {
    return {};
  }
}

export const keys = $state<{ own: Bindings; help: boolean }>({ own: stored(), help: false });

export function bind(action: ActionId, stroke: string): void {
  keys.own[action] = stroke;
  localStorage.setItem(KEY, JSON.stringify(keys.own));
}

export function resetKeys(): void {
  keys.own = {};
  localStorage.removeItem(KEY);
}

export function keyName(action: ActionId): string {
  return keyOf(action, keys.own);
}

export type Handlers = Partial<Record<ActionId, () => unknown>>;
const stack: Handlers[] = [];

/** Registers handlers until the returned function is called; later ones have precedence. */
export function handleKeys(handlers: Handlers): () => void {
  stack.push(handlers);
  return () => {
    const at = stack.indexOf(handlers);
    if (at >= 0) stack.splice(at, 1);
  };
}

function focusOf(element: Element | null): Focus {
  if (element instanceof HTMLElement && element.dataset["undo"] === "page") return "undone";
  if (element instanceof HTMLTextAreaElement) return "text";
  if (element instanceof HTMLInputElement) {
    if (element.type === "radio") return element.checked ? "radio" : "choice";
    if (element.type === "range") return "slider";
    return ["checkbox", "button", "submit", "file"].includes(element.type) ? "button" : "text";
  }
  if (element instanceof HTMLSelectElement) return "list";
  if (element instanceof HTMLElement && element.isContentEditable) return "text";
  if (element instanceof HTMLButtonElement || element instanceof HTMLAnchorElement) return "button";
  if (element?.tagName === "SUMMARY") return "button";
  return "page";
}

/** For `<svelte:window onkeydown>`. */
export function onKeydown(e: KeyboardEvent): void {
  // Some browsers report 229 for the stroke that ends a composition, no longer marked as composing.
  if (e.defaultPrevented || e.isComposing || e.keyCode === 229) return;
  const stroke = strokeName(e);
  const action = stroke && actionOf(stroke, keys.own);
  if (!stroke || !action || document.querySelector("dialog[open]")) return;
  if (fieldKeeps(focusOf(document.activeElement), stroke, action)) return;
  const handler = stack.findLast((h) => h[action])?.[action];
  if (!handler) return;
  e.preventDefault();
  if (!e.repeat || repeats(action)) handler();
}
