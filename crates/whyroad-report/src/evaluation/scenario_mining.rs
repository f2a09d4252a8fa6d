//! The metrics of the Argoverse 2 scenario-mining challenge: HOTA-Temporal, HOTA-Track, and balanced accuracy by
//! timestamp and by log, as its published evaluation defines them (`av2.evaluation.scenario_mining`, with HOTA of
//! TrackEval):
//!
//! - objects farther than 50 m from the ego are left out ([`RANGE_M`]); two centers are similar by
//!   `1 - distance / 2 m`;
//! - each prompt is a class of its own; ten score thresholds at recalls 1.0 to 0.1 are tried and the best HOTA counts;
//! - HOTA-Temporal compares the frames in which an object is referred to, HOTA-Track the whole of its track;
//! - balanced accuracy is the mean of the true positive and the true negative rate, a rate over nothing being 1; frames
//!   whose truth is ambiguous do not count.
//!
//! The region-of-interest raster of the challenge is applied where it is given ([`region`]). [`sequence`] has the file
//! format, free of pickles; [`result`] writes that of the challenge.

mod accuracy;
mod assignment;
pub mod bridge;
mod hota;
pub mod region;
pub mod result;
pub mod sequence;
mod thresholds;

use sequence::{Frame, Label, Object, Sequence};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Objects farther from the ego are not evaluated, m.
pub const RANGE_M: f64 = 50.0;
/// Centers this far apart have similarity 0, m.
pub const MATCH_DISTANCE_M: f64 = 2.0;

/// The four figures of one prompt, or their means over prompts; 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Frames in which an object is referred to.
    pub hota_temporal: f64,
    /// Whole tracks of objects that are ever referred to.
    pub hota_track: f64,
    /// Is anything referred to in this frame?
    pub timestamp_balanced_accuracy: f64,
    /// Is anything referred to in this log?
    pub log_balanced_accuracy: f64,
}

/// All figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Scores {
    /// Means over the prompts; `None` where there is no prompt: nothing was compared.
    pub mean: Option<Figures>,
    /// By prompt.
    pub prompts: BTreeMap<String, Figures>,
}

/// The two files do not match.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Mismatch {
    /// No prediction for a sequence of the truth.
    #[error("the predictions have no sequence for log {log_id}, prompt {prompt:?}")]
    NoPrediction {
        /// Log.
        log_id: String,
        /// Prompt.
        prompt: String,
    },
    /// The frames differ.
    #[error("log {log_id}, prompt {prompt:?}: the frame times of truth and predictions differ")]
    Frames {
        /// Log.
        log_id: String,
        /// Prompt.
        prompt: String,
    },
}

/// Compares predictions with truth. Every sequence of the truth needs a prediction with the same frames (it may be
/// empty of objects); predictions for other sequences are ignored.
pub fn score(truth: &[Sequence], predictions: &[Sequence]) -> Result<Scores, Mismatch> {
    let mut by_prompt: BTreeMap<&str, Vec<(&Sequence, &Sequence)>> = BTreeMap::new();
    for t in truth {
        let p = predictions
            .iter()
            .find(|p| p.log_id == t.log_id && p.prompt == t.prompt)
            .ok_or_else(|| Mismatch::NoPrediction { log_id: t.log_id.clone(), prompt: t.prompt.clone() })?;
        let times = |s: &Sequence| s.frames.iter().map(|f| f.timestamp_ns).collect::<Vec<_>>();
        if times(t) != times(p) {
            return Err(Mismatch::Frames { log_id: t.log_id.clone(), prompt: t.prompt.clone() });
        }
        by_prompt.entry(&t.prompt).or_default().push((t, p));
    }
    let mut scores = Scores::default();
    for (prompt, all) in by_prompt {
        let part = |choose: &dyn Fn(&Sequence) -> Sequence| -> Vec<(Sequence, Sequence)> {
            all.iter().map(|(t, p)| (choose(t), choose(p))).collect()
        };
        let temporal = part(&|s| in_range(s).referred());
        let (hota_temporal, kept) = hota::best(&temporal);
        let (hota_track, _) = hota::best(&part(&|s| in_range(s).whole_tracks().referred()));
        let (timestamp, log) = accuracy::balanced(&temporal, kept);
        let figures = Figures {
            hota_temporal,
            hota_track,
            timestamp_balanced_accuracy: timestamp,
            log_balanced_accuracy: log,
        };
        scores.prompts.insert(prompt.to_owned(), figures);
    }
    if scores.prompts.is_empty() {
        return Ok(scores);
    }
    let n = scores.prompts.len() as f64;
    let mean = |of: fn(&Figures) -> f64| scores.prompts.values().map(of).sum::<f64>() / n;
    scores.mean = Some(Figures {
        hota_temporal: mean(|f| f.hota_temporal),
        hota_track: mean(|f| f.hota_track),
        timestamp_balanced_accuracy: mean(|f| f.timestamp_balanced_accuracy),
        log_balanced_accuracy: mean(|f| f.log_balanced_accuracy),
    });
    Ok(scores)
}

impl Sequence {
    /// Only objects that are referred to.
    fn referred(mut self) -> Self {
        for f in &mut self.frames {
            f.objects.retain(|o| o.label == Label::ReferredObject);
        }
        self
    }

    /// An object that is ever referred to is referred to in every frame.
    fn whole_tracks(mut self) -> Self {
        let referred = |f: &Frame| -> Vec<String> {
            let of = f.objects.iter().filter(|o| o.label == Label::ReferredObject);
            of.map(|o| o.track_id.clone()).collect()
        };
        let ever: BTreeSet<String> = self.frames.iter().flat_map(referred).collect();
        for o in self.frames.iter_mut().flat_map(|f| &mut f.objects) {
            if ever.contains(&o.track_id) {
                o.label = Label::ReferredObject;
            }
        }
        self
    }
}

fn in_range(s: &Sequence) -> Sequence {
    let near = |f: &Frame, o: &Object| (o.x - f.ego[0]).hypot(o.y - f.ego[1]) <= RANGE_M;
    let mut out = s.clone();
    for f in &mut out.frames {
        let all = std::mem::take(&mut f.objects);
        f.objects = all.into_iter().filter(|o| near(f, o)).collect();
    }
    out
}

/// 1 where the centers coincide, 0 from [`MATCH_DISTANCE_M`] apart.
fn similarity(a: &Object, b: &Object) -> f64 {
    (1.0 - (a.x - b.x).hypot(a.y - b.y) / MATCH_DISTANCE_M).max(0.0)
}

#[cfg(test)]
mod tests;
