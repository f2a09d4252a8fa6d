//! Agreement of people who labeled the same episode independently: labels as first submitted, before any check could
//! align them. Kappas are those of `whyroad_label::agreement`.

use super::decisions::{lateral, longitudinal};
use serde::Serialize;
use std::collections::BTreeMap;
use whyroad_label::agreement::{cohen_pooled, fleiss, median};
use whyroad_label::facts::{Judgement, TaskFacts};

/// The compared field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// The class.
    Class,
    /// The longitudinal decision.
    Longitudinal,
    /// The lateral decision with its side.
    Lateral,
    /// The keyframe.
    Keyframe,
}

impl Measure {
    /// Its id.
    pub fn id(self) -> &'static str {
        match self {
            Measure::Class => "class",
            Measure::Longitudinal => "longitudinal",
            Measure::Lateral => "lateral",
            Measure::Keyframe => "keyframe",
        }
    }

    /// Its displayed name, Chinese and English.
    pub fn name(self) -> (&'static str, &'static str) {
        match self {
            Measure::Class => ("场景", "class"),
            Measure::Longitudinal => ("纵向决策", "longitudinal decision"),
            Measure::Lateral => ("横向决策", "lateral decision"),
            Measure::Keyframe => ("关键帧（0.5 s 内为相同）", "keyframe (same: within 0.5 s)"),
        }
    }
}

/// One measure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AgreementRow {
    /// The compared field.
    pub measure: Measure,
    /// Episodes with two labels or more.
    pub episodes: u64,
    /// Pairs of labels.
    pub pairs: u64,
    /// Share of pairs that agree; for keyframes, those within half a second.
    pub same: Option<f64>,
    /// Cohen's kappa over all pairs; `None` where chance alone would always agree.
    pub cohen: Option<f64>,
    /// Fleiss' kappa over episodes.
    pub fleiss: Option<f64>,
    /// Median distance of keyframes, s.
    pub median_s: Option<f64>,
}

/// Maximum difference of keyframes that count as the same, s.
const SAME_KEYFRAME_S: f64 = 0.5;

/// A row for each measure; no rows without an episode that two people labeled.
pub(super) fn rows(tasks: &[TaskFacts]) -> Vec<AgreementRow> {
    let mut groups: BTreeMap<&str, Vec<(&str, &Judgement)>> = BTreeMap::new();
    for t in tasks {
        if let Some(first) = &t.first {
            let author = t.author.as_deref().unwrap_or_default();
            groups.entry(&t.episode).or_default().push((author, first));
        }
    }
    groups.retain(|_, g| g.len() > 1);
    // For the sake of a repeatable order.
    groups.values_mut().for_each(|g| g.sort());
    if groups.is_empty() {
        return vec![];
    }
    let word = |measure: Measure| -> fn(&Judgement) -> String {
        match measure {
            Measure::Class => |j| j.scenario.as_ref().map(ToString::to_string).unwrap_or_default(),
            Measure::Longitudinal => |j| longitudinal(j).unwrap_or_default(),
            _ => |j| lateral(j).unwrap_or_default(),
        }
    };
    let mut out: Vec<AgreementRow> = [Measure::Class, Measure::Longitudinal, Measure::Lateral]
        .into_iter()
        .map(|measure| {
            let of = word(measure);
            let rated: Vec<Vec<(&str, String)>> =
                groups.values().map(|g| g.iter().map(|(who, j)| (*who, of(j))).collect()).collect();
            let items: Vec<Vec<&str>> =
                rated.iter().map(|g| g.iter().map(|(_, value)| value.as_str()).collect()).collect();
            let pairs: Vec<_> = rated.iter().flat_map(|i| pairs(i)).collect();
            let same = pairs.iter().filter(|(a, b)| a.1 == b.1).count() as f64;
            AgreementRow {
                measure,
                episodes: items.len() as u64,
                pairs: pairs.len() as u64,
                same: (!pairs.is_empty()).then(|| same / pairs.len() as f64),
                cohen: cohen_pooled(&pairs),
                fleiss: fleiss(&items),
                median_s: None,
            }
        })
        .collect();
    let keyframes: Vec<Vec<_>> =
        groups.values().map(|g| g.iter().filter_map(|(_, j)| j.keyframe).collect()).collect();
    let away: Vec<f64> =
        keyframes.iter().flat_map(|k| pairs(k)).map(|(a, b)| a.seconds_since(b).abs()).collect();
    let near = away.iter().filter(|d| **d <= SAME_KEYFRAME_S).count() as f64;
    out.push(AgreementRow {
        measure: Measure::Keyframe,
        episodes: keyframes.iter().filter(|k| k.len() > 1).count() as u64,
        pairs: away.len() as u64,
        same: (!away.is_empty()).then(|| near / away.len() as f64),
        cohen: None,
        fleiss: None,
        median_s: median(away),
    });
    out
}

fn pairs<T: Clone>(of: &[T]) -> Vec<(T, T)> {
    of.iter().enumerate().flat_map(|(i, a)| of[i + 1..].iter().map(move |b| (a.clone(), b.clone()))).collect()
}
