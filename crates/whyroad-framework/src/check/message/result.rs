//! The result of a mining query (DATA_FORMAT.md 5.2).

use super::values::{scenario_id, share};
use crate::check::class_index::ClassIndex;
use crate::check::finding::{Finding, Sink, Words};
use crate::check::json::Node;
use crate::check::slot::Slot;
use crate::check::walk::{Object, Walk};
use whyroad_model::Severity;

pub(super) fn result<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, classes: &ClassIndex) {
    let Some(mut o) = walk.object(node, "/mining_result".into()) else { return };
    let (n, at) = (walk.need(&mut o, "query_id"), o.at("query_id"));
    walk.text(n, &at);
    let n = walk.need(&mut o, "scenario_id");
    scenario_id(walk, n, "/mining_result/scenario_id", classes);
    let (n, at) = (walk.need(&mut o, "total_matched"), o.at("total_matched"));
    let total = walk.count(n, &at).get();
    let (n, returned_at) = (walk.need(&mut o, "returned"), o.at("returned"));
    let returned = walk.count(n, &returned_at).get();
    if let (Some(total), Some(returned)) = (total, returned)
        && returned > total
    {
        walk.report(Finding::error("message.result.count", returned_at.clone()), &|| {
            Words::new(
                format!("返回 {returned} 条，多于匹配的 {total} 条"),
                format!("{returned} returned of only {total} matched"),
            )
        });
    }
    let (n, at) = (walk.need(&mut o, "clips"), o.at("clips"));
    if let Slot::Is(items) = walk.list(n, &at) {
        listed(walk, items.len() as u64, returned, returned_at);
        for (i, item) in items.iter().enumerate() {
            clip(walk, item, format!("{at}/{i}"));
        }
    }
    if let Some(n) = walk.need(&mut o, "statistics") {
        statistics(walk, n, total, returned);
    }
    not_observable(walk, &mut o);
    walk.close(o, Severity::Warning);
}

/// The length of the list against the stated number; a shorter list may be an excerpt.
fn listed(walk: &mut Walk<'_>, listed: u64, returned: Option<u64>, at: String) {
    let Some(returned) = returned.filter(|r| *r != listed) else { return };
    let mut finding = Finding::warning("message.result.count", at);
    if listed > returned {
        finding.severity = Severity::Error;
    }
    walk.report(finding, &|| {
        Words::new(
            format!("returned 为 {returned}，clips 却列出 {listed} 条"),
            format!("returned is {returned}, but clips lists {listed}"),
        )
    });
}

/// Whether the ego responded: `EgoResponse` of the model.
const RESPONSES: [&str; 3] = ["observed", "absent", "unknown"];

fn clip<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, pointer: String) {
    let Some(mut o) = walk.object(node, pointer) else { return };
    let (n, at) = (walk.need(&mut o, "clip_id"), o.at("clip_id"));
    walk.text(n, &at);
    let (n, at) = (walk.need(&mut o, "match_score"), o.at("match_score"));
    share(walk, n, &at);
    let at = o.at("keyframe_suggestion");
    if let Some(mut k) = walk.need(&mut o, "keyframe_suggestion").and_then(|n| walk.object(n, at)) {
        let (n, at) = (walk.need(&mut k, "timestamp"), k.at("timestamp"));
        walk.time(n, &at);
        let (n, at) = (walk.need(&mut k, "frame_idx"), k.at("frame_idx"));
        walk.frame(n, &at);
        walk.close(k, Severity::Warning);
    }
    let (n, at) = (walk.need(&mut o, "conditions_matched"), o.at("conditions_matched"));
    if let Slot::Is(items) = walk.list(n, &at) {
        for (i, item) in items.iter().enumerate() {
            let Some(mut c) = walk.object(item, format!("{at}/{i}")) else { continue };
            let (n, at) = (walk.need(&mut c, "condition"), c.at("condition"));
            walk.text(n, &at);
            walk.nullable(&mut c, "actual_value");
            for words in ["description", "actual_words"] {
                let at = c.at(words);
                if let Some(mut d) = c.get(words).and_then(|n| walk.object(n, at)) {
                    for language in ["zh", "en"] {
                        let (n, at) = (walk.need(&mut d, language), d.at(language));
                        walk.text(n, &at);
                    }
                    walk.close(d, Severity::Warning);
                }
            }
            walk.close(c, Severity::Warning);
        }
    }
    for key in ["scenario_id", "episode_id", "target_id"] {
        let (n, at) = (o.get(key), o.at(key));
        walk.text(n, &at);
    }
    let (n, at) = (o.get("calibrated"), o.at("calibrated"));
    walk.flag(n, &at);
    let (n, at) = (o.get("ego_response"), o.at("ego_response"));
    if let Slot::Is(word) = walk.text(n, &at)
        && !RESPONSES.contains(&word)
    {
        walk.report(Finding::error("message.enum", at), &|| {
            Words::new(
                format!("'{word}' 不是 ego_response 的取值"),
                format!("'{word}' is not an ego_response value"),
            )
            .one_of(&RESPONSES.join("、"), &RESPONSES.join(", "))
        });
    }
    walk.close(o, Severity::Warning);
}

/// Matches by score. They may be of all that matched or of those returned; the sample in DATA_FORMAT.md 5.2
/// counts the returned.
fn statistics<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, total: Option<u64>, returned: Option<u64>) {
    const AT: &str = "/mining_result/statistics/score_distribution";
    let Some(mut o) = walk.object(node, "/mining_result/statistics".into()) else { return };
    let distribution = walk.need(&mut o, "score_distribution");
    let (n, at) = (o.get("uncalibrated"), o.at("uncalibrated"));
    walk.count(n, &at);
    walk.close(o, Severity::Warning);
    let Some(d) = distribution.and_then(|n| walk.object(n, AT.into())) else { return };
    let mut sum = Some(0);
    for e in d.entries() {
        let at = d.at(&e.key);
        let bounds =
            e.key.split_once('-').and_then(|(a, b)| Some((a.parse::<f64>().ok()?, b.parse::<f64>().ok()?)));
        if !bounds.is_some_and(|(a, b)| 0.0 <= a && a < b && b <= 1.0) {
            let key = &e.key;
            walk.report(Finding::error("message.result.statistics", at.clone()), &|| {
                Words::new(
                    format!("'{key}' 不是 0 至 1 之间的分数段"),
                    format!("'{key}' is not a range of scores between 0 and 1"),
                )
                .hint("写作 \"0.9-1.0\"", "write it as \"0.9-1.0\"")
            });
        }
        sum = match (sum, walk.count(Some(&e.node), &at).get()) {
            (Some(s), Some(n)) => Some(s + n),
            _ => None,
        };
    }
    let (Some(sum), Some(total), Some(returned)) = (sum, total, returned) else { return };
    if sum != total && sum != returned {
        walk.report(Finding::error("message.result.statistics", AT), &|| {
            Words::new(
                format!("分数分布合计 {sum}，既不等于匹配数 {total}，也不等于返回数 {returned}"),
                format!("the score distribution adds up to {sum}, neither the {total} matched nor the {returned} returned"),
            )
        });
    }
}

fn not_observable<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>) {
    let (n, at) = (parent.get("not_observable"), parent.at("not_observable"));
    let Slot::Is(items) = walk.list(n, &at) else { return };
    for (i, item) in items.iter().enumerate() {
        let Some(mut o) = walk.object(item, format!("{at}/{i}")) else { continue };
        let (n, at) = (walk.need(&mut o, "scenario_id"), o.at("scenario_id"));
        walk.text(n, &at);
        for key in ["drives", "missing_signals"] {
            let (n, at) = (walk.need(&mut o, key), o.at(key));
            walk.texts(n, &at);
        }
        walk.close(o, Severity::Warning);
    }
}
