//! Rules of the trace text (LABELING.md 7): its form, and what it says against the decisions.

use crate::check::consistency::trace::{Reading, TraceVerdict, form, judge, read};
use crate::check::view::View;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::lexicon::Lexicon;
use whyroad_model::label_fields::{name, pointer};

/// Form of the trace, and what it says against the decisions.
pub(in crate::check) fn trace(label: &View<'_>, lexicon: &Lexicon, sink: &mut dyn Sink) -> Option<Reading> {
    let text = label.trace.get()?;
    if text.trim().is_empty() {
        sink.report(Finding::error("label.trace.empty", pointer::COC_TRACE), &|| {
            Words::new("coc_trace 为空", "coc_trace is empty").hint(
                "按“状态、原因、决策”的顺序写 50 至 100 字",
                "write the state, why it matters, and the decision, in some 30 to 60 words",
            )
        });
        return None;
    }
    let limits = &lexicon.limits;
    let seen = form(text, limits);
    if seen.length < limits.too_short_below {
        sink.report(Finding::error("label.trace.too_short", pointer::COC_TRACE), &|| {
            Words::new(
                format!("coc_trace 太短（约 {} 字），写不下状态、原因和决策", seen.length),
                format!(
                    "coc_trace is too short to hold state, reason and decision ({} words or so)",
                    seen.length / 2
                ),
            )
            .hint("写 50 至 100 字", "write some 30 to 60 words")
        });
    } else if limits.too_long_above > 0 && seen.length > limits.too_long_above {
        sink.report(Finding::warning("label.trace.too_long", pointer::COC_TRACE), &|| {
            Words::new(
                format!("coc_trace 过长（约 {} 字）", seen.length),
                format!("coc_trace is long (about {} words)", seen.length / 2),
            )
            .hint("只留影响决策的内容，50 至 100 字", "keep what bears on the decision, some 30 to 60 words")
        });
    }
    if limits.too_long_above > 0 && seen.numbers > limits.numbers_above {
        sink.report(Finding::warning("label.trace.numbers", pointer::COC_TRACE), &|| {
            Words::new(
                format!("coc_trace 中数字过多（{} 个）", seen.numbers),
                format!("coc_trace has too many numbers ({})", seen.numbers),
            )
            .hint(
                "先定性描述：“很近”“较快”，数字只留关键的",
                "describe it in words first (close, fast); keep only the numbers that matter",
            )
        });
    }
    let reading = read(text, lexicon);
    if let Some((start, end)) = reading.decision_id {
        sink.report(
            Finding::warning("label.trace.decision_id", pointer::COC_TRACE).part(start, end),
            &|| {
                let id = &text[start..end];
                Words::new(
                    format!("coc_trace 中出现决策标识 '{id}'"),
                    format!("coc_trace contains the decision identifier '{id}'"),
                )
                .hint("用自然语言写决策", "name the decision in natural language")
            },
        );
    }
    let (longitudinal, lateral) = (label.longitudinal, label.lateral);
    let mut none = false;
    judge(&reading, lexicon, longitudinal.get(), lateral.get(), label.direction.get(), &mut |v| {
        // An unreadable decision is not a null decision: its channel is not judged.
        let unreadable = match &v {
            TraceVerdict::Unlabelled { channel: name::LONGITUDINAL, .. } => longitudinal == Slot::Broken,
            TraceVerdict::Unlabelled { .. } => lateral == Slot::Broken,
            _ => false,
        };
        if !unreadable {
            none |= v == TraceVerdict::NoDecision;
            verdict(&v, text, sink);
        }
    });
    // A trace too short, or without a decision, cannot give a reason for one.
    (!none && seen.length >= limits.too_short_below).then_some(reading)
}

/// The part `from..to` of the trace states the label's decision, as the ego's.
pub(in crate::check) fn states_decision(
    reading: &Reading,
    lexicon: &Lexicon,
    label: &View<'_>,
    from: usize,
    to: usize,
) -> bool {
    reading.mentions.iter().filter(|m| (from..to).contains(&m.start) && !m.by_other).any(|m| {
        let says = &lexicon.phrases[m.phrase];
        label.longitudinal.get().is_some_and(|d| says.longitudinal.contains(&d))
            || label.lateral.get().is_some_and(|d| says.lateral.contains(&d))
    })
}

fn verdict(v: &TraceVerdict, text: &str, sink: &mut dyn Sink) {
    match v {
        TraceVerdict::OtherDecision { label, says, start, end } => {
            sink.report(
                Finding::error("label.trace.contradicts", pointer::COC_TRACE).part(*start, *end),
                &|| {
                    let phrase = &text[*start..*end];
                    Words::new(
                        format!("标签的决策是 {label}，coc_trace 却说“{phrase}”（{}）", says.join(" 或 ")),
                        format!(
                            "the label decides for {label}, but the trace says '{phrase}' ({})",
                            says.join(" or ")
                        ),
                    )
                    .hint(
                        "检查决策，或改写 coc_trace 的结尾",
                        "check the decision, or rewrite the end of the trace",
                    )
                },
            );
        }
        TraceVerdict::Denied { label, start, end } => {
            sink.report(
                Finding::error("label.trace.contradicts", pointer::COC_TRACE).part(*start, *end),
                &|| {
                    let phrase = &text[*start..*end];
                    Words::new(
                        format!("标签的决策是 {label}，coc_trace 却否定了“{phrase}”"),
                        format!("the label decides for {label}, but the trace says not to '{phrase}'"),
                    )
                    .hint(
                        "检查决策，或改写 coc_trace 的结尾",
                        "check the decision, or rewrite the end of the trace",
                    )
                },
            );
        }
        TraceVerdict::OtherSide { label, says, start, end } => {
            sink.report(
                Finding::error("label.trace.direction", pointer::COC_TRACE).part(*start, *end),
                &|| {
                    let phrase = &text[*start..*end];
                    Words::new(
                        format!("标签的方向是 {label}，coc_trace 却说“{phrase}”（{says}）"),
                        format!("the label goes {label}, but the trace says '{phrase}' ({says})"),
                    )
                },
            );
        }
        TraceVerdict::Unlabelled { channel, says, start, end } => {
            sink.report(
                Finding::warning("label.trace.unlabelled", pointer::COC_TRACE).part(*start, *end),
                &|| {
                    let phrase = &text[*start..*end];
                    Words::new(
                        format!("coc_trace 说“{phrase}”（{says}），标签的 {channel} 却为 null"),
                        format!("the trace says '{phrase}' ({says}), but the label's {channel} is null"),
                    )
                    .hint(
                        "确有新决策时补上，否则改写 coc_trace",
                        "add the decision if there was one, or rewrite the trace",
                    )
                },
            );
        }
        TraceVerdict::NoDecision => {
            sink.report(Finding::warning("label.trace.decision_missing", pointer::COC_TRACE), &|| {
                Words::new("coc_trace 没有说出任何决策", "the trace names no decision").hint(
                    "以决策结尾，例如“因此减速让行”",
                    "end with the decision, such as \"so the ego slows down to yield\"",
                )
            });
        }
    }
}
