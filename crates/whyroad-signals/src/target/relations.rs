//! Relation of a target to the ego: lead, follower, beside, oncoming, crossing. Lead and follower are the nearest
//! vehicles in the ego's lane (see `Placement::way`) in the lane's direction.

use crate::ego::motion::EgoMotion;
use crate::geometry::wrap;
use crate::table::TableBuilder;
use crate::target::placement::{MOVING_MPS, Placement, Target};
use crate::target::rows::Rows;
use std::f64::consts::PI;
use whyroad_model::catalog::{id, value::TargetRelation};
use whyroad_model::scene::Drive;
use whyroad_model::{ObjectClass, Tri};

/// Maximum angle between a lead or follower and the lane: 60 deg (RefAV following: cos > 0.5).
const SAME_WAY_RAD: f64 = PI / 3.0;
/// Minimum angle between headings for crossing: 45 deg (RefAV).
const CROSSING_RAD: f64 = PI / 4.0;
/// Minimum angle between headings for oncoming: 135 deg (RefAV).
const ONCOMING_RAD: f64 = 3.0 * PI / 4.0;
const CROSSING_REACH_M: f64 = 50.0;
const ONCOMING_REACH_M: f64 = 100.0;
const BESIDE_REACH_M: (f64, f64) = (50.0, 6.0);

/// Lead and follower by frame: `(target index, row in its track)`.
pub struct Neighbors {
    /// The lead.
    pub lead: Vec<Option<(usize, usize)>>,
    /// The follower.
    pub follower: Vec<Option<(usize, usize)>>,
    /// By frame: an object of unknown class in the ego's lane that is nearer than the lead, and the lead if it is a
    /// vehicle.
    pub maybe_lead: Vec<Option<usize>>,
}

/// Whoever stands in the way and whose heading is not known is taken to stand along it.
fn leads_or_follows(p: &Placement) -> bool {
    let (at, _, _) = p.way();
    let turned = wrap(p.footprint.heading - at.heading).abs();
    p.blocks_way() && (turned <= SAME_WAY_RAD || (turned.is_nan() && p.speed() < MOVING_MPS))
}

/// The nearest vehicles ahead and behind in the ego's lane, frame by frame. If equal, the target with the first id is
/// used, so that the order of candidates changes nothing. A vehicle beside the ego in a wide lane, with no part in the
/// ego's way ahead, is no lead: its gap is infinite.
pub fn neighbors(targets: &[Target<'_>], frames: usize) -> Neighbors {
    let mut found =
        Neighbors { lead: vec![None; frames], follower: vec![None; frames], maybe_lead: vec![None; frames] };
    let (mut nearest, mut farthest) = (vec![f64::INFINITY; frames], vec![f64::NEG_INFINITY; frames]);
    for (k, target) in targets.iter().enumerate().filter(|(_, t)| t.track.class.is_vehicle()) {
        for (row, place) in target.places.iter().enumerate() {
            let Some(p) = place.as_ref().filter(|p| leads_or_follows(p)) else { continue };
            let i = p.frame;
            let in_path = !p.approach.gap.is_infinite();
            if p.ahead > 0.0 && in_path && p.near < nearest[i] {
                nearest[i] = p.near;
                found.lead[i] = Some((k, row));
            }
            if p.ahead <= 0.0 && p.far > farthest[i] {
                farthest[i] = p.far;
                found.follower[i] = Some((k, row));
            }
        }
    }
    for (k, target) in targets.iter().enumerate().filter(|(_, t)| t.track.class == ObjectClass::Unknown) {
        for p in target.places.iter().flatten().filter(|p| leads_or_follows(p)) {
            if p.ahead > 0.0 && p.near < nearest[p.frame] {
                nearest[p.frame] = p.near;
                found.maybe_lead[p.frame] = Some(k);
            }
        }
    }
    found
}

fn relation(p: &Placement, is_lead: bool, is_follower: bool) -> TargetRelation {
    if is_lead {
        return TargetRelation::Lead;
    }
    if is_follower {
        return TargetRelation::Follower;
    }
    if !p.same_level || !p.within_reach() {
        return TargetRelation::None;
    }
    let turned = p.turned();
    let distance = || p.ahead.hypot(p.path.lateral);
    if turned >= ONCOMING_RAD - 1e-9 {
        return if distance() <= ONCOMING_REACH_M { TargetRelation::Oncoming } else { TargetRelation::None };
    }
    if turned >= CROSSING_RAD {
        // A stationary object across the path is not crossing.
        return if p.speed() >= MOVING_MPS && distance() <= CROSSING_REACH_M {
            TargetRelation::Crossing
        } else {
            TargetRelation::None
        };
    }
    if p.in_way {
        return if p.ahead > 0.0 { TargetRelation::Ahead } else { TargetRelation::Behind };
    }
    if p.ahead.abs() <= BESIDE_REACH_M.0 && p.path.lateral.abs() <= BESIDE_REACH_M.1 {
        return if p.path.lateral > 0.0 { TargetRelation::Left } else { TargetRelation::Right };
    }
    TargetRelation::None
}

/// Writes `target.in_ego_lane`, `is_lead`, `is_follower`, `relation`.
pub fn write(drive: &Drive, targets: &[Target<'_>], near: &Neighbors, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    let is =
        |who: &[Option<(usize, usize)>], k: usize, p: &Placement| who[p.frame].is_some_and(|(j, _)| j == k);
    let [mut in_way, mut leads, mut follows] = [(); 3].map(|()| rows.column(Tri::Unknown));
    let mut relations = rows.column(None);
    rows.each_placed(targets, |row, (k, _), p| {
        let (is_lead, is_follower) = (is(&near.lead, k, p), is(&near.follower, k, p));
        in_way.0[row] = Tri::from(p.in_way);
        // Whether it leads depends on its class, or on that of another one.
        let is_open = near.maybe_lead[p.frame].is_some_and(|j| j == k || is_lead);
        leads.0[row] = if is_open { Tri::Unknown } else { Tri::from(is_lead) };
        follows.0[row] = Tri::from(is_follower);
        relations.0[row] = Some(relation(p, is_lead, is_follower));
    });
    table.flag(id::TARGET_IN_EGO_LANE, in_way);
    table.flag(id::TARGET_IS_LEAD, leads);
    table.flag(id::TARGET_IS_FOLLOWER, follows);
    table.category(id::TARGET_RELATION, relations);
}

/// Writes the `lead.*` signals: the lead's own target signals, copied to the frame.
pub fn write_lead(ego: &EgoMotion, near: &Neighbors, table: &mut TableBuilder<'_>) {
    let frames = 0..ego.len();
    let known = |i: usize| ego.is_known(i);
    table.flag(
        id::LEAD_EXISTS,
        frames
            .clone()
            .map(|i| match near.lead[i] {
                None if !known(i) || near.maybe_lead[i].is_some() => Tri::Unknown,
                lead => Tri::from(lead.is_some()),
            })
            .collect(),
    );
    let copies = [
        (id::LEAD_GAP, id::TARGET_GAP, f64::INFINITY),
        (id::LEAD_TTC, id::TARGET_TTC, f64::INFINITY),
        (id::LEAD_THW, id::TARGET_THW, f64::INFINITY),
        (id::LEAD_SPEED, id::TARGET_SPEED, f64::NAN),
        (id::LEAD_ACCEL, id::TARGET_ACCEL, f64::NAN),
    ];
    for (id, source, without) in copies {
        let value = |i: usize| match near.lead[i] {
            _ if near.maybe_lead[i].is_some() => f64::NAN,
            Some((k, _)) => table.target_number(source, k, i),
            None if known(i) => without,
            None => f64::NAN,
        };
        let column = frames.clone().map(value).collect();
        table.number(id, column);
    }
}
