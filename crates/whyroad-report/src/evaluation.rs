//! Evaluation of episodes against independent ground truth: per class precision, recall, F1, keyframe error, and which
//! classes are confused.
//!
//! Truth comes as [`truth::TruthSet`], episodes as `whyroad mine` writes them. An episode matches an entry of the truth
//! when they name the same class and drive, the same target where both name one, and their keyframes are at most
//! [`KEYFRAME_TOLERANCE_S`] apart or their time ranges have an intersection over union of at least [`LEAST_IOU`]. Each
//! entry and each episode is used once; among all ways to pair them one with the most pairs is taken, close
//! keyframes first. Nothing here knows how an episode was found.

mod figures;
pub(crate) mod matching;
pub mod scenario_mining;
mod text;
pub mod truth;

pub use figures::{ClassFigures, Confusion, Evaluation, MissedEntry, SpuriousEpisode};
pub use matching::{KEYFRAME_TOLERANCE_S, LEAST_IOU};
pub use text::render;

use matching::{Moment, pairs, same_target};
use std::collections::BTreeMap;
use truth::TruthSet;
use whyroad_model::DriveId;
use whyroad_model::messages::EpisodeRecord;

/// Compares `episodes` with `truth`.
///
/// An entry that names an L2 (its variant is not known) is matched by every episode of that L2, after the entries that
/// name a leaf. Only drives that the truth names are evaluated; an episode beyond the truth is false where its class
/// and drive are declared complete, and otherwise does not count. Nor does an episode that only an optional entry
/// matches; optional entries come last.
pub fn evaluate(truth: &TruthSet, episodes: &[EpisodeRecord]) -> Evaluation {
    let Pairing { entries, partner, taken, open } = pair(truth, episodes);
    figures::collect(truth, &entries, &partner, &figures::Outcome { episodes, taken: &taken, open: &open })
}

/// Whether each episode is right, as [`evaluate`] counts it; `None` where the truth is not declared complete for its
/// class and drive, and where it is undecided.
pub fn judge(truth: &TruthSet, episodes: &[EpisodeRecord]) -> Vec<Option<bool>> {
    let Pairing { taken, open, .. } = pair(truth, episodes);
    let one = |(i, e): (usize, &EpisodeRecord)| {
        (!open[i] && truth.is_complete(&e.scenario_id, &e.drive_id)).then_some(taken[i])
    };
    episodes.iter().enumerate().map(one).collect()
}

/// The pairs of entries and episodes.
struct Pairing<'a> {
    /// Those that have to be found.
    entries: Vec<&'a truth::TruthEntry>,
    /// For each entry, its episode.
    partner: Vec<Option<usize>>,
    /// For each episode, whether it is the partner of an entry, optional or not.
    taken: Vec<bool>,
    /// For each episode, whether it is that of an optional entry.
    open: Vec<bool>,
}

fn pair<'a>(truth: &'a TruthSet, episodes: &[EpisodeRecord]) -> Pairing<'a> {
    let mut entries: Vec<&truth::TruthEntry> = truth.entries.iter().collect();
    // Leaves first, so that an L2's entry takes episodes that no leaf's entry matches.
    entries.sort_by_key(|e| {
        (e.optional, !e.scenario_id.is_leaf(), e.keyframe_ns, e.scenario_id.clone(), e.target_id.clone())
    });
    let required = entries.iter().filter(|e| !e.optional).count();
    let mut by_drive: BTreeMap<&DriveId, Vec<usize>> = BTreeMap::new();
    for (i, e) in episodes.iter().enumerate() {
        by_drive.entry(&e.drive_id).or_default().push(i);
    }
    let mut taken = vec![false; episodes.len()];
    let mut partner = vec![None; entries.len()];
    for (optional, leaves) in [(false, true), (false, false), (true, true), (true, false)] {
        for (drive, of_drive) in &by_drive {
            let wanted: Vec<usize> = (0..entries.len())
                .filter(|&i| entries[i].optional == optional && entries[i].scenario_id.is_leaf() == leaves)
                .filter(|&i| &entries[i].drive_id == *drive)
                .collect();
            let free: Vec<usize> = of_drive.iter().copied().filter(|&e| !taken[e]).collect();
            let fits = |w: usize, f: usize| {
                let (entry, episode) = (entries[wanted[w]], &episodes[free[f]]);
                let class = episode.scenario_id.is_within(&entry.scenario_id);
                (class && same_target(entry, episode))
                    .then(|| Moment::of_entry(entry).match_error(&Moment::of_episode(episode)))
                    .flatten()
            };
            for (w, f) in pairs(wanted.len(), free.len(), fits) {
                partner[wanted[w]] = Some(free[f]);
                taken[free[f]] = true;
            }
        }
    }
    let mut open = vec![false; episodes.len()];
    for e in partner.drain(required..).flatten() {
        open[e] = true;
    }
    entries.truncate(required);
    Pairing { entries, partner, taken, open }
}

#[cfg(test)]
mod tests;
