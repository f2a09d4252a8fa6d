//! Phases of the ego's lane changes (LABELING.md 4), and aborted lane changes.

use crate::behavior::lane_change_intention::formed;
use crate::road::ego_lane::{OVER_LINE_M, lateral_extent};
use crate::road::lane_change::{self, Side};
use crate::road::network::Road;
use crate::road::own_shift::{OnWay, most_shifted};
use crate::series::GAP_S;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::placement::MOVING_MPS;
use whyroad_model::Tri;
use whyroad_model::catalog::{id, value::EgoLaneChangePhase};
use whyroad_model::road_map::LaneKind;

/// Maximum distance from the lane's center at which the ego is centered, m (LABELING.md 4).
const CENTERED_M: f64 = 0.3;
/// Minimum distance from the center at which the ego has left it, m.
const LEFT_CENTER_M: f64 = 0.5;
/// Maximum distance of the ego's side from the line to which it moves, m: within wide lanes drivers wander by half a
/// meter and more (NGSIM).
const NEAR_LINE_M: f64 = 0.3;
/// A peak is the maximum of many values: this many standard deviations of it are noise.
const PEAK_DEVIATIONS: f64 = 2.5;
/// Minimum share of the offset of an attempt that the ego's own steering caused.
const OWN_SHARE: f64 = 0.4;
/// Rows before and after an attempt in which the ego drives along its lane: 2 s at 10 Hz.
const ALONG_ROWS: usize = 20;
/// A longer excursion is not an attempt but a way of driving, s.
const LONGEST_S: f64 = 20.0;
/// The ego turns back where the offset is this much below its peak, m.
const TURNED_BACK_M: f64 = 0.05;

/// A lane change or an attempt at one, by its phases.
struct Phases {
    side: Side,
    /// First frame of `execute`.
    first: usize,
    /// One past the last frame of `execute`.
    until: usize,
    /// One past the last frame of `complete`; `until` for an attempt, which has no such phase.
    end: usize,
}

fn codes(
    scene: &Interaction<'_>,
    road: &Road,
    mut all: Vec<Phases>,
    known: impl Fn(usize) -> bool,
) -> Vec<Option<EgoLaneChangePhase>> {
    let Some(lanes) = scene.around.lanes else { return Vec::new() };
    all.sort_by_key(|p| p.first);
    let mut codes: Vec<Option<EgoLaneChangePhase>> =
        (0..scene.times.len()).map(|i| known(i).then_some(EgoLaneChangePhase::None)).collect();
    // In a junction the indicator is for the turn.
    let turns = |i: usize| lanes.at(i).is_some_and(|on| road.lanes[on.lane].in_junction);
    for p in all {
        let earliest = (0..p.first)
            .rfind(|&i| codes[i] != Some(EgoLaneChangePhase::None) || turns(i))
            .map_or(0, |i| i + 1);
        codes[formed(scene, p.side, p.first, earliest)..p.first].fill(Some(EgoLaneChangePhase::Prepare));
        codes[p.first..p.until].fill(Some(EgoLaneChangePhase::Execute));
        codes[p.until..p.end].fill(Some(EgoLaneChangePhase::Complete));
    }
    codes
}

/// A period off the lane's center, on one side.
struct Excursion {
    first: usize,
    /// One past the last frame off the center: there it is centered again.
    end: usize,
    side: usize,
}

/// Uninterrupted periods off the center of one lane (and its successors), that begin and end centered.
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
        if !joined || open.as_ref().is_some_and(|x| off.abs() > CENTERED_M && x.side != side) {
            open = None;
        }
        if off.abs() <= CENTERED_M {
            found.extend(open.take().map(|x| Excursion { end: i, ..x }));
        } else if open.is_none() && joined && last.is_some_and(|(_, _, before)| before.abs() <= CENTERED_M) {
            open = Some(Excursion { first: i, end: i, side });
        }
        last = now;
    }
    found
}

/// Frames from turning back until centered, for an excursion that was an attempt.
fn given_up(scene: &Interaction<'_>, road: &Road, x: &Excursion) -> Option<std::ops::Range<usize>> {
    let (lanes, ego) = (scene.around.lanes?, scene.around.ego);
    let sign = if x.side == 0 { 1.0 } else { -1.0 };
    let off = |i: usize| lanes.at(i).map_or(f64::NEG_INFINITY, |on| sign * on.lateral);
    let peak = (x.first..x.end).max_by(|&a, &b| off(a).total_cmp(&off(b)))?;
    let on = lanes.at(peak)?;
    let beside = road.lanes[on.lane].neighbors[x.side]?;
    if !matches!(road.lanes[beside].kind, LaneKind::Vehicle | LaneKind::Bus)
        || scene.times[x.end] - scene.times[x.first] > LONGEST_S
        || ego.speed[peak] < MOVING_MPS
    {
        return None;
    }
    let (low, high) = lateral_extent(on.corridor, &ego.footprint(peak), on.s);
    let (left, right) = on.corridor.widths_at(on.s);
    let noise = PEAK_DEVIATIONS * ego.place_sd(peak);
    let over_line = OVER_LINE_M + noise;
    // How far the ego's side is beyond the line.
    let beyond = if x.side == 0 { high - left } else { -right - low };
    let is_near = off(peak) > LEFT_CENTER_M + noise && beyond > noise - NEAR_LINE_M;
    if !is_near && beyond <= over_line {
        return None;
    }
    // Only the ego's own steering counts: in a lane that widens or forks, an ego that drives straight on has aborted
    // nothing.
    let place = |i: usize| OnWay { position: ego.position[i], direction: scene.around.path.ego_heading[i] };
    let span = |from: usize, to: usize| (from..=to).step_by(3).map(place).collect::<Vec<_>>();
    // From before it left the center until after it was back, where it drives along the lane.
    let (first, last) = (x.first.saturating_sub(ALONG_ROWS), (x.end + ALONG_ROWS).min(ego.len() - 1));
    let out = most_shifted(&span(first, peak), &span(peak, peak), sign);
    let back = most_shifted(&span(peak, peak), &span(peak, last), -sign);
    if out.max(back) < OWN_SHARE * off(peak) {
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
        aside: &ego.asides(),
    };
    let changes = lane_change::found(road, &rows);
    let known = |i: usize| lanes.places[i].is_some();
    let mut all: Vec<Phases> = changes
        .iter()
        .map(|c| Phases { side: c.side, first: c.start, until: c.crossing, end: c.end })
        .collect();
    let mut aborted: Vec<Tri> =
        (0..ego.len()).map(|i| if known(i) { Tri::False } else { Tri::Unknown }).collect();
    for x in &excursions(scene, road) {
        let changing = |i: usize| changes.iter().any(|c| (c.start..c.end).contains(&i));
        // Without the ego's size nothing says how near to the line it came.
        if !ego.footprint(x.first).width.is_finite() {
            aborted[x.first..x.end].fill(Tri::Unknown);
            continue;
        }
        let Some(back) = given_up(scene, road, x).filter(|range| !range.clone().any(changing)) else {
            continue;
        };
        let side = if x.side == 0 { Side::Left } else { Side::Right };
        all.push(Phases { side, first: x.first, until: back.start, end: back.start });
        aborted[back].fill(Tri::True);
    }
    table.category(id::EGO_LANE_CHANGE_PHASE, codes(scene, road, all, known));
    table.flag(id::EGO_LANE_CHANGE_ABORTED, aborted);
}
