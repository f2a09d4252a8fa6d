//! Motion and classes of a drive as known at a moment: the only call through which consumers (data sets, Python, the
//! service) get speeds, accelerations and classes. They are estimated from the drive cut at that moment.

use std::borrow::Cow;
use whyroad_model::scene::Motion;
use whyroad_model::{Drive, ObjectClass, TrackId};
use whyroad_signals::estimate;

/// The states of the ego and the tracked objects from frames `0..frames` of a drive.
#[derive(Clone, Debug, Default)]
pub struct States {
    /// Number of frames used.
    pub frames: usize,
    /// The ego's box center, one row per frame; `None` when the log has no ego.
    pub ego: Option<Motion>,
    /// Objects with at least one observation, ordered by id.
    pub objects: Vec<ObjectStates>,
}

/// One object.
#[derive(Clone, Debug, Default)]
pub struct ObjectStates {
    /// Id within the drive.
    pub id: TrackId,
    /// Class by these frames.
    pub class: ObjectClass,
    /// Frame of each row, strictly ascending; may have gaps.
    pub frames: Vec<u32>,
    /// Motion of the box center, one row per entry of `frames`; NaN is unknown.
    pub motion: Motion,
    /// Box length in m, one value per row; NaN is unknown.
    pub length_m: Vec<f64>,
    /// Box width in m.
    pub width_m: Vec<f64>,
    /// Box height in m.
    pub height_m: Vec<f64>,
}

impl ObjectStates {
    /// Row of `frame`, if the object was observed then.
    pub fn row_at(&self, frame: usize) -> Option<usize> {
        let frame = u32::try_from(frame).ok()?;
        self.frames.binary_search(&frame).ok()
    }
}

/// The states of `drive` from its frames before `until` (exclusive, clamped to the drive). Later frames never affect
/// the result: `states(drive, keyframe + 1)` is what Stage I or a model's input may contain, and `states(drive,
/// drive.frame_count())` is the whole drive.
pub fn states(drive: &Drive, until: usize) -> States {
    let frames = until.min(drive.frame_count());
    let whole = frames == drive.frame_count();
    let seen = if whole { estimate(drive).into_owned() } else { estimated(drive.until_frame(frames)) };
    let objects = seen.tracks.into_iter().map(|t| ObjectStates {
        id: t.id,
        class: t.class,
        frames: t.frames,
        motion: t.motion,
        length_m: t.length_m,
        width_m: t.width_m,
        height_m: t.height_m,
    });
    States { frames, objects: objects.collect(), ego: seen.ego.map(|e| e.motion) }
}

/// The drive with complete motion, for display: the lake holds only measurements.
pub fn estimated(drive: Drive) -> Drive {
    match estimate(&drive) {
        Cow::Owned(complete) => complete,
        Cow::Borrowed(_) => drive,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_model::Nanos;
    use whyroad_model::scene::{Ego, Track};

    fn motion(n: usize) -> Motion {
        let x = (0..n).map(|i| i as f64).collect();
        Motion { x, y: vec![0.0; n], heading: vec![0.0; n], ..Motion::unknown(n) }
    }

    #[test]
    fn nothing_after_the_cut_is_there() {
        let n = 4;
        let sizes = vec![4.0; 2];
        let track = |id: &str, frames: Vec<u32>| Track {
            id: id.into(),
            frames,
            motion: motion(2),
            length_m: sizes.clone(),
            width_m: sizes.clone(),
            height_m: sizes.clone(),
            ..Track::default()
        };
        let drive = Drive {
            times: (0..n).map(|i| Nanos(i * 100_000_000)).collect(),
            ego: Some(Ego { motion: motion(4), ..Ego::default() }),
            tracks: vec![track("a", vec![1, 3]), track("b", vec![2, 3])],
            ..Drive::default()
        };
        let seen = states(&drive, 2);
        assert_eq!(seen.frames, 2);
        assert_eq!(seen.ego.unwrap().x, [0.0, 1.0]);
        assert_eq!(seen.objects.len(), 1, "b was first seen in frame 2");
        assert_eq!(seen.objects[0].frames, [1]);
        assert_eq!(states(&drive, 99).objects.len(), 2);
    }
}
