// The trace in slots and back: nothing typed is lost, and what is missing is named.
import assert from "node:assert/strict";
import { test } from "vitest";
import { fitsSlots, isDraft, keepsDraft, lacks, languageOf, slotsOf, slotsShown, stillDraft, traceOf, type TraceSlots, type TypedTrace } from "./trace_slots.ts";

// The drafts as whyroad-label's draft/trace.rs writes them.
const DRAFT_ZH = "【草稿】左前方的轿车正在驶入自车车道，因此自车让行。";
const DRAFT_EN = "[DRAFT] the car ahead is slowing; the light is red; therefore the ego's decision: yield to agent.";

test("a draft has state and decision; the reason is what a person adds", () => {
  const zh = slotsOf(DRAFT_ZH);
  assert.deepEqual(zh, { state: "左前方的轿车正在驶入自车车道", reason: "", decision: "自车让行" });
  assert.ok(isDraft(DRAFT_ZH) && isDraft(DRAFT_EN) && !isDraft("因此自车让行"));
  const whole = traceOf({ ...zh, reason: "车距不足" }, "zh");
  assert.equal(whole, "左前方的轿车正在驶入自车车道；车距不足，因此自车让行。");
  assert.ok(!isDraft(whole));
  assert.deepEqual(slotsOf(DRAFT_EN), { state: "the car ahead is slowing", reason: "the light is red", decision: "the ego's decision: yield to agent" });
});

test("a draft stays one until its reason is written", () => {
  const slots = slotsOf(DRAFT_ZH);
  const other = { ...slots, decision: "自车跟车" };
  assert.equal(stillDraft(traceOf(other, "zh"), DRAFT_ZH, other), "【草稿】左前方的轿车正在驶入自车车道，因此自车跟车。");
  const whole = { ...slots, reason: "车距不足以保持安全" };
  assert.ok(!isDraft(stillDraft(traceOf(whole, "zh"), DRAFT_ZH, whole)));
  assert.equal(stillDraft("自己写的。", "自己写的", slotsOf("自己写的")), "自己写的。", "what a person wrote is no draft");
});

test("slots give back what was typed into them", () => {
  for (const language of ["zh", "en"] as const) {
    const typed =
      language === "zh"
        ? { state: "前车减速，距离 22 m", reason: "车距不足以保持安全，需要让出空间", decision: "自车减速让行" }
        : { state: "the lead brakes 22 m ahead", reason: "the gap is too short at this speed", decision: "the ego slows down to yield" };
    const text = traceOf(typed, language);
    assert.deepEqual(slotsOf(text), typed);
    assert.ok(fitsSlots(text));
    assert.equal(languageOf(text, "zh"), language);
    // Half typed, too: an empty slot leaves no marks behind.
    for (const name of ["reason", "decision"] as const) {
      const part = { ...typed, [name]: "" };
      assert.deepEqual(slotsOf(traceOf(part, language)), part, `${language} without ${name}`);
    }
  }
  assert.equal(traceOf({ state: "", reason: "", decision: "" }, "zh"), "");
});

test("who writes \"therefore\" into the decision has it once", () => {
  const typing = (before: TraceSlots, typed: string, language: "zh" | "en"): string => {
    let text = traceOf(before, language);
    // The box shows all that was typed so far; the other slots are read from the text.
    for (let n = 1; n <= typed.length; n++) text = traceOf({ ...slotsOf(text), decision: typed.slice(0, n) }, language);
    return text;
  };
  const zh = { state: "行人正走上斑马线", reason: "他会走到自车前方", decision: "" };
  assert.equal(typing(zh, "因此自车停住让行", "zh"), "行人正走上斑马线；他会走到自车前方，因此自车停住让行。");
  assert.equal(typing(zh, "所以，自车停住让行", "zh"), "行人正走上斑马线；他会走到自车前方，因此自车停住让行。");
  const en = { state: "a person steps onto the crosswalk", reason: "they will be in the ego's way", decision: "" };
  const whole = "a person steps onto the crosswalk; they will be in the ego's way, therefore the ego stops.";
  assert.equal(typing(en, "so the ego stops", "en"), whole);
  assert.equal(typing(en, "Therefore, the ego stops", "en"), whole);
  // A word that only begins like it.
  assert.equal(traceOf({ ...en, decision: "soon the ego stops" }, "en"), whole.replace("the ego stops", "soon the ego stops"));
});

test("what is typed into a slot stays there until it is left", () => {
  const typing = (before: TraceSlots, slot: "state" | "reason", words: string, language: "zh" | "en"): string => {
    let text = traceOf(before, language);
    let typed: TypedTrace | null = null;
    for (let n = 1; n <= words.length; n++) {
      const slots: TraceSlots = { ...slotsShown(text, typed), [slot]: words.slice(0, n) };
      text = traceOf(slots, language);
      typed = { text, slots };
      assert.deepEqual(slotsShown(text, typed), slots);
    }
    return text;
  };
  const en = { state: "a person steps onto the crosswalk", reason: "", decision: "" };
  const sentence = typing(en, "reason", "the gap will be too short soon, so the ego stops.", "en");
  assert.equal(sentence, "a person steps onto the crosswalk; the gap will be too short soon, so the ego stops.");
  assert.deepEqual(slotsOf(sentence), { ...en, reason: "the gap will be too short soon", decision: "the ego stops" });
  const zh = typing({ state: "行人正走上斑马线", reason: "", decision: "" }, "reason", "两者路径相交，因此自车停住让行", "zh");
  assert.deepEqual(slotsOf(zh), { state: "行人正走上斑马线", reason: "两者路径相交", decision: "自车停住让行" });
  // A sentence that was ended leaves no second mark; another change of the text is read from the text.
  assert.equal(typing({ ...en, reason: "they are in the way" }, "state", "A person waits.", "en"), "A person waits; they are in the way.");
  assert.equal(slotsShown("前车减速。", { text: "前车刹车。", slots: { state: "前车刹车", reason: "", decision: "" } }).state, "前车减速");
});

test("a decision alone is no state", () => {
  for (const [language, decision] of [["zh", "自车让行"], ["en", "the ego yields"]] as const) {
    const only = { state: "", reason: "", decision };
    assert.deepEqual(slotsOf(traceOf(only, language)), only);
    // A reason without a state would be read as one.
    const stated = { ...only, state: language === "zh" ? "前车减速" : "the lead brakes" };
    assert.deepEqual(slotsOf(traceOf(stated, language)), stated);
  }
  assert.equal(slotsOf("So far the lane is free.").state, "So far the lane is free");
});

test("sentences of a draft go to their slots, and stay there while one is typed into", () => {
  const zh = "本车道前方的轿车车速低于自车。自车正在追近前车，照这样开很快就会跟得太近，所以自车减速跟车，保持安全距离。";
  const slots = slotsOf(zh, true);
  assert.deepEqual(slots, { state: "本车道前方的轿车车速低于自车", reason: "自车正在追近前车，照这样开很快就会跟得太近", decision: "自车减速跟车，保持安全距离" });
  const typed = { ...slots, state: `${slots.state}。两车相距 18 m` };
  assert.deepEqual(slotsOf(traceOf(typed, "zh")), typed);
  const en = "The ego is driving at about 2.5 m/s. A junction lies ahead. The ego is close behind the lead, so it slows down.";
  const three = { state: "The ego is driving at about 2.5 m/s. A junction lies ahead", reason: "the ego is close behind the lead", decision: "it slows down" };
  assert.deepEqual(slotsOf(en, true), three);
  assert.ok(fitsSlots(zh) && fitsSlots(en));
});

test("a text in another form keeps its words", () => {
  const free = "自车让行。左侧车辆压线切入";
  assert.equal(slotsOf(free).state, free);
  assert.equal(slotsOf("a sofa lies on the road; it is also soft").decision, "", "`so` inside a word joins nothing");
  assert.ok(fitsSlots("前车刹车；来不及，因此减速。"));
});

test("what is missing is named, by content", () => {
  assert.deepEqual(lacks(slotsOf(DRAFT_ZH)), ["reason"]);
  assert.deepEqual(lacks({ state: "前车减速", reason: "太近", decision: "让行" }), ["short_reason"]);
  assert.deepEqual(lacks({ state: "前车正在减速", reason: "前车正在减速", decision: "让行" }), ["repeats_state"]);
  assert.deepEqual(lacks({ state: "the lead brakes", reason: "the gap is too short", decision: "yield" }), []);
});

test("a draft whose decision alone was changed is still one", () => {
  const draft = "前车减速。车距不足，需要拉开间距，所以自车跟车。";
  const slots = slotsOf(draft, true);
  assert.ok(keepsDraft(traceOf({ ...slots, decision: "自车让行" }, "zh"), draft));
  assert.ok(!keepsDraft(traceOf({ ...slots, reason: "再不减速会追尾" }, "zh"), draft));
  assert.ok(!keepsDraft("", draft) && !keepsDraft("因此自车让行。", ""));
});
