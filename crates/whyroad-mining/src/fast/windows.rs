//! Numbers over the past window: share of time, least, greatest. One pass over the rows, for any window.

use super::numbers::Numbers;
use super::temporal::{Stretches, begins_inside, reaches};
use super::truth::Truth;
use std::collections::VecDeque;
use whyroad_model::Nanos;

/// Share of the past window, now included, in which the condition was true; NaN where a part of it is unknown.
pub fn past_share(c: &Truth, on: Stretches<'_>, d: Nanos) -> Numbers<'static> {
    let mut out = vec![f64::NAN; c.len()];
    for (segment, rows) in on.each() {
        let (mut start, mut held, mut unknown) = (0, 0i64, 0usize);
        let time = |i: usize| (rows[i].end - rows[i].time).0;
        for i in 0..rows.len() {
            let at = segment.start + i;
            held += if c.yes.get(at) { time(i) } else { 0 };
            unknown += usize::from(!c.known.get(at));
            while start < i && !reaches(rows, i, start, d) {
                let left = segment.start + start;
                held -= if c.yes.get(left) { time(start) } else { 0 };
                unknown -= usize::from(!c.known.get(left));
                start += 1;
            }
            if unknown == 0 && (start > 0 || begins_inside(rows, i, d)) {
                out[at] = held as f64 / (rows[i].end - rows[start].time).0 as f64;
            }
        }
    }
    Numbers::of(out)
}

/// Extreme of the past window, now included; `better` decides which of two is kept. NaN where a part is unknown.
pub fn past_extreme(
    v: &Numbers<'_>,
    on: Stretches<'_>,
    d: Nanos,
    better: impl Fn(f64, f64) -> bool,
) -> Numbers<'static> {
    let values = v.values();
    let mut out = vec![f64::NAN; values.len()];
    each_extreme(&values, on, d, better, |row, best| out[row] = values[best]);
    Numbers::of(out)
}

/// For each row the one that has the extreme of the past window, the latest of equals; `None` where it is unknown.
pub fn past_extreme_rows(
    v: &Numbers<'_>,
    on: Stretches<'_>,
    d: Nanos,
    better: impl Fn(f64, f64) -> bool,
) -> Vec<Option<usize>> {
    let values = v.values();
    let mut out = vec![None; values.len()];
    each_extreme(&values, on, d, better, |row, best| out[row] = Some(best));
    out
}

/// Calls `put` for each row of which the extreme is known, with the row that has it.
fn each_extreme(
    values: &[f64],
    on: Stretches<'_>,
    d: Nanos,
    better: impl Fn(f64, f64) -> bool,
    mut put: impl FnMut(usize, usize),
) {
    // Rows that can still become the extreme, the best one first.
    let mut candidates: VecDeque<usize> = VecDeque::new();
    for (segment, rows) in on.each() {
        candidates.clear();
        let (mut start, mut unknown) = (0, 0usize);
        for i in 0..rows.len() {
            let x = values[segment.start + i];
            if x.is_nan() {
                unknown += 1;
            } else {
                while candidates.back().is_some_and(|&k| !better(values[segment.start + k], x)) {
                    candidates.pop_back();
                }
                candidates.push_back(i);
            }
            while start < i && !reaches(rows, i, start, d) {
                unknown -= usize::from(values[segment.start + start].is_nan());
                start += 1;
            }
            while candidates.front().is_some_and(|&k| k < start) {
                candidates.pop_front();
            }
            let complete = start > 0 || begins_inside(rows, i, d);
            if let (true, 0, Some(&best)) = (complete, unknown, candidates.front()) {
                put(segment.start + i, segment.start + best);
            }
        }
    }
}
