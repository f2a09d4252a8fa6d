//! Forecast of when the remaining required labels will be accepted: past days resampled into the future.
//!
//! Method: the counts of accepted labels of the last complete days (at most [`WINDOW_DAYS`]) are drawn again in blocks
//! of seven days, which keeps the rhythm of the week, until the required number is reached; repeated [`RUNS`]
//! times with a fixed seed. The forecast is the median day, its interval the middle 80 %. It assumes that people
//! continue to work as in those days. Source: H. R. Künsch, "The jackknife and the bootstrap for general stationary
//! observations", Annals of Statistics 17 (1989), for the moving blocks.

use serde::Serialize;
use whyroad_model::random::SplitMix64;

/// Days of the past that are drawn from.
pub const WINDOW_DAYS: usize = 56;
/// Days of the past that are needed.
pub const LEAST_DAYS: usize = 14;
/// Length of a block.
const BLOCK: usize = 7;
/// Runs.
const RUNS: usize = 2000;
/// No forecast goes beyond this many days.
const HORIZON: usize = 3650;

/// Days from now until the required number is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct DaysLeft {
    /// Median.
    pub median: usize,
    /// 10 % of the runs are done by then.
    pub low: usize,
    /// 90 % of the runs are done by then; `None` beyond ten years.
    pub high: Option<usize>,
}

/// Why there is no forecast.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NoForecast {
    /// No label is missing.
    Done,
    /// Fewer than [`LEAST_DAYS`] days since the first label was accepted.
    TooFewDays,
    /// Nothing was accepted in the days that are drawn from, or more than ten years would pass.
    NoProgress,
}

/// Days until `wanted` more are accepted, from the accepted labels of each past day, oldest first.
pub fn days_left(daily: &[u64], wanted: u64) -> Result<DaysLeft, NoForecast> {
    if wanted == 0 {
        return Err(NoForecast::Done);
    }
    if daily.len() < LEAST_DAYS {
        return Err(NoForecast::TooFewDays);
    }
    let window = &daily[daily.len().saturating_sub(WINDOW_DAYS)..];
    if window.iter().all(|n| *n == 0) {
        return Err(NoForecast::NoProgress);
    }
    let mut random = SplitMix64::new(0x5eed);
    // The future begins on the weekday after the last day: blocks start on that weekday, so weekends remain weekends.
    let starts: Vec<usize> =
        (0..=window.len() - BLOCK).filter(|i| (window.len() - i).is_multiple_of(BLOCK)).collect();
    let mut days: Vec<usize> = (0..RUNS).map(|_| run(window, &starts, wanted, &mut random)).collect();
    days.sort_unstable();
    let at = |share: f64| days[((days.len() - 1) as f64 * share).round() as usize];
    if at(0.5) >= HORIZON {
        return Err(NoForecast::NoProgress);
    }
    Ok(DaysLeft { median: at(0.5), low: at(0.1), high: Some(at(0.9)).filter(|d| *d < HORIZON) })
}

fn run(window: &[u64], starts: &[usize], wanted: u64, random: &mut SplitMix64) -> usize {
    let (mut done, mut day) = (0, 0);
    while day < HORIZON {
        let start = starts[(random.bits() % starts.len().max(1) as u64) as usize];
        for n in &window[start..start + BLOCK] {
            done += n;
            day += 1;
            if done >= wanted {
                return day;
            }
        }
    }
    HORIZON
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_pace_gives_the_day_of_the_division() {
        // 10 a day: 95 more are reached on the tenth day, in every run.
        let left = days_left(&[10; 30], 95).unwrap();
        assert_eq!(left, DaysLeft { median: 10, low: 10, high: Some(10) });
    }

    #[test]
    fn weekends_without_work_count() {
        // Four weeks of five days with 10 and two without, ending on a Sunday: 60 take 8 days (Mon to Fri,
        // Sat, Sun, Mon).
        let week = [10, 10, 10, 10, 10, 0, 0];
        let left = days_left(&week.repeat(4), 60).unwrap();
        assert_eq!((left.median, left.low, left.high), (8, 8, Some(8)));
    }

    #[test]
    fn an_uneven_pace_gives_an_interval() {
        let uneven: Vec<u64> = (0..56).map(|d| if (d / 7) % 2 == 0 { 2 } else { 20 }).collect();
        let left = days_left(&uneven, 500).unwrap();
        // Mean 11 a day: about 45 days.
        assert!((35..60).contains(&left.median), "{left:?}");
        assert!(left.low < left.median && left.median < left.high.unwrap(), "{left:?}");
        assert_eq!(left, days_left(&uneven, 500).unwrap(), "the seed is fixed");
    }

    #[test]
    fn what_cannot_be_said_is_not_said() {
        assert_eq!(days_left(&[5; 13], 10), Err(NoForecast::TooFewDays));
        assert_eq!(days_left(&[0; 40], 10), Err(NoForecast::NoProgress));
        assert_eq!(days_left(&[5; 40], 0), Err(NoForecast::Done));
        assert_eq!(days_left(&[1; 40], 1_000_000), Err(NoForecast::NoProgress));
    }
}
