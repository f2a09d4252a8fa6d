//! Keyframe and class against the episodes that the rules found: the moment that the labeling spec prescribes, and
//! another class at the same moment.

use crate::check::recording::Recorded;
use crate::check::view::View;
use whyroad_framework::check::class_index::ClassIndex;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_model::label_fields::pointer;
use whyroad_model::messages::{EpisodeRecord, KeyframeType, MatchedCondition};
use whyroad_model::{Bilingual, Lang};

/// An episode at least this far away is another one, s.
const OTHER_EPISODE_S: f64 = 6.0;
/// Maximum difference of a moment from the spec's, s; twice as much for the start of a range, which people judge less
/// exactly.
const MOMENT_S: f64 = 1.2;
/// Maximum distance of two classes at the same moment, s.
const SAME_MOMENT_S: f64 = 1.0;

pub(super) fn check(label: &View<'_>, recorded: &Recorded, classes: &ClassIndex, sink: &mut dyn Sink) {
    let (Some(keyframe), Some(l1), Some(l2)) =
        (label.keyframe.timestamp.get(), label.scenario.l1.get(), label.scenario.l2.get())
    else {
        return;
    };
    if recorded.episodes.is_empty() {
        return;
    }
    let off = |e: &EpisodeRecord| keyframe.seconds_since(e.keyframe.timestamp);
    let nearest = |of: &dyn Fn(&EpisodeRecord) -> bool| {
        recorded.episodes.iter().filter(|e| of(e)).min_by(|a, b| off(a).abs().total_cmp(&off(b).abs()))
    };
    let same_l2 = |e: &EpisodeRecord| e.scenario_id.l1 == l1 && e.scenario_id.l2.as_deref() == Some(l2);
    let l3 = label.scenario.l3.get();
    let same = |e: &EpisodeRecord| same_l2(e) && (l3.is_none() || e.scenario_id.l3.as_deref() == l3);
    if let Some(e) = nearest(&same).filter(|e| off(e).abs() < OTHER_EPISODE_S) {
        let slack = if e.keyframe.kind == KeyframeType::Proactive { 2.0 * MOMENT_S } else { MOMENT_S };
        if off(e).abs() > slack {
            let (seconds, rule, due) = (off(e), &e.keyframe_rule, e.keyframe.timestamp);
            sink.report(Finding::warning("label.keyframe.moment", pointer::KEYFRAME_TIMESTAMP), &|| {
                let (zh, en) = if seconds > 0.0 { ("晚", "after") } else { ("早", "before") };
                Words::new(
                    format!("关键帧比规则的时刻{zh} {:.1} s：“{}”在 {due}", seconds.abs(), rule.zh),
                    format!(
                        "the keyframe is {:.1} s {en} the moment of the rule: '{}' is at {due}",
                        seconds.abs(),
                        rule.en
                    ),
                )
                .hint("把关键帧移到该时刻", "move the keyframe to that moment")
            });
        }
        return;
    }
    if nearest(&same_l2).is_some_and(|e| off(e).abs() < OTHER_EPISODE_S) {
        return;
    }
    let other = |e: &EpisodeRecord| e.is_primary && off(e).abs() <= SAME_MOMENT_S;
    let Some(e) = nearest(&other) else { return };
    // A secondary trigger that the label names is already covered.
    let id = e.scenario_id.to_string();
    if label.secondary.iter().any(|s| s.get().is_some_and(|s| id.starts_with(s))) {
        return;
    }
    sink.report(Finding::warning("label.class.rule", pointer::SCENARIO), &|| {
        let own = label.class_id();
        let name = own.as_ref().and_then(|id| classes.name(id)).cloned().unwrap_or_default();
        let rule = classes.name(&e.scenario_id).cloned().unwrap_or_else(|| Bilingual::same(&id));
        let why = |lang: Lang| {
            let words = |c: &MatchedCondition| match &c.description {
                Some(words) => words.get(lang).to_owned(),
                None => c.condition.clone(),
            };
            e.conditions_matched.iter().take(2).map(words).collect::<Vec<_>>()
        };
        Words::new(
            format!("规则在此时刻找到的是“{}”（{}），而不是“{}”", rule.zh, why(Lang::Zh).join("；"), name.zh),
            format!(
                "the rules find '{}' at this moment ({}), not '{}'",
                rule.en,
                why(Lang::En).join("; "),
                name.en
            ),
        )
        .hint(
            "检查场景类别；另一触发可列为次场景",
            "check the scenario class; the other trigger may be a secondary scenario",
        )
    });
}
