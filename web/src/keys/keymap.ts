// What the keyboard can do, by which keys, and when a key must be left alone. Pure: no DOM events, no state.
import type { TextPair } from "../text/screen_texts.ts";

/** Where an action works: everywhere, or also while a text field has the focus. */
type Reach = "page" | "always";

interface Act {
  name: TextPair;
  key: string;
  reach: Reach;
}

const action = (zh: string, en: string, key: string, reach: Reach = "page"): Act => ({ name: [zh, en], key, reach });

/** All actions with their default keys, in the order in which the help shows them. */
export const actions = {
  help: action("显示快捷键", "Show the keys", "?"),
  language: action("切换中文 / 英文", "Switch Chinese / English", "Alt+L", "always"),
  leave: action("离开输入框，回到画面", "Leave the field, back to the scene", "Escape", "always"),
  save: action("立即保存", "Save now", "Ctrl+S", "always"),
  undo: action("撤销", "Undo", "Ctrl+Z"),
  redo: action("重做", "Redo", "Ctrl+Shift+Z"),
  acceptField: action("采纳当前项的草稿，到下一项", "Accept the draft of this field, on to the next", "Alt+A", "always"),
  advance: action("主按钮：领取、锁定、提交、接受、下一个", "The main button: take, lock, submit, accept, next", "Ctrl+Enter", "always"),
  play: action("播放 / 暂停", "Play / pause", "Space"),
  back: action("上一帧", "Frame back", "ArrowLeft"),
  forward: action("下一帧", "Frame on", "ArrowRight"),
  back1: action("后退 1 秒", "Back 1 s", "Shift+ArrowLeft"),
  forward1: action("前进 1 秒", "On 1 s", "Shift+ArrowRight"),
  first: action("到开头", "To the beginning", "Home"),
  last: action("到末尾", "To the end", "End"),
  toKeyframe: action("跳到关键帧", "To the keyframe", "0"),
  slower: action("放慢", "Slower", "["),
  faster: action("加快", "Faster", "]"),
  loop: action("循环区间", "Loop the range", "L"),
  follow: action("跟随 / 自由视角", "Follow / free view", "F"),
  zoomIn: action("放大", "Zoom in", "="),
  zoomOut: action("缩小", "Zoom out", "-"),
  nextObject: action("选下一个目标", "Pick the next object", "N"),
  previousObject: action("选上一个目标", "Pick the previous object", "P"),
  targetObject: action("选规则的目标", "Pick the rule's target", "T"),
  names: action("显示目标编号", "Show object names", "M"),
  nextCamera: action("下一个相机", "Next camera", "V"),
  previousCamera: action("上一个相机", "Previous camera", "Shift+V"),
  occlusion: action("显示遮挡区", "Show hidden areas", "H"),
  addComponent: action("把选中的目标加为要素", "Make the picked object a component", "C"),
  linkObject: action("把选中的目标关联到当前要素", "Link the picked object to the component", "O"),
  evidence: action("把此刻记为证据时刻", "Add this moment as evidence", "E"),
  uncertain: action("当前要素的不确定性：低 / 高", "Uncertainty of the component: low / high", "X"),
  keyframe: action("关键帧设在此刻", "Keyframe here", "K"),
  keyframe2: action("第二关键帧设在此刻", "Second keyframe here", "Shift+K"),
  keyStart: action("关键帧范围起点设在此刻", "Keyframe range starts here", "Shift+I"),
  keyEnd: action("关键帧范围终点设在此刻", "Keyframe range ends here", "Shift+U"),
  rangeStart: action("时间范围起点设在此刻", "Range starts here", "I"),
  rangeEnd: action("时间范围终点设在此刻", "Range ends here", "U"),
  safe: action("合法且安全", "Legal and safe", "Y"),
  reject: action("剔除…", "Reject…", "D"),
  sendBack: action("退回…（检查、审计）", "Send back… (check, audit)", "B"),
  toComponents: action("到关键要素", "Go to the components", "1"),
  toLongitudinal: action("到纵向决策", "Go to the longitudinal decision", "2"),
  toLateral: action("到横向决策", "Go to the lateral decision", "3"),
  toCauses: action("到原因", "Go to the causes", "4"),
  toTrace: action("到因果推理", "Go to the trace", "5"),
  toRecords: action("到必记项", "Go to the records", "6"),
  toFindings: action("到检查结果", "Go to the findings", "7"),
  toComments: action("到意见", "Go to the comments", "8"),
  spec: action("显示 / 收起标注规范", "Show / hide the specification", "S"),
} as const satisfies Record<string, Act>;

export type ActionId = keyof typeof actions;
export const actionIds = Object.keys(actions) as ActionId[];
export type Bindings = Partial<Record<ActionId, string>>;

export interface Stroke {
  key: string;
  ctrlKey: boolean;
  altKey: boolean;
  shiftKey: boolean;
  metaKey: boolean;
}

/** The name of a key stroke, `Ctrl+Shift+Z`; null for a modifier alone. Command counts as Ctrl. */
export function strokeName(e: Stroke): string | null {
  if (["Control", "Shift", "Alt", "Meta", "AltGraph", "Process", "Unidentified", "Dead"].includes(e.key)) return null;
  const letter = e.key.length === 1;
  const key = e.key === " " ? "Space" : letter ? e.key.toUpperCase() : e.key;
  const cased = !letter || e.key.toLowerCase() !== e.key.toUpperCase();
  const modifiers = [
    e.ctrlKey || e.metaKey ? "Ctrl+" : "",
    e.altKey ? "Alt+" : "",
    // Shift makes `?` out of `/` on one keyboard and something else on another: the sign itself is the name.
    e.shiftKey && cased ? "Shift+" : "",
  ];
  return modifiers.join("") + key;
}

export function keyOf(action: ActionId, own: Bindings): string {
  return own[action] ?? actions[action].key;
}

export function actionOf(stroke: string, own: Bindings): ActionId | null {
  return actionIds.find((a) => keyOf(a, own) === stroke) ?? null;
}

/** What has the focus: it decides which strokes are its own. */
export type Focus = "text" | "choice" | "button" | "slider" | "page";

/** Does the focused thing need this stroke itself? Text needs all that types; choices, buttons and sliders what works them. */
export function fieldKeeps(focus: Focus, stroke: string, action: ActionId): boolean {
  if (focus === "text") return actions[action].reach !== "always";
  const keys: Record<Exclude<Focus, "text">, readonly string[]> = {
    page: [],
    button: ["Space", "Enter"],
    choice: ["Space", "Enter", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End"],
    slider: ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End"],
  };
  return keys[focus].includes(stroke);
}

export type Refused = { clash: ActionId } | { types: true };

/** Why `stroke` cannot be the key of `action`; null when it can. */
export function bindingProblem(action: ActionId, stroke: string, own: Bindings): Refused | null {
  const other = actionIds.find((a) => a !== action && keyOf(a, own) === stroke);
  if (other) return { clash: other };
  const types = !stroke.startsWith("Ctrl+") && !stroke.startsWith("Alt+") && stroke !== "Escape" && !/^F\d+$/.test(stroke);
  return actions[action].reach === "always" && types ? { types: true } : null;
}
