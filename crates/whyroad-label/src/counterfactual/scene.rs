//! The recorded scene along the ego's path: which objects are or will be on it, where and when, and the light.

use super::idm::Driver;
use super::{HORIZON_S, MOST_RELEVANT, Removed, STEP_S};
use whyroad_model::time::frame_at;
use whyroad_model::{Drive, ObjectClass, SignalTable, TrackId};

/// Free space at each side of the boxes, m.
const SIDE_MARGIN_M: f64 = 0.35;
/// The path is extended straight beyond its end by this length, m.
const BEYOND_M: f64 = 80.0;
/// The ego yields to a road user that comes onto the path less than this after the ego would have been there, s:
/// drivers wait for people who are about to cross, and for cars that are about to merge.
const BEFORE_S: f64 = 3.0;
/// The ego yields to a road user that leaves the path less than this before the ego would be there, s.
const AFTER_S: f64 = 1.5;
/// A road user that comes onto the path later than this is not considered yet, s.
const FORESIGHT_S: f64 = 5.0;
/// Objects that are always farther from the path than this are left out, m.
const NEAR_M: f64 = 15.0;

/// A point of the ego's path.
#[derive(Clone, Copy, Debug)]
struct PathPoint {
    x: f64,
    y: f64,
    s: f64,
    heading: f64,
}

/// Number of path segments in one block; blocks that are far away are skipped as a whole.
const BLOCK: usize = 16;

/// The path, indexed for searching the point that is nearest to something.
struct Path {
    segments: Vec<Segment>,
    /// Bounds of each [`BLOCK`] of segments: minimum x and y, maximum x and y. The first segment, which is extended
    /// backwards, is always searched.
    bounds: Vec<[f64; 4]>,
}

/// A segment of the path from one point to the next.
#[derive(Clone, Copy, Debug)]
struct Segment {
    from: PathPoint,
    dx: f64,
    dy: f64,
    length: f64,
}

/// Position of one object along and beside the path, step by step.
#[derive(Clone, Debug)]
struct Course {
    id: TrackId,
    /// One row per step: rear end along the path from the ego's front (m), speed along it (m/s), on the path.
    rows: Vec<Option<Row>>,
    /// Its times and positions on the path when it comes from beside the path.
    visits: Vec<Visit>,
    /// Minimum distance from the path, m.
    nearest_m: f64,
}

#[derive(Clone, Copy, Debug)]
struct Row {
    rear_m: f64,
    speed_mps: f64,
    on_path: bool,
}

/// A period on the path.
#[derive(Clone, Copy, Debug)]
struct Visit {
    from_s: f64,
    to_s: f64,
    /// The nearest point that it occupies, m from the ego's front.
    at_m: f64,
    /// It was beside the path before.
    from_beside: bool,
}

/// Something ahead to which the ego must respond.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// The object or the light.
    pub by: Removed,
    /// Free distance, m.
    pub gap_m: f64,
    /// Speed along the path, m/s.
    pub speed_mps: f64,
}

/// A scene from one frame on.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Speed of the ego at the start, m/s.
    pub speed_mps: f64,
    courses: Vec<Course>,
    /// The stop line of a light that holds the ego: distance (m), and the state of the light in each step.
    light: Option<(f64, Vec<LightStep>)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LightStep {
    Free,
    Yellow,
    Red,
}

impl Scene {
    /// The scene of `drive` from `frame` on. `None` where the ego's poses or speed are unknown.
    pub fn at(drive: &Drive, signals: &SignalTable, frame: usize) -> Option<Self> {
        let ego = drive.ego.as_ref()?;
        let speed_mps = signals.frame_columns.get("ego.speed")?.number(frame)?;
        let path = Path::through(&path(drive, frame)?);
        let steps = (HORIZON_S / STEP_S) as usize;
        let start = drive.times[frame];
        let frames: Vec<Option<usize>> = (0..=steps)
            .map(|step| {
                let at = start.plus_secs(step as f64 * STEP_S);
                let f = frame_at(&drive.times, at).min(drive.times.len() - 1);
                (drive.times[f].seconds_since(at).abs() < 2.0 * STEP_S).then_some(f)
            })
            .collect();
        let ego_size = (ego.length_m, ego.width_m);
        let mut courses: Vec<Course> = drive
            .tracks
            .iter()
            .filter(|t| {
                !matches!(t.class, ObjectClass::StaticObject | ObjectClass::Unknown) || t.motion.len() > 1
            })
            .filter_map(|t| course(t, &frames, &path, ego_size))
            .filter(|c| c.nearest_m < NEAR_M)
            .collect();
        // Objects that are on the path first, and nearest, matter most.
        let rank = |c: &Course| {
            c.visits
                .first()
                .map_or((2, c.nearest_m), |v| (i32::from(v.from_beside), v.at_m.max(0.0) + 5.0 * v.from_s))
        };
        courses.sort_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        courses.truncate(MOST_RELEVANT);
        let light = light(signals, frame, &frames);
        Some(Self { speed_mps, courses, light })
    }

    /// Everything that can be removed.
    pub fn things(&self) -> Vec<Removed> {
        let mut out: Vec<Removed> = self.courses.iter().map(|c| Removed::Object(c.id.clone())).collect();
        out.extend(self.light.as_ref().map(|_| Removed::Light));
        out
    }

    /// What the ego must respond to `t` s after the start, when it has driven `s` m and drives at `v` m/s.
    pub(super) fn constraints<'s>(
        &'s self,
        t: f64,
        s: f64,
        v: f64,
        driver: &'s Driver,
    ) -> impl Iterator<Item = Constraint> + 's {
        let step = (t / STEP_S).round() as usize;
        let objects = self.courses.iter().filter_map(move |c| {
            let by = || Removed::Object(c.id.clone());
            let row = c.rows.get(step).copied().flatten();
            if let Some(r) = row.filter(|r| r.on_path && r.rear_m > s - 2.0) {
                return Some(Constraint { by: by(), gap_m: r.rear_m - s, speed_mps: r.speed_mps.max(0.0) });
            }
            // An object that is about to come onto the path while the ego would be there.
            let visit = c
                .visits
                .iter()
                .find(|v| v.from_beside && v.from_s > t && v.from_s < t + FORESIGHT_S && v.at_m > s)?;
            let arrives_s = t + (visit.at_m - s) / v.max(1.0);
            let meets = arrives_s > visit.from_s - BEFORE_S && arrives_s < visit.to_s + AFTER_S;
            meets.then(|| Constraint { by: by(), gap_m: visit.at_m - s, speed_mps: 0.0 })
        });
        let light = self.light.as_ref().and_then(move |(line, steps)| {
            let gap_m = line - s;
            let held = match steps.get(step).copied().unwrap_or(LightStep::Free) {
                LightStep::Free => false,
                LightStep::Yellow => driver.can_stop(v, gap_m),
                LightStep::Red => gap_m > 0.0,
            };
            (held && gap_m > 0.0).then_some(Constraint { by: Removed::Light, gap_m, speed_mps: 0.0 })
        });
        objects.chain(light)
    }
}

/// The path that the ego drives from `frame` on, extended straight beyond its end.
fn path(drive: &Drive, frame: usize) -> Option<Vec<PathPoint>> {
    let motion = &drive.ego.as_ref()?.motion;
    let mut out: Vec<PathPoint> = Vec::new();
    for f in frame..drive.times.len() {
        let (x, y, heading) = (motion.x[f], motion.y[f], motion.heading[f]);
        if x.is_nan() || y.is_nan() || heading.is_nan() {
            continue;
        }
        let Some(last) = out.last() else {
            out.push(PathPoint { x, y, s: 0.0, heading });
            continue;
        };
        let step = (x - last.x).hypot(y - last.y);
        if step > 0.3 {
            let s = last.s + step;
            out.push(PathPoint { x, y, s, heading });
            if s > 250.0 {
                break;
            }
        }
    }
    let last = *out.last()?;
    let (sin, cos) = last.heading.sin_cos();
    out.push(PathPoint {
        x: last.x + BEYOND_M * cos,
        y: last.y + BEYOND_M * sin,
        s: last.s + BEYOND_M,
        heading: last.heading,
    });
    Some(out)
}

impl Path {
    fn through(points: &[PathPoint]) -> Self {
        let segment = |w: &[PathPoint]| {
            let (dx, dy) = (w[1].x - w[0].x, w[1].y - w[0].y);
            Segment { from: w[0], dx, dy, length: dx.hypot(dy).max(1e-6) }
        };
        let segments: Vec<Segment> = points.windows(2).map(segment).collect();
        let around = |block: &[Segment]| {
            let none = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
            block.iter().fold(none, |[x0, y0, x1, y1], s| {
                let (a, b) = (s.from, (s.from.x + s.dx, s.from.y + s.dy));
                [x0.min(a.x).min(b.0), y0.min(a.y).min(b.1), x1.max(a.x).max(b.0), y1.max(a.y).max(b.1)]
            })
        };
        let bounds = segments.chunks(BLOCK).map(around).collect();
        Self { segments, bounds }
    }

    /// Position along and beside the path: (s, signed distance, heading there). `near`: index of a segment that is
    /// probably near, such as the last one found; the nearest one is stored in it. The result does not depend on it.
    fn place(&self, x: f64, y: f64, near: &mut usize) -> (f64, f64, f64) {
        let mut best = (f64::INFINITY, 0.0, 0.0, 0.0);
        // Slightly more than the square of the minimum distance: most blocks and segments are rejected here, without a
        // square root.
        let mut farthest = f64::INFINITY;
        if let Some(segment) = self.segments.get(*near) {
            farthest = segment.nearest(x, y).squared * (1.0 + 1e-9);
        }
        for (block, [x0, y0, x1, y1]) in self.bounds.iter().enumerate() {
            let (dx, dy) = ((x0 - x).max(x - x1).max(0.0), (y0 - y).max(y - y1).max(0.0));
            // Slightly less, for rounding.
            if block > 0 && (dx * dx + dy * dy) * (1.0 - 1e-9) > farthest {
                continue;
            }
            let from = block * BLOCK;
            let to = (from + BLOCK).min(self.segments.len());
            for (i, segment) in self.segments[from..to].iter().enumerate() {
                let found = segment.nearest(x, y);
                if found.squared > farthest {
                    continue;
                }
                let d = (x - found.x).hypot(y - found.y);
                if d < best.0 {
                    farthest = d * d * (1.0 + 1e-9);
                    let Segment { from: a, dx, dy, length } = *segment;
                    let side = (dx * (y - a.y) - dy * (x - a.x)) / length;
                    best = (d, a.s + found.along, side, a.heading);
                    *near = from + i;
                }
            }
        }
        (best.1, best.2, best.3)
    }
}

/// The point of a segment that is nearest to another.
struct Nearest {
    x: f64,
    y: f64,
    /// From the beginning of the segment, m.
    along: f64,
    /// Square of the distance, m2.
    squared: f64,
}

impl Segment {
    fn nearest(&self, x: f64, y: f64) -> Nearest {
        let Segment { from: a, dx, dy, length } = *self;
        let along = ((x - a.x) * dx + (y - a.y) * dy) / length;
        // A position behind the first point has a negative s.
        let low = if a.s == 0.0 { f64::NEG_INFINITY } else { 0.0 };
        let k = along.clamp(low, length);
        let (px, py) = (a.x + dx * k / length, a.y + dy * k / length);
        Nearest { x: px, y: py, along: k, squared: (x - px).powi(2) + (y - py).powi(2) }
    }
}

fn course(
    track: &whyroad_model::scene::Track,
    frames: &[Option<usize>],
    path: &Path,
    (ego_length, ego_width): (f64, f64),
) -> Option<Course> {
    let mut rows: Vec<Option<Row>> = Vec::with_capacity(frames.len());
    let mut nearest_m = f64::INFINITY;
    let or = |v: f64, d: f64| if v.is_nan() { d } else { v };
    let mut near = 0;
    for frame in frames {
        let row = frame.and_then(|f| track.row_at(f)).and_then(|r| {
            let m = &track.motion;
            let (x, y) = (m.x[r], m.y[r]);
            if x.is_nan() || y.is_nan() {
                return None;
            }
            let (s, side, heading) = path.place(x, y, &mut near);
            let turn = or(m.heading[r], heading) - heading;
            let (length, width) = (or(track.length_m[r], 1.0), or(track.width_m[r], 0.8));
            // Extent of the box across and along the path.
            let across = (length * turn.sin()).abs() + (width * turn.cos()).abs();
            let along = (length * turn.cos()).abs() + (width * turn.sin()).abs();
            let speed_mps = {
                let (vx, vy) = (or(m.vx[r], 0.0), or(m.vy[r], 0.0));
                vx * heading.cos() + vy * heading.sin()
            };
            let free = side.abs() - 0.5 * (across + ego_width);
            nearest_m = nearest_m.min(free.max(0.0).hypot((-s).max(0.0)));
            let rear_m = s - 0.5 * along - 0.5 * ego_length;
            Some(Row { rear_m, speed_mps, on_path: free < SIDE_MARGIN_M && rear_m > -1.0 })
        });
        rows.push(row);
    }
    if rows.iter().all(Option::is_none) {
        return None;
    }
    let mut visits: Vec<Visit> = Vec::new();
    let mut open = false;
    for (i, row) in rows.iter().enumerate() {
        let t = i as f64 * STEP_S;
        match row {
            Some(r) if r.on_path && open => {
                if let Some(v) = visits.last_mut() {
                    v.to_s = t;
                    v.at_m = v.at_m.min(r.rear_m);
                }
            }
            Some(r) if r.on_path => {
                open = true;
                visits.push(Visit { from_s: t, to_s: t, at_m: r.rear_m, from_beside: i > 0 });
            }
            _ => open = false,
        }
    }
    Some(Course { id: track.id.clone(), rows, visits, nearest_m })
}

/// The stop line of the ego's light, and the state of the light in each step; `None` where no light is known to hold
/// the ego.
fn light(signals: &SignalTable, frame: usize, frames: &[Option<usize>]) -> Option<(f64, Vec<LightStep>)> {
    let state = signals.frame_columns.get("light.state")?;
    let line = signals.frame_columns.get("light.distance_to_stop_line")?.number(frame)?;
    let mut last = LightStep::Free;
    let steps: Vec<LightStep> = frames
        .iter()
        .map(|f| {
            last = match f.and_then(|f| state.category(f)) {
                Some("red" | "red_yellow") => LightStep::Red,
                Some("yellow") => LightStep::Yellow,
                Some(state) if state.contains("green") => LightStep::Free,
                // Past the line the signal has no light; the last state is kept.
                _ => last,
            };
            last
        })
        .collect();
    steps.iter().any(|s| *s != LightStep::Free).then_some((line, steps))
}
