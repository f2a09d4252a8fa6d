//! What `whyroad mine` prints: what was found by class, and the best matches of a single question.

use std::fmt::Write as _;
use whyroad_engine::output::{Question, Searched, Summary};
use whyroad_framework::Taxonomy;
use whyroad_model::messages::{CoverageState, MinedClip};
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{Lang, ScenarioId};

/// What was found, what was searched for in vain, what could not be decided.
pub(super) fn table(
    summary: &Summary,
    questions: &[Question],
    searched: Searched,
    taxonomy: &Taxonomy,
    lang: Lang,
) -> String {
    let asked =
        |id: &ScenarioId| questions.iter().any(|q| id.is_within(&q.scenario) || q.scenario.is_within(id));
    let mut out = String::new();
    let head = match lang {
        Lang::Zh => ["类别", "片段", "主要", "已搜行程", "缺少的信号"],
        Lang::En => ["class", "episodes", "primary", "drives searched", "missing signals"],
    };
    let _ = writeln!(out, "{:<52} {:>8} {:>8} {:>15}  {}", head[0], head[1], head[2], head[3], head[4]);
    let rows = summary.coverage.unresolved.iter().chain(&summary.coverage.leaves);
    let mut rows: Vec<_> =
        rows.filter(|l| l.state != CoverageState::NoRule && asked(&l.scenario_id)).collect();
    let order = taxonomy.ids();
    rows.sort_by_key(|l| order.iter().position(|id| *id == l.scenario_id));
    for l in rows {
        let mut missing: Vec<&str> =
            l.gaps.iter().flat_map(|g| g.missing_signals.iter().map(String::as_str)).collect();
        missing.sort_unstable();
        missing.dedup();
        let _ = writeln!(
            out,
            "{:<52} {:>8} {:>8} {:>15}  {}",
            l.scenario_id.to_string(),
            // "0" would claim that there are none.
            if l.state == CoverageState::NotObservable { "-".to_owned() } else { l.episodes.to_string() },
            if l.state == CoverageState::NotObservable {
                "-".to_owned()
            } else {
                l.primary_episodes.to_string()
            },
            format!("{}/{}", l.drives_searched, summary.drives),
            missing.join(", ")
        );
    }
    if searched == Searched::Framework {
        let _ = writeln!(out, "{}", leaves(summary, lang));
    } else {
        let _ = match lang {
            Lang::Zh => writeln!(out, "{} 个行程，{} 个片段", summary.drives, summary.episodes),
            Lang::En => writeln!(out, "{} drives, {} episodes", summary.drives, summary.episodes),
        };
    }
    if !summary.best.is_empty() {
        out.push('\n');
        best(&mut out, summary, searched, lang);
    }
    out
}

fn leaves(summary: &Summary, lang: Lang) -> String {
    let count = |s: CoverageState| summary.coverage.leaves.iter().filter(|l| l.state == s).count();
    let (found, none) = (count(CoverageState::Found), count(CoverageState::NotFound));
    let (blind, without) = (count(CoverageState::NotObservable), count(CoverageState::NoRule));
    let (drives, episodes) = (summary.drives, summary.episodes);
    match lang {
        Lang::Zh => format!(
            "{drives} 个行程，{episodes} 个片段；叶子类别：找到 {found}，搜索未见 {none}，不可观测 {blind}，尚无规则 {without}"
        ),
        Lang::En => format!(
            "{drives} drives, {episodes} episodes; leaves: {found} found, {none} searched and not found, {blind} not observable, {without} without a rule"
        ),
    }
}

/// Where the answer to a single question is to be looked at.
fn best(out: &mut String, summary: &Summary, searched: Searched, lang: Lang) {
    let (shown, matched) = (summary.best.len(), summary.matched);
    let clip_width = summary.best.iter().map(|c| c.clip_id.chars().count()).max().unwrap_or(0).max(4);
    let target = |c: &MinedClip| c.target_id.clone().unwrap_or_else(|| "-".to_owned());
    let target_width = summary.best.iter().map(|c| target(c).chars().count()).max().unwrap_or(0).max(6);
    // A class's rule has conditions by the dozen: `explain` shows them over time.
    let with_values = searched == Searched::Question;
    let _ = match (lang, with_values) {
        (Lang::Zh, true) => {
            writeln!(out, "得分最高的 {shown} 个，共 {matched} 个：片段、关键帧、目标、得分、关键帧处的值")
        }
        (Lang::Zh, false) => {
            writeln!(out, "得分最高的 {shown} 个，共 {matched} 个：片段、关键帧、目标、得分")
        }
        (Lang::En, true) => {
            writeln!(
                out,
                "the best {shown} of {matched}: clip, keyframe, target, score, values at the keyframe"
            )
        }
        (Lang::En, false) => writeln!(out, "the best {shown} of {matched}: clip, keyframe, target, score"),
    };
    for c in &summary.best {
        let seconds = f64::from(c.keyframe_suggestion.frame_idx) / FRAME_RATE_HZ;
        let class = c.scenario_id.as_ref().map(|id| format!("  {id}")).unwrap_or_default();
        let values: Vec<String> = c
            .conditions_matched
            .iter()
            .filter(|_| with_values)
            .map(|m| match &m.actual_value {
                serde_json::Value::Bool(_) | serde_json::Value::Null => m.condition.clone(),
                value => {
                    format!("{} ({})", m.condition, value.as_str().map_or(value.to_string(), str::to_owned))
                }
            })
            .collect();
        let line = format!(
            "{:<clip_width$}  {seconds:>5.1} s  {:<target_width$}  {:.2}{class}  {}",
            c.clip_id,
            target(c),
            c.match_score,
            values.join("; ")
        );
        let _ = writeln!(out, "{}", line.trim_end());
    }
}
