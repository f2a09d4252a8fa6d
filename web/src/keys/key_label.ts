// Key strokes for display: arrows as symbols, short names for long ones.

const SIGNS: Record<string, string> = {
  ArrowLeft: "←",
  ArrowRight: "→",
  ArrowUp: "↑",
  ArrowDown: "↓",
  Escape: "Esc",
  PageUp: "PgUp",
  PageDown: "PgDn",
};

export function keyLabel(stroke: string): string {
  // `Ctrl++` is the plus key: the last part may be the sign itself.
  const at = stroke.lastIndexOf("+", stroke.length - 2) + 1;
  const key = stroke.slice(at);
  return stroke.slice(0, at) + (SIGNS[key] ?? key);
}
