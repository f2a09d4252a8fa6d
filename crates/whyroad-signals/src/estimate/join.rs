//! Interrupted ids: an object that disappears and one that appears soon after at the predicted position, with the same
//! motion, kind and size, are one object. Each end is joined to at most one beginning and vice versa, the nearest
//! first; ambiguous candidates are not joined.

use super::noise::{LogNoise, Rows};
use whyroad_model::ObjectClass;

/// Maximum time between the end and the beginning, s.
pub const MAX_AWAY_S: f64 = 1.05;
/// Rows over which the motion at an end is fitted, s.
const FIT_S: f64 = 1.0;
/// Maximum acceleration of an object while it is not observed, m/s2.
const UNSEEN_ACCEL_MPS2: f64 = 3.0;
/// Maximum difference of sizes, as a share of the larger one.
const SIZE_SHARE: f64 = 0.3;
/// Standard deviations within which positions and velocities agree.
const DEVIATIONS: f64 = 3.0;

/// One track as joining sees it.
#[derive(Clone, Copy, Debug)]
pub struct Candidate<'a> {
    /// Its measurements.
    pub rows: Rows<'a>,
    /// Class.
    pub class: ObjectClass,
    /// Median length and width of the box, m; NaN is unknown.
    pub size: (f64, f64),
}

/// Position and velocity at one end of a track.
#[derive(Clone, Copy, Debug)]
struct End {
    time: f64,
    place: (f64, f64),
    velocity: (f64, f64),
    /// Variance of a coordinate of the position, and of the velocity.
    variances: (f64, f64),
}

/// Index of the track that continues each track, if there is one. `of` returns the noise of each candidate's kind.
pub fn joins(tracks: &[Candidate<'_>], of: impl Fn(usize) -> LogNoise) -> Vec<Option<usize>> {
    let first_time =
        tracks.iter().filter_map(|t| t.rows.times.first()).copied().fold(f64::INFINITY, f64::min);
    let last_time =
        tracks.iter().filter_map(|t| t.rows.times.last()).copied().fold(f64::NEG_INFINITY, f64::max);
    let mut beginnings: Vec<(f64, usize)> = (0..tracks.len())
        .filter_map(|i| tracks[i].rows.times.first().map(|t| (*t, i)))
        .filter(|(t, _)| *t > first_time)
        .collect();
    beginnings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut fits: Vec<(f64, usize, usize)> = Vec::new();
    for (i, track) in tracks.iter().enumerate() {
        let Some(&gone) = track.rows.times.last().filter(|t| **t < last_time) else { continue };
        let from = beginnings.partition_point(|(t, _)| *t <= gone);
        let mut last = None;
        for &(_, k) in beginnings[from..].iter().take_while(|(t, _)| t - gone <= MAX_AWAY_S) {
            if !alike(track, &tracks[k]) {
                continue;
            }
            let noise = of(i);
            let Some(end) = *last.get_or_insert_with(|| end(track.rows, &noise)) else { break };
            // Too far apart for any motion, so a fit is not needed.
            let far = 80.0 * MAX_AWAY_S + 5.0;
            let (Some(x), Some(y)) = (tracks[k].rows.x.first(), tracks[k].rows.y.first()) else { continue };
            if (x - end.place.0).abs() > far || (y - end.place.1).abs() > far {
                continue;
            }
            let Some(start) = beginning(tracks[k].rows, &noise) else { continue };
            if let Some(distance) = distance(&end, &start) {
                fits.push((distance, i, k));
            }
        }
    }
    fits.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut next = vec![None; tracks.len()];
    let mut taken = vec![false; tracks.len()];
    for &(distance, i, k) in &fits {
        if next[i].is_some() || taken[k] {
            continue;
        }
        // Two candidates that fit about equally well: it is unknown which one is right.
        let rivals = fits.iter().filter(|(d, a, b)| (*a == i) != (*b == k) && *d < 1.5 * distance + 0.1);
        if rivals.count() == 0 {
            (next[i], taken[k]) = (Some(k), true);
        }
    }
    next
}

fn alike(a: &Candidate<'_>, b: &Candidate<'_>) -> bool {
    let close = |a: f64, b: f64| a.is_nan() || b.is_nan() || (a - b).abs() <= SIZE_SHARE * a.max(b);
    let classes = a.class == b.class
        || a.class == ObjectClass::Unknown
        || b.class == ObjectClass::Unknown
        || (a.class.is_vehicle() && b.class.is_vehicle());
    classes && close(a.size.0, b.size.0) && close(a.size.1, b.size.1)
}

/// Distance, in standard deviations, between the beginning and the predicted position of the ended track; `None` beyond
/// the gate.
fn distance(end: &End, start: &End) -> Option<f64> {
    let away = start.time - end.time;
    let mean = |a: f64, b: f64| 0.5 * (a + b);
    let velocity = (mean(end.velocity.0, start.velocity.0), mean(end.velocity.1, start.velocity.1));
    let off =
        (start.place.0 - end.place.0 - velocity.0 * away, start.place.1 - end.place.1 - velocity.1 * away);
    let unseen = UNSEEN_ACCEL_MPS2 * away;
    let spread = end.variances.0
        + start.variances.0
        + 0.5 * (end.variances.1 + start.variances.1) * away * away
        + (0.25 * unseen * away).powi(2)
        + 0.01;
    let speed_spread = end.variances.1 + start.variances.1 + (0.5 * unseen).powi(2) + 0.04;
    let (dvx, dvy) = (start.velocity.0 - end.velocity.0, start.velocity.1 - end.velocity.1);
    let place = off.0.hypot(off.1) / spread.sqrt();
    let speed = dvx.hypot(dvy) / speed_spread.sqrt();
    // Two coordinates: the gate is slightly wider than for one.
    let gate = DEVIATIONS * 1.25;
    (place <= gate && speed <= gate).then_some(place.hypot(speed))
}

fn end(rows: Rows<'_>, noise: &LogNoise) -> Option<End> {
    let last = *rows.times.last()?;
    let from = rows.times.partition_point(|t| *t < last - FIT_S);
    fit(rows, from..rows.times.len(), last, noise)
}

fn beginning(rows: Rows<'_>, noise: &LogNoise) -> Option<End> {
    let first = *rows.times.first()?;
    let to = rows.times.partition_point(|t| *t <= first + FIT_S);
    fit(rows, 0..to, first, noise)
}

/// A line through the rows, read at `time`.
fn fit(rows: Rows<'_>, range: std::ops::Range<usize>, time: f64, noise: &LogNoise) -> Option<End> {
    let known: Vec<usize> = range.filter(|&i| rows.x[i].is_finite() && rows.y[i].is_finite()).collect();
    let n = known.len() as f64;
    if known.is_empty() {
        return None;
    }
    let step =
        if n > 1.0 { (rows.times[known[known.len() - 1]] - rows.times[known[0]]) / (n - 1.0) } else { 0.1 };
    let variance = noise.position.variance(step.max(0.02));
    let mean_of = |v: &[f64]| known.iter().map(|&i| v[i]).sum::<f64>() / n;
    let middle = mean_of(rows.times);
    let spread: f64 = known.iter().map(|&i| (rows.times[i] - middle).powi(2)).sum();
    let along = |v: &[f64]| known.iter().map(|&i| (rows.times[i] - middle) * v[i]).sum::<f64>() / spread;
    let stated: Vec<usize> = known
        .iter()
        .copied()
        .filter(|&i| rows.vx.get(i).is_some_and(|v| v.is_finite()) && rows.vy[i].is_finite())
        .collect();
    let (velocity, of_velocity) = if !stated.is_empty() {
        let k = stated.len() as f64;
        let mean = |v: &[f64]| stated.iter().map(|&i| v[i]).sum::<f64>() / k;
        ((mean(rows.vx), mean(rows.vy)), noise.velocity.variance(step.max(0.02)) / k)
    } else if known.len() >= 3 && spread > 0.0 {
        ((along(rows.x), along(rows.y)), variance / spread)
    } else {
        // A single position: any velocity.
        ((0.0, 0.0), 100.0)
    };
    let ahead = time - middle;
    // Error at the end of a line over one second for an accelerating object.
    let bend = (0.25 * UNSEEN_ACCEL_MPS2 * ahead * ahead).powi(2);
    Some(End {
        time,
        place: (mean_of(rows.x) + velocity.0 * ahead, mean_of(rows.y) + velocity.1 * ahead),
        velocity,
        variances: (variance / n + of_velocity * ahead * ahead + bend, of_velocity + (0.5 * ahead).powi(2)),
    })
}

#[cfg(test)]
mod tests {
    use super::super::noise::Noise;
    use super::*;

    /// A car at 10 m/s along x from `from` to `to` seconds, with an offset of `y` m.
    fn car(from: f64, to: f64, y: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let n = ((to - from) * 10.0).round() as usize;
        let times: Vec<f64> = (0..n).map(|i| from + i as f64 / 10.0).collect();
        let x = times.iter().map(|t| 10.0 * t).collect();
        (times, x, vec![y; n])
    }

    fn found(tracks: &[(Vec<f64>, Vec<f64>, Vec<f64>)], classes: &[ObjectClass]) -> Vec<Option<usize>> {
        let candidates: Vec<Candidate<'_>> = tracks
            .iter()
            .zip(classes)
            .map(|((times, x, y), class)| Candidate {
                rows: Rows { times, x, y, ..Rows::default() },
                class: *class,
                size: (f64::NAN, f64::NAN),
            })
            .collect();
        let position = Noise { white: 0.1, correlated: 0.0, negligible: 0.015 };
        joins(&candidates, |_| LogNoise { position, ..LogNoise::default() })
    }

    #[test]
    fn an_id_that_breaks_is_joined_and_a_neighbor_is_not() {
        use ObjectClass::{Car, Pedestrian};
        // Missing for 0.3 s; the car in the adjacent lane is observed without interruption.
        let broken = [car(0.0, 4.0, 0.0), car(4.3, 9.0, 0.1), car(0.0, 9.0, 3.5)];
        assert_eq!(found(&broken, &[Car; 3]), [Some(1), None, None]);
        assert_eq!(found(&broken, &[Car, Pedestrian, Car]), [None; 3], "another kind");
        let aside = [car(0.0, 4.0, 0.0), car(4.3, 9.0, 3.5)];
        assert_eq!(found(&aside, &[Car; 2]), [None; 2], "a lane aside");
        let late = [car(0.0, 4.0, 0.0), car(6.0, 9.0, 0.0)];
        assert_eq!(found(&late, &[Car; 2]), [None; 2], "two seconds away");
    }

    #[test]
    fn two_that_fit_equally_are_left_apart() {
        let two = [car(0.0, 4.0, 0.0), car(4.2, 9.0, 0.3), car(4.2, 9.0, -0.3)];
        assert_eq!(found(&two, &[ObjectClass::Car; 3]), [None; 3]);
    }
}
