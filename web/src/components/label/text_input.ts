// What a text field hands on: every change, but nothing while an input method is still composing (half a pinyin is no text).

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
