//! A sample as a short vector, so that samples with the same training content have a small distance: the ego's motion
//! before and after t0, the object that the label is about, and the surroundings. Each number is divided by the size of
//! a clear difference; the distance of two samples is the root mean square over all numbers, and their similarity is `1
//! / (1 + distance)`.

use crate::item::DESCRIPTOR;
use crate::sample::{Object, Sample, Trajectory};
use std::collections::BTreeSet;

/// Represents "unknown": equal to itself, far from every known value.
const UNKNOWN: f32 = -9.0;

/// The vector; always [`DESCRIPTOR`] numbers.
pub(crate) fn of(sample: &Sample, named: &BTreeSet<String>) -> Vec<f32> {
    let mut out = Vec::with_capacity(DESCRIPTOR);
    let mut put = |value: Option<f32>, scale: f32| out.push(value.map_or(UNKNOWN, |v| v / scale));
    let past = |share: f32| index(&sample.history, share);
    let ahead = |share: f32| index(&sample.future, share);
    for sixth in 1..=6 {
        let i = ahead(sixth as f32 / 6.0);
        put(value(&sample.future.x, i), 4.0);
        put(value(&sample.future.y, i), 1.0);
    }
    for share in [0.0, 0.5] {
        let i = past(share);
        put(value(&sample.history.x, i), 4.0);
        put(value(&sample.history.y, i), 1.0);
    }
    let now = past(1.0);
    put(value(&sample.history.speed, now), 2.0);
    put(value(&sample.history.accel, now), 1.0);
    put(value(&sample.history.yaw_rate, now), 0.1);

    let target = sample.objects.iter().find(|o| named.contains(&o.id)).or_else(|| in_path(sample));
    let row = |t: f32| target.and_then(|o| row_at(o, t));
    let half = sample.history.t_s.first().copied().unwrap_or(0.0) / 2.0;
    for t in [0.0, half] {
        put(row(t).and_then(|(o, r)| o.x[r]), 5.0);
        put(row(t).and_then(|(o, r)| o.y[r]), 1.5);
    }
    put(row(0.0).and_then(|(o, r)| o.vx[r]), 2.0);
    put(row(0.0).and_then(|(o, r)| o.vy[r]), 1.0);
    let class = target.map(|o| o.class.as_str());
    for group in [
        ["car", "emergency_vehicle", "tricycle", "vehicle", ""],
        ["truck", "bus", "large_vehicle", "", ""],
        ["bicycle", "bicyclist", "motorcycle", "motorcyclist", "e_bike"],
        ["pedestrian", "wheeled_pedestrian", "animal", "", ""],
    ] {
        put(Some(f32::from(class.is_some_and(|c| group.contains(&c)))), 0.5);
    }
    put(Some(f32::from(target.is_some())), 0.5);

    let here: Vec<(f32, f32)> = sample
        .objects
        .iter()
        .filter_map(|o| row_at(o, 0.0).and_then(|(o, r)| Some((o.x[r]?, o.y[r]?))))
        .collect();
    let near = here.iter().filter(|(x, y)| x.hypot(*y) < 30.0).count();
    put(Some(near as f32), 4.0);
    type Sector = fn(f32, f32) -> bool;
    let sectors: [Sector; 4] =
        [|x, y| x > y.abs(), |x, y| -x > y.abs(), |x, y| y >= x.abs(), |x, y| -y >= x.abs()];
    for inside in sectors {
        let nearest =
            here.iter().filter(|(x, y)| inside(*x, *y)).map(|(x, y)| x.hypot(*y)).fold(50.0, f32::min);
        put(Some(nearest), 10.0);
    }
    let lit = |color: &str| sample.lights.as_ref().map(|l| f32::from(l.iter().any(|l| l.color == color)));
    for color in ["red", "yellow", "green"] {
        put(lit(color), 0.5);
    }
    let lanes = sample.map.as_ref().map(|m| m.iter().filter(|e| e.kind.ends_with("lane")).count() as f32);
    put(lanes, 10.0);
    let weather = sample.context.as_ref().and_then(|c| c.iter().find(|c| c.kind == "weather"));
    put(weather.map(|w| w.value.bytes().map(f32::from).sum::<f32>() % 97.0), 1.0);
    debug_assert_eq!(out.len(), DESCRIPTOR);
    out
}

fn index(t: &Trajectory, share: f32) -> usize {
    let last = t.t_s.len().saturating_sub(1);
    (share * last as f32).round() as usize
}

fn value(values: &[Option<f32>], i: usize) -> Option<f32> {
    values.get(i).copied().flatten()
}

/// The nearest object ahead in a corridor of the ego's width.
fn in_path(sample: &Sample) -> Option<&Object> {
    let ahead = |o: &&Object| {
        row_at(o, 0.0)
            .is_some_and(|(o, r)| matches!((o.x[r], o.y[r]), (Some(x), Some(y)) if x > 0.0 && y.abs() < 2.0))
    };
    sample.objects.iter().find(ahead)
}

/// The row nearest to `t`, at most 0.15 s away.
fn row_at(o: &Object, t: f32) -> Option<(&Object, usize)> {
    let near = o.t_s.iter().enumerate().map(|(i, s)| (i, (s - t).abs()));
    let (row, off) = near.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (off <= 0.15).then_some((o, row))
}

/// Root mean square difference.
pub(crate) fn distance(a: &[f32], b: &[f32]) -> f64 {
    let sum: f32 = a.iter().zip(b).map(|(p, q)| (p - q) * (p - q)).sum();
    (f64::from(sum) / a.len().max(1) as f64).sqrt()
}

/// 1 for equal samples, towards 0 for different ones.
pub(crate) fn similarity(distance: f64) -> f64 {
    1.0 / (1.0 + distance)
}

/// The distance at which samples have this similarity.
pub(crate) fn distance_of(similarity: f64) -> f64 {
    1.0 / similarity.max(1e-6) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(speed: f32) -> Sample {
        let steps = |n: i32, from: i32| (0..n).map(move |i| (from + i) as f32 / 10.0);
        let along = |t: f32| Some(speed * t);
        let trajectory = |n, from| Trajectory {
            t_s: steps(n, from).collect(),
            x: steps(n, from).map(along).collect(),
            y: steps(n, from).map(|_| Some(0.0)).collect(),
            speed: steps(n, from).map(|_| Some(speed)).collect(),
            ..Trajectory::default()
        };
        Sample { history: trajectory(21, -20), future: trajectory(60, 1), ..Sample::default() }
    }

    #[test]
    fn a_little_faster_is_similar_and_much_faster_is_not() {
        let d =
            |v| similarity(distance(&of(&sample(10.0), &BTreeSet::new()), &of(&sample(v), &BTreeSet::new())));
        assert_eq!(of(&sample(10.0), &BTreeSet::new()).len(), DESCRIPTOR);
        assert_eq!(d(10.0), 1.0);
        assert!(d(10.1) > 0.9, "{}", d(10.1));
        assert!(d(15.0) < 0.6, "{}", d(15.0));
        assert!((similarity(distance_of(0.9)) - 0.9).abs() < 1e-12);
    }
}
