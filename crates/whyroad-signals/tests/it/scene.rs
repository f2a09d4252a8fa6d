//! Hand-made drives for tests: motion as a formula of time, roads as lines. Velocities and accelerations come from the
//! formulas by difference quotients with a step of 0.1 ms, not from our code.
#![allow(dead_code, missing_docs, reason = "each test file uses its part")]

use whyroad_model::road_map::{Area, Lane, Point3, RoadMap};
use whyroad_model::scene::{Drive, Ego, Motion, Track};
use whyroad_model::{Nanos, ObjectClass, SignalTable, Tri};

/// x (m), y (m), heading (rad) at a time (s).
pub type Pose = (f64, f64, f64);

pub const EGO_LENGTH: f64 = 4.0;
pub const EGO_WIDTH: f64 = 2.0;
const STEP: f64 = 1e-4;

fn wrapped(a: f64) -> f64 {
    a.sin().atan2(a.cos())
}

fn push(motion: &mut Motion, pose: &dyn Fn(f64) -> Pose, t: f64) {
    let at = |t: f64| pose(t);
    let velocity = |t: f64| {
        let (a, b) = (at(t - STEP), at(t + STEP));
        ((b.0 - a.0) / (2.0 * STEP), (b.1 - a.1) / (2.0 * STEP))
    };
    let forward = |t: f64| {
        let (vx, vy) = velocity(t);
        let h = at(t).2;
        vx * h.cos() + vy * h.sin()
    };
    let (x, y, heading) = at(t);
    let (vx, vy) = velocity(t);
    motion.x.push(x);
    motion.y.push(y);
    motion.z.push(0.8);
    motion.heading.push(wrapped(heading));
    motion.vx.push(vx);
    motion.vy.push(vy);
    motion.accel.push((forward(t + 0.01) - forward(t - 0.01)) / 0.02);
    motion.yaw_rate.push(wrapped(at(t + STEP).2 - at(t - STEP).2) / (2.0 * STEP));
}

/// A drive of `frames` frames at 10 Hz whose ego is 4 m x 2 m and moves by `pose`.
pub fn drive(frames: usize, pose: impl Fn(f64) -> Pose) -> Drive {
    let mut drive = Drive {
        times: (0..frames).map(|i| Nanos(1_000_000_000 + i as i64 * 100_000_000)).collect(),
        ..Drive::default()
    };
    let mut motion = Motion::default();
    for i in 0..frames {
        push(&mut motion, &pose, i as f64 * 0.1);
    }
    drive.ego = Some(Ego {
        length_m: EGO_LENGTH,
        width_m: EGO_WIDTH,
        height_m: 1.6,
        reference_to_centre_m: 0.0,
        motion,
        ..Ego::default()
    });
    drive
}

/// Adds a target that is observed in all frames.
pub fn add(drive: &mut Drive, id: &str, class: ObjectClass, size: (f64, f64), pose: impl Fn(f64) -> Pose) {
    add_seen(drive, id, class, size, |_| true, pose);
}

/// Adds a target that is observed in the frames for which `seen` is true.
pub fn add_seen(
    drive: &mut Drive,
    id: &str,
    class: ObjectClass,
    (length, width): (f64, f64),
    seen: impl Fn(usize) -> bool,
    pose: impl Fn(f64) -> Pose,
) {
    let mut track = Track { id: id.into(), class, source_class: class.id().into(), ..Track::default() };
    for i in (0..drive.times.len()).filter(|&i| seen(i)) {
        track.frames.push(i as u32);
        push(&mut track.motion, &pose, i as f64 * 0.1);
        track.length_m.push(length);
        track.width_m.push(width);
        track.height_m.push(1.6);
        track.interior_points.push(50.0);
    }
    drive.tracks.push(track);
    drive.tracks.sort_by(|a, b| a.id.cmp(&b.id));
}

pub fn car(drive: &mut Drive, id: &str, pose: impl Fn(f64) -> Pose) {
    add(drive, id, ObjectClass::Car, (4.0, 2.0), pose);
}

/// A lane along `center` with this width, m.
pub fn lane(id: &str, center: &[(f64, f64)], width: f64) -> Lane {
    let side = |sign: f64| -> Vec<Point3> {
        (0..center.len())
            .map(|i| {
                let (a, b) = (center[i.saturating_sub(1)], center[(i + 1).min(center.len() - 1)]);
                let l = (b.0 - a.0).hypot(b.1 - a.1);
                let (nx, ny) = (-(b.1 - a.1) / l, (b.0 - a.0) / l);
                Point3 {
                    x: center[i].0 + sign * nx * width / 2.0,
                    y: center[i].1 + sign * ny * width / 2.0,
                    z: 0.0,
                }
            })
            .collect()
    };
    Lane {
        id: id.into(),
        left: side(1.0),
        right: side(-1.0),
        center: center.iter().map(|&(x, y)| Point3 { x, y, z: 0.0 }).collect(),
        width_m: Some(width),
        ..Lane::default()
    }
}

pub fn map(mut lanes: Vec<Lane>) -> RoadMap {
    lanes.sort_by(|a, b| a.id.cmp(&b.id));
    RoadMap { lanes, ..RoadMap::default() }
}

/// Along x: right lane r0, r1 (y = 0), left lane l0, l1 (y = 3.5), and an oncoming lane o (y = 7); joints at x = 100.
pub fn road() -> RoadMap {
    let line = |x0: f64, x1: f64, y: f64| [(x0, y), ((x0 + x1) / 2.0, y), (x1, y)];
    let mut lanes = vec![
        lane("l0", &line(-200.0, 100.0, 3.5), 3.5),
        lane("l1", &line(100.0, 500.0, 3.5), 3.5),
        lane("o", &line(500.0, -200.0, 7.0), 3.5),
        lane("r0", &line(-200.0, 100.0, 0.0), 3.5),
        lane("r1", &line(100.0, 500.0, 0.0), 3.5),
    ];
    let mut link =
        |i: usize, left: Option<&str>, right: Option<&str>, next: Option<&str>, before: Option<&str>| {
            lanes[i].left_neighbor = left.map(str::to_owned);
            lanes[i].right_neighbor = right.map(str::to_owned);
            lanes[i].successors = next.map(str::to_owned).into_iter().collect();
            lanes[i].predecessors = before.map(str::to_owned).into_iter().collect();
        };
    link(0, Some("o"), Some("r0"), Some("l1"), None);
    link(1, Some("o"), Some("r1"), None, Some("l0"));
    link(2, Some("l0"), None, None, None);
    link(3, Some("l0"), None, Some("r1"), None);
    link(4, Some("l1"), None, None, Some("r0"));
    map(lanes)
}

pub fn area(id: &str, corners: &[(f64, f64)]) -> Area {
    Area { id: id.into(), boundary: corners.iter().map(|&(x, y)| Point3 { x, y, z: 0.0 }).collect() }
}

/// Reads a table by name, frame and target.
pub struct Table(pub SignalTable);

impl Table {
    pub fn of(drive: &Drive) -> Self {
        Self(whyroad_signals::derive(drive))
    }
    fn column(&self, name: &str) -> &whyroad_model::Column {
        let t = &self.0;
        t.frame_columns
            .get(name)
            .or_else(|| t.target_columns.get(name))
            .unwrap_or_else(|| panic!("no {name}"))
    }
    fn row(&self, target: &str, frame: usize) -> usize {
        self.0.target(&target.into()).and_then(|t| t.row(frame)).expect("target has the frame")
    }
    /// A number; NaN when unknown.
    pub fn ego(&self, name: &str, frame: usize) -> f64 {
        self.column(name).number(frame).unwrap_or(f64::NAN)
    }
    pub fn ego_flag(&self, name: &str, frame: usize) -> Tri {
        self.column(name).flag(frame)
    }
    pub fn ego_category(&self, name: &str, frame: usize) -> Option<&str> {
        self.column(name).category(frame)
    }
    pub fn num(&self, target: &str, name: &str, frame: usize) -> f64 {
        self.column(name).number(self.row(target, frame)).unwrap_or(f64::NAN)
    }
    pub fn flag(&self, target: &str, name: &str, frame: usize) -> Tri {
        self.column(name).flag(self.row(target, frame))
    }
    pub fn category(&self, target: &str, name: &str, frame: usize) -> Option<&str> {
        self.column(name).category(self.row(target, frame))
    }
    /// Frames in which a frame category has this value: first and last.
    pub fn span(&self, name: &str, value: &str) -> Option<(usize, usize)> {
        let column = self.column(name);
        let frames: Vec<usize> = (0..column.len()).filter(|&i| column.category(i) == Some(value)).collect();
        Some((*frames.first()?, *frames.last()?))
    }
}

#[track_caller]
pub fn near(actual: f64, expected: f64, tolerance: f64) {
    assert!((actual - expected).abs() <= tolerance, "{actual} is not {expected} within {tolerance}");
}
