//! `ego`: the recording vehicle's pose and bus, at its own rate, brought to frames.

use super::findings;
use super::meta::EgoBox;
use super::problems::Problems;
use super::reader::{Clock, Reader};
use super::sheet::{Sheet, TIME};
use crate::assemble::frames::{Sample, Sampled};
use crate::assemble::resample::{greatest, latest, linear};
use crate::report::RowCount;
use whyroad_model::scene::{Ego, EgoBus};

pub(super) const REQUIRED: &[&[&str]] = &[TIME, &["x_m"], &["y_m"], &["heading_rad", "heading_deg"]];

/// No drive begins this long after its start, s: 2001-09-09 as seconds since 1970.
const SINCE_1970_S: f64 = 1e9;

/// Time between frames, s.
const FRAME_S: f64 = 0.1;

const ROUTES: &[&str] = &["none", "left", "right", "straight", "uturn", "exit"];

/// The rows that can be kept, ascending in time.
pub(super) struct EgoRows {
    pub label: String,
    /// ns.
    pub times: Vec<i64>,
    pose: Vec<Pose>,
    accel: Vec<f64>,
    yaw_rate: Vec<f64>,
    /// One value per row.
    bus: EgoBus,
}

#[derive(Clone, Copy)]
struct Pose {
    position: [f64; 3],
    heading: f64,
    velocity: Velocity,
}

/// A stated velocity, m/s: over ground, or along the heading alone.
#[derive(Clone, Copy)]
pub(super) struct Velocity {
    pub vector: [f64; 2],
    pub forward: f64,
}

/// Velocity over ground from `vx_mps, vy_mps`, or from `speed_mps` along the heading (negative: backwards).
pub(super) fn velocities(sheet: &Sheet, problems: &mut Problems) -> Vec<Velocity> {
    if sheet.has("speed_mps") && !sheet.has("vx_mps") {
        let speed = sheet.numbers("speed_mps", problems);
        return speed.into_iter().map(|forward| Velocity { vector: [f64::NAN; 2], forward }).collect();
    }
    let (vx, vy) = (sheet.numbers("vx_mps", problems), sheet.numbers("vy_mps", problems));
    vx.into_iter().zip(vy).map(|(x, y)| Velocity { vector: [x, y], forward: f64::NAN }).collect()
}

/// Rows whose time was recorded before: the clock was set back. A table whose rows are in no order at all is sorted
/// instead: more than this share of its rows come before the one above.
const UNSORTED_SHARE: f64 = 0.05;

fn backward(order: &[(i64, usize)]) -> Vec<usize> {
    let steps = order.windows(2).filter(|w| w[1].0 < w[0].0).count();
    if steps as f64 > UNSORTED_SHARE * order.len() as f64 {
        return Vec::new();
    }
    let mut latest = i64::MIN;
    let mut out = Vec::new();
    for &(time, row) in order {
        // Equal times are duplicates.
        if time < latest {
            out.push(row);
        }
        latest = latest.max(time);
    }
    out
}

/// Reads the table; `None` when no row can be kept.
pub(super) fn rows(sheet: Sheet, reader: &mut Reader) -> Option<EgoRows> {
    let mut problems = Problems::default();
    let p = &mut problems;
    let times = sheet.times(reader.start, p);
    let [x, y, z] = ["x_m", "y_m", "z_m"].map(|n| sheet.numbers(n, p));
    let headings = sheet.headings(p);
    let velocity = velocities(&sheet, p);
    let [accel, yaw_rate, speed, steering] =
        ["accel_mps2", "yaw_rate_radps", "bus_speed_mps", "steering_rad"].map(|n| sheet.numbers(n, p));
    let share = |text: &str| text.parse::<f64>().ok().filter(|v| v.is_nan() || (0.0..=1.0).contains(v));
    let throttle = sheet.parsed("throttle", "a number from 0 to 1", p, share);
    let throttle: Vec<f64> = throttle.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect();
    let vertical_accel = sheet.numbers("vertical_accel_mps2", p);
    let [brake, aeb, cruise, wipers] = ["brake", "aeb", "cruise", "wipers"].map(|n| sheet.flags(n, p));
    let gear = sheet.parsed("gear", "one of P, R, N, D", p, |t| match t {
        "P" | "R" | "N" | "D" => t.chars().next(),
        _ => None,
    });
    let turn_signal = sheet.words("turn_signal", "one of off, left, right, hazard", p);
    let route = sheet.parsed("route_command", "one of none, left, right, straight, uturn, exit", p, |t| {
        ROUTES.contains(&t).then(|| t.to_owned())
    });

    let mut count = RowCount { read: sheet.rows, ..RowCount::new("ego") };
    let mut order: Vec<(i64, usize)> = Vec::new();
    for (i, time) in times.iter().enumerate() {
        let row = sheet.first_row + i;
        match time {
            None => problems.row("no_time", row, &mut count),
            Some(_) if [x[i], y[i], headings[i]].iter().any(|v| v.is_nan()) => {
                problems.row("no_position", row, &mut count);
            }
            Some(t) => order.push((*t, i)),
        }
    }
    for i in backward(&order) {
        problems.row("out_of_order", sheet.first_row + i, &mut count);
        order.retain(|(_, of)| *of != i);
    }
    order.sort_unstable();
    let mut kept: Vec<(i64, usize)> = Vec::with_capacity(order.len());
    for (t, i) in order {
        if kept.last().is_some_and(|(last, _)| *last == t) {
            problems.row("duplicate", sheet.first_row + i, &mut count);
        } else {
            kept.push((t, i));
        }
    }
    count.keep("pose", kept.len());
    reader.report.tables.push(count);
    reader.report.diagnostics.extend(problems.diagnostics(&sheet.label));
    if kept.is_empty() {
        if sheet.rows == 0 {
            reader.report.diagnostics.push(findings::no_row(&sheet.label));
        }
        return None;
    }
    let seconds = kept[0].0.saturating_sub(reader.start.0) as f64 / 1e9;
    if !sheet.states_dates() && seconds > SINCE_1970_S {
        reader.report.diagnostics.push(findings::since_1970(&sheet.label, seconds));
        return None;
    }
    let pose = |i: usize| Pose { position: [x[i], y[i], z[i]], heading: headings[i], velocity: velocity[i] };
    let numbers = |v: &[f64]| kept.iter().map(|&(_, i)| v[i]).collect::<Vec<_>>();
    fn pick<T: Clone>(kept: &[(i64, usize)], v: &[Option<T>]) -> Vec<Option<T>> {
        kept.iter().map(|&(_, i)| v[i].clone()).collect()
    }
    Some(EgoRows {
        label: sheet.label.clone(),
        times: kept.iter().map(|k| k.0).collect(),
        pose: kept.iter().map(|&(_, i)| pose(i)).collect(),
        accel: numbers(&accel),
        yaw_rate: numbers(&yaw_rate),
        bus: EgoBus {
            speed_mps: numbers(&speed),
            steering: numbers(&steering),
            brake: pick(&kept, &brake),
            throttle: numbers(&throttle),
            gear: pick(&kept, &gear),
            turn_signal: pick(&kept, &turn_signal),
            aeb: pick(&kept, &aeb),
            wipers: pick(&kept, &wipers),
            vertical_accel: numbers(&vertical_accel),
            cruise: pick(&kept, &cruise),
            route_command: pick(&kept, &route),
        },
    })
}

impl EgoRows {
    fn seconds(&self, clock: &Clock) -> Vec<f64> {
        self.times.iter().map(|&t| clock.seconds(t)).collect()
    }

    /// Takes away the frames for which there is no pose: a gap in the log is a gap in the drive.
    pub fn keep_covered(&self, clock: &mut Clock) {
        let seconds = self.seconds(clock);
        let there = linear(&seconds, &vec![0.0; seconds.len()], &clock.frames, clock.max_gap_s);
        let mut there = there.iter();
        clock.frames.retain(|_| there.next().is_some_and(|v| !v.is_nan()));
    }

    /// The ego at the clock's frames, its pose moved to the middle of its box.
    pub fn at(&self, clock: &Clock, shape: &EgoBox) -> Ego {
        let seconds = self.seconds(clock);
        let d = shape.reference_to_centre_m;
        let mut samples = Sampled::default();
        for (pose, &time) in self.pose.iter().zip(&seconds) {
            let (s, c) = pose.heading.sin_cos();
            let [x, y, z] = pose.position;
            // A velocity is that of the reference point; the middle of the car also swings round it, but has the same
            // speed along the heading.
            let Velocity { vector, forward } = pose.velocity;
            let (vector, forward) = match d {
                0.0 => (vector, forward),
                _ if forward.is_nan() => ([f64::NAN; 2], vector[0] * c + vector[1] * s),
                _ => (vector, forward),
            };
            samples.push(Sample {
                time,
                position: [x + d * c, y + d * s, z],
                heading: pose.heading,
                velocity: vector,
                forward,
                size: [f64::NAN; 3],
                ..Sample::UNKNOWN
            });
        }
        let mut motion = samples.motion_at(&clock.frames, clock.max_gap_s);
        let number = |v: &[f64]| linear(&seconds, v, &clock.frames, clock.max_gap_s);
        let is_given = |v: &[f64]| v.iter().any(|x| x.is_finite());
        if is_given(&self.yaw_rate) {
            motion.yaw_rate = number(&self.yaw_rate);
        }
        if is_given(&self.accel) {
            motion.accel = number(&self.accel);
        }
        let last = latest(&seconds, &clock.frames, clock.max_gap_s);
        Ego {
            length_m: shape.length_m,
            width_m: shape.width_m,
            height_m: shape.height_m,
            reference_to_centre_m: d,
            motion,
            bus: EgoBus {
                speed_mps: if is_given(&self.bus.speed_mps) {
                    number(&self.bus.speed_mps)
                } else {
                    Vec::new()
                },
                steering: if is_given(&self.bus.steering) { number(&self.bus.steering) } else { Vec::new() },
                throttle: if is_given(&self.bus.throttle) { number(&self.bus.throttle) } else { Vec::new() },
                brake: states(&self.bus.brake, &last),
                gear: states(&self.bus.gear, &last),
                turn_signal: states(&self.bus.turn_signal, &last),
                aeb: states(&self.bus.aeb, &last),
                wipers: states(&self.bus.wipers, &last),
                vertical_accel: if is_given(&self.bus.vertical_accel) {
                    greatest(&seconds, &self.bus.vertical_accel, &clock.frames, FRAME_S)
                } else {
                    Vec::new()
                },
                cruise: states(&self.bus.cruise, &last),
                route_command: states(&self.bus.route_command, &last),
            },
            known_at: samples.lags(&clock.frames),
        }
    }
}

/// States at frames; none at all when no row has one.
pub(super) fn states<T: Clone>(values: &[Option<T>], last: &[Option<usize>]) -> Vec<Option<T>> {
    if values.iter().all(Option::is_none) {
        return Vec::new();
    }
    last.iter().map(|i| values[(*i)?].clone()).collect()
}
