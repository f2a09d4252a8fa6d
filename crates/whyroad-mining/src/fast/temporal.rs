//! The operators over time as operations on runs: the work is in the number of changes, not of rows times window.
//! `crate::interpret::temporal` defines what each means; a property test keeps the two equal.
//!
//! All are monotone, so each is computed twice with the same code: on the rows that are certainly true, and on those
//! that are possibly true (true or unknown), including the time outside the recording.

use super::bits::Bits;
use super::layout::Segment;
use super::truth::Truth;
use crate::interpret::{CLOCK_TOLERANCE, Row, STEP};
use std::ops::Range;
use whyroad_model::Nanos;

/// The rows of the drive, and the stretches of them that form a column.
#[derive(Clone, Copy)]
pub struct Stretches<'a> {
    /// Rows of the drive.
    pub rows: &'a [Row],
    /// Stretches in the order of the column.
    pub segments: &'a [Segment],
}

impl<'a> Stretches<'a> {
    /// Each stretch with its rows.
    pub fn each(self) -> impl Iterator<Item = (Segment, &'a [Row])> {
        let rows = self.rows;
        self.segments.iter().filter(|s| s.len > 0).map(move |s| (*s, &rows[s.row..s.row + s.len]))
    }
}

fn moved(range: Range<usize>, by: usize) -> Range<usize> {
    range.start + by..range.end + by
}

/// `c for d`.
pub fn held_for(c: &Truth, on: Stretches<'_>, d: Nanos) -> Truth {
    let possible = c.possible();
    let (mut sure_out, mut possible_out) = (Bits::zeros(c.len()), Bits::zeros(c.len()));
    for (segment, rows) in on.each() {
        let enough = |run: &Range<usize>| {
            let (from, to) = (run.start - segment.start, run.end - segment.start);
            rows[to - 1].end - rows[from].time + CLOCK_TOLERANCE >= d
        };
        for run in c.yes.runs(segment.range()).filter(enough) {
            sure_out.set_range(run);
        }
        let range = segment.range();
        let open = |run: &Range<usize>| run.start == range.start || run.end == range.end || enough(run);
        for run in possible.runs(segment.range()).filter(open) {
            possible_out.set_range(run);
        }
    }
    Truth::bounded(sure_out, &possible_out)
}

/// `c within d`.
pub fn within(c: &Truth, on: Stretches<'_>, d: Nanos) -> Truth {
    let possible = c.possible();
    let (mut sure_out, mut possible_out) = (Bits::zeros(c.len()), Bits::zeros(c.len()));
    for (segment, rows) in on.each() {
        let horizon = |row: &Row| row.time + d + CLOCK_TOLERANCE;
        for (from, into) in [(&*c.yes, &mut sure_out), (&possible, &mut possible_out)] {
            let mut reach = 0;
            for run in from.runs(segment.range()) {
                let first = rows[run.start - segment.start].time;
                // The first row whose window reaches the run.
                let guess = (run.start - segment.start).saturating_sub((d.0 / STEP.0) as usize);
                reach = first_in_near(reach, rows.len(), guess, |i| horizon(&rows[i]) >= first);
                into.set_range(segment.start + reach..run.end);
            }
        }
        // From here on the window looks beyond the recording.
        let last = rows[rows.len() - 1];
        let known_until = last.time.max(last.end - CLOCK_TOLERANCE);
        let open = rows.partition_point(|r| horizon(r) < known_until);
        possible_out.set_range(moved(open..rows.len(), segment.start));
    }
    Truth::bounded(sure_out, &possible_out)
}

/// True when the past window of length `d` at row `i` reaches back to row `j`.
pub fn reaches(rows: &[Row], i: usize, j: usize, d: Nanos) -> bool {
    let from = rows[i].time - d - CLOCK_TOLERANCE;
    rows[j].time >= from || (rows[j].frame.is_none() && rows[j].end > from)
}

/// True when what a past window of length `d` at row `i` would find before the first row is nothing.
pub fn begins_inside(rows: &[Row], i: usize, d: Nanos) -> bool {
    rows[0].time - STEP + CLOCK_TOLERANCE < rows[i].time - d - CLOCK_TOLERANCE
}

/// `previously(c, d)`.
pub fn previously(c: &Truth, on: Stretches<'_>, d: Nanos) -> Truth {
    let possible = c.possible();
    let (mut sure_out, mut possible_out) = (Bits::zeros(c.len()), Bits::zeros(c.len()));
    let is_steady = |rows: &[Row]| (1..rows.len()).all(|i| reaches(rows, i, i - 1, d));
    let all_are_steady = is_steady(on.rows);
    for (segment, rows) in on.each() {
        let n = rows.len();
        let outs = [(&*c.yes, &mut sure_out), (&possible, &mut possible_out)];
        if all_are_steady || is_steady(rows) {
            for (from, into) in outs {
                let mut reach = 0;
                for run in from.runs(segment.range()) {
                    let (first, last) = (run.start - segment.start, run.end - 1 - segment.start);
                    reach = reach.max(last + 1).min(n);
                    // One past the last row whose past window reaches the run.
                    let guess = last + 1 + (d.0 / STEP.0) as usize;
                    reach = first_in_near(reach, n, guess, |i| !reaches(rows, i, last, d));
                    into.set_range(moved(first + 1..reach, segment.start));
                }
            }
        } else {
            // A window so short that not even the row before is always in it.
            for (from, into) in outs {
                let mut start = 0;
                for i in 0..n {
                    while start < i && !reaches(rows, i, start, d) {
                        start += 1;
                    }
                    if from.any_in(moved(start..i, segment.start)) {
                        into.set_range(moved(i..i + 1, segment.start));
                    }
                }
            }
            for i in (1..n).filter(|&i| !reaches(rows, i, i - 1, d)) {
                possible_out.set_range(moved(i..i + 1, segment.start));
            }
        }
        // Up to here the window looks beyond the recording; in the first row it is empty.
        let open = first_in(1, n, |i| !reaches(rows, i, 0, d) || begins_inside(rows, i, d));
        possible_out.set_range(moved(0..(1 + open).min(n), segment.start));
    }
    Truth::bounded(sure_out, &possible_out)
}

/// The first index from `from` on that fulfills a condition that, once fulfilled, stays so; `to` where none does. With
/// a constant clock rate, the guess is right.
fn first_in_near(from: usize, to: usize, guess: usize, fulfilled: impl Fn(usize) -> bool) -> usize {
    let right = from < guess && guess < to && fulfilled(guess) && !fulfilled(guess - 1);
    if right { guess } else { from + first_in(from, to, fulfilled) }
}

/// How many indices from `from` on do not fulfill a condition that, once fulfilled, stays so. Looks near first.
fn first_in(from: usize, to: usize, fulfilled: impl Fn(usize) -> bool) -> usize {
    let n = to.saturating_sub(from);
    let mut step = 1;
    while step < n && !fulfilled(from + step - 1) {
        step *= 2;
    }
    let (mut low, mut high) = (step / 2, step.min(n));
    while low < high {
        let middle = low + (high - low) / 2;
        if fulfilled(from + middle) { high = middle } else { low = middle + 1 }
    }
    low
}

/// `previously(c)`: never known to be false.
pub fn ever_before(c: &Truth, on: Stretches<'_>) -> Truth {
    let mut yes = Bits::zeros(c.len());
    for (segment, _) in on.each() {
        if let Some(run) = c.yes.runs(segment.range()).next() {
            yes.set_range(run.start + 1..segment.range().end);
        }
    }
    let yes = std::rc::Rc::new(yes);
    Truth { yes: yes.clone(), known: yes }
}

/// The row before; unknown in the first one.
pub fn before(c: &Truth, on: Stretches<'_>) -> Truth {
    let (mut yes, mut known) = (c.yes.later(), c.known.later());
    for (segment, _) in on.each() {
        for plane in [&mut yes, &mut known] {
            plane.clear_range(segment.start..segment.start + 1);
        }
    }
    Truth::new(yes, known)
}

/// `a since b`: from a row with b as long as a goes on. Before the first row every value is possible.
pub fn since(a: &Truth, b: &Truth, on: Stretches<'_>) -> Truth {
    let along = |a: &Bits, b: &Bits, outside: bool| {
        let mut out = b.clone();
        for (segment, _) in on.each() {
            for run in a.runs(segment.range()) {
                let begins = run.start == segment.start;
                let carried = if begins { outside } else { b.get(run.start - 1) };
                let from = if carried { Some(run.start) } else { b.positions(run.clone()).next() };
                if let Some(from) = from {
                    out.set_range(from..run.end);
                }
            }
        }
        out
    };
    Truth::bounded(along(&a.yes, &b.yes, false), &along(&a.possible(), &b.possible(), true))
}

/// `a until b`: as [`since`], in the other direction of time.
pub fn until(a: &Truth, b: &Truth, on: Stretches<'_>) -> Truth {
    let along = |a: &Bits, b: &Bits, outside: bool| {
        let mut out = b.clone();
        for (segment, _) in on.each() {
            for run in a.runs(segment.range()) {
                let ends = run.end == segment.range().end;
                let carried = if ends { outside } else { b.get(run.end) };
                let to = if carried { Some(run.end) } else { b.last_in(run.clone()).map(|j| j + 1) };
                if let Some(to) = to {
                    out.set_range(run.start..to);
                }
            }
        }
        out
    };
    Truth::bounded(along(&a.yes, &b.yes, false), &along(&a.possible(), &b.possible(), true))
}

/// Short breaks filled. One that reaches the edge of the recording may have ended just beyond it.
pub fn bridged(c: &Truth, on: Stretches<'_>, d: Nanos) -> Truth {
    let filled = |c: &Bits, outside: bool| {
        let (mut out, breaks) = (c.clone(), c.inverted());
        for (segment, rows) in on.each() {
            for run in breaks.runs(segment.range()) {
                let (first, end) = (run.start - segment.start, run.end - segment.start);
                let before =
                    if first > 0 { Some(rows[first - 1].end) } else { outside.then(|| rows[0].time) };
                let beyond = outside.then(|| rows[rows.len() - 1].end);
                let after = rows.get(end).map(|r| r.time).or(beyond);
                if matches!((before, after), (Some(from), Some(to)) if to - from <= d + CLOCK_TOLERANCE) {
                    out.set_range(run);
                }
            }
        }
        out
    };
    Truth::bounded(filled(&c.yes, false), &filled(&c.possible(), true))
}
