//! Output of `whyroad mine`: results by class, totals, classes that are not observable, and the best matches of a
//! single question. No line is wider than 120 columns unless an id is: ids are whole, as other commands take them.

use crate::text_table::{Align, aligned, wrapped};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use whyroad_engine::output::{BestMatch, EpisodeExample, KeyframeSeconds, Question, Searched, Summary};
use whyroad_framework::Taxonomy;
use whyroad_framework::taxonomy::Resolution;
use whyroad_lake::mined::MiningQuestion;
use whyroad_model::messages::{CoverageState, LeafCoverage, MatchedCondition};
use whyroad_model::{Lang, ScenarioId, counted};

/// The results of a run.
pub(in crate::cmd) struct Results<'a> {
    pub summary: &'a Summary,
    /// The question as it was asked.
    pub asked: &'a MiningQuestion,
    pub questions: &'a [Question],
    pub searched: Searched,
    pub taxonomy: &'a Taxonomy,
    /// Leaves whose rule exists but cannot be used.
    pub faulty: &'a BTreeSet<ScenarioId>,
    pub lang: Lang,
}

/// Maximum number of leaves with a faulty rule that are named.
const NAMED: usize = 3;

impl Results<'_> {
    /// The text, with the text on what drives lack where that is asked for.
    pub fn text(&self, missing: Option<String>) -> String {
        let mut out = String::new();
        let found: Vec<&LeafCoverage> = self.rows(|l| l.state == CoverageState::Found);
        if !found.is_empty() {
            out += &self.found(&found);
            out.push('\n');
        }
        out += &wrapped(&self.totals(), 2);
        let gaps = self.gaps();
        if let Some(missing) = missing.filter(|_| !gaps.is_empty()) {
            out.push('\n');
            out += &missing;
        } else if !gaps.is_empty() {
            out += &wrapped(&self.not_observable(&gaps), 2);
        }
        if !self.summary.best.is_empty() {
            out.push('\n');
            self.best(&mut out);
        }
        out
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let class = |l: &&LeafCoverage| {
            let example = self.summary.examples.get(&l.scenario_id);
            json!({
                "scenario_id": l.scenario_id,
                "state": l.state,
                "episodes": l.episodes,
                "primary_episodes": l.primary_episodes,
                "drives_searched": l.drives_searched,
                "missing_signals": missing(l),
                "example": example.map(|e| json!({
                    "clip_id": e.clip_id,
                    "keyframe_s": e.at.keyframe_s,
                    "clip_s": e.at.clip_s,
                    "score": e.score,
                })),
            })
        };
        let classes: Vec<Value> = self.rows(|l| l.state != CoverageState::NoRule).iter().map(class).collect();
        json!({
            "drives": self.summary.drives,
            "left_out": self.summary.coverage.left_out,
            "episodes": self.summary.episodes,
            "primary_episodes": self.summary.primary_episodes,
            "classes": classes,
            "best": self.summary.best,
        })
    }

    /// Requested classes that some drive cannot show.
    pub fn gaps(&self) -> Vec<&LeafCoverage> {
        self.rows(|l| !l.gaps.is_empty())
    }

    /// Requested classes, in the order of the taxonomy.
    fn rows(&self, wanted: impl Fn(&LeafCoverage) -> bool) -> Vec<&LeafCoverage> {
        let coverage = &self.summary.coverage;
        let all = coverage.unresolved.iter().chain(&coverage.leaves);
        let mut rows: Vec<_> = all.filter(|l| wanted(l) && self.is_asked(&l.scenario_id)).collect();
        let order = self.taxonomy.ids();
        let place = |id: &ScenarioId| order.iter().position(|o| o == id).unwrap_or(usize::MAX);
        rows.sort_by_key(|l| place(&l.scenario_id));
        rows
    }

    /// Whether the question is about the class. Without named classes it is about all, also those without a rule: the
    /// questions are only about classes with one.
    fn is_asked(&self, id: &ScenarioId) -> bool {
        matches!(self.asked, MiningQuestion::Framework { scenarios } if scenarios.is_empty())
            || self.questions.iter().any(|q| id.is_within(&q.scenario))
    }

    fn found(&self, rows: &[&LeafCoverage]) -> String {
        let head = match self.lang {
            Lang::Zh => ["类别", "事件", "主要", "示例片段", "关键帧（片段内）"],
            Lang::En => ["class", "episodes", "primary", "example clip", "keyframe (in clip)"],
        };
        let mut lines = vec![head.map(str::to_owned)];
        for l in rows {
            let example = self.summary.examples.get(&l.scenario_id);
            let at = |e: &EpisodeExample| seconds(e.at);
            lines.push([
                self.short_id(&l.scenario_id),
                l.episodes.to_string(),
                l.primary_episodes.to_string(),
                example.map(|e| e.clip_id.to_string()).unwrap_or_default(),
                example.map(at).unwrap_or_default(),
            ]);
        }
        let columns = [Align::Left, Align::Right, Align::Right, Align::Left, Align::Left];
        aligned(columns, &lines)
    }

    /// `l2.l3` where that names the class, as every command accepts it.
    pub(super) fn short_id(&self, id: &ScenarioId) -> String {
        let parts: Vec<&str> = [id.l2.as_deref(), id.l3.as_deref()].into_iter().flatten().collect();
        let short = parts.join(".");
        match self.taxonomy.resolve(&short) {
            Resolution::Found(found) if found == *id => short,
            _ => id.to_string(),
        }
    }

    fn totals(&self) -> String {
        let s = self.summary;
        let (drives, episodes, primary) = (s.drives, s.episodes, s.primary_episodes);
        let totals = match self.lang {
            Lang::Zh => format!("{drives} 个行程，{episodes} 个事件（主要 {primary}）"),
            Lang::En => {
                format!("{}, {} ({primary} primary)", counted(drives, "drive"), counted(episodes, "episode"))
            }
        };
        let left_out = match (s.coverage.left_out.len(), self.lang) {
            (0, _) => String::new(),
            (n, Lang::Zh) => format!("；另有 {n} 个行程无法读取，内容未知"),
            (n, Lang::En) => format!("; {} could not be read: their content is unknown", counted(n, "drive")),
        };
        let totals = totals + &left_out;
        if self.searched == Searched::Question {
            return totals;
        }
        let asked = || s.coverage.leaves.iter().filter(|l| self.is_asked(&l.scenario_id));
        let count = |state: CoverageState| asked().filter(|l| l.state == state).count();
        let (found, none) = (count(CoverageState::Found), count(CoverageState::NotFound));
        let in_part = asked().filter(|l| l.state == CoverageState::NotFound && !l.gaps.is_empty()).count();
        let (blind, without) = (count(CoverageState::NotObservable), count(CoverageState::NoRule));
        let faulty: Vec<String> = asked()
            .filter(|l| l.state == CoverageState::NoRule && self.faulty.contains(&l.scenario_id))
            .map(|l| self.short_id(&l.scenario_id))
            .collect();
        let n = faulty.len();
        let more = if n > NAMED { ", ..." } else { "" };
        let named = faulty.into_iter().take(NAMED).collect::<Vec<_>>().join(", ");
        let faulty = match (n, self.lang) {
            (0, _) => String::new(),
            (_, Lang::Zh) => {
                format!("（其中 {n} 个的规则有错误，不可用：{named}{more}；它们的时刻可能列在所属的 L2 下）")
            }
            (_, Lang::En) => {
                format!(
                    " ({n} of them with a faulty rule: {named}{more}; moments of these may be listed as their L2)"
                )
            }
        };
        match self.lang {
            Lang::Zh => format!(
                "{totals}；L3 场景：找到 {found}，已搜索未找到 {none}（其中 {in_part} 个只搜索了部分行程），不可观测 {blind}，无规则 {without}{faulty}"
            ),
            Lang::En => format!(
                "{totals}; leaves: {found} found, {none} searched and not found ({in_part} of them on some drives only), {blind} not observable, {without} without a rule{faulty}"
            ),
        }
    }

    fn not_observable(&self, gaps: &[&LeafCoverage]) -> String {
        let nowhere = gaps.iter().filter(|l| l.drives_searched == 0).count();
        let parts = [(nowhere, "所有", "any drive"), (gaps.len() - nowhere, "部分", "some drives")];
        let parts = parts.into_iter().filter(|(classes, ..)| *classes > 0);
        match self.lang {
            Lang::Zh => {
                let parts: Vec<String> = parts
                    .map(|(classes, which, _)| format!("{classes} 个类别在{which}行程上因缺少信号而不可观测"))
                    .collect();
                format!("{}；加 --missing 再次运行可列出", parts.join("，"))
            }
            Lang::En => {
                let parts: Vec<String> = parts
                    .map(|(classes, _, which)| {
                        let are = if classes == 1 { "class is" } else { "classes are" };
                        format!("{classes} {are} not observable on {which}")
                    })
                    .collect();
                format!("{}, for lack of signals; --missing lists them", parts.join(" and "))
            }
        }
    }

    /// Where to find the answer to a single question.
    fn best(&self, out: &mut String) {
        let (best, matched) = (&self.summary.best, self.summary.matched);
        let shown = best.len();
        // A class's rule has many conditions: `explain` shows them over time.
        let with_values = self.searched == Searched::Question;
        let _ = match (self.lang, with_values) {
            (Lang::Zh, true) => {
                writeln!(
                    out,
                    "得分最高的 {shown} 个，共 {matched} 个：片段、关键帧（片段内）、目标、得分、关键帧处的值"
                )
            }
            (Lang::Zh, false) => {
                writeln!(out, "得分最高的 {shown} 个，共 {matched} 个：片段、关键帧（片段内）、目标、得分")
            }
            (Lang::En, true) => {
                writeln!(
                    out,
                    "the best {shown} of {matched}: clip, keyframe (in clip), target, score, values at the keyframe"
                )
            }
            (Lang::En, false) => {
                writeln!(out, "the best {shown} of {matched}: clip, keyframe (in clip), target, score")
            }
        };
        let line = |BestMatch { clip: c, at }: &BestMatch| {
            [
                c.clip_id.clone(),
                seconds(*at),
                c.target_id.clone().unwrap_or_else(|| "-".to_owned()),
                format!("{:.2}", c.match_score),
                c.scenario_id.as_ref().map(|id| self.short_id(id)).unwrap_or_default(),
            ]
        };
        let lines: Vec<[String; 5]> = best.iter().map(line).collect();
        let columns = [Align::Left, Align::Left, Align::Left, Align::Right, Align::Left];
        let table = aligned(columns, &lines);
        for (line, best) in table.lines().zip(best) {
            let _ = writeln!(out, "{line}");
            if with_values {
                let values: Vec<String> =
                    best.clip.conditions_matched.iter().map(|m| value(m, self.lang)).collect();
                let separator = if self.lang == Lang::Zh { "； " } else { "; " };
                out.push_str(&wrapped(&format!("    {}", values.join(separator)), 4));
            }
        }
    }
}

/// The time of a keyframe in its drive and, where that is another, in its clip.
fn seconds(at: KeyframeSeconds) -> String {
    let KeyframeSeconds { keyframe_s: drive, clip_s: clip } = at;
    if (drive - clip).abs() < 0.05 { format!("{drive:.1} s") } else { format!("{drive:.1} s ({clip:.1} s)") }
}

/// A condition in words with the measured value.
fn value(m: &MatchedCondition, lang: Lang) -> String {
    let condition = m.description.as_ref().map_or(m.condition.as_str(), |words| words.get(lang));
    let value = match (&m.actual_value, &m.actual_words) {
        (Value::Bool(_) | Value::Null, _) => return condition.to_owned(),
        (_, Some(words)) => words.get(lang).to_owned(),
        (value, None) => value.as_str().map_or_else(|| value.to_string(), str::to_owned),
    };
    match lang {
        Lang::Zh => format!("{condition}（{value}）"),
        Lang::En => format!("{condition} ({value})"),
    }
}

/// Signals that some drive lacked for a class, sorted, each once.
fn missing(l: &LeafCoverage) -> Vec<&str> {
    let mut out: Vec<&str> =
        l.gaps.iter().flat_map(|g| g.missing_signals.iter().map(String::as_str)).collect();
    out.sort_unstable();
    out.dedup();
    out
}
