//! The conversation of a sample, shared by the formats of vision-language trainers: a question that only tells what was
//! known at t0, and the answer: the trace, then the decisions.

use super::{ExportOptions, Exported, TraceLanguage};
use crate::sample::{Sample, Trajectory};
use whyroad_framework::Framework;
use whyroad_model::Lang;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};

/// One conversation.
pub(super) struct Conversation<'s> {
    /// Language of all texts.
    pub lang: Lang,
    /// The user's text, without image tags.
    pub question: String,
    /// The trace alone.
    pub trace: &'s str,
    /// The trace and the decisions: what the model should answer.
    pub answer: String,
}

/// The conversations of a sample in the languages that are asked for; one that is missing is counted.
pub(super) fn conversations<'s>(
    sample: &'s Sample,
    options: &ExportOptions,
    exported: &mut Exported,
) -> Vec<Conversation<'s>> {
    let wanted: &[Lang] = match options.language {
        TraceLanguage::Chinese => &[Lang::Zh],
        TraceLanguage::English => &[Lang::En],
        TraceLanguage::Both => &[Lang::Zh, Lang::En],
    };
    let found: Vec<Conversation<'s>> = wanted
        .iter()
        .filter_map(|lang| {
            let trace = trace(sample, *lang)?;
            let answer = format!("{trace}\n{}", decisions(sample, *lang));
            Some(Conversation { lang: *lang, question: question(sample, *lang), trace, answer })
        })
        .collect();
    if found.is_empty() {
        exported.leave_out(sample, "no trace in this language");
    }
    found
}

/// The trace in a language.
pub(super) fn trace(sample: &Sample, lang: Lang) -> Option<&str> {
    match lang {
        Lang::Zh => sample.trace_zh.as_deref(),
        Lang::En => sample.trace_en.as_deref(),
    }
}

/// What is asked: the images, the ego's motion up to t0, the route; nothing after t0.
fn question(sample: &Sample, lang: Lang) -> String {
    let speeds = speeds(&sample.history, lang);
    let route = match lang {
        Lang::Zh => sample.route_text_zh.as_deref(),
        Lang::En => sample.route_text_en.as_deref(),
    };
    let mut parts: Vec<String> = Vec::new();
    match lang {
        Lang::Zh => {
            if !sample.images.is_empty() {
                parts.push("图像为自车截至当前时刻的观测，按时间先后排列。".to_owned());
            }
            parts.extend(speeds.map(|s| format!("自车车速：{s}。")));
            parts.extend(route.map(|r| format!("导航指令：{r}。")));
            parts.push("请说明影响决策的关键因素，并给出自车的纵向与横向决策。".to_owned());
        }
        Lang::En => {
            if !sample.images.is_empty() {
                parts.push(
                    "The images show what the ego vehicle observed up to now, oldest first.".to_owned(),
                );
            }
            parts.extend(speeds.map(|s| format!("Ego speed: {s}.")));
            parts.extend(route.map(|r| format!("Route: {r}.")));
            parts.push(
                "Explain what matters for the decision, and state the longitudinal and the lateral decision."
                    .to_owned(),
            );
        }
    }
    parts.join(if lang == Lang::Zh { "" } else { " " })
}

/// Speeds about every 0.5 s up to t0; nothing where none is known.
fn speeds(history: &Trajectory, lang: Lang) -> Option<String> {
    let mut parts = Vec::new();
    let mut last = f32::NEG_INFINITY;
    for (t, speed) in history.t_s.iter().zip(&history.speed) {
        if *t - last < 0.45 && *t < -0.01 {
            continue;
        }
        if let Some(speed) = speed {
            last = *t;
            parts.push(match lang {
                Lang::Zh if *t > -0.01 => format!("当前 {speed:.1} 米/秒"),
                Lang::Zh => format!("{:.1} 秒前 {speed:.1} 米/秒", -t),
                Lang::En if *t > -0.01 => format!("{speed:.1} m/s now"),
                Lang::En => format!("{speed:.1} m/s {:.1} s ago", -t),
            });
        }
    }
    (!parts.is_empty()).then(|| parts.join(if lang == Lang::Zh { "，" } else { ", " }))
}

/// The decisions by name; "no change" is said.
fn decisions(sample: &Sample, lang: Lang) -> String {
    let sets = &Framework::bundled().decisions;
    let longitudinal = sample.longitudinal.as_deref().and_then(Longitudinal::from_id);
    let lateral = sample.lateral.as_deref().and_then(Lateral::from_id);
    let side = sample.lateral_direction.as_deref().and_then(LateralDirection::from_id);
    let none = if lang == Lang::Zh { "无变化" } else { "no change" };
    let name = |text: Option<&whyroad_framework::decisions::DecisionText>| {
        text.map_or_else(|| none.to_owned(), |t| t.name.get(lang).to_owned())
    };
    let first = name(sets.longitudinal.iter().find(|d| Some(d.id) == longitudinal).map(|d| &d.text));
    let mut second = name(sets.lateral.iter().find(|d| Some(d.id) == lateral).map(|d| &d.text));
    if let Some(side) = side {
        second += &match (side, lang) {
            (LateralDirection::Left, Lang::Zh) => "（左）".to_owned(),
            (LateralDirection::Right, Lang::Zh) => "（右）".to_owned(),
            (LateralDirection::Uturn, Lang::Zh) => "（掉头）".to_owned(),
            (side, Lang::En) => format!(" ({})", side.id()),
        };
    }
    match lang {
        Lang::Zh => format!("纵向决策：{first}；横向决策：{second}。"),
        Lang::En => format!("Longitudinal: {first}. Lateral: {second}."),
    }
}
