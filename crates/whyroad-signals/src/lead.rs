//! More about the lead for rules without a target: what it is, whether it brakes, stands, changes lanes or has left.

use crate::interaction::Interaction;
use crate::lane_change::NONE;
use crate::stops::Standing;
use crate::table::TableBuilder;
use whyroad_model::{Column, ObjectClass, Tri};

/// Braking from this on is hard, m/s2 (SUMO SSM and ScenarioCharacterization: 3 m/s2).
const HARD_MPS2: f64 = -3.0;
/// A lead of at most this long ago has just left, s; a hair over ten frames of a jittered clock.
const JUST_S: f64 = 1.02;

/// Index of the class in the values of lead.class, after `none`.
fn class_code(class: ObjectClass) -> Option<u16> {
    ObjectClass::ALL.iter().position(|&c| c == class).and_then(|i| u16::try_from(i + 1).ok())
}

/// The last lead within the last second that is no lead any more is seen, ahead, out of the lane.
fn left_lane(scene: &Interaction<'_>, i: usize) -> Tri {
    if !scene.around.ego.is_known(i) {
        return Tri::Unknown;
    }
    let recent = (0..i).rev().take_while(|&j| scene.times[i] - scene.times[j] <= JUST_S);
    let now = scene.near.lead[i].map(|(k, _)| k);
    let mut seen = false;
    for k in recent.filter_map(|j| scene.near.lead[j].map(|(k, _)| k)).filter(|k| Some(*k) != now) {
        seen = true;
        let target = &scene.targets[k];
        let place = target.track.row_at(i).and_then(|r| target.places[r].as_ref());
        if place.is_some_and(|p| !p.in_way && p.ahead > 0.0) {
            return Tri::True;
        }
    }
    // A lead that is not seen any more may have left or be hidden.
    let lost = |k: usize| scene.targets[k].track.row_at(i).is_none();
    let gone = seen
        && (0..i)
            .rev()
            .take_while(|&j| scene.times[i] - scene.times[j] <= JUST_S)
            .any(|j| scene.near.lead[j].is_some_and(|(k, _)| lost(k)));
    if gone { Tri::Unknown } else { Tri::False }
}

/// Writes `lead.class`, `large`, `braking`, `stopped_time`, `changes_lane`, `left_lane`.
pub fn write(scene: &Interaction<'_>, standing: &[Standing], table: &mut TableBuilder<'_>) {
    let (near, targets) = (scene.near, scene.targets);
    let n = scene.times.len();
    let known = |i: usize| scene.around.ego.is_known(i);
    let class = |i: usize| match near.lead[i] {
        Some((k, _)) => class_code(targets[k].track.class),
        None => known(i).then_some(0),
    };
    table.category("lead.class", (0..n).map(class));
    let flag = |value: &dyn Fn(usize, usize) -> Tri| -> Vec<Tri> {
        let at = |i: usize| match near.lead[i] {
            Some((k, r)) => value(k, r),
            None if known(i) => Tri::False,
            None => Tri::Unknown,
        };
        (0..n).map(at).collect()
    };
    table.flag("lead.large", flag(&|k, _| Tri::from(targets[k].track.class.is_large_vehicle())));
    let braking = |k: usize, r: usize| match targets[k].accel[r] {
        a if a.is_nan() => Tri::Unknown,
        a => Tri::from(a <= HARD_MPS2),
    };
    table.flag("lead.braking", flag(&braking));
    let stopped = |i: usize| match near.lead[i] {
        Some((k, r)) => standing[k].time[r],
        None if known(i) => 0.0,
        None => f64::NAN,
    };
    table.number("lead.stopped_time", (0..n).map(stopped).collect());
    if let Some(Column::Category { codes, .. }) = table.column("target.lane_change") {
        let spans = table.targets();
        let changing = |k: usize, r: usize| {
            let frame = targets[k].track.frames[r] as usize;
            match spans[k].row(frame).map(|row| codes[row]) {
                Some(code) if code != whyroad_model::column::UNKNOWN_CODE => Tri::from(code != NONE),
                _ => Tri::Unknown,
            }
        };
        let column = flag(&changing);
        table.flag("lead.changes_lane", column);
    }
    table.flag("lead.left_lane", (0..n).map(|i| left_lane(scene, i)).collect());
}
