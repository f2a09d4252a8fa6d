//! Operators that look along an unbroken stretch of truth: `since`, `until`, and the bridging of short breaks.
//! All are monotone in their operands, so the answer with every unknown taken as false and with every unknown
//! taken as true bound all others: where the two agree it is known.

use super::{CLOCK_TOLERANCE, Row, Truths};
use crate::interpret::MARGIN_LIMIT;
use whyroad_model::{Nanos, Tri};

/// Truth and margin of one row.
type Cell = (Tri, f64);

/// What lies outside the recording.
const OUTSIDE: Cell = (Tri::Unknown, f64::NAN);

/// `a since b`: b at this row or an earlier one, and a at every row after that one, this one included. Before
/// the first row nothing is known: while a has held since the beginning, b may have occurred before it.
pub fn since(a: &Truths, b: &Truths) -> Truths {
    along(a, b, 0..a.value.len())
}

/// `a until b`: b at this row or a later one, and a at every row before that one, this one included. While a
/// holds until the end of what was recorded, b may still come.
pub fn until(a: &Truths, b: &Truths) -> Truths {
    along(a, b, (0..a.value.len()).rev())
}

/// At each row: b, or a and the answer at the row that came before in `order`.
fn along(a: &Truths, b: &Truths, order: impl Iterator<Item = usize>) -> Truths {
    let mut out = Truths::unknown(a.value.len());
    let mut answer = OUTSIDE;
    for i in order {
        answer = or((b.value[i], b.margin[i]), and((a.value[i], a.margin[i]), answer));
        (out.value[i], out.margin[i]) = answer;
    }
    out
}

/// Kleene conjunction: the least margin among those known.
fn and(a: Cell, b: Cell) -> Cell {
    settled(a.0.and(b.0), a.1.min(b.1))
}

/// Kleene disjunction: the greatest margin among those known.
fn or(a: Cell, b: Cell) -> Cell {
    settled(a.0.or(b.0), a.1.max(b.1))
}

fn settled(truth: Tri, margin: f64) -> Cell {
    let margin = match truth {
        Tri::Unknown => f64::NAN,
        Tri::True => margin.max(0.0),
        Tri::False => margin.min(0.0),
    };
    (truth, margin)
}

/// `c` with its short breaks filled: true at a row, or at one before and one after it between which no more than
/// `d` passes. A break that reaches the edge of the recording may have ended just beyond it: unknown.
pub fn bridged(c: &Truths, rows: &[Row], d: Nanos) -> Truths {
    let n = rows.len();
    let mut out = Truths::unknown(n);
    for i in 0..n {
        let sure = fills(&c.value, rows, d, i, |t| t == Some(Tri::True));
        let possible = fills(&c.value, rows, d, i, |t| t != Some(Tri::False));
        let truth = match (sure, possible) {
            (true, _) => Tri::True,
            (false, true) => Tri::Unknown,
            (false, false) => Tri::False,
        };
        (out.value[i], out.margin[i]) = settled(truth, filled_margin(c, rows, d, i));
    }
    out
}

/// True when `admits` the row, or one on each side of it with at most `d` between them. `None` asks whether it
/// admits what lies outside the recording.
fn fills(value: &[Tri], rows: &[Row], d: Nanos, i: usize, admits: impl Fn(Option<Tri>) -> bool) -> bool {
    if admits(Some(value[i])) {
        return true;
    }
    let beyond = admits(None);
    let before = (0..i).rev().find(|&j| admits(Some(value[j]))).map(|j| rows[j].end);
    let after = (i + 1..rows.len()).find(|&k| admits(Some(value[k]))).map(|k| rows[k].time);
    let before = before.or(beyond.then(|| rows[0].time));
    let after = after.or(beyond.then(|| rows[rows.len() - 1].end));
    matches!((before, after), (Some(from), Some(to)) if to - from <= d + CLOCK_TOLERANCE)
}

/// The row's own margin or, if that is better, the lesser one of two rows that fill the break around it.
fn filled_margin(c: &Truths, rows: &[Row], d: Nanos, i: usize) -> f64 {
    let mut best = c.margin[i].max(-MARGIN_LIMIT);
    for j in (0..i).rev() {
        if rows[i].end - rows[j].end > d + CLOCK_TOLERANCE {
            break;
        }
        for k in (i + 1..rows.len()).take_while(|&k| rows[k].time - rows[j].end <= d + CLOCK_TOLERANCE) {
            best = best.max(and((c.value[j], c.margin[j]), (c.value[k], c.margin[k])).1);
        }
    }
    best
}

#[cfg(test)]
mod tests;
