//! Values near the end of the drive that a stage shows, which in Stage I is the keyframe: what later measurements would
//! change is marked, or withheld.

use crate::domain::scene::SceneView;
use serde_json::Value;
use std::collections::BTreeSet;

/// Half of the window of a derivative, s (`schema/signals.yaml`, `ego.jerk`): nearer to the end it is one-sided.
const REACH_S: f64 = 0.2;
/// Half of the window of an acceleration that is computed from positions, s.
const ACCEL_REACH_S: f64 = 0.3;
const ACCEL: &str = "ego.accel";
/// The derivative of the acceleration: one-sided it is mostly noise, and uncertain wherever its window has an
/// acceleration that is.
const JERK: &str = "ego.jerk";

/// Actions of the ego: a run that is shorter joins the one before, s (`schema/signals.yaml`, `ego.meta_longitudinal`).
const LEAST_RUN_S: f64 = 0.5;
const SPEEDS: [&str; 2] = ["ego.forward_speed", "ego.speed"];
const ACTIONS: [&str; 2] = ["ego.meta_longitudinal", "ego.meta_lateral"];

/// Removes values at the end of what Stage I shows that later measurements would change beyond use.
pub(super) fn withhold_uncertain(view: &mut SceneView) {
    let Some(end) = view.t_s.last().copied() else { return };
    let Some(jerk) = view.signals.get_mut(JERK) else { return };
    let near = view.t_s.iter().map(|t| *t > end - REACH_S + 1e-3);
    jerk.iter_mut().zip(near).filter(|(_, near)| *near).for_each(|(v, _)| *v = Value::Null);
}

/// Distances along the ego's way. Beyond the end of the drive its way is assumed to lead along the lane: what it has
/// not reached there may be nearer or farther.
const AHEAD: [&str; 4] = [
    "map.distance_to_junction",
    "map.distance_to_crosswalk",
    "map.distance_to_stop_line",
    "light.distance_to_stop_line",
];

/// Units of rates of change, which are computed from what is on both sides of a moment.
const RATES: [&str; 3] = ["m/s2", "m/s3", "rad/s"];
/// Standard deviations that are this much longer than usual are those of an end.
const MUCH_LONGER: f64 = 1.5;

/// The ends of a drive that are shown: beyond them nothing is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    /// The first frame shown is that of the drive.
    pub start: bool,
    /// The last frame shown is that of the drive, which in Stage I ends at the keyframe.
    pub end: bool,
}

/// Marks the rates of change at the ends of the drive, where measurements beyond would change them, except those that
/// the log has (`measured`), other estimates whose deviations rise there, and the ego's actions at its end.
pub(super) fn mark_uncertain(view: &mut SceneView, ends: Ends, measured: &[&str]) {
    let n = view.t_s.len();
    let (Some(first), Some(last)) = (view.t_s.first().copied(), view.t_s.last().copied()) else { return };
    let t_s = &view.t_s;
    let start_of = |reach: f64| t_s.partition_point(|t| *t < first + reach - 1e-3);
    let end_of = |reach: f64| t_s.partition_point(|t| *t <= last - reach + 1e-3);
    // Within the shortest run of the end what follows may change an action.
    let last_run = end_of(LEAST_RUN_S);
    if ends.end && last_run < n {
        view.uncertain.extend(ACTIONS.map(|name| (name.to_owned(), vec![[last_run, n]])));
    }
    let is_rate = |unit: Option<&str>| unit.is_some_and(|unit| RATES.contains(&unit));
    let read = view.about.iter().filter(|(_, a)| is_rate(a.unit.as_deref())).map(|(name, _)| name.clone());
    let of_ego = [ACCEL, "ego.yaw_rate"].map(str::to_owned);
    // A speed that is computed from positions alone is a rate of change, too.
    let has_no_spread = |name: &&str| !view.deviations.contains_key(*name);
    let speeds = SPEEDS.into_iter().filter(has_no_spread).map(str::to_owned);
    let rates: BTreeSet<String> = read.chain(of_ego).chain(speeds).collect();
    // An estimate of anything else is uncertain where its deviations say so: a speed that is still changing.
    let names: BTreeSet<String> = view.deviations.keys().cloned().chain(rates.iter().cloned()).collect();
    for name in names.into_iter().filter(|name| !measured.contains(&name.as_str())) {
        let known = view.deviations.get(&name);
        let wide = |from_start| known.map_or(0, |deviations| wide_end(deviations, from_start));
        let has_speeds = SPEEDS.iter().any(|speed| measured.contains(speed));
        let reach = if name.ends_with(".accel") && !has_speeds { ACCEL_REACH_S } else { REACH_S };
        let (start, end) = if rates.contains(&name) { (start_of(reach), end_of(reach)) } else { (0, n) };
        let mut ranges = Vec::new();
        if ends.start {
            ranges.push([0, start.max(wide(true)).min(n)]);
        }
        if ends.end {
            ranges.push([end.min(n - wide(false)), n]);
        }
        ranges.retain(|[from, to]| from < to);
        if !ranges.is_empty() {
            view.uncertain.insert(name, ranges);
        }
    }
    for name in AHEAD.iter().filter(|_| ends.end) {
        let values = view.signals.get(*name).map_or(&[][..], Vec::as_slice);
        let ahead = values.iter().rev().take_while(|v| v.as_f64().is_some_and(|v| v > 0.0)).count();
        if ahead > 0 {
            view.uncertain.insert((*name).to_owned(), vec![[values.len() - ahead, values.len()]]);
        }
    }
    // After all others: it needs the acceleration's.
    let (Some(accel), true) = (view.uncertain.get(ACCEL), view.uncertain.contains_key(JERK)) else { return };
    let widened = accel.iter().map(|&[from, to]| {
        let before = if from == 0 { 0 } else { t_s.partition_point(|t| *t < t_s[from] - REACH_S - 1e-3) };
        [before, t_s.partition_point(|t| *t <= t_s[to - 1] + REACH_S + 1e-3)]
    });
    let widened = widened.collect();
    view.uncertain.insert(JERK.to_owned(), widened);
}

/// Number of frames from the start, or from the end, whose deviations are all much longer than in the middle.
fn wide_end(deviations: &[Option<f64>], from_start: bool) -> usize {
    let mut known: Vec<f64> = deviations.iter().copied().flatten().collect();
    known.sort_by(f64::total_cmp);
    let Some(usual) = known.get(known.len().saturating_sub(1) / 2).copied().filter(|usual| *usual > 0.0)
    else {
        return 0;
    };
    let is_wide = |d: &&Option<f64>| d.is_none_or(|d| d > MUCH_LONGER * usual);
    if from_start {
        deviations.iter().take_while(is_wide).count()
    } else {
        deviations.iter().rev().take_while(is_wide).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::scene::{MetaView, SignalAbout, SignalKind, TrackView};
    use crate::domain::workflow::Stage;
    use serde_json::json;
    use whyroad_model::Bilingual;

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
            deviations: Default::default(),
            uncertain: Default::default(),
            about: Default::default(),
            hidden_until: None,
        }
    }

    /// 0.2 s before the end and later, a window of 0.2 s to either side is one-sided.
    #[test]
    fn the_jerk_at_the_end_is_withheld() {
        let mut before = view(Stage::Stage1, 5, 11.0, json!(0.25));
        withhold_uncertain(&mut before);
        assert_eq!(before.signals[JERK], [json!(0.25), json!(0.25), json!(0.25), Value::Null, Value::Null]);
    }

    /// Frames every 0.1 s: a window of 0.2 s to either side is one-sided in two frames. The deviations of a smoother
    /// rise towards an end (made up).
    #[test]
    fn rates_of_change_are_uncertain_at_the_ends() {
        let at_end = Ends { start: false, end: true };
        let mut before = view(Stage::Stage1, 6, 11.0, json!(0.25));
        mark_uncertain(&mut before, at_end, &["ego.yaw_rate"]);
        assert_eq!(
            before.uncertain.remove("ego.accel"),
            Some(vec![[3, 6]]),
            "from positions: 0.3 s to either side"
        );
        assert!(!before.uncertain.contains_key("ego.yaw_rate"), "the log has it");
        assert_eq!(before.uncertain["ego.forward_speed"], [[4, 6]], "from positions");
        before.uncertain.clear();
        mark_uncertain(&mut before, at_end, &["ego.yaw_rate", "ego.forward_speed"]);
        assert!(!before.uncertain.contains_key("ego.forward_speed"));
        // 0.5 s and less from the end, frames 1 to 5 of 6: a run is known after 0.5 s.
        assert_eq!(before.uncertain["ego.meta_longitudinal"], [[1, 6]]);
        before.deviations.insert("ego.accel".into(), [0.3, 0.3, 0.3, 0.5, 0.6, 0.9].map(Some).into());
        mark_uncertain(&mut before, at_end, &["ego.yaw_rate"]);
        assert_eq!(before.uncertain["ego.accel"], [[3, 6]], "by what the estimator says");
        before.deviations.insert("ego.forward_speed".into(), [0.1, 0.1, 0.1, 0.1, 0.2, 0.3].map(Some).into());
        before.deviations.insert("target.speed".into(), vec![Some(0.1); 6]);
        mark_uncertain(&mut before, at_end, &["ego.yaw_rate"]);
        assert_eq!(before.uncertain["ego.forward_speed"], [[4, 6]], "more than half as much again as usual");
        assert!(!before.uncertain.contains_key("target.speed"));
        let mut after = view(Stage::Stage2, 9, 14.4, json!(-1.5));
        after.deviations.insert("ego.accel".into(), vec![Some(0.3); 9]);
        mark_uncertain(&mut after, Ends { start: true, end: true }, &["ego.yaw_rate"]);
        assert_eq!(after.uncertain["ego.accel"], [[0, 3], [6, 9]], "not at the keyframe, frame 4");
    }

    /// Frames every 0.1 s. An acceleration from measured speeds is one-sided in the last 2 frames: the window of a
    /// jerk reaches them from 2 frames before. With a measured acceleration, only its own window is one-sided.
    #[test]
    fn a_jerk_is_uncertain_where_an_acceleration_in_its_window_is() {
        let at_end = Ends { start: false, end: true };
        let nothing = Bilingual::new("", "");
        let (kind, unit) = (SignalKind::Number, Some("m/s3".into()));
        let about = SignalAbout { kind, unit, title: nothing.clone(), meaning: nothing };
        let mut before = view(Stage::Stage1, 9, 11.0, json!(0.25));
        before.about.insert(JERK.into(), about);
        mark_uncertain(&mut before, at_end, &["ego.speed"]);
        assert_eq!((&before.uncertain[ACCEL], &before.uncertain[JERK]), (&vec![[7, 9]], &vec![[5, 9]]));
        before.uncertain.clear();
        mark_uncertain(&mut before, at_end, &["ego.speed", ACCEL]);
        assert_eq!(before.uncertain[JERK], [[7, 9]]);
    }

    /// A junction that the ego has left, and one that it has not reached when the drive ends: where it will enter that
    /// one is not known (on a recorded drive the two ways differed by 5.5 m).
    #[test]
    fn what_lies_beyond_the_end_of_the_drive_is_at_an_uncertain_distance() {
        let values = json!([2.0, 0.0, 0.0, 30.0, 29.0]);
        let mut before = view(Stage::Stage1, 5, 11.0, json!(0.25));
        before.signals.insert(AHEAD[0].into(), values.as_array().cloned().unwrap_or_default());
        mark_uncertain(&mut before, Ends { start: false, end: true }, &[]);
        assert_eq!(before.uncertain[AHEAD[0]], [[3, 5]]);
        before.uncertain.clear();
        mark_uncertain(&mut before, Ends { start: true, end: false }, &[]);
        assert!(!before.uncertain.contains_key(AHEAD[0]), "the drive goes on");
    }

    #[test]
    fn a_wide_end_lasts_until_the_deviations_are_the_usual_ones() {
        let rising = [0.9, 0.3, 0.3, 0.3, 0.3, 0.5, 0.6, 0.9].map(Some);
        assert_eq!([wide_end(&rising, true), wide_end(&rising, false)], [1, 3]);
        assert_eq!(wide_end(&[0.3; 4].map(Some), false), 0);
        assert_eq!(wide_end(&[None; 3], false), 0);
    }
}
