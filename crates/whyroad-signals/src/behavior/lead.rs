//! More signals of the lead for rules without a target: its class, whether it brakes, stands, changes lanes or has
//! left.

use crate::behavior::stops::Standing;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use whyroad_model::Tri;
use whyroad_model::catalog::{
    CategoryValue, id,
    value::{LeadClass, TargetLaneChange},
};

/// Braking at least this hard is hard braking, m/s2 (SUMO SSM and ScenarioCharacterization: 3 m/s2).
const HARD_MPS2: f64 = -3.0;
/// A vehicle that was the lead at most this long ago has just left, s; slightly more than ten frames of a jittered
/// clock.
const JUST_S: f64 = 1.02;

/// The last lead within the last second, which is no longer the lead, is observed ahead and outside of the lane.
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
    // A lead that is no longer observed may have left or be hidden.
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
        Some((k, _)) => LeadClass::from_name(targets[k].track.class.id()),
        None => known(i).then_some(LeadClass::None),
    };
    table.category(id::LEAD_CLASS, (0..n).map(class));
    let flag = |value: &dyn Fn(usize, usize) -> Tri| -> Vec<Tri> {
        let at = |i: usize| match near.lead[i] {
            Some((k, r)) => value(k, r),
            None if known(i) => Tri::False,
            None => Tri::Unknown,
        };
        (0..n).map(at).collect()
    };
    table.flag(id::LEAD_LARGE, flag(&|k, _| targets[k].track.class.large_vehicle()));
    let braking = |k: usize, r: usize| match targets[k].accel[r] {
        a if a.is_nan() => Tri::Unknown,
        a => Tri::from(a <= HARD_MPS2),
    };
    table.flag(id::LEAD_BRAKING, flag(&braking));
    let stopped = |i: usize| match near.lead[i] {
        Some((k, r)) => standing[k].time[r],
        None if known(i) => 0.0,
        None => f64::NAN,
    };
    table.number(id::LEAD_STOPPED_TIME, (0..n).map(stopped).collect());
    if table.has(id::TARGET_LANE_CHANGE) {
        let changing = |k: usize, r: usize| {
            let frame = targets[k].track.frames[r] as usize;
            let change = table.target_category(id::TARGET_LANE_CHANGE, k, frame);
            change.map(|c| c != TargetLaneChange::None).into()
        };
        let column = flag(&changing);
        table.flag(id::LEAD_CHANGES_LANE, column);
    }
    table.flag(id::LEAD_LEFT_LANE, (0..n).map(|i| left_lane(scene, i)).collect());
}
