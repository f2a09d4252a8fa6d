// Events of a text field: every change, but none while an input method is composing (half a pinyin is not text).

type Box = HTMLInputElement | HTMLTextAreaElement;

export function textInput(set: (text: string) => void): {
  oninput: (e: Event & { currentTarget: Box }) => void;
  oncompositionend: (e: CompositionEvent & { currentTarget: Box }) => void;
} {
  return {
    oninput: (e) => {
      if (!(e instanceof InputEvent && e.isComposing)) set(e.currentTarget.value);
    },
    oncompositionend: (e) => set(e.currentTarget.value),
  };
}
