//! The `pair.` signals: relations of two near objects, relative to the first.

use super::body::Body;
use super::scene::Scene;
use super::single::category;
use crate::geometry::{P2, wrap};
use crate::refav::{
    self, DIRECTED_MPS, FOLLOWING_BESIDE_M, FOLLOWING_COS, FOLLOWING_M, HEADING_SPEED_MPS, has_free_will,
};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_4, PI};
use whyroad_model::catalog::CategoryValue;
use whyroad_model::catalog::value::{PairDirection, PairRoadSide, PairSector};
use whyroad_model::pair::PairSpan;
use whyroad_model::{Column, Tri};

/// Minimum speed of an object with a direction of motion, m/s.
const COURSE_MPS: f64 = 0.1;

/// Two objects in a frame in which both are observed and near each other.
struct Meeting<'a> {
    a: &'a Body,
    i: usize,
    b: &'a Body,
    k: usize,
    first: usize,
    second: usize,
}

impl Meeting<'_> {
    fn is_sized(&self) -> bool {
        self.a.has_box(self.i) && self.b.has_box(self.k)
    }

    /// The second one's center in the first one's axes.
    fn seen(&self) -> P2 {
        self.a.sees(self.i, self.b.position[self.k])
    }

    fn offset(&self) -> P2 {
        self.b.position[self.k] - self.a.position[self.i]
    }
}

/// The column of a signal; `None` if none of its values can be known.
pub(super) fn column(scene: &Scene<'_>, name: &str, spans: &[PairSpan], near: &[bool]) -> Option<Column> {
    let rows = Rows { scene, spans, near };
    Some(match name {
        "pair.distance" => Column::Number(rows.symmetric(f64::INFINITY, distance)),
        "pair.ttc_box" => Column::Number(rows.symmetric(f64::INFINITY, ttc_box)),
        "pair.closing" => Column::Number(rows.symmetric(f64::NAN, closing)),
        "pair.forward" => Column::Number(rows.each(f64::NAN, f64::NAN, |m| m.seen().x)),
        "pair.lateral" => Column::Number(rows.each(f64::NAN, f64::NAN, |m| m.seen().y)),
        "pair.bearing" => Column::Number(rows.each(f64::NAN, f64::NAN, |m| m.seen().heading())),
        "pair.course" => Column::Number(rows.each(f64::NAN, f64::NAN, course)),
        "pair.sector" => rows.category(PairSector::None, sector),
        "pair.direction" => rows.category(PairDirection::None, direction),
        "pair.same_lane" => {
            let (road, lanes) = (scene.road?, scene.lanes?);
            rows.flags(|m| {
                let (Some(a), Some(b)) = (lanes.lanes[m.first][m.i], lanes.lanes[m.second][m.k]) else {
                    return Tri::False;
                };
                Tri::from(a == b || lanes.chain(road, a).contains(&b))
            })
        }
        "pair.road_side" => {
            let (road, lanes) = (scene.road?, scene.lanes?);
            rows.category(PairRoadSide::None, |m| {
                let (Some(a), Some(b)) = (lanes.lanes[m.first][m.i], lanes.lanes[m.second][m.k]) else {
                    return Some(PairRoadSide::None);
                };
                let sides = lanes.sides(road, a);
                Some(if sides.same.contains(&b) {
                    PairRoadSide::Same
                } else if sides.opposite.contains(&b) {
                    PairRoadSide::Opposite
                } else {
                    PairRoadSide::None
                })
            })
        }
        "pair.follows" => {
            scene.lanes?;
            rows.flags(|m| follows(scene, m))
        }
        "pair.crosses" => Column::Flag(crosses(&rows)),
        _ => return None,
    })
}

/// The rows of all pairs.
struct Rows<'a> {
    scene: &'a Scene<'a>,
    spans: &'a [PairSpan],
    near: &'a [bool],
}

impl Rows<'_> {
    /// A value for each row: `unseen` where one of the two is not observed, `far` where they are not near.
    fn each<T: Clone>(&self, unseen: T, far: T, f: impl Fn(&Meeting<'_>) -> T) -> Vec<T> {
        let mut out = Vec::with_capacity(self.near.len());
        for span in self.spans {
            self.of_span(span, (&unseen, &far), &f, &mut out);
        }
        out
    }

    fn of_span<T: Clone>(
        &self,
        span: &PairSpan,
        (unseen, far): (&T, &T),
        f: impl Fn(&Meeting<'_>) -> T,
        out: &mut Vec<T>,
    ) {
        let (a, b) = (&self.scene.bodies[span.first], &self.scene.bodies[span.second]);
        for (row, frame) in span.rows().zip(span.frames.start..) {
            out.push(match (a.at(frame), b.at(frame)) {
                (Some(i), Some(k)) if self.near[row] => {
                    f(&Meeting { a, i, b, k, first: span.first, second: span.second })
                }
                (Some(_), Some(_)) => far.clone(),
                _ => unseen.clone(),
            });
        }
    }

    /// A number that is symmetric, computed once.
    fn symmetric(&self, far: f64, f: impl Fn(&Meeting<'_>) -> f64) -> Vec<f64> {
        let mut out: Vec<f64> = Vec::with_capacity(self.near.len());
        let mut done: HashMap<(usize, usize), usize> = HashMap::new();
        for span in self.spans {
            match done.get(&(span.second, span.first)) {
                Some(&from) => out.extend_from_within(from..from + span.frames.len()),
                None => {
                    done.insert((span.first, span.second), out.len());
                    self.of_span(span, (&f64::NAN, &far), &f, &mut out);
                }
            }
        }
        out
    }

    fn flags(&self, f: impl Fn(&Meeting<'_>) -> Tri) -> Column {
        Column::Flag(self.each(Tri::Unknown, Tri::False, f))
    }

    fn category<C: CategoryValue>(&self, far: C, f: impl Fn(&Meeting<'_>) -> Option<C>) -> Column {
        category(self.each(None, Some(far), f))
    }
}

fn distance(m: &Meeting<'_>) -> f64 {
    if m.is_sized() { m.a.footprint(m.i).distance(&m.b.footprint(m.k)) } else { f64::NAN }
}

fn ttc_box(m: &Meeting<'_>) -> f64 {
    let (v, w) = (m.a.velocity[m.i], m.b.velocity[m.k]);
    if !m.is_sized() || !v.is_finite() || !w.is_finite() {
        return f64::NAN;
    }
    m.a.footprint(m.i).time_to_contact(v, &m.b.footprint(m.k), w)
}

fn closing(m: &Meeting<'_>) -> f64 {
    let apart = m.offset();
    let relative = m.b.velocity[m.k] - m.a.velocity[m.i];
    -relative.dot(apart) / apart.norm().max(1e-9)
}

fn course(m: &Meeting<'_>) -> f64 {
    let v = m.a.velocity[m.i];
    let goes_nowhere = v.norm() < COURSE_MPS;
    if goes_nowhere { f64::NAN } else { wrap(m.offset().heading() - v.heading()).abs() }
}

fn sector(m: &Meeting<'_>) -> Option<PairSector> {
    let (at, front, side) = (m.seen(), m.a.length[m.i] / 2.0, m.a.width[m.i] / 2.0);
    if !m.is_sized() || !at.is_finite() {
        return None;
    }
    Some(if at.x > front {
        PairSector::Front
    } else if at.x < -front {
        PairSector::Back
    } else if at.y > side {
        PairSector::Left
    } else if at.y < -side {
        PairSector::Right
    } else {
        PairSector::None
    })
}

fn direction(m: &Meeting<'_>) -> Option<PairDirection> {
    let (own, theirs) = (m.a.velocity[m.i], m.b.velocity[m.k]);
    if !own.is_finite() || !theirs.is_finite() {
        return None;
    }
    let (own_speed, their_speed) = (own.norm(), theirs.norm());
    let (a, b) = if own_speed < DIRECTED_MPS && has_free_will(m.a.class) && their_speed > DIRECTED_MPS {
        (m.a.heading[m.i], theirs.heading())
    } else if their_speed < DIRECTED_MPS && has_free_will(m.b.class) && own_speed > HEADING_SPEED_MPS {
        (own.heading(), m.b.heading[m.k])
    } else if own_speed < DIRECTED_MPS || their_speed < DIRECTED_MPS {
        return Some(PairDirection::None);
    } else {
        (own.heading(), theirs.heading())
    };
    let turned = wrap(b - a).abs();
    // A tolerance, so that exactly 45 and 135 deg do not depend on rounding.
    if turned.is_nan() {
        None
    } else if turned <= FRAC_PI_4 + 1e-9 {
        Some(PairDirection::Same)
    } else if turned >= PI - FRAC_PI_4 - 1e-9 {
        Some(PairDirection::Opposite)
    } else {
        Some(PairDirection::Perpendicular)
    }
}

fn way(body: &Body, i: usize) -> P2 {
    refav::direction(body.velocity[i], body.heading[i])
}

fn follows(scene: &Scene<'_>, m: &Meeting<'_>) -> Tri {
    let (Some(road), Some(lanes)) = (scene.road, scene.lanes) else { return Tri::Unknown };
    if !m.is_sized() || !m.a.velocity[m.i].is_finite() || !m.b.velocity[m.k].is_finite() {
        return Tri::Unknown;
    }
    let (Some(own), Some(theirs)) = (lanes.lanes[m.first][m.i], lanes.lanes[m.second][m.k]) else {
        return Tri::False;
    };
    let (at, front) = (m.seen(), m.a.length[m.i] / 2.0);
    let alike = way(m.a, m.i).dot(way(m.b, m.k)) > FOLLOWING_COS;
    if !alike || at.x <= front || at.x >= FOLLOWING_M + front {
        return Tri::False;
    }
    let lane = &road.lanes[own];
    let same = theirs == own || lane.successors.contains(&theirs);
    let beside = lane.neighbors.contains(&Some(theirs));
    let (half, side) = (m.b.width[m.k] / 2.0, m.a.width[m.i] / 2.0);
    let reaches_in = [at.y + half, at.y - half].iter().any(|edge| edge.abs() <= side);
    Tri::from((same && at.y.abs() < FOLLOWING_BESIDE_M) || (beside && reaches_in))
}

/// The first object crosses in front of the second.
fn crosses(rows: &Rows<'_>) -> Vec<Tri> {
    let mut flags = Vec::with_capacity(rows.near.len());
    for span in rows.spans {
        let (walker, car) = (&rows.scene.bodies[span.first], &rows.scene.bodies[span.second]);
        let start = flags.len();
        // Rows with a known position of the first object in the axes of the second, and a known lateral speed.
        let mut seen: Vec<refav::Passing> = Vec::new();
        for (row, frame) in (start..).zip(span.frames.start..span.frames.end) {
            let (Some(i), Some(k)) = (walker.at(frame), car.at(frame)) else {
                flags.push(Tri::Unknown);
                continue;
            };
            let at = car.sees(k, walker.position[i]);
            let across = car.in_axes(k, walker.velocity[i]).y;
            let (front, side) = (car.length[k] / 2.0, car.width[k] / 2.0);
            let known = at.is_finite() && across.is_finite() && front.is_finite() && side.is_finite();
            flags.push(if known { Tri::False } else { Tri::Unknown });
            if known {
                seen.push(refav::Passing { row, at, across, front, side });
            }
        }
        for row in refav::crossing(&seen) {
            flags[row] = Tri::True;
        }
    }
    flags
}
