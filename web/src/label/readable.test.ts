// Values for readers: no JSON, no frame numbers, no timestamps.
import assert from "node:assert/strict";
import { test } from "vitest";
import { describeFinding, readable, type LabelContext } from "./readable.ts";

const words: LabelContext = {
  framework: {
    longitudinal: [{ id: "resume", name: { zh: "起步", en: "Resume" }, meaning: null, not: null, directions: [] }],
    lateral: [],
    none: { id: "null", name: { zh: "无", en: "none" }, meaning: null, not: null, directions: [] },
    categories: [{ id: "critical_objects", name: { zh: "关键目标", en: "critical objects" } }],
    leaves: new Map(),
    groups: new Map(),
    impossiblePairs: [],
    safetyReasons: [],
  },
  second: (iso) => (iso === "2026-01-15T10:30:09.400Z" ? -0.3 : null),
};

test("values become words in both languages", () => {
  assert.equal(readable("resume", words, "zh"), "起步");
  assert.equal(readable({ longitudinal: "resume", lateral: null }, words, "en"), "longitudinal Resume; lateral null");
  assert.equal(readable({ longitudinal: "resume", lateral: null }, words, "zh", "/driving_decision"), "纵向 起步；横向 无决策变化", "a judgment, not an empty field");
  assert.equal(readable(null, words, "en", "/driving_decision/lateral"), "No change");
  assert.equal(readable({ lateral: null }, words, "zh", "/causes"), "横向 空");
  assert.equal(readable({ timestamp: "2026-01-15T10:30:09.400Z", frame_idx: 94, type: "reactive" }, words, "zh"), "−0.3 s");
  const component = { id: "c1", category: "critical_objects", description: "lead", uncertainty: "low" };
  assert.equal(readable([component], words, "en"), "c1: lead; category critical objects; uncertainty low");
  assert.equal(readable({ lateral: "x", longitudinal: "y" }, words, "en"), "longitudinal y; lateral x", "in the order of the form");
  assert.equal(readable(["c1", "c2"], words, "zh"), "c1、c2");
  assert.equal(readable(undefined, words, "en"), "(nothing)");
  assert.equal(readable("前车刹车", words, "en"), "前车刹车", "free text stays as it was written");
});

test("records have the names, choices and units of the class", () => {
  const spec = {
    records: [
      { id: "has_traffic_light", name: { zh: "有信号灯", en: "has a traffic light" } },
      { id: "gap", name: { zh: "间距", en: "gap" }, unit: "m" },
      { id: "reason", name: { zh: "原因", en: "reason" }, choices: [{ id: "queue", name: { zh: "排队", en: "a queue" } }] },
      { id: "passed", name: { zh: "被超车辆", en: "overtaken vehicle" }, object: true },
    ],
  } as unknown as NonNullable<LabelContext["spec"]>;
  const here: LabelContext = { ...words, spec, trackName: (id) => (id === "a1" ? "#1" : id) };
  const records = { has_traffic_light: false, gap: 4.5, reason: "queue", passed: "a1", other: 2 };
  assert.equal(readable(records, here, "zh"), "有信号灯 否；间距 4.5 m；原因 排队；被超车辆 #1；other 2");
  assert.equal(readable(records, here, "en"), "has a traffic light no; gap 4.5 m; reason a queue; overtaken vehicle #1; other 2");
});

test("a finding speaks of seconds and names, as the screen does", () => {
  const leaf = { id: "a.cutin.urgent", name: { zh: "紧急", en: "urgent" }, path: [{ zh: "甲", en: "A" }, { zh: "切入", en: "cut-in" }, { zh: "紧急", en: "urgent" }], definition: null, condition: null, choices: null, decides: [] };
  const f = words.framework;
  assert.ok(f);
  const more: LabelContext = { ...words, framework: { ...f, leaves: new Map([[leaf.id, leaf]]), lateral: [{ id: "lane_change", name: { zh: "换道", en: "lane change" }, meaning: null, not: null, directions: [] }] } };
  assert.equal(describeFinding("证据时间 2026-01-15T10:30:09.400Z 晚于关键帧 2026-01-15T10:30:09.100Z", more, "zh"), "证据时间 −0.3 s 晚于关键帧 2026-01-15T10:30:09.100Z", "a moment that is not of this drive stays");
  const id = "58350757f1d04f628aab9b22cf33549b";
  const named: LabelContext = { ...more, trackName: (track) => (track === id ? "#5" : track) };
  assert.equal(describeFinding(`去掉轿车（${id}），自车会多行驶 5 m`, named, "zh"), "去掉轿车（#5），自车会多行驶 5 m");
  const quoted = "the trace contains the decision identifier 'lane_change'";
  assert.equal(describeFinding(quoted, more, "en"), quoted, "as it stands in the text");
  assert.equal(describeFinding("a.cutin.urgent needs lane_change, not some_word", more, "en"), "“urgent” needs “lane change”, not some_word");
  const here: LabelContext = { ...more, trackName: (id) => (id.startsWith("58350757") ? "#9" : id) };
  assert.equal(describeFinding("without the car 58350757f1d04f628aab9b22cf33549b it would come 5 m farther", here, "en"), "without the car #9 it would come 5 m farther");
  assert.equal(describeFinding("没有轿车58350757-f1d0-4f62-8aab-9b22cf33549b", here, "zh"), "没有轿车#9");
  const elsewhere = "not 68350757f1d04f628aab9b22cf33549b";
  assert.equal(describeFinding(elsewhere, here, "en"), elsewhere, "an object that is not in the scene stays");
});
