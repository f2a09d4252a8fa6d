// A task made up by arithmetic, and answers to every request of the labeling screen about it: for measuring the page
// without a server and without recorded data. The scene is a curved motorway of four lanes with any number of objects,
// and cameras with an image at every frame.
import { picture } from "./png.mjs";

const HZ = 10;
const iso = (i) => new Date(Date.UTC(2026, 0, 15, 10, 30, 0) + i * 100).toISOString();
const round = (v) => Math.round(v * 1000) / 1000;

/** A point `s` meters along the road, `d` meters left of its center, and the road's heading there. */
function onRoad(s, d) {
  const heading = 0.35 * Math.sin(s / 180);
  const y = -63 * Math.cos(s / 180);
  return [s - d * Math.sin(heading), y + d * Math.cos(heading), heading];
}

/** Repeatable numbers from 0 to 1. */
function dice(seed) {
  let s = seed;
  return () => {
    s = (Math.imul(s, 1664525) + 1013904223) >>> 0;
    return s / 2 ** 32;
  };
}

export function scene({ objects, seconds, stage, cameras = 0 }) {
  const n = seconds * HZ;
  const key = Math.round(n / 3);
  const shown = stage === "stage1" ? key + 1 : n;
  const rows = [...Array(shown).keys()];
  const roll = dice(7);
  const column = (f) => rows.map((i) => round(f(i / HZ)));
  const moving = (s0, d0, v, sway = 0) => {
    const at = (t) => onRoad(s0 + v * t, d0 + sway * Math.sin(t / 3));
    return { x: column((t) => at(t)[0]), y: column((t) => at(t)[1]), heading: column((t) => at(t)[2]), speed: column(() => v) };
  };
  const kinds = [
    ["car", 4.6, 1.9],
    ["truck", 11.5, 2.5],
    ["bus", 12, 2.55],
    ["motorcycle", 2.2, 0.8],
    ["bicycle", 1.8, 0.6],
    ["pedestrian", 0.6, 0.6],
  ];
  const tracks = [...Array(objects).keys()].map((i) => {
    const [name, length, width] = kinds[roll() < 0.6 ? 0 : Math.floor(roll() * kinds.length)];
    const walks = name === "pedestrian" || name === "bicycle";
    const lane = Math.floor(roll() * 4);
    const m = moving((roll() - 0.35) * 320, walks ? 9 + 3 * roll() : lane * 3.6 - 5.4, walks ? 1 + roll() : 11 + 6 * roll(), 0.3 * roll());
    return { id: `t${i}`, class: name, first: 0, length, width, ...m, visible: rows.map(() => (i % 17 === 3 ? 0.05 : 1)) };
  });
  const ego = moving(0, -1.8, 14, 0.2);
  const brake = (t) => -1.8 * Math.exp(-((t - key / HZ - 1.2) ** 2));
  return {
    stage,
    frame_rate: HZ,
    times: rows.map(iso),
    t_s: rows.map((i) => round((i - key) / HZ)),
    clip_frames: rows.map((i) => i),
    keyframe_index: key,
    ego: {
      size: [4.7, 1.9],
      ...ego,
      accel: column(brake),
      yaw_rate: column((t) => 0.03 * Math.cos(t / 2)),
      steering: column((t) => 0.4 * Math.sin(t / 2)),
      turn_signal: rows.map((i) => (i > key - 20 && i < key + 15 ? "left" : "off")),
    },
    tracks,
    lights: [
      { lane_id: "l1", t_index: 0, colour: "green" },
      { lane_id: "l1", t_index: Math.floor(key / 2), colour: "yellow" },
      { lane_id: "l1", t_index: Math.floor(key / 2) + 20, colour: "red" },
    ],
    meta: {
      longitudinal: rows.map((i) => (i < key ? "maintain_speed" : i < key + 30 ? "gentle_decelerate" : "gentle_accelerate")),
      lateral: rows.map((i) => (i % 90 < 60 ? "go_straight" : "steer_left")),
    },
    signals: {
      "target.lateral_offset": column((t) => 2 - t / 12),
      "target.ttc": rows.map((i) => (i < key / 2 ? "none" : round(Math.max(1.2, 9 - (i - key / 2) / 10)))),
      "target.wheel_over_line": rows.map((i) => i > key),
    },
    about: {
      "target.lateral_offset": { kind: "number", unit: "m", title: { zh: "横向偏移", en: "lateral offset" }, meaning: { zh: "到车道中心的横向偏移", en: "Offset from the lane's center" } },
      "target.ttc": { kind: "number", unit: "s", title: { zh: "碰撞时间 TTC", en: "TTC" }, meaning: { zh: "碰撞时间", en: "Time to collision" } },
      "target.wheel_over_line": { kind: "flag", unit: null, title: { zh: "车轮压线", en: "a wheel is over the line" }, meaning: { zh: "车轮压线", en: "A wheel is over the line" } },
    },
    cameras: [...Array(cameras).keys()].map((n) => ({
      camera: ["front_wide_120fov", "cross_left_120fov", "cross_right_120fov"][n] ?? `camera_${n}`,
      frames: rows.map((i) => ({ index: i, t_index: i, t_s: round((i - key) / HZ), url: `/api/v1/tasks/t1/media/${n}/${i}` })),
    })),
    ...(stage === "stage1" ? { hidden_until: "stage2" } : {}),
  };
}

export function map() {
  const line = (d, from = -150, to = 450) => [...Array((to - from) / 5 + 1).keys()].map((i) => onRoad(from + i * 5, d).slice(0, 2).map(round));
  const lane = (i) => ({
    id: `l${i}`,
    left: line(-7.2 + 3.6 * (i + 1)),
    right: line(-7.2 + 3.6 * i),
    centre: line(-5.4 + 3.6 * i, -150, 120),
    left_mark: i === 3 ? "solid" : i === 1 ? "double_solid" : "dashed",
    right_mark: i === 0 ? "solid" : i === 2 ? "double_solid" : "dashed",
    kind: "vehicle",
    in_junction: false,
  });
  const across = (s, w) => [onRoad(s, -7.2), onRoad(s, 7.2), onRoad(s + w, 7.2), onRoad(s + w, -7.2)].map((p) => p.slice(0, 2));
  const house = (s, d) => ({ id: `h${s}`, kind: "building", points: [onRoad(s, d), onRoad(s + 18, d), onRoad(s + 18, d + 12), onRoad(s, d + 12)].map((p) => p.slice(0, 2)) });
  return {
    lanes: [0, 1, 2, 3].map(lane),
    crosswalks: [{ id: "x", points: across(126, 4) }],
    stop_lines: [{ id: "s", points: across(122, 0).slice(0, 2) }],
    junctions: [{ id: "j", points: across(130, 20) }],
    drivable: [],
    facilities: [house(30, 18), house(70, 20), house(160, 17), house(20, -32)],
    signs: [],
  };
}

const pair = (zh, en) => ({ zh, en });
export const framework = {
  taxonomy: {
    l1: [
      {
        id: "reactive_agent",
        name: pair("交互响应", "Reactive to Agent"),
        l2: [
          {
            id: "cutin",
            name: pair("Cutin响应", "Response to a cut-in"),
            l3: [{ id: "urgent", name: pair("紧急切入", "Urgent cut-in"), condition: pair("TTC < 3 s", "TTC < 3 s at the keyframe") }],
          },
        ],
      },
    ],
  },
  choices: {
    "reactive_agent.cutin.urgent": {
      longitudinal: [{ id: "yield_to_agent", direction: null, usual: true }, { id: null, direction: null, usual: false }],
      lateral: [{ id: "lane_keeping", direction: null, usual: true }, { id: null, direction: null, usual: false }],
      decides: false,
      reveals: false,
    },
  },
  impossible_pairs: [],
  safety_reasons: [{ id: "other", name: pair("其他", "other") }],
  decisions: {
    longitudinal: [{ id: "yield_to_agent", name: pair("让行", "Yield to agent"), meaning: pair("给特定对象让路。", "Gives way."), directions: [] }],
    lateral: [{ id: "lane_change", name: pair("换道", "Lane change"), meaning: pair("换到邻道。", "To the next lane."), directions: ["left", "right"] }],
    null: { id: "null", name: pair("无决策变化", "No change"), meaning: pair("延续原动作。", "Goes on as before.") },
  },
  categories: [{ id: "critical_objects", name: pair("关键目标", "critical objects") }],
  records: {},
  versions: { taxonomy: "2.0.0" },
};

const user = { id: "u1", name: "anna", display: "安娜", admin: false, disabled: false, lang: "zh" };

/** A task in `stage`, held by the one who asks. */
export function task(view, { stage }) {
  const i = view.keyframe_index;
  const keyframe = { timestamp: view.times[i], frame_idx: i, type: "reactive" };
  const first = { version: "2.1.0", clip_id: "clip_made_up", keyframe, critical_components: [] };
  const rest = {
    time_range: { start_timestamp: view.times[i - 30], start_frame_idx: i - 30, end_timestamp: iso(i + 40), end_frame_idx: i + 40 },
    provenance: { source: "rule" },
    coc_trace: "",
  };
  const rule = (zh, en) => ({ rule: pair(zh, en) });
  return {
    task: {
      id: "t1",
      project: "p1",
      clip_id: "clip_made_up",
      drive_id: "drive_made_up",
      scenario_id: "reactive_agent.cutin.urgent",
      state: stage,
      stage,
      priority: 0,
      overlap: false,
      updated: 0,
    },
    draft: stage === "stage1" ? first : { ...first, ...rest, safety_filter: { answer: "safe" } },
    version: 1,
    stage,
    fence: 1,
    lease_until: Date.now() + 300_000,
    spec: {
      leaf: "reactive_agent.cutin.urgent",
      keyframe: { type: "reactive", ...rule("他车任一车轮越过车道线的时刻", "any wheel of the other vehicle crosses the lane line") },
      start: { ...rule("关键帧前 2 s", "2 s before the keyframe") },
      end: { ...rule("他车中心与车道中心的距离小于 0.5 m", "its center is less than 0.5 m from the lane center"), fallback: rule("关键帧后 3 s", "3 s after the keyframe") },
      pack: { before_s: 3, after_s: 3 },
      records: [{ id: "min_ttc", name: pair("最小 TTC", "Least TTC"), unit: "s" }],
      uncertainty_high: false,
    },
    suggestion: {
      keyframe,
      range_start: view.times[Math.max(0, i - 20)],
      range_end: stage === "stage1" ? null : iso(i + 30),
      target_id: "t5",
      conditions: stage === "stage1" ? [] : [{ condition: "target_vehicle.lateral_offset > 0.5m", actual_value: 0.82 }],
      signals: Object.keys(view.signals),
    },
    comments: [],
    history_count: 1,
    findings: [
      { code: "label.trace.empty", severity: "error", message_zh: "因果描述为空", message_en: "the trace is empty", pointer: "/coc_trace", hint_zh: "写出状态、原因与决策", hint_en: "write state, reason and decision" },
    ],
    permissions: stage === "stage1" ? ["edit", "lock_stage1", "release", "skip", "reject", "comment"] : ["edit", "safety", "submit", "release", "skip", "reject", "comment"],
    changed_from_suggestion: [],
  };
}

/** What the server would answer; `change` may replace parts of the task. */
export function answers({ objects = 200, seconds = 30, stage = "stage2", cameras = 0, words = framework, change = (t) => t } = {}) {
  const view = scene({ objects, seconds, stage, cameras });
  const made = change(task(view, { stage }));
  let version = made.version;
  return (method, path) => {
    if (path === "/session") return { user, csrf: "x", first_run: false };
    if (path === "/projects") return { items: [] };
    if (path === "/framework") return words;
    if (path === "/tasks/t1") return made;
    if (path === "/tasks/t1/scene") return view;
    if (path === "/tasks/t1/map") return map();
    if (path === "/tasks/t1/history/1") return { seq: 1, draft: made.draft };
    if (path === "/tasks/t1/draft") return { version: ++version, findings: made.findings, lease_until: Date.now() + 300_000 };
    if (path === "/tasks/t1/lease") return { fence: 1, lease_until: Date.now() + 300_000, state: made.task.state };
    return null;
  };
}

/** An image of a camera at a frame; few colors, each encoded once. */
const cameraImages = new Map();
function cameraImage(camera, frame) {
  const shade = frame % 20;
  const key = `${camera}/${shade}`;
  if (!cameraImages.has(key)) cameraImages.set(key, picture(1280, 720, [60 + 4 * shade, 80 + 20 * camera, 120]));
  return cameraImages.get(key);
}

/** Lets `page` have the built page in `dist` and these answers, with no server at all. */
export async function stand(page, dist, answer, { readFile, join }) {
  const types = { js: "text/javascript", css: "text/css", html: "text/html" };
  await page.route("**/*", async (route) => {
    const { pathname } = new URL(route.request().url());
    const image = /\/media\/(\d+)\/(\d+)$/.exec(pathname);
    if (image) return route.fulfill({ body: cameraImage(Number(image[1]), Number(image[2])), contentType: "image/png" });
    if (pathname.startsWith("/api/v1")) {
      const body = answer(route.request().method(), pathname.slice(7));
      return route.fulfill(body === null ? { status: 404, json: { code: "not.found", title: "not there" } } : { json: body });
    }
    const file = /\.(js|css)$/.exec(pathname) ? pathname : "/index.html";
    return route.fulfill({ body: await readFile(join(dist, file)), contentType: types[file.split(".").pop()] });
  });
}
