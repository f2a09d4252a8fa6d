//! RefAV's functions in plain terms: loops over frames and objects, geometry by hand, written from the text of
//! `refAV/atomic_functions.py` (arguments as in docs/reference/refav.md) without any code of Whyroad. Lanes are those
//! of the straight roads in `scene`, so that they can be told from coordinates.

use std::collections::BTreeMap;
use whyroad_model::ObjectClass;
use whyroad_model::scene::{Drive, Motion};

/// What a function says of an object in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// It holds, or not.
    Is(bool),
    /// The object is not there.
    Unseen,
    /// So near a threshold that rounding decides, or not defined by the plain text.
    Open,
}

#[derive(Clone, Copy, Debug)]
struct State {
    x: f64,
    y: f64,
    h: f64,
    vx: f64,
    vy: f64,
    ax: f64,
    length: f64,
    width: f64,
}

struct Object {
    class: ObjectClass,
    sign: bool,
    rows: BTreeMap<usize, State>,
}

pub struct Plain {
    objects: BTreeMap<String, Object>,
    related: String,
}

/// Half a hundredth: closer to a threshold than this nothing is claimed.
const OPEN: f64 = 0.005;

fn clear(x: f64, bound: f64) -> bool {
    (x - bound).abs() > OPEN
}

fn below(x: f64, bound: f64) -> Option<bool> {
    clear(x, bound).then_some(x < bound)
}

fn above(x: f64, bound: f64) -> Option<bool> {
    below(x, bound).map(|b| !b)
}

fn all(parts: &[Option<bool>]) -> Option<bool> {
    if parts.contains(&Some(false)) {
        Some(false)
    } else if parts.contains(&None) {
        None
    } else {
        Some(true)
    }
}

fn any(parts: impl IntoIterator<Item = Option<bool>>) -> Option<bool> {
    at_least(1, parts)
}

fn at_least(n: usize, parts: impl IntoIterator<Item = Option<bool>>) -> Option<bool> {
    let (mut sure, mut open) = (0, 0);
    for p in parts {
        sure += usize::from(p == Some(true));
        open += usize::from(p.is_none());
    }
    if sure >= n {
        Some(true)
    } else if sure + open < n {
        Some(false)
    } else {
        None
    }
}

fn wrapped(a: f64) -> f64 {
    a.sin().atan2(a.cos())
}

impl State {
    fn speed(&self) -> f64 {
        self.vx.hypot(self.vy)
    }

    /// A point in the axes of the object.
    fn local(&self, x: f64, y: f64) -> (f64, f64) {
        let (dx, dy) = (x - self.x, y - self.y);
        (dx * self.h.cos() + dy * self.h.sin(), dy * self.h.cos() - dx * self.h.sin())
    }

    fn corners(&self) -> [(f64, f64); 4] {
        let (c, s) = (self.h.cos(), self.h.sin());
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(a, b)| {
            let (u, v) = (a * self.length / 2.0, b * self.width / 2.0);
            (self.x + u * c - v * s, self.y + u * s + v * c)
        })
    }
}

fn to_segment(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let t = (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (a.0 + t * dx - p.0).hypot(a.1 + t * dy - p.1)
}

fn inside(p: (f64, f64), ring: &[(f64, f64)]) -> bool {
    // Convex rings in counter-clockwise or clockwise order.
    let turn = |i: usize| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)
    };
    (0..ring.len()).all(|i| turn(i) >= 0.0) || (0..ring.len()).all(|i| turn(i) <= 0.0)
}

/// Between two convex rings; 0 where they share a point. Edges are sampled, so that crossing ones are found.
fn between(a: &[(f64, f64)], b: &[(f64, f64)]) -> f64 {
    let sampled = |ring: &[(f64, f64)]| -> Vec<(f64, f64)> {
        (0..ring.len())
            .flat_map(|i| {
                let (p, q) = (ring[i], ring[(i + 1) % ring.len()]);
                (0..200).map(move |k| {
                    let s = f64::from(k) / 200.0;
                    (p.0 + s * (q.0 - p.0), p.1 + s * (q.1 - p.1))
                })
            })
            .collect()
    };
    let middle = |r: &[(f64, f64)]| {
        let n = r.len() as f64;
        (r.iter().map(|p| p.0).sum::<f64>() / n, r.iter().map(|p| p.1).sum::<f64>() / n)
    };
    let radius = |r: &[(f64, f64)]| {
        let m = middle(r);
        r.iter().map(|p| (p.0 - m.0).hypot(p.1 - m.1)).fold(0.0, f64::max)
    };
    let (m, n) = (middle(a), middle(b));
    let may_touch = (m.0 - n.0).hypot(m.1 - n.1) <= radius(a) + radius(b);
    if may_touch && (sampled(a).iter().any(|p| inside(*p, b)) || sampled(b).iter().any(|p| inside(*p, a))) {
        return 0.0;
    }
    let corners = |from: &[(f64, f64)], to: &[(f64, f64)]| {
        from.iter()
            .flat_map(|p| (0..to.len()).map(move |i| to_segment(*p, to[i], to[(i + 1) % to.len()])))
            .fold(f64::INFINITY, f64::min)
    };
    corners(a, b).min(corners(b, a))
}

/// Lane by coordinates: its name without the part, its part, kind and side.
fn lane_at(x: f64, y: f64) -> Option<(&'static str, &'static str)> {
    let part = if x < 0.0 {
        "a"
    } else if x < 30.0 {
        "j"
    } else {
        "z"
    };
    let on = |middle: f64, half: f64| (y - middle).abs() < half;
    if !(-200.0..250.0).contains(&x) {
        return None;
    }
    if on(-1.75, 1.75) {
        Some(("e1", part))
    } else if on(1.75, 1.75) {
        Some(("e2", part))
    } else if on(5.25, 1.75) {
        Some(("w2", part))
    } else if on(8.75, 1.75) {
        Some(("w1", part))
    } else if part == "a" && on(-5.25, 1.75) {
        Some(("bus", part))
    } else if part == "z" && on(-4.5, 1.0) {
        Some(("cycle", part))
    } else {
        None
    }
}

/// On the line between two lanes, or at a joint, the plain text does not say which lane it is.
fn is_near_line(x: f64, y: f64) -> bool {
    let near = |v: f64, lines: &[f64]| lines.iter().any(|l| (v - l).abs() < 0.6);
    near(y, &[-7.0, -5.5, -3.5, 0.0, 3.5, 7.0, 10.5]) || near(x, &[-200.0, 0.0, 30.0, 250.0])
}

impl Plain {
    pub fn new(drive: &Drive, related: &str) -> Self {
        let state = |m: &Motion, i: usize, length: f64, width: f64| State {
            x: m.x[i],
            y: m.y[i],
            h: m.heading[i],
            vx: m.vx[i],
            vy: m.vy[i],
            ax: m.accel[i],
            length,
            width,
        };
        let mut objects = BTreeMap::new();
        for t in &drive.tracks {
            let row = |(i, f): (usize, &u32)| (*f as usize, state(&t.motion, i, t.length_m[i], t.width_m[i]));
            let rows = t.frames.iter().enumerate().map(row).collect();
            let sign = t.source_class == "STOP_SIGN";
            objects.insert(t.id.to_string(), Object { class: t.class, sign, rows });
        }
        if let Some(e) = &drive.ego {
            let rows = (0..e.motion.len()).map(|i| (i, state(&e.motion, i, e.length_m, e.width_m))).collect();
            objects.insert("ego".to_owned(), Object { class: ObjectClass::Car, sign: false, rows });
        }
        Self { objects, related: related.to_owned() }
    }

    fn is_related(&self, class: ObjectClass) -> bool {
        use ObjectClass::{Bus, Car, Pedestrian, Truck};
        match self.related.as_str() {
            "vehicle" => matches!(class, Car | Truck | Bus),
            "pedestrian" => class == Pedestrian,
            _ => true,
        }
    }

    /// The other objects there that are asked about and are within 50 m, box to box.
    fn others(&self, id: &str, frame: usize) -> Vec<(&str, &Object, State)> {
        let own = self.objects[id].rows[&frame];
        let other = |(name, o): (&String, &Object)| name != id && self.is_related(o.class);
        let there = self.objects.iter().filter(|(n, o)| other((n, o)));
        there
            .filter_map(|(n, o)| Some((n.as_str(), o, *o.rows.get(&frame)?)))
            .filter(|(_, _, s)| {
                (s.x - own.x).hypot(s.y - own.y) < 48.0 || between(&own.corners(), &s.corners()) <= 50.0
            })
            .collect()
    }

    /// Some other object that is asked about is so near to 50 m that rounding decides.
    fn on_the_rim(&self, id: &str, frame: usize) -> bool {
        let own = self.objects[id].rows[&frame];
        let rim = |o: &State| {
            let centers = (o.x - own.x).hypot(o.y - own.y);
            (48.0..70.0).contains(&centers) && !clear(between(&own.corners(), &o.corners()), 50.0)
        };
        self.objects.values().filter_map(|o| o.rows.get(&frame)).any(rim)
    }

    fn stationary(&self, id: &str) -> Option<bool> {
        let rows = self.objects[id].rows.values();
        let range = |of: fn(&State) -> f64| {
            let all: Vec<f64> = rows.clone().map(of).collect();
            all.iter().copied().fold(f64::MIN, f64::max) - all.iter().copied().fold(f64::MAX, f64::min)
        };
        below(range(|s| s.x).hypot(range(|s| s.y)), 3.0)
    }

    /// Degrees per second by central differences.
    fn yaw_rates(&self, id: &str) -> Vec<(usize, f64)> {
        let rows: Vec<(usize, f64)> = self.objects[id].rows.iter().map(|(f, s)| (*f, s.h)).collect();
        let n = rows.len();
        (0..n)
            .map(|i| {
                let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
                let turned = wrapped(rows[b].1 - rows[a].1).to_degrees();
                (rows[i].0, turned / ((rows[b].0 - rows[a].0) as f64 * 0.1))
            })
            .collect()
    }

    /// In an unbroken run of left yaw that adds up to 45 deg, or to 15 deg at 5 deg/s at an end of the track.
    fn turns_left(&self, id: &str, frame: usize) -> Option<bool> {
        let rates = self.yaw_rates(id);
        let at = rates.iter().position(|(f, _)| *f == frame)?;
        let left = |i: usize| rates[i].1 > 1e-6;
        if !left(at) {
            // RefAV's runs hold the first sample of the next one as well.
            let follows_a_run = at > 0 && left(at - 1);
            return if follows_a_run { None } else { Some(false) };
        }
        let (mut from, mut to) = (at, at);
        while from > 0 && left(from - 1) {
            from -= 1;
        }
        while to + 1 < rates.len() && left(to + 1) {
            to += 1;
        }
        if from == to {
            return None;
        }
        let sum: f64 = rates[from..=to].iter().map(|r| r.1 * 0.1).sum();
        let mean = sum / ((to + 1 - from) as f64 * 0.1);
        let edge = (from == 0 && rates[0].1 > 5.0) || (to + 1 == rates.len() && rates[to].1 > 5.0);
        if (sum - 45.0).abs() < 1.5 || (edge && ((sum - 15.0).abs() < 1.5 || (mean - 5.0).abs() < 0.3)) {
            return None;
        }
        Some(sum > 45.0 || (edge && mean > 5.0 && sum > 15.0))
    }

    fn lateral_accel(&self, id: &str, frame: usize) -> Option<f64> {
        let rows = &self.objects[id].rows;
        let (a, b) = (rows.get(&frame.checked_sub(1)?)?, rows.get(&(frame + 1))?);
        let s = rows[&frame];
        let (ax, ay) = ((b.vx - a.vx) / 0.2, (b.vy - a.vy) / 0.2);
        Some(ay * s.h.cos() - ax * s.h.sin())
    }

    /// `other` crosses in front of `own`, between them all frames in which both are there.
    fn crossed(&self, own: &str, other: &str, frame: usize) -> Option<bool> {
        let (car, walker) = (&self.objects[own], &self.objects[other]);
        let frames: Vec<usize> = car.rows.keys().filter(|f| walker.rows.contains_key(f)).copied().collect();
        let seen: Vec<(f64, f64, f64)> = frames
            .iter()
            .map(|f| {
                let (c, w) = (car.rows[f], walker.rows[f]);
                let (x, y) = c.local(w.x, w.y);
                (x, y, w.vy * c.h.cos() - w.vx * c.h.sin())
            })
            .collect();
        let at = frames.iter().position(|f| *f == frame)?;
        let c = car.rows[&frame];
        let (front, side) = (c.length / 2.0, c.width / 2.0);
        let mut open = false;
        for i in 1..seen.len() {
            let ((_, y0, _), (x, y1, v)) = (seen[i - 1], seen[i]);
            let over = [side, -side].iter().any(|l| (y0 < *l) != (y1 < *l));
            if !over || v.abs() <= 0.2 || x < front - OPEN || x > front + 10.0 + OPEN {
                continue;
            }
            let near_bound = !clear(x, front) || !clear(x, front + 10.0);
            let sign = (y1 - y0).signum();
            let on = |j: usize| sign * seen[j].1 < 5.0 && sign * seen[j].2 > 0.2;
            let edge = |j: usize| !clear(sign * seen[j].1, 5.0) || !clear(sign * seen[j].2, 0.2);
            let (low, high) = (at.min(i), at.max(i));
            let reached = (low..=high).all(on) && (at >= i || on(i - 1));
            open |= near_bound || (low..=high).any(edge);
            if reached {
                return if near_bound { None } else { Some(true) };
            }
        }
        if open { None } else { Some(false) }
    }

    fn lane_of(&self, id: &str, frame: usize) -> Option<Option<(&'static str, &'static str)>> {
        let s = self.objects[id].rows[&frame];
        (!is_near_line(s.x, s.y)).then(|| lane_at(s.x, s.y))
    }

    fn follows(&self, a: &str, b: &str, frame: usize) -> Option<bool> {
        let (s, o) = (self.objects[a].rows[&frame], self.objects[b].rows[&frame]);
        let (x, y) = s.local(o.x, o.y);
        let way = |s: &State| {
            let v = s.speed();
            if v > 0.5 { (s.vx / v, s.vy / v) } else { (s.h.cos(), s.h.sin()) }
        };
        let (p, q) = (way(&s), way(&o));
        let front = s.length / 2.0;
        let place = all(&[above(x, front), below(x, 25.0 + front), above(p.0 * q.0 + p.1 * q.1, 0.5)]);
        if place == Some(false) {
            return Some(false);
        }
        let (own, theirs) = (self.lane_of(a, frame)?, self.lane_of(b, frame)?);
        let (Some(own), Some(theirs)) = (own, theirs) else { return Some(false) };
        // Whoever drives askew or against a lane may be assigned another one: the plain text does not say.
        let east = |l: &str| l.starts_with('e') || l == "bus" || l == "cycle";
        let along =
            |s: &State, l: &str| wrapped(s.h - if east(l) { 0.0 } else { std::f64::consts::PI }).abs() < 0.3;
        if !along(&s, own.0) || !along(&o, theirs.0) {
            return None;
        }
        let next = |a: (&str, &str), b: (&str, &str)| {
            a.0 == b.0
                && matches!(
                    (east(a.0), a.1, b.1),
                    (true, "a", "j") | (true, "j", "z") | (false, "z", "j") | (false, "j", "a")
                )
        };
        let same = own == theirs || next(own, theirs);
        let pair = |l: &str| if l.starts_with('e') { 'e' } else { 'w' };
        let lanes = |l: &str| l.starts_with('e') || l.starts_with('w');
        let beside = own.1 == theirs.1
            && own.1 != "j"
            && own.0 != theirs.0
            && lanes(own.0)
            && lanes(theirs.0)
            && pair(own.0) == pair(theirs.0);
        let half = o.width / 2.0;
        let reaches = any([y + half, y - half].map(|e| below(e.abs(), s.width / 2.0)));
        any([all(&[place, Some(same), below(y.abs(), 5.0)]), all(&[place, Some(beside), reaches])])
    }

    fn direction_opposite(&self, a: &str, b: &str, frame: usize) -> Option<bool> {
        let (oa, ob) = (&self.objects[a], &self.objects[b]);
        let (s, o) = (oa.rows[&frame], ob.rows[&frame]);
        if !clear(s.speed(), 1.0) || !clear(o.speed(), 1.0) || !clear(s.speed(), 0.5) {
            return None;
        }
        use ObjectClass::{Bicycle, Cone, StaticObject};
        let willing = |o: &Object| !matches!(o.class, Bicycle | Cone | StaticObject);
        let course = |s: &State| s.vy.atan2(s.vx);
        let (p, q) = if s.speed() < 1.0 && willing(oa) && o.speed() > 1.0 {
            (s.h, course(&o))
        } else if o.speed() < 1.0 && willing(ob) && s.speed() > 0.5 {
            (course(&s), o.h)
        } else if s.speed() < 1.0 || o.speed() < 1.0 {
            return Some(false);
        } else {
            (course(&s), course(&o))
        };
        above(wrapped(p - q).abs().to_degrees(), 135.0)
    }

    /// Center within 5 m of the junction's lanes, which fill 0 to 30 m along and -3.5 to 10.5 m across.
    fn near_junction(s: &State) -> f64 {
        (-s.x).max(s.x - 30.0).max(0.0).hypot((-3.5 - s.y).max(s.y - 10.5).max(0.0))
    }

    pub fn answer(&self, function: &str, call: &str, id: &str, frame: usize) -> Answer {
        let Some(s) = self.objects[id].rows.get(&frame).copied() else { return Answer::Unseen };
        match self.holds(function, call, id, frame, &s) {
            Some(value) => Answer::Is(value),
            None => Answer::Open,
        }
    }

    fn holds(&self, function: &str, call: &str, id: &str, frame: usize, s: &State) -> Option<bool> {
        use ObjectClass::{Bicycle, Bus, Truck};
        let own = &self.objects[id];
        let moving = || self.stationary(id).map(|s| !s);
        let others = || self.others(id, frame);
        match function {
            "get_objects_of_category" => Some(own.class == Bicycle),
            "is_category" => Some(matches!(own.class, Truck | Bus)),
            "stationary" => self.stationary(id),
            "scenario_not" => moving(),
            "has_velocity" => all(&[below(s.speed(), 0.5).map(|b| !b), moving()]),
            "accelerating" => all(&[above(s.ax, 0.65), moving()]),
            "scenario_or" => any([self.stationary(id), above(s.ax, 0.65)]),
            "has_lateral_acceleration" => {
                let a = self.lateral_accel(id, frame)?;
                // Slopes of 0.4 s and of 0.2 s differ where the acceleration changes.
                if (a - 1.0).abs() < 0.25 || (a - 9.0).abs() < 0.25 {
                    return None;
                }
                all(&[Some((1.0..=9.0).contains(&a)), moving()])
            }
            "turning" => self.turns_left(id, frame),
            "scenario_and" => all(&[self.turns_left(id, frame), below(Self::near_junction(s), 5.0)]),
            "near_intersection" => below(Self::near_junction(s), 5.0),
            "on_intersection" => {
                let (x, y) = (s.x, s.y);
                let near = [x, x - 30.0, y + 3.5, y - 10.5].iter().any(|d| d.abs() < 0.05);
                (!near).then_some((0.0..30.0).contains(&x) && (-3.5..10.5).contains(&y))
            }
            "at_pedestrian_crossing" => {
                let crosswalk = [(32.0, -8.0), (36.0, -8.0), (36.0, 12.0), (32.0, 12.0)];
                below(between(&s.corners(), &crosswalk), 1.0)
            }
            "in_drivable_area" => {
                let near = [s.y + 7.0, s.y - 10.5, s.x + 200.0, s.x - 250.0].iter().any(|d| d.abs() < 0.01);
                (!near).then_some((-7.0..10.5).contains(&s.y) && (-200.0..250.0).contains(&s.x))
            }
            "on_road" => self.lane_of(id, frame).map(|l| l.is_some()),
            "on_lane_type" => self.lane_of(id, frame).map(|l| l.is_some_and(|l| l.0 == "cycle")),
            // The one car that changes crosses the line half way, between 2 and 6 s; where it begins and ends is a
            // matter of thresholds.
            "changing_lanes" => match (id, frame) {
                ("changes", 36..=44) => Some(true),
                ("changes", 0..=18 | 65..) => Some(false),
                ("changes", _) => None,
                (o, _) if o.starts_with('o') && o.len() == 3 => None,
                _ => Some(false),
            },
            "at_stop_sign" => {
                let sign = self.objects.values().find(|o| o.sign);
                let sign = sign.and_then(|o| o.rows.get(&frame))?;
                let (x, y) = sign.local(s.x, s.y);
                let lane = self.lane_of(id, frame)?;
                let turned = wrapped(s.h - sign.h).abs().to_degrees();
                all(&[
                    above(x, -1.0),
                    below(x, 10.0),
                    below(y, 0.0),
                    above(y, -7.0),
                    above(turned, 90.0),
                    // The lane whose right edge ends nearest to the sign.
                    Some(lane == Some(("e1", "a"))),
                ])
                .filter(|_| lane != Some(("bus", "a")))
            }
            "has_objects_in_relative_direction" if call.contains("left") => {
                if self.on_the_rim(id, frame) {
                    return None;
                }
                any(others().iter().map(|(_, _, o)| above(s.local(o.x, o.y).1, s.width / 2.0)))
            }
            "has_objects_in_relative_direction" => {
                if self.on_the_rim(id, frame) {
                    return None;
                }
                at_least(
                    2,
                    others().iter().map(|(_, _, o)| {
                        let (x, y) = s.local(o.x, o.y);
                        all(&[above(x, s.length / 2.0), below(y.abs(), s.width / 2.0 + 3.0)])
                    }),
                )
            }
            "get_objects_in_relative_direction" => {
                if self.on_the_rim(id, frame) {
                    return None;
                }
                any(others().iter().map(|(_, _, o)| below(o.local(s.x, s.y).0, -o.length / 2.0)))
            }
            "facing_toward" => {
                if self.on_the_rim(id, frame) {
                    return None;
                }
                any(others().iter().map(|(_, _, o)| {
                    let (x, y) = s.local(o.x, o.y);
                    below(y.atan2(x).abs().to_degrees(), 22.5)
                }))
            }
            "heading_toward" => {
                if self.on_the_rim(id, frame) || !clear(s.speed(), 0.1) {
                    return None;
                }
                any(others().iter().map(|(_, _, o)| {
                    let (dx, dy) = (o.x - s.x, o.y - s.y);
                    let angle = wrapped(dy.atan2(dx) - s.vy.atan2(s.vx)).abs().to_degrees();
                    let closing = -((o.vx - s.vx) * dx + (o.vy - s.vy) * dy) / dx.hypot(dy);
                    all(&[below(angle, 22.5), above(closing, 0.5), Some(s.speed() > 0.1)])
                }))
            }
            "near_objects" => {
                at_least(2, others().iter().map(|(_, _, o)| below(between(&s.corners(), &o.corners()), 10.0)))
            }
            "reverse_relationship" => {
                any(others().iter().map(|(_, _, o)| below(between(&o.corners(), &s.corners()), 10.0)))
            }
            "being_crossed_by" => any(others().iter().map(|(n, _, _)| self.crossed(id, n, frame))),
            "following" => any(others().iter().map(|(n, _, _)| self.follows(id, n, frame))),
            "heading_in_relative_direction_to" => {
                if self.on_the_rim(id, frame) {
                    return None;
                }
                any(others().iter().map(|(n, _, _)| self.direction_opposite(id, n, frame)))
            }
            "in_same_lane" | "on_relative_side_of_road" => {
                if self.on_the_rim(id, frame) {
                    return None;
                }
                let own = self.lane_of(id, frame)?;
                any(others().iter().map(|(n, _, _)| {
                    let theirs = self.lane_of(n, frame)?;
                    let (Some(a), Some(b)) = (own, theirs) else { return Some(false) };
                    if function == "in_same_lane" {
                        return Some(a.0 == b.0);
                    }
                    // What is beyond the opposite side of a bus or bicycle lane is not said.
                    let side = |l: &str| l.chars().next().filter(|c| matches!(c, 'e' | 'w'));
                    Some(side(a.0)? != side(b.0)?)
                }))
            }
            other => panic!("no plain definition of {other}"),
        }
    }
}
