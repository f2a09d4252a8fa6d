//! The point where a target's straight course crosses the ego's path, and when both get there; whether it really
//! crosses, as recorded; and the time gap that an oncoming vehicle leaves to a turning ego.

use crate::geometry::{P2, Ray, angle_between_lines, wrap};
use crate::road::junction;
use crate::road::stretch::Stretch;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::placement::{MOVING_MPS, Placement, Surroundings, Target};
use crate::target::rows::Rows;
use std::ops::Range;
use whyroad_model::Tri;
use whyroad_model::catalog::id;

/// Courses that meet at a smaller angle run along each other: 20 deg.
const CROSSING_LEAST_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Maximum distance along a course, m.
const REACH_M: f64 = 100.0;
/// Maximum time until a crossing, s.
const SOON_S: f64 = 10.0;
/// A target that has crossed is still reported for this long, s.
const JUST_S: f64 = 3.0;
/// Below this speed the ego is at standstill, m/s.
const STANDS_MPS: f64 = 0.1;
/// A junction farther ahead does not concern the ego yet, m (LABELING.md 4: 60 m before a junction).
const JUNCTION_REACH_M: f64 = 60.0;
/// A crossing within this distance of a junction's border is in it, m.
const BORDER_M: f64 = 3.0;
/// A target that approaches the junction at this angle or more to the ego's entry is oncoming: 115 deg, as for
/// `map.opposing_arm`.
const ONCOMING_RAD: f64 = 115.0 * std::f64::consts::PI / 180.0;
/// Rows farther apart in time than this show no crossing between them, s.
const JOINED_S: f64 = 0.55;

/// A crossing ahead of both.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    /// Time until the target's front end is there, s.
    theirs: f64,
    /// Time until the ego's front bumper is there, s.
    own: f64,
    /// Its position on the path, arc length, m.
    s: f64,
}

/// The segments of the path on which a crossing is possible while the ego is at `ego_s`: from its rear to 150 m ahead.
fn ahead(around: &Surroundings<'_>, ego_s: f64) -> Range<usize> {
    let at = around.path.line.arc_lengths();
    let first = at.partition_point(|&s| s <= ego_s - around.ego.length / 2.0).saturating_sub(1);
    // The last point begins no segment.
    first..at.partition_point(|&s| s <= ego_s + 150.0).min(at.len() - 1).max(first)
}

/// The first crossing of the course with these segments of the path, ahead of the ego's rear.
fn crossing(p: &Placement, around: &Surroundings<'_>, among: &Range<usize>) -> Option<Crossing> {
    if p.speed() < MOVING_MPS || !p.same_level || !p.within_reach() {
        return None;
    }
    let direction = p.velocity * (1.0 / p.speed());
    let length = p.footprint.length;
    let rear = p.footprint.center - direction * (length / 2.0);
    let (ego_s, half) = (around.path.ego_s[p.frame], around.ego.length / 2.0);
    let line = &around.path.line;
    let (points, at, lengths) = (line.points(), line.arc_lengths(), line.segment_lengths());
    let least_sine = CROSSING_LEAST_RAD.sin();
    let mut best: Option<(f64, f64)> = None;
    for i in line.segments_met(Ray { from: rear, direction, reach: REACH_M }, among.clone()) {
        let segment = points[i + 1] - points[i];
        let across = direction.cross(segment);
        // Sine of the angle, times the segment's length.
        if across.abs() < least_sine * lengths[i] {
            continue;
        }
        let to = points[i] - rear;
        let (ahead, aside) = (to.cross(segment), to.cross(direction));
        // Most segments end beside the course by more than rounding errors: nothing is divided for them.
        if aside * across < 0.0 || aside.abs() > across.abs() * (1.0 + 1e-12) {
            continue;
        }
        let (x, share) = (ahead / across, aside / across);
        let s = at[i] + share * (at[i + 1] - at[i]);
        if (0.0..=1.0).contains(&share)
            && (0.0..=REACH_M).contains(&x)
            && s >= ego_s - half
            && best.is_none_or(|b| x < b.0)
        {
            best = Some((x, s));
        }
    }
    let (x, s) = best?;
    let speed = around.ego.forward_speed[p.frame];
    let own = if s - ego_s <= half {
        0.0
    } else if speed < STANDS_MPS {
        f64::INFINITY
    } else {
        (s - ego_s - half) / speed
    };
    Some(Crossing { theirs: (x - length).max(0.0) / p.speed(), own, s })
}

/// Times at which the target's center passes over the path ahead of the ego in the recording, s.
fn recorded(target: &Target<'_>, around: &Surroundings<'_>, times: &[f64]) -> Vec<f64> {
    let known: Vec<&Placement> = target.places.iter().flatten().collect();
    let crosses = |a: &Placement, b: &Placement| {
        let sides = a.path.lateral * b.path.lateral < 0.0 || (b.path.lateral == 0.0 && a.path.lateral != 0.0);
        let near = a.path.lateral.abs().max(b.path.lateral.abs()) < 10.0;
        let ahead = b.ahead >= -around.ego.length / 2.0 && b.within_reach() && b.same_level;
        let turned = b.speed() >= MOVING_MPS
            && angle_between_lines(b.direction(), b.path.heading) >= CROSSING_LEAST_RAD;
        sides && near && ahead && turned && times[b.frame] - times[a.frame] <= JOINED_S
    };
    known.windows(2).filter(|w| crosses(w[0], w[1])).map(|w| times[w[1].frame]).collect()
}

/// The junction that concerns the ego at `ego_s`, and the direction in which it enters it.
fn junction_ahead(junctions: &[Stretch], around: &Surroundings<'_>, frame: usize) -> Option<(Stretch, f64)> {
    let (ego_s, half) = (around.path.ego_s[frame], around.ego.length / 2.0);
    let next = junctions.iter().find(|j| j.to >= ego_s)?;
    let near = next.from - ego_s - half <= JUNCTION_REACH_M;
    near.then(|| (*next, around.path.heading_at(next.from - 1.0)))
}

/// Writes `target.time_to_conflict`, `ego_time_to_conflict`, `crosses_path`, `oncoming_gap`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let (targets, around, times) = (scene.targets, scene.around, scene.times);
    let path_ahead: Vec<Range<usize>> = around.path.ego_s.iter().map(|s| ahead(around, *s)).collect();
    let passed: Vec<Vec<f64>> = targets.iter().map(|t| recorded(t, around, times)).collect();
    let crosses = |k: usize, p: &Placement, found: Option<Crossing>| {
        let now = times[p.frame];
        let soon = found.is_some_and(|c| c.theirs <= SOON_S);
        soon || passed[k].iter().any(|t| (-JUST_S..=SOON_S).contains(&(t - now)))
    };
    // The junction ahead by frame, where there is a map.
    let entered = around.road.map(|road| {
        let junctions = junction::stretches(around.path, |p: P2| road.in_junction(p), junction::MERGE_M);
        (0..times.len()).map(|i| junction_ahead(&junctions, around, i)).collect::<Vec<_>>()
    });
    let oncoming = |k: usize, p: &Placement, found: Option<Crossing>, ahead: Option<(Stretch, f64)>| {
        let Some((junction, heading)) = ahead else { return f64::INFINITY };
        let faces = || wrap(p.course() - heading).abs() >= ONCOMING_RAD - 1e-9;
        let inside = |c: &Crossing| c.s >= junction.from - BORDER_M && c.s <= junction.to + BORDER_M;
        match found.filter(inside) {
            Some(c) if targets[k].track.class.is_vehicle() && faces() => c.theirs,
            _ => f64::INFINITY,
        }
    };
    let mut crossing_soon = rows.column(Tri::Unknown);
    let [mut theirs, mut own, mut gaps] = [(); 3].map(|()| rows.column(f64::NAN));
    rows.each_placed(targets, |row, (k, _), p| {
        let found = if p.is_sized() { crossing(p, around, &path_ahead[p.frame]) } else { None };
        if p.velocity.is_finite() {
            crossing_soon.0[row] = Tri::from(crosses(k, p, found));
        }
        if p.is_sized() && p.velocity.is_finite() {
            (theirs.0[row], own.0[row]) = found.map_or((f64::INFINITY, f64::INFINITY), |c| (c.theirs, c.own));
            if let Some(entered) = &entered {
                gaps.0[row] = oncoming(k, p, found, entered[p.frame]);
            }
        }
    });
    table.number(id::TARGET_TIME_TO_CONFLICT, theirs);
    table.number(id::TARGET_EGO_TIME_TO_CONFLICT, own);
    table.flag(id::TARGET_CROSSES_PATH, crossing_soon);
    if entered.is_some() {
        table.number(id::TARGET_ONCOMING_GAP, gaps);
    }
}
