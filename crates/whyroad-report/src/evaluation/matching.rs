//! Pairing ground truth with episodes: allowed pairs, and the pairing with the most pairs.

use super::truth::TruthEntry;
use whyroad_model::Nanos;
use whyroad_model::messages::EpisodeRecord;

/// Keyframes at most this far apart are the same moment, s.
pub const KEYFRAME_TOLERANCE_S: f64 = 1.0;
/// Time ranges that overlap by at least this share of their union are the same episode.
pub const LEAST_IOU: f64 = 0.3;

/// A time range and its keyframe.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    start: Nanos,
    keyframe: Nanos,
    end: Nanos,
}

impl Moment {
    /// From its times; `end` is one past the last moment.
    pub fn new(start: Nanos, keyframe: Nanos, end: Nanos) -> Self {
        Self { start, keyframe, end }
    }

    /// Of an entry of the truth.
    pub fn of_entry(e: &TruthEntry) -> Self {
        Self { start: e.start_ns, keyframe: e.keyframe_ns, end: e.end_ns }
    }

    /// Of an episode.
    pub fn of_episode(e: &EpisodeRecord) -> Self {
        let range = &e.time_range;
        Self { start: range.start_timestamp, keyframe: e.keyframe.timestamp, end: range.end_timestamp }
    }

    /// Seconds between the keyframes, signed: positive when `found` is late.
    pub fn lateness(&self, found: &Moment) -> f64 {
        found.keyframe.seconds_since(self.keyframe)
    }

    /// Intersection over union of the time ranges; 0 where both are empty.
    pub fn iou(&self, other: &Moment) -> f64 {
        let both = self.end.min(other.end).0.saturating_sub(self.start.max(other.start).0).max(0);
        let either = (self.end.0 - self.start.0) + (other.end.0 - other.start.0) - both;
        if either > 0 { both as f64 / either as f64 } else { 0.0 }
    }

    /// Distance of the keyframes in s where the two are one moment, else `None`.
    pub fn match_error(&self, found: &Moment) -> Option<f64> {
        let error = self.lateness(found).abs();
        (error <= KEYFRAME_TOLERANCE_S || self.iou(found) >= LEAST_IOU).then_some(error)
    }
}

/// True unless both name a target and they differ.
pub fn same_target(entry: &TruthEntry, episode: &EpisodeRecord) -> bool {
    match (&entry.target_id, &episode.target_id) {
        (Some(a), Some(b)) => a == b,
        _ => true,
    }
}

/// A pairing of `left` with `right` that has as many pairs as any (augmenting paths, Kuhn 1955). Close ones are
/// tried first. `fits` gives the distance of a pair that may be made.
pub fn pairs(left: usize, right: usize, fits: impl Fn(usize, usize) -> Option<f64>) -> Vec<(usize, usize)> {
    let mut options: Vec<Vec<(f64, usize)>> = (0..left)
        .map(|l| {
            let mut all: Vec<(f64, usize)> = (0..right).filter_map(|r| Some((fits(l, r)?, r))).collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            all
        })
        .collect();
    let mut order: Vec<usize> = (0..left).filter(|&l| !options[l].is_empty()).collect();
    order.sort_by(|&a, &b| options[a][0].0.total_cmp(&options[b][0].0).then(a.cmp(&b)));
    let mut owner: Vec<Option<usize>> = vec![None; right];
    for &l in &order {
        let mut seen = vec![false; right];
        augment(l, &mut options, &mut owner, &mut seen);
    }
    let mut out: Vec<(usize, usize)> =
        owner.iter().enumerate().filter_map(|(r, l)| Some(((*l)?, r))).collect();
    out.sort_unstable();
    out
}

fn augment(
    l: usize,
    options: &mut [Vec<(f64, usize)>],
    owner: &mut [Option<usize>],
    seen: &mut [bool],
) -> bool {
    for i in 0..options[l].len() {
        let r = options[l][i].1;
        if std::mem::replace(&mut seen[r], true) {
            continue;
        }
        let free = match owner[r] {
            None => true,
            Some(other) => augment(other, options, owner, seen),
        };
        if free {
            owner[r] = Some(l);
            return true;
        }
    }
    false
}
