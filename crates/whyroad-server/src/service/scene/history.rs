//! Values up to the keyframe are the same in both stages: those of the drive cut at the keyframe, by which the
//! components were written. The whole drive has others, because its estimates use later measurements.

use crate::domain::scene::SceneView;
use serde_json::Value;

/// Half of the window of a derivative, s (`schema/signals.yaml`, `ego.jerk`): nearer to the end it is one-sided.
const REACH_S: f64 = 0.2;
/// The signal that is a derivative of a derivative: one-sided it is mostly noise.
const JERK: &str = "ego.jerk";

/// Removes values at the end of what Stage I shows that later measurements would change beyond use.
pub(super) fn withhold_uncertain(view: &mut SceneView) {
    let Some(end) = view.t_s.last().copied() else { return };
    let Some(jerk) = view.signals.get_mut(JERK) else { return };
    let near = view.t_s.iter().map(|t| *t > end - REACH_S + 1e-3);
    jerk.iter_mut().zip(near).filter(|(_, near)| *near).for_each(|(v, _)| *v = Value::Null);
}

/// Gives `view` the values that Stage I showed, `before`. What was unknown then keeps its value.
pub(super) fn keep(view: &mut SceneView, before: &SceneView) {
    let n = before.times.len();
    if view.times.get(..n) != Some(before.times.as_slice()) {
        return;
    }
    if let (Some(ego), Some(then)) = (&mut view.ego, &before.ego) {
        known(&mut ego.speed, &then.speed);
        known(&mut ego.accel, &then.accel);
        known(&mut ego.yaw_rate, &then.yaw_rate);
    }
    for then in &before.tracks {
        let Some(now) = view.tracks.iter_mut().find(|t| t.id == then.id) else { continue };
        // Both begin at their first observation, which the end of the drive does not change.
        if now.first == then.first {
            known(&mut now.speed, &then.speed);
        }
    }
    known(&mut view.meta.longitudinal, &before.meta.longitudinal);
    known(&mut view.meta.lateral, &before.meta.lateral);
    for (name, then) in &before.signals {
        let Some(now) = view.signals.get_mut(name) else { continue };
        now.iter_mut().zip(then).filter(|(_, v)| !v.is_null()).for_each(|(now, v)| now.clone_from(v));
    }
}

fn known<T: Clone>(now: &mut [Option<T>], then: &[Option<T>]) {
    now.iter_mut().zip(then).filter(|(_, v)| v.is_some()).for_each(|(now, v)| now.clone_from(v));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::scene::{MetaView, TrackView};
    use crate::domain::workflow::Stage;
    use serde_json::json;

    fn view(stage: Stage, n: usize, speed: f64, accel: Value) -> SceneView {
        SceneView {
            stage,
            frame_rate: 10.0,
            times: (0..n).map(|i| format!("t{i}")).collect(),
            t_s: (0..n).map(|i| (i as f64 - 4.0) / 10.0).collect(),
            clip_frames: vec![0; n],
            keyframe_index: 4,
            ego: None,
            tracks: vec![TrackView {
                id: "a".into(),
                class: "car".into(),
                length: None,
                width: None,
                first: 2,
                x: vec![Some(speed); n - 2],
                y: vec![],
                heading: vec![],
                speed: vec![Some(speed); n - 2],
                visible: vec![],
            }],
            lights: vec![],
            meta: MetaView::default(),
            cameras: vec![],
            signals: [(JERK.to_owned(), vec![accel.clone(); n]), ("ego.passes".to_owned(), vec![accel; n])]
                .into(),
            about: Default::default(),
            hidden_until: None,
        }
    }

    /// Frames 0 to 4 were shown before the lock, with 11 km/h, 5 and 6 only after it.
    #[test]
    fn the_second_stage_keeps_what_the_first_one_showed() {
        let mut before = view(Stage::Stage1, 5, 11.0, json!(0.25));
        before.signals.insert("ego.passes".into(), vec![Value::Null; 5]);
        withhold_uncertain(&mut before);
        // 0.2 s before the end and later, a window of 0.2 s to either side is one-sided.
        assert_eq!(before.signals[JERK], [json!(0.25), json!(0.25), json!(0.25), Value::Null, Value::Null]);
        let mut after = view(Stage::Stage2, 7, 14.4, json!(-1.5));
        keep(&mut after, &before);
        assert_eq!(after.tracks[0].speed, [11.0, 11.0, 11.0, 14.4, 14.4].map(Some));
        assert_eq!(after.tracks[0].x[0], Some(14.4), "positions stay");
        assert_eq!(
            after.signals[JERK][..5],
            [json!(0.25), json!(0.25), json!(0.25), json!(-1.5), json!(-1.5)]
        );
        assert_eq!(after.signals["ego.passes"], vec![json!(-1.5); 7], "unknown before is not shown before");
    }
}
