//! The analytics as a fragment of a page: with its own style, without script, in both languages. The report and the
//! page of the labeling service include it; `html[lang]` selects the visible language.

mod context_section;
mod label_section;
mod missing_section;
mod stage_table;

use super::Analytics;
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, ScenarioId};
use whyroad_render::markup::Markup;

const STYLE: &str = include_str!("../../assets/analytics.css");

/// Displayed names of classes: `L2 · L3`.
pub(super) struct ClassNames(BTreeMap<ScenarioId, Bilingual>);

impl ClassNames {
    pub(super) fn of(a: &Analytics) -> Self {
        let own: BTreeMap<&ScenarioId, &Bilingual> =
            a.stages.iter().map(|r| (&r.scenario_id, &r.name)).collect();
        let title = |id: &ScenarioId, name: &Bilingual| {
            let above = ScenarioId { l3: None, ..id.clone() };
            match own.get(&above).filter(|_| id.is_leaf()) {
                Some(l2) => {
                    Bilingual::new(format!("{} · {}", l2.zh, name.zh), format!("{} · {}", l2.en, name.en))
                }
                None => name.clone(),
            }
        };
        Self(a.stages.iter().map(|r| (r.scenario_id.clone(), title(&r.scenario_id, &r.name))).collect())
    }

    pub(super) fn get(&self, id: &ScenarioId) -> Bilingual {
        self.0.get(id).cloned().unwrap_or_else(|| Bilingual::same(id.to_string()))
    }
}

/// The fragment: one element of class `analytics`.
pub fn fragment(a: &Analytics) -> Markup {
    let names = ClassNames::of(a);
    let mut m = Markup::new();
    m.raw("<section class=\"analytics\" id=\"analytics\" tabindex=\"0\"><style>\n")
        .raw(STYLE)
        .raw("</style><h2>");
    m.say("数据分析", "Analytics").raw("</h2>");
    given(&mut m, a);
    figures(&mut m, a);
    stage_table::write(&mut m, a);
    missing_section::shortfalls(&mut m, a, &names);
    missing_section::unseen(&mut m, a, &names);
    label_section::progress(&mut m, a);
    label_section::agreement(&mut m, a);
    label_section::corrections(&mut m, a, &names);
    label_section::decisions(&mut m, a, &names);
    context_section::write(&mut m, a);
    m.raw("</section>");
    m
}

/// Inputs of the numbers: missing inputs are unknown, not zero.
fn given(m: &mut Markup, a: &Analytics) {
    let inputs = [
        (a.given.mined, "挖掘结果", "mined episodes"),
        (a.given.tasks, "标注任务", "labeling tasks"),
        (a.given.releases, "发布数据集", "releases"),
    ];
    m.raw("<p class=\"faint\">").say("数据来源：", "Made from: ");
    list(m, inputs.iter().filter(|i| i.0));
    if inputs.iter().any(|i| !i.0) {
        m.say("。未提供：", ". Not given: ");
        list(m, inputs.iter().filter(|i| !i.0));
        m.say("（相应数字未知，显示为 …）", " (their numbers are unknown and shown as …)");
    }
    m.say("。", ".");
    if let Some(at) = a.as_of {
        let day: String = at.to_string().chars().take(10).collect();
        m.say(" 截至 ", " As of ").text(&day).say("（UTC）。", " (UTC).");
    }
    m.raw("</p>");
}

fn list<'i>(m: &mut Markup, inputs: impl Iterator<Item = &'i (bool, &'static str, &'static str)>) {
    for (i, (_, zh, en)) in inputs.enumerate() {
        if i > 0 {
            m.say("、", ", ");
        }
        m.say(zh, en);
    }
}

/// The most important numbers.
fn figures(m: &mut Markup, a: &Analytics) {
    let total = |of: fn(&super::StageCounts) -> Option<u64>| -> Option<u64> {
        let tops = a.stages.iter().filter(|r| r.scenario_id.l2.is_none() || !r.in_taxonomy);
        tops.filter_map(|r| of(&r.counts)).reduce(|x, y| x + y)
    };
    m.raw("<dl class=\"stage-figures\">");
    for (value, zh, en) in [
        (total(|c| c.mined), "已挖掘", "mined"),
        (total(|c| c.tasked), "已建任务", "tasked"),
        (total(|c| c.labelled), "已标注", "labeled"),
        (total(|c| c.accepted), "已接受", "accepted"),
        (total(|c| c.released), "已发布", "released"),
    ] {
        m.raw("<div><dd>");
        count(m, value);
        m.raw("</dd><dt>").say(zh, en).raw("</dt></div>");
    }
    m.raw("</dl>");
}

/// A count; `…` where it is unknown.
pub(super) fn count(m: &mut Markup, value: Option<u64>) {
    match value {
        Some(n) => m.int(n),
        None => m.raw("…"),
    };
}

/// A number; `…` where it is unknown.
pub(super) fn number(m: &mut Markup, value: Option<f64>, digits: usize) {
    match value {
        Some(v) => m.num(v, digits),
        None => m.raw("…"),
    };
}

/// Hours with that many decimals; what was driven, however short, is never shown as 0.
pub(super) fn hours(m: &mut Markup, value: f64, digits: i32) {
    let least = 10_f64.powi(-digits);
    if value > 0.0 && value < least / 2.0 {
        m.text("< ").num(least, digits as usize);
    } else {
        m.num(value, digits as usize);
    }
}

/// The head of a table: titles, those of numbers to the right.
pub(super) fn head(m: &mut Markup, titles: &[(&'static str, &'static str, Align)]) {
    m.raw("<thead><tr>");
    for (zh, en, align) in titles {
        // A column of bars has no title: the column of values beside it has one.
        if zh.is_empty() {
            m.raw("<td class=\"bar\"></td>");
            continue;
        }
        m.raw(match align {
            Align::Text => "<th scope=\"col\">",
            Align::Number => "<th scope=\"col\" class=\"n\">",
            Align::Bar => "<th scope=\"col\" class=\"bar\">",
        });
        m.say(zh, en).raw("</th>");
    }
    m.raw("</tr></thead>");
}

/// Alignment of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Align {
    Text,
    Number,
    Bar,
}
