//! Agreement of mining with itself when a log is perturbed: episodes of the original drive against those of the
//! perturbed drive, by class. Perturbation and mining are done elsewhere; this module counts and shows the results.

mod page;
mod text;

pub use page::page;
pub use text::{Shown, render};

use crate::evaluation::matching::{Moment, pairs};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::{Bilingual, DriveId, Nanos, ScenarioId, TrackId};

/// The compared part of an episode.
#[derive(Clone, Debug)]
pub struct Occurrence {
    /// Class.
    pub scenario: ScenarioId,
    /// Target and the objects in other roles, by their ids in the original drive.
    pub objects: Vec<TrackId>,
    /// First moment.
    pub start: Nanos,
    /// The keyframe.
    pub keyframe: Nanos,
    /// One past the last moment.
    pub end: Nanos,
}

/// Counts of one class under one perturbation.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ClassAgreement {
    /// Episodes of the original drives.
    pub before: usize,
    /// Episodes of the perturbed drives.
    pub after: usize,
    /// Episodes of both that are the same.
    pub same: usize,
    /// `2 same / (before + after)`: 1 when nothing changed.
    pub agreement: f64,
    /// `after / before`; `None` where there was none before.
    pub ratio: Option<f64>,
    /// Median distance of the keyframes of episodes that are the same, s.
    pub keyframe_shift_s: Option<f64>,
    #[serde(skip)]
    shifts: Vec<f64>,
}

/// Which of the two has an episode that the other lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Only the original drive.
    Lost,
    /// Only the perturbed drive.
    New,
}

/// An episode that is found in only one of the two.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Which one has it.
    pub change: Change,
    /// Class.
    pub scenario: ScenarioId,
    /// Drive.
    pub drive: DriveId,
    /// Target and the objects in other roles, by their ids in the original drive.
    pub objects: Vec<TrackId>,
    /// Its keyframe, s since the first frame of the drive.
    pub keyframe_s: f64,
}

/// One perturbation.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PerturbationAgreement {
    /// Its name.
    pub name: String,
    /// Its description.
    pub meaning: Bilingual,
    /// All classes together.
    pub all: ClassAgreement,
    /// By class.
    pub classes: BTreeMap<ScenarioId, ClassAgreement>,
    /// Episodes that are not the same, by drive as compared, then class.
    pub differences: Vec<Difference>,
}

/// All perturbations of a lake.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Robustness {
    /// Drives that were compared.
    pub drives: usize,
    /// Drives that could not be read, or were not reached before the run was interrupted.
    pub left_out: usize,
    /// Seed of the perturbations.
    pub seed: u64,
    /// The perturbations in the order requested.
    pub perturbations: Vec<PerturbationAgreement>,
}

/// Episodes with fewer than this many before and after are not enough to judge a class.
pub const FEW: usize = 5;

impl Robustness {
    /// An empty comparison.
    pub fn new(seed: u64, perturbations: impl IntoIterator<Item = (String, Bilingual)>) -> Self {
        let one = |(name, meaning)| PerturbationAgreement { name, meaning, ..Default::default() };
        Self { seed, perturbations: perturbations.into_iter().map(one).collect(), ..Self::default() }
    }

    /// Adds one drive, which begins at `start`: its episodes, and those of each perturbation in order.
    pub fn add(&mut self, drive: (&DriveId, Nanos), before: &[Occurrence], after: &[Vec<Occurrence>]) {
        self.drives += 1;
        for (of, after) in self.perturbations.iter_mut().zip(after) {
            of.add(drive, before, after);
        }
    }

    /// Completes the figures.
    pub fn finish(&mut self) {
        for of in &mut self.perturbations {
            of.all = ClassAgreement::default();
            for class in of.classes.values_mut() {
                class.finish();
                of.all.before += class.before;
                of.all.after += class.after;
                of.all.same += class.same;
                of.all.shifts.extend_from_slice(&class.shifts);
            }
            of.all.finish();
        }
    }

    /// The lowest agreement of a perturbation over all classes; 1 where there is nothing to compare.
    pub fn least(&self) -> f64 {
        self.perturbations.iter().map(|p| p.all.agreement).fold(1.0, f64::min)
    }

    /// Classes with at least [`FEW`] episodes that became more than `limit` times as frequent: perturbation, class,
    /// ratio.
    pub fn more_frequent(&self, limit: f64) -> Vec<(&str, &ScenarioId, f64)> {
        let mut out = Vec::new();
        for p in &self.perturbations {
            for (id, c) in p.classes.iter().filter(|(_, c)| c.after >= FEW) {
                let ratio = c.ratio.unwrap_or(f64::INFINITY);
                if ratio > limit {
                    out.push((p.name.as_str(), id, ratio));
                }
            }
        }
        out
    }
}

impl PerturbationAgreement {
    fn add(&mut self, (drive, start): (&DriveId, Nanos), before: &[Occurrence], after: &[Occurrence]) {
        let classes: BTreeSet<&ScenarioId> = before.iter().chain(after).map(|e| &e.scenario).collect();
        for class in classes {
            let [old, new] =
                [before, after].map(|all| all.iter().filter(|e| e.scenario == *class).collect::<Vec<_>>());
            let moment = |e: &Occurrence| Moment::new(e.start, e.keyframe, e.end);
            let matched = pairs(old.len(), new.len(), |a, b| {
                let (a, b) = (old[a], new[b]);
                if a.objects == b.objects { moment(a).match_error(&moment(b)) } else { None }
            });
            let count = self.classes.entry(class.clone()).or_default();
            count.before += old.len();
            count.after += new.len();
            count.same += matched.len();
            let shift = |(a, b): &(usize, usize)| moment(old[*a]).lateness(&moment(new[*b])).abs();
            count.shifts.extend(matched.iter().map(shift));
            let difference = |change: Change, e: &Occurrence| Difference {
                change,
                scenario: class.clone(),
                drive: drive.clone(),
                objects: e.objects.clone(),
                keyframe_s: e.keyframe.seconds_since(start),
            };
            let (kept, found): (BTreeSet<_>, BTreeSet<_>) = matched.iter().copied().unzip();
            let lost = (0..old.len()).filter(|i| !kept.contains(i)).map(|i| (Change::Lost, old[i]));
            let new = (0..new.len()).filter(|i| !found.contains(i)).map(|i| (Change::New, new[i]));
            self.differences.extend(lost.chain(new).map(|(change, e)| difference(change, e)));
        }
    }
}

impl ClassAgreement {
    fn finish(&mut self) {
        let all = self.before + self.after;
        self.agreement = if all == 0 { 1.0 } else { 2.0 * self.same as f64 / all as f64 };
        self.ratio = (self.before > 0).then(|| self.after as f64 / self.before as f64);
        self.shifts.sort_by(f64::total_cmp);
        self.keyframe_shift_s = self.shifts.get(self.shifts.len() / 2).copied();
    }
}

#[cfg(test)]
mod tests;
