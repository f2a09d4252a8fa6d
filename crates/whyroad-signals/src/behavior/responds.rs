//! Decision moments: changes of the ego's meta action that have an effect (LABELING.md 5).

use crate::behavior::ego_offset::unrolled;
use crate::geometry::P2;
use crate::series::GAP_S;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use whyroad_model::Tri;
use whyroad_model::catalog::id;

/// Time after the change in which the effect is searched, s.
const WITHIN_S: f64 = 3.0;
/// Minimum change of speed that is an effect, m/s.
const SPEED_MPS: f64 = 1.0;
/// Minimum lateral movement that is an effect, m (LABELING.md 4: lateral displacement > 0.3 m).
const SIDEWAYS_M: f64 = 0.3;
/// A decision moment is reported for this long, s.
const PULSE_S: f64 = 0.5;

/// True in the first frame of a new action.
fn changes<C: PartialEq>(actions: &[Option<C>], i: usize) -> bool {
    i > 0 && matches!((&actions[i - 1], &actions[i]), (Some(before), Some(now)) if before != now)
}

/// Whether the action that begins in frame `i` has an effect; unknown where the recording ends too early.
fn effect(scene: &Interaction<'_>, offset: &[f64], i: usize) -> Tri {
    let (ego, times) = (scene.around.ego, scene.times);
    let in_lane = |j: usize| {
        let place = scene.around.lanes.and_then(|l| l.at(j));
        place.is_some_and(|on| scene.around.road.is_some_and(|r| !r.lanes[on.lane].in_junction))
    };
    let straight = P2::from_heading(ego.heading[i]).left();
    for j in i + 1..times.len() {
        if times[j] - times[i] > WITHIN_S + 0.02 {
            return Tri::False;
        }
        if times[j] - times[j - 1] > GAP_S || !ego.is_known(j) {
            return Tri::Unknown;
        }
        let sideways = if in_lane(i) && in_lane(j) {
            offset[j] - offset[i]
        } else {
            (ego.position[j] - ego.position[i]).dot(straight)
        };
        let faster = ego.forward_speed[j] - ego.forward_speed[i];
        // A tolerance: exactly 1 m/s must not depend on rounding.
        if faster.abs() >= SPEED_MPS - 1e-9 || sideways.abs() > SIDEWAYS_M {
            return Tri::True;
        }
    }
    Tri::Unknown
}

/// Writes `ego.responds`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let (ego, times) = (scene.around.ego, scene.times);
    let offset = unrolled(scene);
    let (along, across) = (&scene.actions.longitudinal, &scene.actions.lateral);
    let mut flags: Vec<Tri> =
        (0..ego.len()).map(|i| if ego.is_known(i) { Tri::False } else { Tri::Unknown }).collect();
    for i in (0..ego.len()).filter(|&i| changes(along, i) || changes(across, i)) {
        let found = effect(scene, &offset, i);
        if found == Tri::False {
            continue;
        }
        for (j, flag) in flags.iter_mut().enumerate().skip(i) {
            if times[j] - times[i] >= PULSE_S - 1e-6 {
                break;
            }
            if *flag != Tri::True {
                *flag = found;
            }
        }
    }
    table.flag(id::EGO_RESPONDS, flags);
}
