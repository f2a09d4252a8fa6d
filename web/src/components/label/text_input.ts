// Events of a text field of the label: every change, but none while an input method is composing (half a pinyin is not
// text). What is written there is undone as any other change: the browser's own undo knows nothing of what the page put
// into a field, and takes back what was typed into another one.

type Box = HTMLInputElement | HTMLTextAreaElement;

export function textInput(set: (text: string) => void): {
  oninput: (e: Event & { currentTarget: Box }) => void;
  oncompositionend: (e: CompositionEvent & { currentTarget: Box }) => void;
  "data-undo": "page";
} {
  return {
    oninput: (e) => {
      if (!(e instanceof InputEvent && e.isComposing)) set(e.currentTarget.value);
    },
    oncompositionend: (e) => set(e.currentTarget.value),
    "data-undo": "page",
  };
}
