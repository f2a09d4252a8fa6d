//! From judged episodes to the shares that mining uses as scores (`schema/calibration.yaml`), and the errors of such
//! shares on held-out episodes.
//!
//! Shares by class are estimates of few examples, so each is drawn towards a prior (m-estimate, Cestnik 1990): a class
//! towards all classes, a step of the margin score towards its class, or both towards an earlier table. Steps are
//! tenths of the margin score with enough episodes each (histogram binning, Zadrozny and Elkan 2001), made monotone by
//! pooling adjacent violators (isotonic regression, Ayer et al. 1955; Zadrozny and Elkan 2002). A logistic curve (Platt
//! 1999) is not used: rules that compare no numbers have one score only, and most classes have too few wrong episodes
//! to fit two parameters.

mod error;
mod text;

pub use error::{CalibrationError, held_out, measure};
pub use text::render;

use crate::evaluation::{judge, truth::TruthSet};
use crate::shares::{Block, pooled, wilson};
use crate::verdicts::VerdictLine;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::Calibration;
use whyroad_framework::calibration::{
    CalibrationSource, CalibrationStep, ClassCalibration, LEAST_JUDGED, SourceKind,
};
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{DriveId, ScenarioId};

/// The prior counts as this many episodes.
pub const PRIOR_EPISODES: f64 = 4.0;
/// An earlier table counts as at most this many episodes per class and step: its drives may differ from the drives that
/// are judged now (power prior, Ibrahim and Chen 2000).
pub const TABLE_EPISODES: f64 = 10.0;
/// A step has at least this many judged episodes, where the class has.
pub const STEP_EPISODES: usize = 10;
/// Least margin score, of conditions that are only just met.
const LEAST_SCORE: f64 = 0.5;

/// An episode with a judgment whether its class is right.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedEpisode {
    /// Class as mined.
    pub scenario_id: ScenarioId,
    /// Drive.
    pub drive_id: DriveId,
    /// How far its conditions are exceeded.
    pub margin_score: f64,
    /// Whether the class is right.
    pub right: bool,
}

impl JudgedEpisode {
    /// `None` for an episode whose margin score is not known.
    fn of(e: &EpisodeRecord, right: bool) -> Option<Self> {
        // Folders of versions without calibration have the margin score as the score.
        let margin_score = e.margin_score.or((e.calibrated != Some(true)).then_some(e.score))?;
        let (scenario_id, drive_id) = (e.scenario_id.clone(), e.drive_id.clone());
        Some(Self { scenario_id, drive_id, margin_score, right })
    }
}

/// Episodes that ground truth judges: where their class is declared complete.
pub fn judged_by_truth(truth: &TruthSet, episodes: &[EpisodeRecord]) -> Vec<JudgedEpisode> {
    let judged = episodes.iter().zip(judge(truth, episodes));
    judged.filter_map(|(e, right)| JudgedEpisode::of(e, right?)).collect()
}

/// Episodes that people gave a verdict on, once per verdict; and the ids of verdicts whose episode is not among
/// `episodes`.
pub fn judged_by_verdicts(
    verdicts: &[VerdictLine],
    episodes: &[EpisodeRecord],
) -> (Vec<JudgedEpisode>, BTreeSet<String>) {
    let by_id: BTreeMap<&str, &EpisodeRecord> = episodes.iter().map(|e| (e.episode_id.as_str(), e)).collect();
    let (mut judged, mut missing) = (Vec::new(), BTreeSet::new());
    for v in verdicts {
        match by_id.get(v.episode_id.as_str()).and_then(|e| JudgedEpisode::of(e, v.is_right())) {
            Some(e) => judged.push(e),
            None => {
                missing.insert(v.episode_id.clone());
            }
        }
    }
    (judged, missing)
}

/// Summary of judged episodes.
pub fn source(name: &str, kind: SourceKind, judged: &[JudgedEpisode]) -> CalibrationSource {
    CalibrationSource {
        name: name.to_owned(),
        kind,
        drives: judged.iter().map(|e| &e.drive_id).collect::<BTreeSet<_>>().len(),
        judged: judged.len(),
        right: judged.iter().filter(|e| e.right).count(),
    }
}

/// The table of these episodes. Classes of `earlier` with few new episodes are not changed.
pub fn fit(
    judged: &[JudgedEpisode],
    earlier: Option<&Calibration>,
    sources: Vec<CalibrationSource>,
) -> Calibration {
    let mut by_class: BTreeMap<&ScenarioId, Vec<&JudgedEpisode>> = BTreeMap::new();
    for e in judged {
        by_class.entry(&e.scenario_id).or_default().push(e);
    }
    // Rule of succession: without any episode, one half.
    let right = judged.iter().filter(|e| e.right).count();
    let of_all = (right as f64 + 1.0) / (judged.len() as f64 + 2.0);
    let known = |id: &ScenarioId| earlier.and_then(|t| t.class(id)).filter(|c| !c.steps.is_empty());
    let mut classes: BTreeMap<ScenarioId, ClassCalibration> =
        earlier.into_iter().flat_map(|t| &t.classes).map(|c| (c.id.clone(), c.clone())).collect();
    for (id, episodes) in by_class {
        let prior = known(id);
        if prior.is_some_and(ClassCalibration::is_usable) && episodes.len() < LEAST_JUDGED {
            continue;
        }
        classes.insert(id.clone(), one_class(id, &episodes, prior, of_all));
    }
    Calibration { version: "1.0.0".to_owned(), sources, classes: classes.into_values().collect() }
}

fn one_class(
    id: &ScenarioId,
    episodes: &[&JudgedEpisode],
    earlier: Option<&ClassCalibration>,
    of_all: f64,
) -> ClassCalibration {
    let judged = episodes.len();
    let right = episodes.iter().filter(|e| e.right).count();
    let of_class = drawn((right, judged), of_all, PRIOR_EPISODES);
    let blocks = binned(episodes).into_iter().map(|bin| {
        let right = bin.episodes.iter().filter(|e| e.right).count();
        let counts = (right, bin.episodes.len());
        let (prior, weight) = match earlier {
            Some(table) => {
                let shares = bin.episodes.iter().filter_map(|e| table.share_at(e.margin_score));
                let mean = shares.sum::<f64>() / counts.1 as f64;
                (mean, TABLE_EPISODES.min(table.judged as f64))
            }
            None => (of_class, PRIOR_EPISODES),
        };
        let weight_of_all = counts.1 as f64 + weight;
        let sum = drawn(counts, prior, weight) * weight_of_all;
        Block { from: bin.from, sum, weight: weight_of_all, right: counts.0, judged: counts.1 }
    });
    let step = |b: Block| CalibrationStep {
        from: b.from,
        share: to_decimals(b.sum / b.weight),
        judged: b.judged,
        right: b.right,
    };
    let mut steps: Vec<CalibrationStep> = pooled(blocks).into_iter().map(step).collect();
    // One step is the class, whose share is drawn towards that of all classes, once.
    if let ([only], None) = (&mut steps[..], earlier) {
        only.share = to_decimals(of_class);
    }
    ClassCalibration {
        id: id.clone(),
        judged,
        right,
        interval: wilson(right, judged).map(to_decimals),
        steps,
    }
}

/// A share of (right, all), drawn towards `prior` which counts as this many additional episodes.
fn drawn((right, all): (usize, usize), prior: f64, episodes: f64) -> f64 {
    (right as f64 + episodes * prior) / (all as f64 + episodes)
}

fn to_decimals(x: f64) -> f64 {
    (x * 1e4).round() / 1e4
}

struct Bin<'a> {
    from: f64,
    episodes: Vec<&'a JudgedEpisode>,
}

/// Tenths of the margin score, neighbors merged until each has enough episodes.
fn binned<'a>(episodes: &[&'a JudgedEpisode]) -> Vec<Bin<'a>> {
    let mut tenths: BTreeMap<u32, Vec<&JudgedEpisode>> = BTreeMap::new();
    for e in episodes {
        // A score of 0.7 is not below 0.7 because of the last bit of a product.
        let tenth = ((e.margin_score.clamp(LEAST_SCORE, 1.0) * 10.0) + 1e-9).floor().min(9.0) as u32;
        tenths.entry(tenth).or_default().push(e);
    }
    let mut bins: Vec<Bin<'a>> = Vec::new();
    for (tenth, episodes) in tenths {
        match bins.last_mut().filter(|b| b.episodes.len() < STEP_EPISODES) {
            Some(short) => short.episodes.extend(episodes),
            None => bins.push(Bin { from: f64::from(tenth) / 10.0, episodes }),
        }
    }
    if let [.., before, last] = &mut bins[..]
        && last.episodes.len() < STEP_EPISODES
    {
        before.episodes.append(&mut last.episodes);
        bins.pop();
    }
    if let Some(first) = bins.first_mut() {
        first.from = LEAST_SCORE;
    }
    bins
}

#[cfg(test)]
mod tests;
