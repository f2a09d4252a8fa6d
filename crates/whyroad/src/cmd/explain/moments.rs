//! The decision moments of a clip: which class explains each, and for those that none explains, which come nearest.

use crate::cmd::other::moments;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use whyroad_engine::output::record::write_down;
use whyroad_framework::Framework;
use whyroad_mining::episode::find;
use whyroad_mining::fast::mine_drive;
use whyroad_mining::rule::OTHER;
use whyroad_mining::{Episode, Rule, RuleSet};
use whyroad_model::{Bilingual, ClipCut, ClipId, Lang, ScenarioId, SignalTable, counted};
use whyroad_report::coverage::class_title;
use whyroad_report::unexplained::{UnexplainedMoment, render_ego, render_moment};
use whyroad_signals::Catalog;

/// The decision moments of a clip.
#[derive(Serialize)]
pub(super) struct Moments {
    /// Those that no class explains.
    unexplained: Vec<UnexplainedMoment>,
    /// The others: seconds from the start of the clip, and the class of an episode near it or around it.
    explained: Vec<(f64, ScenarioId)>,
    /// Frames of the drive of those that no class explains.
    #[serde(skip)]
    pub frames: Vec<usize>,
    /// Displayed names of the classes.
    #[serde(skip)]
    names: BTreeMap<ScenarioId, Bilingual>,
}

impl Moments {
    /// Runs all rules of the framework on the drive. `rule` is that for decision moments.
    pub fn of(
        (framework, catalog): (&Framework, &Catalog),
        rule: &Rule,
        table: &SignalTable,
        clip: &ClipId,
    ) -> Self {
        let (mut rules, _) = RuleSet::of_framework(framework, catalog);
        rules.rules.retain(|r| r.on_demand().is_none());
        let classes = rules.rules.clone();
        let near = rules.precedence.neighbourhood.0;
        let found = mine_drive(&rules.with_decision_moments(catalog), table).episodes;
        let of_clip = clip.frames(&table.drive_id, &table.times).unwrap_or_default();
        let records = write_down(&found, &table.drive_id, &table.times, ClipCut::Fixed, Lang::En);
        let is_left = |e: &Episode| e.scenario.l1 == OTHER;
        let unexplained: Vec<UnexplainedMoment> = found
            .iter()
            .zip(&records)
            .filter(|(e, _)| is_left(e) && of_clip.contains(e.keyframe))
            .map(|(_, r)| moments::of_record(&r.record, clip, &classes, table))
            .collect();
        let left = found.iter().filter(|e| is_left(e) && of_clip.contains(e.keyframe));
        let frames = left.map(|e| e.keyframe).collect();
        let explains = |moment: usize, e: &Episode| {
            let apart = (table.times[e.keyframe].0 - table.times[moment].0).abs();
            apart < near || (e.range.contains(moment) && !is_left(e))
        };
        let all = find(rule, table).episodes.into_iter().map(|e| e.keyframe);
        let explained = all.filter(|m| of_clip.contains(*m)).filter_map(|m| {
            let by = found.iter().filter(|e| explains(m, e)).min_by_key(|e| e.keyframe.abs_diff(m))?;
            let at = table.times[m].seconds_since(table.times[of_clip.start]);
            (!is_left(by)).then(|| (at, by.scenario.clone()))
        });
        let names = classes.iter().map(|r| &r.scenario);
        let names = names.map(|id| (id.clone(), class_title(&framework.taxonomy, id))).collect();
        Self { explained: explained.collect(), unexplained, frames, names }
    }

    /// True where the clip has decision moments, and classes explain all of them.
    pub fn all_explained(&self) -> bool {
        self.unexplained.is_empty() && !self.explained.is_empty()
    }

    /// The outcome in a sentence; `shown` is the frame of the clip that is explained, and its time in seconds. None
    /// without decision moments.
    pub fn outcome(&self, shown: Option<(usize, f64)>, lang: Lang) -> Option<String> {
        let (left, explained) = (self.unexplained.len(), self.explained.len());
        if left == 0 {
            return (explained > 0).then(|| match lang {
                Lang::Zh => format!("没有：片段中的 {explained} 个决策时刻都有类别解释"),
                Lang::En if explained == 1 => "none: a class explains the only decision moment".to_owned(),
                Lang::En => format!("none: classes explain all {explained} decision moments"),
            });
        }
        let times: Vec<String> = self.unexplained.iter().map(|m| format!("{:.1} s", m.clip_s)).collect();
        let shown = shown.filter(|_| left > 1).map(|(frame, seconds)| match lang {
            Lang::Zh => format!("；以下为 {seconds:.1} s（第 {frame} 帧）"),
            Lang::En => format!("; shown: {seconds:.1} s (frame {frame})"),
        });
        let shown = shown.unwrap_or_default();
        Some(match lang {
            Lang::Zh => format!("没有类别能解释的时刻 {left} 个：{}{shown}", times.join("、")),
            Lang::En => {
                format!("{} that no class explains: {}{shown}", counted(left, "moment"), times.join(", "))
            }
        })
    }

    /// The text below the chart.
    pub fn text(&self, lang: Lang) -> String {
        let zh = lang == Lang::Zh;
        let name =
            |id: &ScenarioId| self.names.get(id).map_or_else(|| id.to_string(), |n| n.get(lang).to_owned());
        let mut out = String::new();
        if !self.explained.is_empty() {
            out +=
                if zh { "\n已有类别解释的时刻：\n" } else { "\nMoments that a class explains:\n" };
            for (at, class) in &self.explained {
                let _ = writeln!(out, "   {at:.1} s  {} ({class})", name(class));
            }
        }
        let left = self.unexplained.len();
        let _ = match lang {
            Lang::Zh => writeln!(out, "\n没有类别能解释的时刻：{left} 个"),
            Lang::En => writeln!(out, "\nMoments that no class explains: {left}"),
        };
        for m in &self.unexplained {
            let (at, ego) = (m.clip_s, render_ego(m, lang));
            let _ = match lang {
                Lang::Zh => writeln!(out, "\n{at:.1} s  自车 {ego}；最接近的类别："),
                Lang::En => writeln!(out, "\n{at:.1} s  ego {ego}; nearest classes:"),
            };
            out += &render_moment(m, lang, name);
        }
        out
    }
}
