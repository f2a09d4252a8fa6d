//! Two sets of episodes over the same drives compared: episodes gained, lost, reclassified, moved in time, or with
//! another primary class. Used for two mined folders, two versions of the rules, and the samples of two releases.
//!
//! An episode of one side and an episode of the other are the same moment when they are on one drive and target and
//! [`Moment::match_error`] says so. Pairs of one class are made first; the remaining episodes are paired across
//! classes.

mod page;
mod text;

pub use page::{PageHead, render_page};
pub use text::render;

use crate::evaluation::matching::{Moment, pairs};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{DriveId, ScenarioId};

/// Keyframes that differ by more than this count as moved, s: half a frame at 10 Hz.
pub const MOVED_S: f64 = 0.05;
/// Examples that are named per class and change.
pub const EXAMPLES: usize = 5;

/// A change of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Only in the second folder.
    Gained,
    /// Only in the first folder.
    Lost,
    /// The same moment has another class in the second folder.
    Reclassified,
    /// The same moment and class, another keyframe.
    Moved,
    /// The same moment and class, primary in one folder and secondary in the other.
    Primary,
    /// The same moment and class, another label: only of two releases.
    Relabelled,
}

impl Change {
    /// All changes, in the order of their columns.
    pub const ALL: [Self; 6] =
        [Self::Gained, Self::Lost, Self::Reclassified, Self::Moved, Self::Primary, Self::Relabelled];
}

/// One changed episode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChangedEpisode {
    /// What changed.
    pub change: Change,
    /// The episode's id in the first folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before: Option<String>,
    /// The episode's id in the second folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
    /// The class in the second folder, where it is another.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class_after: Option<ScenarioId>,
    /// Keyframe of the second minus keyframe of the first, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keyframe_shift_s: Option<f64>,
    /// The drive.
    pub drive: DriveId,
    /// Keyframe in the second folder, in the first where the second has none.
    pub keyframe: whyroad_model::Nanos,
    /// A label of this moment was accepted by a person: for gained episodes, a label of the class after; for all
    /// others, a label of the class before. `None` where no labels were given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accepted: Option<bool>,
    /// Of a reclassified moment: a label of the class after was accepted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accepted_after: Option<bool>,
}

/// Counts of one class.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ClassComparison {
    /// Episodes in the first folder.
    pub before: usize,
    /// Episodes in the second folder.
    pub after: usize,
    /// Episodes by change.
    pub changes: BTreeMap<Change, usize>,
    /// Of these, moments that people accepted with this class; `None` where no labels were given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accepted: Option<BTreeMap<Change, usize>>,
    /// Reclassified moments that people accepted with the class after.
    #[serde(skip_serializing_if = "is_zero")]
    pub accepted_after: usize,
    /// The first of each change, by id.
    pub examples: Vec<ChangedEpisode>,
}

fn is_zero(n: &usize) -> bool {
    *n == 0
}

/// What one side searched, and what it found.
#[derive(Clone, Copy, Debug)]
pub struct Searched<'a> {
    /// Drives that were searched.
    pub drives: &'a [DriveId],
    /// Classes that were asked for, each with everything below it; `None`: all of a taxonomy.
    pub classes: Option<&'a [ScenarioId]>,
    /// The episodes.
    pub episodes: &'a [EpisodeRecord],
    /// Hashes of the labels by the id of the episode, of a release.
    pub labels: Option<&'a BTreeMap<String, String>>,
}

impl Searched<'_> {
    /// The classes that both sides asked for, sorted; `None`: all.
    fn shared(&self, other: &Self) -> Option<Vec<ScenarioId>> {
        let (ours, theirs) = match (self.classes, other.classes) {
            (None, None) => return None,
            (Some(one), None) | (None, Some(one)) => {
                // A custom rule is in no taxonomy.
                return Some(one.iter().filter(|c| c.custom_name().is_none()).cloned().collect());
            }
            (Some(ours), Some(theirs)) => (ours, theirs),
        };
        let within = |of: &[ScenarioId], all: &[ScenarioId]| -> Vec<ScenarioId> {
            of.iter().filter(|c| all.iter().any(|a| c.is_within(a))).cloned().collect()
        };
        let both = [within(ours, theirs), within(theirs, ours)].concat();
        Some(both.into_iter().collect::<BTreeSet<_>>().into_iter().collect())
    }
}

/// Classes that are compared, where a side did not ask for all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SharedClasses {
    /// Classes that both sides asked for, each with everything below it.
    pub compared: Vec<ScenarioId>,
    /// Episodes of other classes in the first folder.
    pub left_out_before: usize,
    /// Episodes of other classes in the second folder.
    pub left_out_after: usize,
}

/// The comparison of two folders.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// The classes that are compared; absent where both sides asked for the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub classes_of_both: Option<SharedClasses>,
    /// Labels were compared, too: both sides are releases.
    #[serde(skip)]
    pub with_labels: bool,
    /// Drives that both searched.
    pub drives: usize,
    /// Drives that only the first searched; their episodes are not compared.
    pub only_before: Vec<DriveId>,
    /// Drives that only the second searched.
    pub only_after: Vec<DriveId>,
    /// Episodes that are the same in both.
    pub unchanged: usize,
    /// By class; a reclassified episode counts with its class before.
    pub classes: BTreeMap<ScenarioId, ClassComparison>,
}

/// A moment that a person accepted as being of a class.
#[derive(Clone, Debug, PartialEq)]
pub struct AcceptedMoment {
    /// The drive.
    pub drive: DriveId,
    /// The class.
    pub scenario: ScenarioId,
    /// The keyframe, nanoseconds since 1970.
    pub keyframe: whyroad_model::Nanos,
}

/// Maximum distance of the keyframes of an accepted label and its episode, s.
const ACCEPTED_WITHIN_S: f64 = 1.0;

impl AcceptedMoment {
    /// True when the label belongs to this episode.
    fn is_of(&self, e: &EpisodeRecord) -> bool {
        self.drive == e.drive_id
            && self.scenario == e.scenario_id
            && self.keyframe.seconds_since(e.keyframe.timestamp).abs() <= ACCEPTED_WITHIN_S
    }
}

/// Compares the episodes of two folders, of the drives and classes that both searched: what one did not search is not
/// lost. `accepted`, where it is given, judges the changes.
pub fn compare(before: Searched<'_>, after: Searched<'_>, accepted: Option<&[AcceptedMoment]>) -> Comparison {
    let first: BTreeSet<&DriveId> = before.drives.iter().collect();
    let second: BTreeSet<&DriveId> = after.drives.iter().collect();
    let shared = before.shared(&after);
    let is_shared =
        |e: &&EpisodeRecord| shared.as_ref().is_none_or(|all| all.iter().any(|c| e.scenario_id.is_within(c)));
    let outside = |of: &[EpisodeRecord]| of.iter().filter(|e| !is_shared(e)).count();
    let classes_of_both =
        shared.as_ref().filter(|_| before.classes != after.classes).map(|all| SharedClasses {
            compared: all.clone(),
            left_out_before: outside(before.episodes),
            left_out_after: outside(after.episodes),
        });
    let mut out = Comparison {
        classes_of_both,
        drives: first.intersection(&second).count(),
        only_before: first.difference(&second).map(|d| (*d).clone()).collect(),
        only_after: second.difference(&first).map(|d| (*d).clone()).collect(),
        with_labels: before.labels.is_some() && after.labels.is_some(),
        ..Comparison::default()
    };
    let labels = (before.labels, after.labels);
    let is_relabelled = |a: &EpisodeRecord, b: &EpisodeRecord| {
        let of = |labels: Option<&BTreeMap<String, String>>, e: &EpisodeRecord| {
            labels.and_then(|all| all.get(&e.episode_id)).cloned()
        };
        of(labels.0, a).zip(of(labels.1, b)).is_some_and(|(a, b)| a != b)
    };
    let (before, after) = [before, after].map(|s| by_subject(s.episodes.iter().filter(is_shared))).into();
    let none = Vec::new();
    let subjects: BTreeSet<&Subject<'_>> = before.keys().chain(after.keys()).collect();
    for subject in subjects {
        if !(first.contains(subject.0) && second.contains(subject.0)) {
            continue;
        }
        let a = before.get(subject).unwrap_or(&none);
        let b = after.get(subject).unwrap_or(&none);
        out.add((a, b), accepted, &is_relabelled);
    }
    out
}

/// Drive and target.
type Subject<'e> = (&'e DriveId, Option<&'e str>);

fn by_subject<'e>(
    episodes: impl Iterator<Item = &'e EpisodeRecord>,
) -> BTreeMap<Subject<'e>, Vec<&'e EpisodeRecord>> {
    let mut out: BTreeMap<Subject<'e>, Vec<&EpisodeRecord>> = BTreeMap::new();
    for e in episodes {
        out.entry((&e.drive_id, e.target_id.as_ref().map(|t| t.as_str()))).or_default().push(e);
    }
    out
}

impl Comparison {
    /// The changes that can be seen between these two sides.
    pub fn changes(&self) -> impl Iterator<Item = Change> + use<> {
        let with_labels = self.with_labels;
        Change::ALL.into_iter().filter(move |c| with_labels || *c != Change::Relabelled)
    }

    /// The classes that differ: with a change, or with another number of episodes, as a class to which moments of
    /// another one went.
    pub fn changed_classes(&self) -> impl Iterator<Item = (&ScenarioId, &ClassComparison)> {
        self.classes.iter().filter(|(_, of)| !of.changes.is_empty() || of.before != of.after)
    }

    /// Compares the episodes of one drive and target.
    fn add(
        &mut self,
        (before, after): (&[&EpisodeRecord], &[&EpisodeRecord]),
        accepted: Option<&[AcceptedMoment]>,
        is_relabelled: &dyn Fn(&EpisodeRecord, &EpisodeRecord) -> bool,
    ) {
        for e in before {
            self.class(&e.scenario_id, accepted).before += 1;
        }
        for e in after {
            self.class(&e.scenario_id, accepted).after += 1;
        }
        let close =
            |a: &EpisodeRecord, b: &EpisodeRecord| Moment::of_episode(a).match_error(&Moment::of_episode(b));
        let same_class = pairs(before.len(), after.len(), |i, j| {
            (before[i].scenario_id == after[j].scenario_id).then(|| close(before[i], after[j])).flatten()
        });
        let (mut paired_a, mut paired_b): (BTreeSet<usize>, BTreeSet<usize>) =
            (BTreeSet::new(), BTreeSet::new());
        for (i, j) in same_class {
            paired_a.insert(i);
            paired_b.insert(j);
            self.same(before[i], after[j], accepted, is_relabelled);
        }
        let left: Vec<usize> = (0..before.len()).filter(|i| !paired_a.contains(i)).collect();
        let right: Vec<usize> = (0..after.len()).filter(|j| !paired_b.contains(j)).collect();
        for (i, j) in pairs(left.len(), right.len(), |i, j| close(before[left[i]], after[right[j]])) {
            let (a, b) = (before[left[i]], after[right[j]]);
            paired_a.insert(left[i]);
            paired_b.insert(right[j]);
            self.change(a, Some(a), Some(b), Change::Reclassified, accepted);
        }
        for i in (0..before.len()).filter(|i| !paired_a.contains(i)) {
            self.change(before[i], Some(before[i]), None, Change::Lost, accepted);
        }
        for j in (0..after.len()).filter(|j| !paired_b.contains(j)) {
            self.change(after[j], None, Some(after[j]), Change::Gained, accepted);
        }
    }

    /// A moment that has one class in both folders.
    fn same(
        &mut self,
        a: &EpisodeRecord,
        b: &EpisodeRecord,
        accepted: Option<&[AcceptedMoment]>,
        is_relabelled: &dyn Fn(&EpisodeRecord, &EpisodeRecord) -> bool,
    ) {
        let moved = Moment::of_episode(a).lateness(&Moment::of_episode(b)).abs() > MOVED_S;
        if moved {
            self.change(a, Some(a), Some(b), Change::Moved, accepted);
        }
        if a.is_primary != b.is_primary {
            self.change(a, Some(a), Some(b), Change::Primary, accepted);
        }
        // Another keyframe is another label, too: it counts as moved.
        let relabelled = !moved && is_relabelled(a, b);
        if relabelled {
            self.change(a, Some(a), Some(b), Change::Relabelled, accepted);
        }
        if !moved && !relabelled && a.is_primary == b.is_primary {
            self.unchanged += 1;
        }
    }

    fn change(
        &mut self,
        of: &EpisodeRecord,
        a: Option<&EpisodeRecord>,
        b: Option<&EpisodeRecord>,
        change: Change,
        accepted: Option<&[AcceptedMoment]>,
    ) {
        let judge = |e: &EpisodeRecord| accepted.map(|labels| labels.iter().any(|l| l.is_of(e)));
        let judged = judge(of);
        let both = a.zip(b);
        let shift = both.map(|(a, b)| Moment::of_episode(a).lateness(&Moment::of_episode(b)));
        let changed = ChangedEpisode {
            change,
            before: a.map(|e| e.episode_id.clone()),
            after: b.map(|e| e.episode_id.clone()),
            class_after: both
                .filter(|(a, b)| a.scenario_id != b.scenario_id)
                .map(|(_, b)| b.scenario_id.clone()),
            keyframe_shift_s: shift,
            drive: of.drive_id.clone(),
            keyframe: b.unwrap_or(of).keyframe.timestamp,
            accepted: judged,
            accepted_after: b.filter(|_| change == Change::Reclassified).and_then(judge),
        };
        let class = self.class(&of.scenario_id, accepted);
        *class.changes.entry(change).or_default() += 1;
        if let (Some(counts), Some(true)) = (&mut class.accepted, judged) {
            *counts.entry(change).or_default() += 1;
        }
        if changed.accepted_after == Some(true) {
            class.accepted_after += 1;
        }
        if class.examples.iter().filter(|e| e.change == change).count() < EXAMPLES {
            class.examples.push(changed);
        }
    }

    fn class(&mut self, id: &ScenarioId, accepted: Option<&[AcceptedMoment]>) -> &mut ClassComparison {
        self.classes.entry(id.clone()).or_insert_with(|| ClassComparison {
            accepted: accepted.map(|_| BTreeMap::new()),
            ..ClassComparison::default()
        })
    }

    /// Episodes of all classes with this change.
    pub fn total(&self, change: Change) -> usize {
        self.classes.values().filter_map(|c| c.changes.get(&change)).sum()
    }

    /// Against accepted labels: moments that people accepted and only the second folder has with their class, and those
    /// that only the first has. Reclassified moments count on both sides. `None` where no labels were given.
    pub fn verdict(&self) -> Option<(usize, usize)> {
        let after: usize = self.classes.values().map(|c| c.accepted_after).sum();
        let gains = self.total_accepted(Change::Gained)? + after;
        let loses = self.total_accepted(Change::Lost)? + self.total_accepted(Change::Reclassified)?;
        Some((gains, loses))
    }

    /// Moments that people accepted, of those with this change; `None` where no labels were given.
    pub fn total_accepted(&self, change: Change) -> Option<usize> {
        let all: Option<Vec<usize>> = self
            .classes
            .values()
            .map(|c| c.accepted.as_ref().map(|a| a.get(&change).copied().unwrap_or(0)))
            .collect();
        all.map(|n| n.into_iter().sum())
    }
}

#[cfg(test)]
mod tests;
