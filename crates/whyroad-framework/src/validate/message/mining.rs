//! The mining interface: query and result (DATA_FORMAT.md 5). Whether a query's fields are signals is asked by
//! whyroad-mining, which knows them.

use super::{out_of_range, scenario_id, share};
use crate::taxonomy::did_you_mean;
use crate::validate::class_index::ClassIndex;
use crate::validate::json::{Kind, Node};
use crate::validate::rules::{Finding, Sink, Words};
use crate::validate::view::Slot;
use crate::validate::walk::{Object, Walk};
use whyroad_model::Severity;
use whyroad_model::units::UNITS;

const OPERATORS: &[&str] = &[">", ">=", "<", "<=", "==", "!=", "in"];

pub(super) fn query<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, classes: &ClassIndex) {
    let Some(mut o) = walk.object(node, "/mining_query".into()) else { return };
    let (n, at) = (o.get("query_id"), o.at("query_id"));
    walk.text(n, &at);
    let n = walk.need(&mut o, "scenario_id");
    scenario_id(walk, n, "/mining_query/scenario_id", classes);
    let (n, at) = (walk.need(&mut o, "conditions"), o.at("conditions"));
    if let Slot::Is(items) = walk.list(n, &at) {
        for (i, item) in items.iter().enumerate() {
            condition(walk, item, format!("{at}/{i}"));
        }
    }
    if let Some(n) = o.get("time_constraints") {
        time_constraints(walk, n);
    }
    let (n, at) = (o.get("output_limit"), o.at("output_limit"));
    walk.frame(n, &at);
    // A misspelt field of a query would silently ask another question.
    walk.close(o, Severity::Error);
}

fn condition<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, pointer: String) {
    let Some(mut o) = walk.object(node, pointer) else { return };
    let (n, at) = (walk.need(&mut o, "field"), o.at("field"));
    walk.text(n, &at);
    let (n, at) = (walk.need(&mut o, "operator"), o.at("operator"));
    let operator = walk.text(n, &at).get();
    if let Some(op) = operator.filter(|op| !OPERATORS.contains(op)) {
        walk.report(Finding::error("message.enum", at), &|| {
            let words = Words::new(format!("'{op}' 不是比较符"), format!("'{op}' is not an operator"));
            let meant = match op {
                "=" | "===" | "eq" => Some("=="),
                "≥" | "=>" => Some(">="),
                "≤" | "=<" => Some("<="),
                "<>" | "≠" => Some("!="),
                _ => None,
            };
            match meant {
                Some(m) => words.hint(format!("是否想写 '{m}'？"), format!("did you mean '{m}'?")),
                None => words.hint(
                    format!("可选：{}", OPERATORS.join(" ")),
                    format!("choose one of: {}", OPERATORS.join(" ")),
                ),
            }
        });
    }
    let (n, at) = (walk.need(&mut o, "value"), o.at("value"));
    if let Some(n) = n {
        let plain = |n: &Node<'_>| matches!(n.kind, Kind::Number(_) | Kind::Text(_) | Kind::Flag(_));
        let fits = match (&n.kind, operator) {
            (Kind::List(items), Some("in") | None) => items.iter().all(plain),
            (Kind::List(_), _) | (Kind::Map(_) | Kind::Null, _) => false,
            (Kind::Text(_) | Kind::Flag(_), Some(">" | ">=" | "<" | "<=")) => false,
            (_, Some("in")) => false,
            _ => true,
        };
        if !fits {
            let op = operator.unwrap_or_default();
            walk.report(Finding::error("message.query.value", at), &|| {
                Words::new(
                    format!("该值不能用于比较符 '{op}'"),
                    format!("this value does not go with the operator '{op}'"),
                )
                .hint("大小比较用数字，in 用列表", "numbers for < and >, a list for in")
            });
        }
    }
    let (n, at) = (o.get("unit"), o.at("unit"));
    if let Some(unit) = walk.any_text(n, &at).get().filter(|u| UNITS.iter().all(|k| k.symbol != *u)) {
        walk.report(Finding::error("message.query.unit", at), &|| {
            let words = Words::new(format!("未知单位 '{unit}'"), format!("unknown unit '{unit}'"));
            let symbols: Vec<&str> = UNITS.iter().map(|u| u.symbol).filter(|s| !s.is_empty()).collect();
            match did_you_mean(&unit.to_lowercase(), symbols.iter().copied()) {
                Some(m) => words.hint(format!("是否想写 '{m}'？"), format!("did you mean '{m}'?")),
                None => words.hint(
                    format!("可选：{}", symbols.join("、")),
                    format!("choose one of: {}", symbols.join(", ")),
                ),
            }
        });
    }
    walk.close(o, Severity::Error);
}

fn time_constraints<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>) {
    let Some(mut o) = walk.object(node, "/mining_query/time_constraints".into()) else { return };
    let mut seconds = |walk: &mut Walk<'d>, key| {
        let (n, at) = (o.get(key), o.at(key));
        let v = walk.number(n, &at).get()?;
        if v < 0.0 {
            out_of_range(walk, &at, &v.to_string(), "不小于 0", "0 or more");
        }
        Some((v, at))
    };
    let (min, max) = (seconds(walk, "condition_duration_min"), seconds(walk, "condition_duration_max"));
    if let (Some((min, _)), Some((max, at))) = (min, max)
        && min > max
    {
        walk.report(Finding::error("message.order", at), &|| {
            Words::new(
                format!("最长 {max} s 短于最短 {min} s"),
                format!("the maximum {max} s is less than the minimum {min} s"),
            )
        });
    }
    walk.close(o, Severity::Error);
}

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

/// The list against the number that is stated for it; a shorter list may be an excerpt.
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
            walk.close(c, Severity::Warning);
        }
    }
    for key in ["scenario_id", "episode_id", "target_id"] {
        let (n, at) = (o.get(key), o.at(key));
        walk.text(n, &at);
    }
    walk.close(o, Severity::Warning);
}

/// Matches by score. They may be of all that matched or of those returned; the sample in DATA_FORMAT.md 5.2
/// counts the returned.
fn statistics<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, total: Option<u64>, returned: Option<u64>) {
    const AT: &str = "/mining_result/statistics/score_distribution";
    let Some(mut o) = walk.object(node, "/mining_result/statistics".into()) else { return };
    let distribution = walk.need(&mut o, "score_distribution");
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
                    format!("'{key}' is no range of scores between 0 and 1"),
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
