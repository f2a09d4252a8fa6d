//! RefAV's turning: uninterrupted runs of yaw of one sign that sum up to a turn.

use crate::geometry::wrap;
use std::f64::consts::FRAC_PI_4;
use whyroad_model::catalog::value::EgoRefavTurning;

/// Minimum mean yaw rate of a turn at a track's edge: 5 deg/s.
const EDGE_RADPS: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Yaw rate by central differences, one-sided at the ends, rad/s.
fn yaw_rates(times: &[f64], headings: &[f64]) -> Vec<f64> {
    let last = times.len() - 1;
    (0..=last)
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
            wrap(headings[b] - headings[a]) / (times[b] - times[a])
        })
        .collect()
}

/// The turn of a run: its sum as computed by RefAV (each rate times the first time step of the track).
fn turn_of(rates: &[f64], step: f64, at_start: bool, at_end: bool) -> EgoRefavTurning {
    let turned = rates.iter().sum::<f64>() * step;
    let sign = turned.signum();
    let code = if turned > 0.0 { EgoRefavTurning::Left } else { EgoRefavTurning::Right };
    if turned.abs() > FRAC_PI_4 {
        return code;
    }
    let mean = rates.iter().sum::<f64>() / rates.len() as f64;
    let fast = |rate: Option<&f64>| rate.is_some_and(|r| sign * r > EDGE_RADPS);
    let cut = (at_start && fast(rates.first())) || (at_end && fast(rates.last()));
    if cut && sign * mean > EDGE_RADPS && turned.abs() > FRAC_PI_4 / 3.0 {
        code
    } else {
        EgoRefavTurning::None
    }
}

/// The value of refav_turning by row; `None` where the heading (rad) is not known. `times` in s.
pub fn turning(times: &[f64], headings: &[f64]) -> Vec<Option<EgoRefavTurning>> {
    let known: Vec<usize> = (0..headings.len()).filter(|&i| headings[i].is_finite()).collect();
    let mut codes: Vec<Option<EgoRefavTurning>> =
        headings.iter().map(|h| h.is_finite().then_some(EgoRefavTurning::None)).collect();
    if known.len() < 2 {
        return codes;
    }
    let at: Vec<f64> = known.iter().map(|&i| times[i]).collect();
    let of: Vec<f64> = known.iter().map(|&i| headings[i]).collect();
    let rates = yaw_rates(&at, &of);
    let (n, step) = (rates.len(), at[1] - at[0]);
    let (mut start, mut end) = (0, 0);
    while start < n - 1 {
        if rates[start] * rates[end] > 0.0 && end < n - 1 {
            end += 1;
            continue;
        }
        // RefAV's runs also contain the first row of the next sign.
        let code = turn_of(&rates[start..=end], step, start == 0, end == n - 1);
        if code != EgoRefavTurning::None {
            for &row in &known[start..=end] {
                codes[row] = Some(code);
            }
        }
        start = end;
        end += 1;
    }
    codes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(heading: impl Fn(f64) -> f64) -> Vec<Option<EgoRefavTurning>> {
        let times: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.1).collect();
        let headings: Vec<f64> = times.iter().map(|&t| wrap(heading(t))).collect();
        turning(&times, &headings)
    }

    #[test]
    fn turns_by_hand() {
        // 50 deg to the left between 2 and 7 s, over the wrap at 180 deg: a turn. 40 deg: none.
        let over = |deg: f64| move |t: f64| 2.9 + (deg / 5.0 * (t - 2.0).clamp(0.0, 5.0)).to_radians();
        assert_eq!(run(over(50.0))[40], Some(EgoRefavTurning::Left));
        assert_eq!(run(over(-50.0))[40], Some(EgoRefavTurning::Right));
        assert!(run(over(40.0)).iter().all(|c| *c == Some(EgoRefavTurning::None)));
        // 30 deg in the first three seconds of the track (10 deg/s): cut off, so 15 deg are enough; 12 deg are not.
        let first = |deg: f64| move |t: f64| (deg / 3.0 * t.min(3.0)).to_radians();
        assert_eq!(run(first(30.0))[10], Some(EgoRefavTurning::Left));
        assert_eq!(run(first(12.0))[10], Some(EgoRefavTurning::None));
    }
}
