//! Our ground truth and our episodes as sequences: the class is the prompt, the target the object referred to, or the
//! ego where there is no target. An object is referred to from the start of its time range to the end.

use super::super::truth::TruthEntry;
use super::result::{MiningResult, ResultFrame, ResultObject, evaluated_frames};
use super::sequence::{Frame, Label, Object, Sequence};
use std::collections::BTreeMap;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::scene::{Motion, Track};
use whyroad_model::{Drive, Nanos, ScenarioId, TrackId};

/// Track id of the ego in sequences.
pub const EGO: &str = "ego";

/// A time range in which an object is referred to.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The prompt.
    pub class: ScenarioId,
    /// Target; `None` means the ego.
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

/// The results on `drive` in the challenge's form: every object in every evaluated frame. `one_object` states which
/// tracks were found to be one object, by id of the later one. An object that only takes another role is related.
pub fn result(
    drive: &Drive,
    prompt: &str,
    episodes: &[EpisodeRecord],
    one_object: &BTreeMap<TrackId, TrackId>,
) -> MiningResult {
    let Some(ego) = &drive.ego else { return MiningResult::default() };
    let label = |id: &str, time: Nanos| {
        let now =
            |e: &&EpisodeRecord| e.time_range.start_timestamp <= time && time < e.time_range.end_timestamp;
        let mut found = (Label::OtherObject, 0.0_f64);
        for e in episodes.iter().filter(now) {
            let target = e.target_id.as_ref().map_or(EGO, |t| t.as_str());
            if target == id {
                let before = if found.0 == Label::ReferredObject { found.1 } else { 0.0 };
                found = (Label::ReferredObject, e.score.max(before));
            } else if found.0 == Label::OtherObject && e.roles.values().any(|r| r.as_str() == id) {
                found = (Label::RelatedObject, e.score);
            }
        }
        found
    };
    let object = |own: &str, seen_as: &str, time: Nanos, m: &Motion, row: usize, size: [f64; 3]| {
        let (label, score) = label(seen_as, time);
        ResultObject {
            track_id: own.to_owned(),
            label,
            center: [m.x[row], m.y[row], if m.z[row].is_finite() { m.z[row] } else { 0.0 }],
            size: size.map(|x| if x.is_finite() { x } else { 0.0 }),
            yaw: m.heading[row],
            score: if label == Label::OtherObject { 1.0 } else { score },
        }
    };
    let mut frames = Vec::new();
    for f in evaluated_frames(drive.times.len()) {
        let (time, m) = (drive.times[f], &ego.motion);
        if !m.x[f].is_finite() {
            continue;
        }
        let of_track = |t: &Track| {
            let row = t.row_at(f).filter(|r| t.motion.x[*r].is_finite())?;
            let seen_as = one_object.get(&t.id).unwrap_or(&t.id);
            let size = [t.length_m[row], t.width_m[row], t.height_m[row]];
            Some(object(t.id.as_str(), seen_as.as_str(), time, &t.motion, row, size))
        };
        let mut objects: Vec<ResultObject> = drive.tracks.iter().filter_map(of_track).collect();
        objects.push(object(EGO, EGO, time, m, f, [ego.length_m, ego.width_m, ego.height_m]));
        let back = ego.reference_to_centre_m;
        let back = if back.is_finite() { back } else { 0.0 };
        let z = if m.z[f].is_finite() { m.z[f] } else { 0.0 };
        let axle = [m.x[f] - back * m.heading[f].cos(), m.y[f] - back * m.heading[f].sin(), z];
        frames.push(ResultFrame { timestamp_ns: time.0, ego: axle, objects });
    }
    MiningResult { log_id: drive.meta.drive_id.to_string(), prompt: prompt.to_owned(), frames }
}
