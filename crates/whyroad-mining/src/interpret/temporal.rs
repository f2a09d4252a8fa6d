//! Operators over time, each by its definition in `docs/reference/rules.md`. One principle decides every edge case:
//! *what was not recorded is unknown*. A drive that is cut off, a target that was not yet observed and a gap in
//! the log can turn an answer into unknown, never into its opposite.

mod chain;

pub use chain::{bridged, since, until};

use super::MARGIN_LIMIT;
use super::timeline::{Row, STEP};
use whyroad_model::{Nanos, Tri};

/// Frame clocks jitter by some ms (an AV2 frame lasts 100.196 ms on average, a simulator's exactly 100): a time in a
/// rule is met within this tolerance.
pub const CLOCK_TOLERANCE: Nanos = Nanos(10_000_000);

/// Truth and margin, one per row. The margin is NaN exactly where the truth is unknown, at least 0 where it is
/// true and at most 0 where it is false.
#[derive(Clone, Debug, PartialEq)]
pub struct Truths {
    /// Truth.
    pub value: Vec<Tri>,
    /// Margin.
    pub margin: Vec<f64>,
}

impl Truths {
    /// Nothing known.
    pub fn unknown(n: usize) -> Self {
        Self { value: vec![Tri::Unknown; n], margin: vec![f64::NAN; n] }
    }

    /// Truths without degree.
    pub fn of_flags(value: Vec<Tri>) -> Self {
        let margin = value
            .iter()
            .map(|t| match t {
                Tri::True => MARGIN_LIMIT,
                Tri::False => -MARGIN_LIMIT,
                Tri::Unknown => f64::NAN,
            })
            .collect();
        Self { value, margin }
    }

    /// Kleene negation.
    #[must_use]
    pub fn negated(mut self) -> Self {
        self.value.iter_mut().for_each(|t| *t = !*t);
        self.margin.iter_mut().for_each(|m| *m = -*m);
        self
    }

    /// Kleene conjunction: the least margin among those known.
    pub fn all(operands: &[Truths], n: usize) -> Self {
        let mut out = Self::of_flags(vec![Tri::True; n]);
        for i in 0..n {
            for t in operands {
                out.value[i] = out.value[i].and(t.value[i]);
                out.margin[i] = out.margin[i].min(t.margin[i]);
            }
        }
        out.settled()
    }

    /// The values of the row before; unknown in the first one.
    #[must_use]
    pub fn shifted(mut self) -> Self {
        if !self.value.is_empty() {
            self.value.pop();
            self.value.insert(0, Tri::Unknown);
            self.margin.pop();
            self.margin.insert(0, f64::NAN);
        }
        self
    }

    /// Margins adjusted to agree with the truth.
    fn settled(mut self) -> Self {
        for (t, m) in self.value.iter().zip(&mut self.margin) {
            *m = match t {
                Tri::Unknown => f64::NAN,
                // `max` and `min` drop a NaN: a margin that could not be computed is 0.
                Tri::True => m.max(0.0),
                Tri::False => m.min(0.0),
            };
        }
        self
    }
}

/// Longest run of rows around each row in which `admits` holds, as `start..end`.
fn runs(value: &[Tri], admits: impl Fn(Tri) -> bool) -> Vec<Option<(usize, usize)>> {
    let mut out = vec![None; value.len()];
    let mut i = 0;
    while i < value.len() {
        let start = i;
        while i < value.len() && admits(value[i]) {
            i += 1;
        }
        out[start..i].fill(Some((start, i)));
        i += usize::from(i == start);
    }
    out
}

/// Time from the start of the first row to the end of the last.
fn lasts(rows: &[Row], (start, end): (usize, usize)) -> Nanos {
    rows[end - 1].end - rows[start].time
}

/// `c for d`: the row belongs to an unbroken run of true that lasts at least `d`. A run that reaches the edge
/// of what is known, and is too short as far as it is known, may be longer: unknown.
pub fn held_for(c: &Truths, rows: &[Row], d: Nanos) -> Truths {
    let n = rows.len();
    let enough = |run: (usize, usize)| lasts(rows, run) + CLOCK_TOLERANCE >= d;
    let sure = runs(&c.value, |t| t == Tri::True);
    let possible = runs(&c.value, |t| t != Tri::False);
    let value = (0..n)
        .map(|i| match (sure[i], possible[i]) {
            (Some(run), _) if enough(run) => Tri::True,
            (_, Some(run)) if enough(run) || run.0 == 0 || run.1 == n => Tri::Unknown,
            _ => Tri::False,
        })
        .collect();
    // Margin: the best window of length d around the row, judged by its worst row.
    let mut margin = c.margin.clone();
    let mut best = vec![f64::NEG_INFINITY; n];
    for start in 0..n {
        let Some(end) = (start + 1..=n).find(|&e| enough((start, e))) else { break };
        let worst = c.margin[start..end].iter().copied().fold(f64::INFINITY, f64::min);
        best[start..end].iter_mut().for_each(|b| *b = b.max(worst));
    }
    for (m, b) in margin.iter_mut().zip(best) {
        *m = if b.is_finite() { b } else { m.min(0.0) };
    }
    Truths { value, margin }.settled()
}

/// `c within d`: true at this row or one that begins at most `d` later.
pub fn within(c: &Truths, rows: &[Row], d: Nanos) -> Truths {
    let horizon = |i: usize| rows[i].time + d + CLOCK_TOLERANCE;
    window_any(c, rows, |i| {
        let end = (i..rows.len()).find(|&j| rows[j].time > horizon(i));
        // The first frame that was not recorded would have begun where the last row ends, or a little before.
        let complete = end.is_some() || rows[rows.len() - 1].end - CLOCK_TOLERANCE > horizon(i);
        (i, end.unwrap_or(rows.len()), complete)
    })
}

/// `previously(c, d)`: true at an earlier row that begins at most `d` before this one; without `d`, at any
/// earlier row, which is never known to be false because every drive begins somewhere.
pub fn previously(c: &Truths, rows: &[Row], d: Option<Nanos>) -> Truths {
    window_any(c, rows, |i| {
        let Some(d) = d else { return (0, i, false) };
        let (start, complete) = past(rows, i, d);
        (start, i, complete)
    })
}

/// First row of the past window of length `d` at `i`, and whether the whole window was recorded.
fn past(rows: &[Row], i: usize, d: Nanos) -> (usize, bool) {
    let from = rows[i].time - d - CLOCK_TOLERANCE;
    // A gap that reaches into the window is part of it; a frame is where it begins.
    let inside = |j: usize| rows[j].time >= from || (rows[j].frame.is_none() && rows[j].end > from);
    let start = (0..=i).rev().take_while(|&j| inside(j)).last().unwrap_or(i);
    // The last frame that was not recorded would have begun one step before the first row, or a little after.
    (start, start > 0 || rows[0].time - STEP + CLOCK_TOLERANCE < from)
}

/// Kleene disjunction over one window per row; unknown rather than false where the window is not complete.
fn window_any(c: &Truths, rows: &[Row], window: impl Fn(usize) -> (usize, usize, bool)) -> Truths {
    let n = rows.len();
    let mut out = Truths::unknown(n);
    for i in 0..n {
        let (start, end, complete) = window(i);
        let edge = if complete && start < end { Tri::False } else { Tri::Unknown };
        out.value[i] = c.value[start..end].iter().fold(edge, |a, b| a.or(*b));
        out.margin[i] = c.margin[start..end].iter().copied().fold(f64::NEG_INFINITY, f64::max);
    }
    out.settled()
}

/// Extreme of the past window, now included; unknown when any part of it is.
pub fn past_extreme(v: &[f64], rows: &[Row], d: Nanos, pick: fn(f64, f64) -> f64) -> Vec<f64> {
    (0..rows.len())
        .map(|i| match past(rows, i, d) {
            (start, true) if v[start..=i].iter().all(|x| !x.is_nan()) => {
                v[start..=i].iter().copied().reduce(pick).unwrap_or(f64::NAN)
            }
            _ => f64::NAN,
        })
        .collect()
}

/// For each row the one that has the extreme of the past window, the latest of equals; `None` where it is unknown.
pub fn past_extreme_rows(v: &[f64], rows: &[Row], d: Nanos, pick: fn(f64, f64) -> f64) -> Vec<Option<usize>> {
    let extremes = past_extreme(v, rows, d, pick);
    (0..rows.len()).map(|i| (past(rows, i, d).0..=i).rev().find(|&j| v[j] == extremes[i])).collect()
}

/// Share of the past window, now included, in which the condition was true; unknown when any part of the
/// window is.
pub fn past_share(c: &Truths, rows: &[Row], d: Nanos) -> Vec<f64> {
    (0..rows.len())
        .map(|i| match past(rows, i, d) {
            (start, true) if !c.value[start..=i].contains(&Tri::Unknown) => {
                let held = (start..=i).filter(|&j| c.value[j] == Tri::True);
                let time: i64 = held.map(|j| (rows[j].end - rows[j].time).0).sum();
                time as f64 / lasts(rows, (start, i + 1)).0 as f64
            }
            _ => f64::NAN,
        })
        .collect()
}

#[cfg(test)]
mod tests;
