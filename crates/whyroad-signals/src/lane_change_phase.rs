//! Phases of the ego's lane changes (LABELING.md 4), and lane changes that it gave up.

use crate::ego_lane::{OVER_LINE_M, lateral_extent};
use crate::interaction::Interaction;
use crate::lane_change::{self, Change, Side};
use crate::placement::MOVING_MPS;
use crate::road::Road;
use crate::series::GAP_S;
use crate::table::TableBuilder;
use whyroad_model::Tri;
use whyroad_model::road_map::LaneKind;
use whyroad_model::scene::TurnSignal;

/// An indicator is on for at most this long before a lane change because of it, s.
const PREPARE_LONGEST_S: f64 = 10.0;
/// Preparation where the log tells no indicator, s (LABELING.md 4: widened by 2 s).
const PREPARE_S: f64 = 2.0;
/// Within this of the lane's centre it is centred, m (LABELING.md 4).
const CENTRED_M: f64 = 0.3;
/// Farther off the centre than this it has left it, m.
const LEFT_CENTRE_M: f64 = 0.5;
/// An excursion longer than this is a way of driving, s.
const LONGEST_S: f64 = 20.0;
/// The turn back is where the offset falls this much under its peak, m.
const TURNED_BACK_M: f64 = 0.05;

// Indices into the catalogue's values of ego.lane_change_phase; a test holds them to the names.
const NONE: u16 = 0;
const PREPARE: u16 = 1;
const EXECUTE: u16 = 2;
const COMPLETE: u16 = 3;

fn shows(signal: TurnSignal, side: Side) -> bool {
    matches!((signal, side), (TurnSignal::Left, Side::Left) | (TurnSignal::Right, Side::Right))
}

/// First frame of the preparation for `change`.
fn prepared_from(scene: &Interaction<'_>, change: &Change, earliest: usize) -> usize {
    let times = scene.times;
    let signals = scene.drive.ego.as_ref().map_or(&[][..], |e| &e.bus.turn_signal[..]);
    let signal = |i: usize| signals.get(i).copied().flatten();
    let told = signal(change.start).is_some();
    let longest = if told { PREPARE_LONGEST_S } else { PREPARE_S };
    let mut from = change.start;
    while from > earliest
        && times[change.start] - times[from - 1] <= longest + 0.02
        && times[from] - times[from - 1] <= GAP_S
        && (!told || signal(from - 1).is_some_and(|s| shows(s, change.side)))
    {
        from -= 1;
    }
    from
}

fn phases(scene: &Interaction<'_>, changes: &[Change], known: impl Fn(usize) -> bool) -> Vec<Option<u16>> {
    let mut codes: Vec<Option<u16>> = (0..scene.times.len()).map(|i| known(i).then_some(NONE)).collect();
    for change in changes {
        let earliest = (0..change.start).rfind(|&i| codes[i] != Some(NONE)).map_or(0, |i| i + 1);
        codes[prepared_from(scene, change, earliest)..change.start].fill(Some(PREPARE));
        codes[change.start..change.crossing].fill(Some(EXECUTE));
        codes[change.crossing..change.end].fill(Some(COMPLETE));
    }
    codes
}

/// A stretch off the lane's centre, to one side.
struct Excursion {
    first: usize,
    /// One past the last frame off the centre: there it is centred again.
    end: usize,
    side: usize,
}

/// Unbroken stretches off the centre of one lane (and its successors), that begin and end centred.
fn excursions(scene: &Interaction<'_>, road: &Road) -> Vec<Excursion> {
    let Some(lanes) = scene.around.lanes else { return Vec::new() };
    let (mut found, mut open): (Vec<Excursion>, Option<Excursion>) = (Vec::new(), None);
    let mut last: Option<(usize, usize, f64)> = None;
    for i in 0..scene.times.len() {
        let now =
            lanes.at(i).filter(|on| !road.lanes[on.lane].in_junction).map(|on| (i, on.lane, on.lateral));
        let joined = match (last, now) {
            (Some((j, before, _)), Some((_, lane, _))) => {
                scene.times[i] - scene.times[j] <= GAP_S
                    && (before == lane || road.lanes[before].successors.contains(&lane))
            }
            _ => false,
        };
        let off = now.map_or(0.0, |(_, _, offset)| offset);
        let side = usize::from(off < 0.0);
        if !joined || open.as_ref().is_some_and(|x| off.abs() > CENTRED_M && x.side != side) {
            open = None;
        }
        if off.abs() <= CENTRED_M {
            found.extend(open.take().map(|x| Excursion { end: i, ..x }));
        } else if open.is_none() && joined && last.is_some_and(|(_, _, before)| before.abs() <= CENTRED_M) {
            open = Some(Excursion { first: i, end: i, side });
        }
        last = now;
    }
    found
}

/// Frames from the turn back until centred, for an excursion that was an attempt.
fn given_up(scene: &Interaction<'_>, road: &Road, x: &Excursion) -> Option<std::ops::Range<usize>> {
    let (lanes, ego) = (scene.around.lanes?, scene.around.ego);
    let sign = if x.side == 0 { 1.0 } else { -1.0 };
    let off = |i: usize| lanes.at(i).map_or(f64::NEG_INFINITY, |on| sign * on.lateral);
    let peak = (x.first..x.end).max_by(|&a, &b| off(a).total_cmp(&off(b)))?;
    let on = lanes.at(peak)?;
    let beside = road.lanes[on.lane].neighbours[x.side]?;
    if !matches!(road.lanes[beside].kind, LaneKind::Vehicle | LaneKind::Bus)
        || scene.times[x.end] - scene.times[x.first] > LONGEST_S
        || ego.speed[peak] < MOVING_MPS
    {
        return None;
    }
    let (low, high) = lateral_extent(on.corridor, &ego.footprint(peak), on.s);
    let (left, right) = on.corridor.widths_at(on.s);
    let over = if x.side == 0 { high > left + OVER_LINE_M } else { low < -right - OVER_LINE_M };
    if off(peak) <= LEFT_CENTRE_M && !over {
        return None;
    }
    let turned = (peak..x.end).rfind(|&i| off(i) >= off(peak) - TURNED_BACK_M)?;
    Some(turned + 1..x.end)
}

/// Writes `ego.lane_change_phase`, `lane_change_aborted`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let (Some(road), Some(lanes)) = (scene.around.road, scene.around.lanes) else { return };
    let ego = scene.around.ego;
    let rows = lane_change::Rows {
        times: scene.times,
        position: &ego.position,
        velocity: &ego.velocity,
        places: &lanes.places,
    };
    let changes = lane_change::found(road, &rows);
    let known = |i: usize| lanes.places[i].is_some();
    table.category("ego.lane_change_phase", phases(scene, &changes, known));
    let mut aborted: Vec<Tri> =
        (0..ego.len()).map(|i| if known(i) { Tri::False } else { Tri::Unknown }).collect();
    for range in excursions(scene, road).iter().filter_map(|x| given_up(scene, road, x)) {
        let changing = |i: usize| changes.iter().any(|c| (c.start..c.end).contains(&i));
        if !range.clone().any(changing) {
            aborted[range].fill(Tri::True);
        }
    }
    table.flag("ego.lane_change_aborted", aborted);
}
