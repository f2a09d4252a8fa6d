//! Our truth and our episodes as sequences: the class is the prompt, the target the object referred to, or the ego
//! where there is no target. An object is referred to from the start of its time range to the end.

use super::super::truth::TruthEntry;
use super::sequence::{Frame, Label, Object, Sequence};
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Drive, Nanos, ScenarioId, TrackId};

/// Track id of the ego in sequences.
pub const EGO: &str = "ego";

/// That an object is referred to for some time.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The prompt.
    pub class: ScenarioId,
    /// Target; none is the ego.
    pub target: Option<TrackId>,
    /// Start.
    pub start: Nanos,
    /// End, not included.
    pub end: Nanos,
    /// 0 to 1.
    pub score: f64,
}

impl From<&EpisodeRecord> for Reference {
    fn from(e: &EpisodeRecord) -> Self {
        Self {
            class: e.scenario_id.clone(),
            target: e.target_id.clone(),
            start: e.time_range.start_timestamp,
            end: e.time_range.end_timestamp,
            score: e.score,
        }
    }
}

impl From<&TruthEntry> for Reference {
    fn from(e: &TruthEntry) -> Self {
        let (class, target) = (e.scenario_id.clone(), e.target_id.clone());
        Self { class, target, start: e.start_ns, end: e.end_ns, score: 1.0 }
    }
}

/// The sequence of `class` on `drive`: every frame with the ego's place, and the whole track of each object that is
/// referred to at least once. Frames without an ego pose have no place to measure from and are left out.
pub fn sequence(drive: &Drive, class: &ScenarioId, references: &[Reference]) -> Sequence {
    let of_class: Vec<&Reference> = references.iter().filter(|r| r.class.is_within(class)).collect();
    let mut frames = Vec::new();
    for (f, time) in drive.times.iter().enumerate() {
        let Some(ego) =
            drive.ego.as_ref().map(|e| [e.motion.x[f], e.motion.y[f]]).filter(|p| p[0].is_finite())
        else {
            continue;
        };
        let mut objects: Vec<Object> = Vec::new();
        for r in &of_class {
            let place = match &r.target {
                None => Some((ego[0], ego[1])),
                Some(id) => drive
                    .track(id)
                    .and_then(|t| Some((t, t.row_at(f)?)))
                    .map(|(t, row)| (t.motion.x[row], t.motion.y[row])),
            };
            let Some((x, y)) = place.filter(|p| p.0.is_finite()) else { continue };
            let id = r.target.as_ref().map_or(EGO, |t| t.as_str());
            let now = r.start <= *time && *time < r.end;
            let label = if now { Label::ReferredObject } else { Label::OtherObject };
            match objects.iter_mut().find(|o| o.track_id == id) {
                // Two episodes of one object: it is referred to in both ranges, with the better score where both hold.
                Some(o) if now => {
                    o.score = if o.label == label { o.score.max(r.score) } else { r.score };
                    o.label = label;
                }
                Some(o) if o.label == Label::OtherObject => o.score = o.score.max(r.score),
                Some(_) => {}
                None => objects.push(Object { track_id: id.to_owned(), label, x, y, score: r.score }),
            }
        }
        objects.sort_by(|a, b| a.track_id.cmp(&b.track_id));
        frames.push(Frame { timestamp_ns: time.0, ego, is_positive: None, objects });
    }
    Sequence { log_id: drive.meta.drive_id.to_string(), prompt: class.to_string(), frames }
}
