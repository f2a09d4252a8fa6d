//! The figures of an evaluation, computed from the pairs.

use super::matching::{Moment, same_target};
use super::truth::{TruthEntry, TruthSet};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{DriveId, Nanos, ScenarioId, TrackId};

/// One class.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ClassFigures {
    /// Entries of the ground truth.
    pub truth: usize,
    /// Of those, the found ones.
    pub matched: usize,
    /// Entries not found.
    pub missed: usize,
    /// Episodes beyond the truth on drives where the class is declared complete.
    pub spurious: usize,
    /// Episodes beyond the truth elsewhere, and those that only an optional entry matches: neither right nor wrong.
    pub unjudged: usize,
    /// matched / (matched + spurious), both where the class is declared complete; `None` where the class is nowhere
    /// declared complete, or nothing could be counted.
    pub precision: Option<f64>,
    /// matched / truth; `None` without truth.
    pub recall: Option<f64>,
    /// Harmonic mean of the two; `None` where one is.
    pub f1: Option<f64>,
    /// Median distance of the keyframes of matched pairs, s.
    pub keyframe_error_median_s: Option<f64>,
    /// 90th percentile of the same, s.
    pub keyframe_error_p90_s: Option<f64>,
    /// Mean lateness (found minus true), s: a bias shows here.
    pub keyframe_lateness_mean_s: Option<f64>,
}

/// An entry without a match, but with an episode of another class at that moment.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Confusion {
    /// Class of the entry.
    pub truth: ScenarioId,
    /// Class of the episode.
    pub found: ScenarioId,
    /// How often.
    pub count: usize,
}

/// An entry that was not found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissedEntry {
    /// Class.
    pub scenario_id: ScenarioId,
    /// Drive.
    pub drive_id: DriveId,
    /// Target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_id: Option<TrackId>,
    /// Keyframe.
    pub keyframe: Nanos,
    /// Classes of the episodes there, best first.
    pub found_instead: Vec<ScenarioId>,
}

/// An episode beyond a complete truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpuriousEpisode {
    /// The episode.
    pub episode_id: String,
    /// Class.
    pub scenario_id: ScenarioId,
    /// Keyframe.
    pub keyframe: Nanos,
}

/// All figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Evaluation {
    /// Classes that the truth or the episodes on its drives name.
    #[serde(serialize_with = "by_name")]
    pub classes: BTreeMap<ScenarioId, ClassFigures>,
    /// All classes as one.
    pub total: ClassFigures,
    /// Mean F1 over the classes that occur in the truth and have one.
    pub macro_f1: Option<f64>,
    /// Over how many classes.
    pub macro_classes: usize,
    /// Median keyframe error over all pairs, s.
    pub keyframe_error_median_s: Option<f64>,
    /// Confusions of classes.
    pub confusions: Vec<Confusion>,
    /// Not found.
    pub missed: Vec<MissedEntry>,
    /// Spurious episodes.
    pub spurious: Vec<SpuriousEpisode>,
}

fn by_name<S: serde::Serializer>(map: &BTreeMap<ScenarioId, ClassFigures>, s: S) -> Result<S::Ok, S::Error> {
    s.collect_map(map.iter().map(|(k, v)| (k.to_string(), v)))
}

#[derive(Default)]
struct Tally {
    figures: ClassFigures,
    /// Matched where the class is declared complete: only these can be compared with the spurious ones.
    judged_matched: usize,
    judged: bool,
    lateness: Vec<f64>,
}

impl Tally {
    fn finish(self) -> ClassFigures {
        let Self { mut figures, judged_matched, judged, lateness } = self;
        let share = |part: usize, whole: usize| (whole > 0).then(|| part as f64 / whole as f64);
        figures.missed = figures.truth - figures.matched;
        figures.recall = share(figures.matched, figures.truth);
        figures.precision = share(judged_matched, judged_matched + figures.spurious);
        figures.f1 = match (figures.precision, figures.recall) {
            // No entry found, and no false episode: precision has no value, the harmonic mean is 0.
            (None, Some(0.0)) if judged => Some(0.0),
            (Some(p), Some(r)) if p + r > 0.0 => Some(2.0 * p * r / (p + r)),
            (Some(_), Some(_)) => Some(0.0),
            _ => None,
        };
        let errors: Vec<f64> = lateness.iter().map(|l| l.abs()).collect();
        figures.keyframe_error_median_s = quantile(&errors, 0.5);
        figures.keyframe_error_p90_s = quantile(&errors, 0.9);
        figures.keyframe_lateness_mean_s =
            (!lateness.is_empty()).then(|| lateness.iter().sum::<f64>() / lateness.len() as f64);
        figures
    }
}

/// Nearest-rank quantile; of an even number of values the median is the mean of the middle two.
fn quantile(values: &[f64], q: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    if n > 0 && q == 0.5 && n.is_multiple_of(2) {
        return Some((sorted[n / 2 - 1] + sorted[n / 2]) / 2.0);
    }
    let rank = ((n as f64 * q).ceil() as usize).clamp(1, n.max(1));
    sorted.get(rank - 1).copied()
}

/// The episodes, and the verdict on each.
pub(super) struct Outcome<'a> {
    /// All of them.
    pub episodes: &'a [EpisodeRecord],
    /// Paired with an entry.
    pub taken: &'a [bool],
    /// Paired with an optional entry, which counts neither way.
    pub open: &'a [bool],
}

/// `partner[i]` is the episode paired with `entries[i]`; optional entries are not among them.
pub(super) fn collect(
    truth: &TruthSet,
    entries: &[&TruthEntry],
    partner: &[Option<usize>],
    Outcome { episodes, taken, open }: &Outcome,
) -> Evaluation {
    let drives: BTreeSet<&DriveId> = truth
        .complete
        .iter()
        .flat_map(|c| &c.drives)
        .chain(truth.entries.iter().map(|e| &e.drive_id))
        .collect();
    let mut tallies: BTreeMap<ScenarioId, Tally> = BTreeMap::new();
    let mut out = Evaluation::default();
    let mut confused: BTreeMap<(ScenarioId, ScenarioId), usize> = BTreeMap::new();
    for (entry, partner) in entries.iter().zip(partner) {
        let tally = tallies.entry(entry.scenario_id.clone()).or_default();
        tally.figures.truth += 1;
        let complete = truth.is_complete(&entry.scenario_id, &entry.drive_id);
        tally.judged |= complete;
        let there = Moment::of_entry(entry);
        if let Some(e) = partner {
            tally.figures.matched += 1;
            tally.judged_matched += usize::from(complete);
            tally.lateness.push(there.lateness(&Moment::of_episode(&episodes[*e])));
            continue;
        }
        let mut instead: Vec<(f64, &EpisodeRecord)> = episodes
            .iter()
            .filter(|e| e.drive_id == entry.drive_id && e.is_primary && same_target(entry, e))
            .filter(|e| !e.scenario_id.is_within(&entry.scenario_id))
            .filter_map(|e| Some((there.match_error(&Moment::of_episode(e))?, e)))
            .collect();
        instead.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.scenario_id.cmp(&b.1.scenario_id)));
        if let Some((_, nearest)) = instead.first() {
            *confused.entry((entry.scenario_id.clone(), nearest.scenario_id.clone())).or_default() += 1;
        }
        out.missed.push(MissedEntry {
            scenario_id: entry.scenario_id.clone(),
            drive_id: entry.drive_id.clone(),
            target_id: entry.target_id.clone(),
            keyframe: entry.keyframe_ns,
            found_instead: instead.iter().map(|(_, e)| e.scenario_id.clone()).collect(),
        });
    }
    for (i, episode) in episodes.iter().enumerate() {
        if (taken[i] && !open[i]) || !drives.contains(&episode.drive_id) {
            continue;
        }
        let tally = tallies.entry(episode.scenario_id.clone()).or_default();
        if !open[i] && truth.is_complete(&episode.scenario_id, &episode.drive_id) {
            tally.judged = true;
            tally.figures.spurious += 1;
            out.spurious.push(SpuriousEpisode {
                episode_id: episode.episode_id.clone(),
                scenario_id: episode.scenario_id.clone(),
                keyframe: episode.keyframe.timestamp,
            });
        } else {
            tally.figures.unjudged += 1;
        }
    }
    let mut total = Tally::default();
    for tally in tallies.values() {
        let f = &tally.figures;
        total.judged |= tally.judged;
        total.judged_matched += tally.judged_matched;
        total.figures.truth += f.truth;
        total.figures.matched += f.matched;
        total.figures.spurious += f.spurious;
        total.figures.unjudged += f.unjudged;
        total.lateness.extend(&tally.lateness);
    }
    out.total = total.finish();
    out.classes = tallies.into_iter().map(|(id, t)| (id, t.finish())).collect();
    let f1: Vec<f64> = out.classes.values().filter(|c| c.truth > 0).filter_map(|c| c.f1).collect();
    out.macro_classes = f1.len();
    out.macro_f1 = (!f1.is_empty()).then(|| f1.iter().sum::<f64>() / f1.len() as f64);
    out.keyframe_error_median_s = out.total.keyframe_error_median_s;
    out.confusions =
        confused.into_iter().map(|((truth, found), count)| Confusion { truth, found, count }).collect();
    out.confusions
        .sort_by(|a, b| b.count.cmp(&a.count).then_with(|| (&a.truth, &a.found).cmp(&(&b.truth, &b.found))));
    out
}
