//! The cases of one class: the drawn ones, and the table of all of them.

use super::{cell, say};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use whyroad_mining::cases::CaseKind;
use whyroad_mining::cases::drawing::{DrawnCase, DrawnEpisode, DrawnTrace};
use whyroad_model::{Lang, ScenarioId};
use whyroad_render::traces::{Panel, Row, render};

/// Maximum number of signals of a drawn case, to keep it readable.
const MOST_ROWS: usize = 7;

/// Cases in the order of the file; their numbers are those of the table and of the drawing.
#[derive(Default)]
pub(super) struct ClassCases(Vec<DrawnCase>);

pub(super) fn by_class(all: Vec<DrawnCase>) -> BTreeMap<ScenarioId, ClassCases> {
    let mut out: BTreeMap<ScenarioId, ClassCases> = BTreeMap::new();
    for case in all {
        out.entry(case.scenario.clone()).or_default().0.push(case);
    }
    out
}

fn kind_name(kind: CaseKind, lang: Lang) -> &'static str {
    match kind {
        CaseKind::Positive => say(lang, "positive", "正例"),
        CaseKind::Negative => say(lang, "negative", "反例"),
        CaseKind::Boundary => say(lang, "boundary", "边界"),
        CaseKind::Unknown => say(lang, "unknown", "未知"),
    }
}

impl ClassCases {
    /// The first case of each kind, below one another.
    pub(super) fn svg(&self) -> Option<String> {
        let kinds = [CaseKind::Positive, CaseKind::Negative, CaseKind::Boundary, CaseKind::Unknown];
        let first = |kind| self.0.iter().enumerate().find(move |(_, c)| c.kind == kind);
        let panels: Vec<Panel> = kinds.into_iter().filter_map(first).map(|(i, c)| panel(i + 1, c)).collect();
        (!panels.is_empty()).then(|| render(&panels))
    }

    /// A row for each case.
    pub(super) fn table(&self, lang: Lang) -> String {
        let mut out = say(
            lang,
            "| no. | kind | case | expected |\n|---|---|---|---|\n",
            "| 序号 | 种类 | 用例 | 应得结果 |\n|---|---|---|---|\n",
        )
        .to_owned();
        for (i, case) in self.0.iter().enumerate() {
            let kind = kind_name(case.kind, lang);
            let _ = writeln!(out, "| {} | {kind} | {} | {} |", i + 1, cell(&case.name), expected(case, lang));
        }
        out
    }
}

fn expected(case: &DrawnCase, lang: Lang) -> String {
    if !case.not_observable.is_empty() {
        let names: Vec<String> = case.not_observable.iter().map(|s| format!("`{s}`")).collect();
        return format!("{}{}", say(lang, "not observable without ", "不可观测，缺 "), names.join(", "));
    }
    if case.expect.is_empty() {
        return say(lang, "no episode", "无事件").to_owned();
    }
    let each: Vec<String> = case.expect.iter().map(|e| episode(e, lang)).collect();
    each.join("<br>")
}

fn episode(e: &DrawnEpisode, lang: Lang) -> String {
    let mut out = format!("{} {} s", say(lang, "keyframe", "关键帧"), e.keyframe);
    if let Some(second) = e.second_keyframe {
        let _ = write!(out, "{} {second} s", say(lang, ", second", "，第二个"));
    }
    let _ = match (e.start, e.end, lang) {
        (Some(a), Some(b), Lang::En) => write!(out, ", range {a} to {b} s"),
        (Some(a), Some(b), Lang::Zh) => write!(out, "，范围 {a} 至 {b} s"),
        (Some(a), None, _) => write!(out, "{} {a} s", say(lang, ", start", "，起始")),
        (None, Some(b), _) => write!(out, "{} {b} s", say(lang, ", end", "，结束")),
        (None, None, _) => Ok(()),
    };
    out
}

fn panel(number: usize, case: &DrawnCase) -> Panel {
    Panel {
        title: format!("{number}  {}: {}", kind_name(case.kind, Lang::En), case.name),
        seconds: case.seconds,
        ranges: case.expect.iter().filter_map(|e| Some((e.start?, e.end?))).collect(),
        keyframes: case.expect.iter().flat_map(|e| [Some(e.keyframe), e.second_keyframe]).flatten().collect(),
        rows: case.traces.iter().take(MOST_ROWS).map(row).collect(),
    }
}

fn row(trace: &DrawnTrace) -> Row {
    Row {
        name: trace.name.clone(),
        unit: trace.unit.map_or("", |u| u.symbol).to_owned(),
        per_base_unit: trace.unit.map_or(1.0, |u| 1.0 / u.to_base),
        column: trace.column.clone(),
        shown: trace.seen,
    }
}
