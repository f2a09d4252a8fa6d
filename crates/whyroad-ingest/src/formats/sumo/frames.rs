//! From the simulation's time steps to frames at 10 Hz.
//!
//! At 10 Hz the steps are the frames. Faster: the step nearest to each tenth of a second after the ego's first, with
//! its own time; the others are left out. Slower, down to one step a second: positions, headings (the shorter way
//! round), speeds in between are interpolated linearly. Frames without the ego are cut.

use super::fcd::{Object, Sample};
use crate::assemble::angles::wrap_angle;
use std::collections::BTreeSet;

const FRAME_NS: i64 = 100_000_000;
/// A step within this of 0.1 s is 10 Hz.
const TOLERANCE_NS: i64 = 10_000_000;
/// Nothing is interpolated over more than this.
const MAX_INTERPOLATION_NS: i64 = 1_050_000_000;

/// How frames were made of the steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cadence {
    AsIs,
    /// Every n-th step.
    Thinned,
    /// Interpolated between steps of this length, ns.
    Filled(i64),
}

/// Frame times (ns of simulated time) and how they were made.
pub(super) fn frames(steps: &[i64], ego: &Object) -> (Vec<i64>, Cadence) {
    let own: Vec<i64> = ego.samples.iter().map(|s| s.time).collect();
    let mut gaps: Vec<i64> = steps.windows(2).map(|w| w[1].saturating_sub(w[0])).collect();
    gaps.sort_unstable();
    let Some(&step) = gaps.get(gaps.len() / 2) else { return (own, Cadence::AsIs) };
    if (step - FRAME_NS).abs() <= TOLERANCE_NS {
        return (own, Cadence::AsIs);
    }
    let ticks = (own[0]..=own[own.len() - 1]).step_by(FRAME_NS as usize);
    if step < FRAME_NS {
        let nearest = |t: i64| {
            let next = own.partition_point(|&x| x < t);
            let around = own[next.saturating_sub(1)..(next + 1).min(own.len())].iter().copied();
            around.min_by_key(|x| (x - t).abs()).filter(|x| (x - t).abs() <= step / 2 + 1)
        };
        let chosen: BTreeSet<i64> = ticks.filter_map(nearest).collect();
        return (chosen.into_iter().collect(), Cadence::Thinned);
    }
    let covered = |t: &i64| at(&ego.samples, *t).is_some();
    (ticks.filter(covered).collect(), Cadence::Filled(step))
}

/// The object at `time`: its own sample, or between its two neighbors. `None` when it was not there.
pub(super) fn at(samples: &[Sample], time: i64) -> Option<Sample> {
    let next = samples.partition_point(|s| s.time < time);
    let b = samples.get(next)?;
    if b.time == time {
        return Some(*b);
    }
    let a = &samples[next.checked_sub(1)?];
    if b.time.saturating_sub(a.time) > MAX_INTERPOLATION_NS {
        return None;
    }
    let share = time.saturating_sub(a.time) as f64 / b.time.saturating_sub(a.time) as f64;
    let mix = |a: f64, b: f64| a + (b - a) * share;
    Some(Sample {
        time,
        x: mix(a.x, b.x),
        y: mix(a.y, b.y),
        z: mix(a.z, b.z),
        heading: wrap_angle(a.heading + wrap_angle(b.heading - a.heading) * share),
        speed: mix(a.speed, b.speed),
        accel: mix(a.accel, b.accel),
        lag: b.time - time,
        signals: a.signals,
        aeb: a.aeb,
    })
}

#[cfg(test)]
mod tests {
    use super::super::vehicle_types::IsPerson;
    use super::*;

    fn object(step_ns: i64, n: i64) -> Object {
        let sample = |i: i64| Sample {
            time: i * step_ns,
            x: i as f64,
            y: 0.0,
            z: 0.0,
            heading: if i % 2 == 0 { 3.1 } else { -3.1 },
            speed: 10.0,
            accel: 0.0,
            lag: 0,
            signals: None,
            aeb: None,
        };
        Object { is_person: IsPerson::No, type_id: String::new(), samples: (0..n).map(sample).collect() }
    }

    fn steps(o: &Object) -> Vec<i64> {
        o.samples.iter().map(|s| s.time).collect()
    }

    #[test]
    fn ten_hertz_is_kept_and_twenty_is_halved() {
        let o = object(FRAME_NS, 5);
        assert_eq!(frames(&steps(&o), &o), (steps(&o), Cadence::AsIs));
        let o = object(50_000_000, 9);
        assert_eq!(frames(&steps(&o), &o).0, [0, 100_000_000, 200_000_000, 300_000_000, 400_000_000]);
        // 25 Hz: 0.00, 0.12 (or 0.08), 0.20, ...: each frame is a real step within half a step of its tick.
        let o = object(40_000_000, 11);
        let (f, _) = frames(&steps(&o), &o);
        assert_eq!(f.len(), 5);
        assert!(
            f.iter()
                .enumerate()
                .all(|(i, t)| (t - i as i64 * FRAME_NS).abs() <= 20_000_000 && t % 40_000_000 == 0)
        );
    }

    #[test]
    fn steps_farther_apart_than_64_bits_hold_leave_the_egos_frames() {
        // Found by the fuzz target `sumo-fcd`: a time of -1e308 s.
        let o = object(FRAME_NS, 2);
        let (f, _) = frames(&[i64::MIN, 0, FRAME_NS], &o);
        assert_eq!(f, [0, FRAME_NS]);
        let mut apart = object(FRAME_NS, 2);
        (apart.samples[0].time, apart.samples[1].time) = (i64::MIN, i64::MAX);
        assert!(at(&apart.samples, 0).is_none());
    }

    #[test]
    fn one_hertz_is_filled_the_short_way_round() {
        let o = object(1_000_000_000, 3);
        let (f, cadence) = frames(&steps(&o), &o);
        assert_eq!((f.len(), cadence), (21, Cadence::Filled(1_000_000_000)));
        let half = at(&o.samples, 500_000_000).map(|s| (s.x, s.heading.abs()));
        // Between 3.1 and -3.1 rad lies pi, not 0.
        assert!(half.is_some_and(|(x, h)| x == 0.5 && (h - std::f64::consts::PI).abs() < 1e-12), "{half:?}");
    }
}
