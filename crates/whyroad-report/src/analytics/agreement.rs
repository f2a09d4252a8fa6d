//! Agreement of people who labeled the same episode independently: labels as first submitted, before any check could
//! align them. Kappas are those of `whyroad_label::agreement`.

use super::decisions::{lateral, longitudinal};
use serde::Serialize;
use std::collections::BTreeMap;
use whyroad_label::agreement::{cohen, fleiss, median};
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
    // Pairs by person, so that the first and second rater are the same ones throughout.
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
            let items: Vec<Vec<String>> =
                groups.values().map(|g| g.iter().map(|(_, j)| of(j)).collect()).collect();
            let pairs: Vec<(String, String)> = items.iter().flat_map(|i| pairs(i)).collect();
            let same = pairs.iter().filter(|(a, b)| a == b).count() as f64;
            AgreementRow {
                measure,
                episodes: items.len() as u64,
                pairs: pairs.len() as u64,
                same: (!pairs.is_empty()).then(|| same / pairs.len() as f64),
                cohen: cohen(&pairs),
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
