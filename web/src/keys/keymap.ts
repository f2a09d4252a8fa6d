// The keyboard shortcuts of the page: actions, their default keys, and when a key stroke belongs to the focused field.
// Pure.
import type { TextPair } from "../text/screen_texts.ts";

/** Where an action works: outside of text fields, or also while a text field has the focus. */
type Reach = "page" | "always";

/** Groups of actions in the order of the help. */
export const groups = {
  general: ["通用", "General"],
  task: ["任务", "Task"],
  playback: ["播放", "Playback"],
  view: ["视图", "View"],
  components: ["要素", "Components"],
  times: ["时刻与范围", "Times and ranges"],
  go: ["转到", "Go to"],
} as const satisfies Record<string, TextPair>;

export type GroupId = keyof typeof groups;

interface Action {
  group: GroupId;
  name: TextPair;
  key: string;
  reach: Reach;
}

const action = (group: GroupId, zh: string, en: string, key: string, reach: Reach = "page"): Action => ({ group, name: [zh, en], key, reach });

/** All actions with their default keys, in the order of the help. */
export const actions = {
  help: action("general", "显示快捷键", "Show keyboard shortcuts", "?"),
  language: action("general", "切换中文 / 英文", "Switch Chinese / English", "Alt+L", "always"),
  leave: action("general", "离开输入框", "Leave the text field", "Escape", "always"),
  save: action("general", "立即保存", "Save now", "Ctrl+S", "always"),
  undo: action("general", "撤销", "Undo", "Ctrl+Z"),
  redo: action("general", "重做", "Redo", "Ctrl+Shift+Z"),
  advance: action("task", "主按钮：领取、锁定、提交、下一个", "Main button: take, lock, submit, next", "Ctrl+Enter", "always"),
  acceptField: action("task", "采纳当前项的草稿，转到下一项", "Accept the draft of this field and go to the next", "Alt+A", "always"),
  safe: action("task", "合法且安全", "Legal and safe", "Y"),
  reject: action("task", "违法或不安全 / 剔除…", "Illegal or unsafe / reject…", "D"),
  accept: action("task", "接受（质检、抽检）", "Accept (check, audit)", "A"),
  wrongClass: action("task", "场景不对…（跳过并告诉负责人）", "The class is wrong… (skip, and tell the lead)", "Shift+C"),
  skip: action("task", "跳过…", "Skip…", "Shift+S"),
  sendBack: action("task", "退回…（质检、抽检）", "Return for rework… (check, audit)", "B"),
  askLead: action("task", "问负责人…", "Ask the lead…", "Q"),
  play: action("playback", "播放 / 暂停", "Play / pause", "Space"),
  back: action("playback", "上一帧", "Previous frame", "ArrowLeft"),
  forward: action("playback", "下一帧", "Next frame", "ArrowRight"),
  back1: action("playback", "后退 1 秒", "Back 1 s", "Shift+ArrowLeft"),
  forward1: action("playback", "前进 1 秒", "Forward 1 s", "Shift+ArrowRight"),
  first: action("playback", "到开头", "To the start", "Home"),
  last: action("playback", "到末尾", "To the end", "End"),
  toKeyframe: action("playback", "到关键帧", "To the keyframe", "0"),
  slower: action("playback", "放慢", "Slower", "["),
  faster: action("playback", "加快", "Faster", "]"),
  loop: action("playback", "循环区间", "Loop the range", "L"),
  follow: action("view", "跟随自车 / 自由视角", "Follow the ego / free view", "F"),
  zoomIn: action("view", "放大", "Zoom in", "="),
  zoomOut: action("view", "缩小", "Zoom out", "-"),
  zoomToTarget: action("view", "缩放到目标", "Zoom to the target", "Z"),
  ruler: action("view", "测距", "Ruler", "R"),
  velocities: action("view", "显示速度箭头", "Show velocity arrows", "W"),
  nextObject: action("view", "选下一个目标", "Select the next object", "N"),
  previousObject: action("view", "选上一个目标", "Select the previous object", "P"),
  targetObject: action("view", "选规则目标", "Select the rule's target", "T"),
  findObject: action("view", "按编号选目标", "Select an object by its number", "G"),
  names: action("view", "显示目标编号", "Show object names", "M"),
  nextCamera: action("view", "下一个相机", "Next camera", "V"),
  previousCamera: action("view", "上一个相机", "Previous camera", "Shift+V"),
  occlusion: action("view", "显示遮挡区", "Show occlusion", "H"),
  scrollDown: action("view", "信号向下翻", "Scroll the signals down", "PageDown"),
  scrollUp: action("view", "信号向上翻", "Scroll the signals up", "PageUp"),
  addComponent: action("components", "把选中的目标加为要素", "Add the selected object as a component", "C"),
  linkObject: action("components", "把选中的目标关联到当前要素", "Link the selected object to the component", "O"),
  removeComponent: action("components", "删除当前要素", "Remove the component", "Delete"),
  evidence: action("components", "把当前时刻记为证据时刻", "Add the current time as evidence", "E"),
  uncertain: action("components", "当前要素的不确定性：低 / 高", "Uncertainty of the component: low / high", "X"),
  keyframe: action("times", "关键帧设在此刻", "Set keyframe here", "K"),
  keyframe2: action("times", "第二关键帧设在此刻", "Set second keyframe here", "Shift+K"),
  keyStart: action("times", "关键帧范围起点设在此刻", "Start keyframe range here", "Shift+I"),
  keyEnd: action("times", "关键帧范围终点设在此刻", "End keyframe range here", "Shift+U"),
  rangeStart: action("times", "时间范围起点设在此刻", "Start time range here", "I"),
  rangeEnd: action("times", "时间范围终点设在此刻", "End time range here", "U"),
  toComponents: action("go", "关键要素", "Critical components", "1"),
  toLongitudinal: action("go", "纵向决策", "Longitudinal decision", "2"),
  toLateral: action("go", "横向决策", "Lateral decision", "3"),
  toDirection: action("go", "横向决策的方向", "Direction of the lateral decision", "9"),
  toCauses: action("go", "原因", "Causes", "4"),
  toTrace: action("go", "因果描述", "Causal trace", "5"),
  toRecords: action("go", "必填记录", "Required records", "6"),
  toFindings: action("go", "校验结果", "Findings", "7"),
  toComments: action("go", "意见", "Comments", "8"),
  spec: action("go", "显示 / 收起标注规范", "Show / hide the labeling specification", "S"),
} as const satisfies Record<string, Action>;

export type ActionId = keyof typeof actions;
export const actionIds = Object.keys(actions) as ActionId[];
export const groupIds = Object.keys(groups) as GroupId[];
export const actionsOf = (group: GroupId): ActionId[] => actionIds.filter((id) => actions[id].group === group);
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
    // Which key gives `?` with Shift depends on the keyboard: the character itself is the name.
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

/**
 * Does holding the key down repeat the action? Steps of the player do; what is done to a task is done once per press,
 * so that a key that is held does not go on to the next field or task, and so is removing a component.
 */
export function repeats(action: ActionId): boolean {
  return actions[action].group !== "task" && action !== "removeComponent";
}

/** Does the stroke type or move something in a text field or a list? */
const types = (stroke: string): boolean =>
  !stroke.startsWith("Ctrl+") && !stroke.startsWith("Alt+") && stroke !== "Escape" && !/^F\d+$/.test(stroke);

/**
 * Kind of the focused element: it decides which strokes belong to it. `undone`: text of the page's own undo; `list`: a
 * drop-down list, in which letters and digits choose an entry by the beginning of its name.
 */
export type Focus = "text" | "undone" | "list" | "choice" | "radio" | "button" | "slider" | "page";

/**
 * Does the focused element need this stroke itself? Text and lists need all that types; the others what operates them.
 * A radio button is chosen by the arrows up and down or by its own key: what plays and steps goes to the player, so
 * that who looks at the frames does not change a decision.
 */
export function fieldKeeps(focus: Focus, stroke: string, action: ActionId): boolean {
  // With a key of its own that types, undo would take a character from the text.
  const undoes = focus === "undone" && (action === "undo" || action === "redo") && !types(stroke);
  if (focus === "text" || focus === "undone") return actions[action].reach !== "always" && !undoes;
  if (focus === "list") return types(stroke);
  const keys: Record<Exclude<Focus, "text" | "undone" | "list">, readonly string[]> = {
    page: [],
    button: ["Space", "Enter"],
    choice: ["Space", "Enter", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End"],
    radio: ["Enter", "ArrowUp", "ArrowDown"],
    slider: ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End"],
  };
  return keys[focus].includes(stroke);
}

export type Refused = { clash: ActionId } | { types: true };

/** Why `stroke` cannot be the key of `action`; null when it can. */
export function bindingProblem(action: ActionId, stroke: string, own: Bindings): Refused | null {
  const other = actionIds.find((a) => a !== action && keyOf(a, own) === stroke);
  if (other) return { clash: other };
  return actions[action].reach === "always" && types(stroke) ? { types: true } : null;
}
