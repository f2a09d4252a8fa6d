//! From a rule's truth over time to episodes: runs, keyframe, time range, score. Everything is in frames of
//! the whole drive; clips are used only where an episode is written.

pub mod arbitrate;
pub(crate) mod build;
pub mod kinds;
pub mod moment;
pub(crate) mod observable;
pub(crate) mod pairs;

pub use build::{Found, conditions_at, find};

use std::collections::BTreeMap;
use whyroad_model::messages::{EgoResponse, KeyframeType, MatchedCondition};
use whyroad_model::{Bilingual, FrameRange, ScenarioId, TrackId, Tri};

/// A stretch of a drive in which a rule held.
#[derive(Clone, Debug, PartialEq)]
pub struct Episode {
    /// The leaf, or the L2 where the variant is not known.
    pub scenario: ScenarioId,
    /// The target that the rule bound.
    pub target: Option<TrackId>,
    /// Object for each role, where the rule binds two objects; empty otherwise.
    pub roles: BTreeMap<String, TrackId>,
    /// Frames in which the rule's condition held, short breaks included.
    pub matched: FrameRange,
    /// One moment or a range.
    pub kind: KeyframeType,
    /// The keyframe; the start of the range for a range.
    pub keyframe: usize,
    /// The second keyframe, where the spec has one and it was found.
    pub second_keyframe: Option<usize>,
    /// `time_range` of the labeling spec; contains the keyframe.
    pub range: FrameRange,
    /// The time range with the context that its spec requires.
    pub context: FrameRange,
    /// How the keyframe was found.
    pub keyframe_rule: Bilingual,
    /// Whether the ego responded to the trigger.
    pub response: EgoResponse,
    /// How far the conditions are exceeded, 0.5 to 1; see [`score`]. Not comparable between classes.
    pub score: f64,
    /// Share of the episodes of the class with such a score that is right; `None` where the class is not calibrated,
    /// and before [`crate::drive::arbitrated`].
    pub share: Option<f64>,
    /// Conditions with their values at the keyframe.
    pub conditions: Vec<MatchedCondition>,
    /// Signals that the rule read, sorted.
    pub signals: Vec<String>,
    /// Whether arbitration made it primary, or which episode of the list it is secondary to.
    pub rank: Rank,
}

/// Result of arbitration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rank {
    /// The primary trigger at its keyframe.
    Primary,
    /// Secondary to the episode at this index.
    SecondaryTo(usize),
}

/// Maximum number of conditions that an episode lists: those that are met most narrowly.
pub const LISTED_CONDITIONS: usize = 5;

/// The response, from the truth of its condition by frame over `range`; `None` for a frame in which it is not
/// evaluated. Without any frame the response is unknown, not absent.
pub(crate) fn response(range: FrameRange, mut truth: impl FnMut(usize) -> Option<Tri>) -> EgoResponse {
    let mut known = !range.is_empty();
    for frame in range.start..range.end {
        match truth(frame) {
            Some(Tri::True) => return EgoResponse::Observed,
            Some(Tri::False) => {}
            Some(Tri::Unknown) | None => known = false,
        }
    }
    if known { EgoResponse::Absent } else { EgoResponse::Unknown }
}

/// Positions of the deciding conditions, at most [`LISTED_CONDITIONS`], in their order: comparisons that can be read at
/// one moment before those over time, and of these the ones that are met most narrowly.
pub(crate) fn deciding(conditions: &[(&str, f64)]) -> Vec<usize> {
    let over_time = |text: &str| {
        [" until ", " since ", " within ", " for ", "previously(", ": "]
            .iter()
            .any(|word| text.contains(word))
    };
    let mut order: Vec<usize> = (0..conditions.len()).collect();
    order.sort_by(|&a, &b| {
        let (x, y) = (conditions[a], conditions[b]);
        // Equal but for the last bits is equal: both evaluators list the same.
        let (mx, my) = ((x.1 * 1e6).round(), (y.1 * 1e6).round());
        over_time(x.0).cmp(&over_time(y.0)).then(mx.total_cmp(&my)).then(a.cmp(&b))
    });
    order.truncate(LISTED_CONDITIONS);
    order.sort_unstable();
    order
}

/// Match score of a margin: 0.5 where the conditions are only just met, towards 1 as they are exceeded by
/// typical magnitudes. Strictly increasing; with margins cut off at 2, at most 0.982.
pub fn score(margin: f64) -> f64 {
    0.5 + 0.5 * margin.tanh()
}
