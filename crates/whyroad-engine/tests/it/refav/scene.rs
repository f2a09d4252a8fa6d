//! Scenes for RefAV's questions: a street with everything on it, and crowds of objects that move at random. Motion is a
//! formula of time; velocities and accelerations are its derivatives.

use whyroad_model::road_map::{Area, Lane, LaneKind, Point3, RoadMap};
use whyroad_model::scene::{Drive, Ego, Motion, Track};
use whyroad_model::{Nanos, ObjectClass};

pub const FRAMES: usize = 100;

type Pose = (f64, f64, f64);

fn motion(frames: impl Iterator<Item = usize>, pose: &dyn Fn(f64) -> Pose) -> Motion {
    const H: f64 = 1e-4;
    let mut m = Motion::default();
    for f in frames {
        let t = f as f64 * 0.1;
        let velocity = |t: f64| {
            let (a, b) = (pose(t - H), pose(t + H));
            ((b.0 - a.0) / (2.0 * H), (b.1 - a.1) / (2.0 * H))
        };
        let (x, y, h) = pose(t);
        let (vx, vy) = velocity(t);
        let forward = |t: f64| {
            let (vx, vy) = velocity(t);
            vx * pose(t).2.cos() + vy * pose(t).2.sin()
        };
        m.x.push(x);
        m.y.push(y);
        m.z.push(0.8);
        m.heading.push(h.sin().atan2(h.cos()));
        m.vx.push(vx);
        m.vy.push(vy);
        m.accel.push((forward(t + 0.01) - forward(t - 0.01)) / 0.02);
        m.yaw_rate.push((pose(t + H).2 - pose(t - H).2) / (2.0 * H));
    }
    m
}

fn empty(id: &str) -> Drive {
    let mut drive = Drive {
        times: (0..FRAMES as i64).map(|i| Nanos(1_000_000_000 + i * 100_000_000)).collect(),
        ..Drive::default()
    };
    drive.meta.drive_id = id.into();
    drive
}

fn ego(drive: &mut Drive, pose: &dyn Fn(f64) -> Pose) {
    let motion = motion(0..FRAMES, pose);
    drive.ego = Some(Ego { length_m: 4.6, width_m: 2.0, height_m: 1.5, motion, ..Ego::default() });
}

fn add(drive: &mut Drive, id: &str, class: ObjectClass, size: (f64, f64), pose: &dyn Fn(f64) -> Pose) {
    add_seen(drive, id, class, size, (0, FRAMES), pose);
}

fn add_seen(
    drive: &mut Drive,
    id: &str,
    class: ObjectClass,
    (length, width): (f64, f64),
    (from, to): (usize, usize),
    pose: &dyn Fn(f64) -> Pose,
) {
    let n = to - from;
    drive.tracks.push(Track {
        id: id.into(),
        class,
        source_class: class.id().to_uppercase(),
        frames: (from as u32..to as u32).collect(),
        motion: motion(from..to, pose),
        length_m: vec![length; n],
        width_m: vec![width; n],
        height_m: vec![1.5; n],
        ..Track::default()
    });
    drive.tracks.sort_by(|a, b| a.id.cmp(&b.id));
}

fn points(all: &[(f64, f64)]) -> Vec<Point3> {
    all.iter().map(|&(x, y)| Point3 { x, y, z: 0.0 }).collect()
}

/// A straight lane from `a` to `b`.
fn lane(id: &str, a: (f64, f64), b: (f64, f64), width: f64, kind: LaneKind) -> Lane {
    let l = (b.0 - a.0).hypot(b.1 - a.1);
    let (nx, ny) = (-(b.1 - a.1) / l * width / 2.0, (b.0 - a.0) / l * width / 2.0);
    let n = 20;
    let along = |k: usize, side: f64| {
        let s = k as f64 / f64::from(n);
        (a.0 + s * (b.0 - a.0) + side * nx, a.1 + s * (b.1 - a.1) + side * ny)
    };
    let line = |side: f64| points(&(0..=n as usize).map(|k| along(k, side)).collect::<Vec<_>>());
    Lane {
        id: id.into(),
        kind,
        center: line(0.0),
        left: line(1.0),
        right: line(-1.0),
        width_m: Some(width),
        ..Lane::default()
    }
}

/// Two lanes east (e1 the right one, e2), one bus lane (b) and a bicycle lane (c) beside them, two lanes west (w1, w2);
/// between x = 0 and x = 30 a junction; a crosswalk behind it.
fn road() -> RoadMap {
    let mut lanes = Vec::new();
    for (name, y, east) in [("e1", -1.75, true), ("e2", 1.75, true), ("w1", 8.75, false), ("w2", 5.25, false)]
    {
        let parts = [("a", -200.0, 0.0), ("j", 0.0, 30.0), ("z", 30.0, 250.0)];
        for (part, from, to) in parts {
            let (a, b) = if east { ((from, y), (to, y)) } else { ((to, y), (from, y)) };
            let mut lane = lane(&format!("{name}{part}"), a, b, 3.5, LaneKind::Vehicle);
            lane.in_junction = part == "j";
            let (before, after) = match (part, east) {
                ("a", true) | ("z", false) => (None, Some("j")),
                ("j", true) => (Some("a"), Some("z")),
                ("j", false) => (Some("z"), Some("a")),
                _ => (Some("j"), None),
            };
            lane.successors = after.map(|p| format!("{name}{p}")).into_iter().collect();
            lane.predecessors = before.map(|p| format!("{name}{p}")).into_iter().collect();
            if part != "j" {
                let other = match name {
                    "e1" => ("e2", true),
                    "e2" => ("e1", false),
                    "w1" => ("w2", true),
                    _ => ("w1", false),
                };
                let neighbor = Some(format!("{}{part}", other.0));
                if other.1 { lane.left_neighbor = neighbor } else { lane.right_neighbor = neighbor }
            }
            lanes.push(lane);
        }
    }
    lanes.push(lane("bus", (-200.0, -5.25), (0.0, -5.25), 3.5, LaneKind::Bus));
    lanes.push(lane("cycle", (30.0, -4.5), (250.0, -4.5), 2.0, LaneKind::Bike));
    lanes.sort_by(|a, b| a.id.cmp(&b.id));
    let area = |id: &str, corners: &[(f64, f64)]| Area { id: id.into(), boundary: points(corners) };
    RoadMap {
        lanes,
        crosswalks: vec![area("x", &[(32.0, -8.0), (36.0, -8.0), (36.0, 12.0), (32.0, 12.0)])],
        drivable_areas: vec![area("d", &[(-200.0, -7.0), (250.0, -7.0), (250.0, 10.5), (-200.0, 10.5)])],
        ..RoadMap::default()
    }
}

/// Ease from 0 to 1 between two times.
fn ease(t: f64, from: f64, to: f64) -> f64 {
    let s = ((t - from) / (to - from)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// A street on which everything happens that RefAV asks about.
pub fn street() -> Drive {
    use ObjectClass::{Bicycle, Bus, Car, Cone, Pedestrian, StaticObject, Truck};
    let mut d = empty("street");
    d.map = Some(road());
    ego(&mut d, &|t| (-60.0 + 8.0 * t, -1.75, 0.0));
    add(&mut d, "lead", Car, (4.5, 1.9), &|t| (-42.0 + 8.0 * t, -1.75, 0.0));
    add(&mut d, "second", Truck, (9.0, 2.5), &|t| (-75.0 + 7.5 * t, -1.7, 0.0));
    // Changes to the left between 2 and 6 s.
    add(&mut d, "changes", Car, (4.5, 1.9), &|t| {
        let y = -1.75 + 3.5 * ease(t, 2.0, 6.0);
        let slope = (3.5 * (ease(t + 0.01, 2.0, 6.0) - ease(t - 0.01, 2.0, 6.0)) / 0.02) / 9.0;
        (-110.0 + 9.0 * t, y, slope.atan())
    });
    add(&mut d, "oncoming", Car, (4.5, 1.9), &|t| (60.0 - 9.0 * t, 5.25, std::f64::consts::PI));
    add(&mut d, "against", Bus, (12.0, 2.5), &|t| (90.0 - 10.0 * t, 8.75, std::f64::consts::PI));
    add(&mut d, "bus", Bus, (12.0, 2.5), &|t| (-60.0 + 5.0 * t, -5.25, 0.0));
    add(&mut d, "parked", Car, (4.5, 1.9), &|_| (60.0, -6.5, 0.1));
    add(&mut d, "cycle", Bicycle, (1.8, 0.6), &|t| (31.0 + 4.0 * t, -4.5, 0.0));
    add(&mut d, "beside", Bicycle, (1.8, 0.6), &|t| (-60.0 + 8.0 * t, -4.0, 0.0));
    // Walks over the crosswalk in front of a car that waits.
    add(&mut d, "walker", Pedestrian, (0.6, 0.6), &|t| (34.0, -9.0 + 1.6 * t, std::f64::consts::FRAC_PI_2));
    add(&mut d, "child", Pedestrian, (0.5, 0.5), &|t| (31.5, 10.0 - 1.2 * t, -std::f64::consts::FRAC_PI_2));
    add(&mut d, "waits", Car, (4.5, 1.9), &|_| (27.0, 1.75, 0.0));
    add_seen(&mut d, "comes", Pedestrian, (0.6, 0.6), (30, 80), &|t| (50.0 - t, -8.0, std::f64::consts::PI));
    add(&mut d, "cone", Cone, (0.4, 0.4), &|_| (10.0, -8.0, 0.0));
    // Speeds up from standstill; its sideways acceleration is that of the turn: radius 12 m, to the left.
    add(&mut d, "starts", Car, (4.5, 1.9), &|t| (100.0 + 0.9 * (t.max(1.0) - 1.0).powi(2), 1.75, 0.0));
    add(&mut d, "turns", Car, (4.5, 1.9), &|t| {
        let a = 0.35 * t.clamp(1.0, 6.0);
        let before = t.min(1.0) - 1.0;
        let s = 4.2 * before;
        let start = 0.35_f64;
        let (cx, cy) = (5.0 - 12.0 * start.sin(), 20.0 + 12.0 * start.cos());
        let on_arc = (cx + 12.0 * a.sin(), cy - 12.0 * a.cos());
        let beyond = 4.2 * (t.max(6.0) - 6.0);
        let along = |x: f64, y: f64, by: f64| (x + by * a.cos(), y + by * a.sin());
        let p = along(on_arc.0, on_arc.1, if t < 1.0 { s } else { beyond });
        (p.0, p.1, a)
    });
    // A stop sign at the right edge of e1a, its face to the cars that come (to the west).
    add(&mut d, "sign", StaticObject, (0.1, 0.7), &|_| (-0.5, -4.0, std::f64::consts::PI));
    for t in d.tracks.iter_mut().filter(|t| t.id.as_str() == "sign") {
        t.source_class = "STOP_SIGN".into();
    }
    d
}

/// Objects of all kinds that move at random, close together and far apart, over the same road.
pub fn crowd(seed: u64) -> Drive {
    use ObjectClass::{Bicycle, Bus, Car, Pedestrian, Truck};
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut d = empty(&format!("crowd{seed}"));
    d.map = Some(road());
    ego(&mut d, &|t| (-20.0 + 6.0 * t, 1.75, 0.0));
    for i in 0..26 {
        let class = [Car, Pedestrian, Truck, Bicycle, Bus, Pedestrian, Car][i % 7];
        let size =
            [(4.5, 1.9), (0.7, 0.6), (9.0, 2.5), (1.8, 0.7), (12.0, 2.6), (0.6, 0.6), (4.2, 1.8)][i % 7];
        let (x, y) = (-60.0 + 160.0 * random(), -12.0 + 26.0 * random());
        let (h, rate) = (6.3 * random() - 3.15, if i % 3 == 0 { 0.0 } else { 0.5 * random() - 0.25 });
        let (v, a) = (7.0 * random() * f64::from(i % 4 != 0), 1.6 * random() - 0.8);
        let speed = move |t: f64| if v > 0.0 { (v + a * t).max(0.0) } else { 0.0 };
        // Path by many small steps, the same at every call.
        let pose = move |t: f64| {
            let n = 400;
            let (mut px, mut py) = (x, y);
            for k in 0..n {
                let (t0, dt) = (t * (f64::from(k) + 0.5) / f64::from(n), t / f64::from(n));
                let heading = h + rate * t0;
                px += speed(t0) * heading.cos() * dt;
                py += speed(t0) * heading.sin() * dt;
            }
            (px, py, h + rate * t)
        };
        let seen = if i % 5 == 4 { (20 + i, 90) } else { (0, FRAMES) };
        add_seen(&mut d, &format!("o{i:02}"), class, size, seen, &pose);
    }
    d
}
