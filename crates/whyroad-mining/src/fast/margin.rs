//! Margins, only where they are needed: on the rows of an episode, and on those around them that an operator over time
//! uses. The definitions are those of `crate::interpret`; what differs is which rows are computed, and that a moving
//! window keeps its extreme instead of searching for it.

use super::evaluation::Evaluation;
use super::layout::RowSet;
use super::signals::NodeValue;
use super::temporal::reaches;
use super::truth::Truth;
use crate::interpret::{CLOCK_TOLERANCE, MARGIN_LIMIT, Row};
use crate::language::program::{NodeId, Op, Subject, ValueScope};
use std::ops::Range;
use std::rc::Rc;
use whyroad_model::{Nanos, Tri};

mod rows;

pub(super) use rows::Deciding;
use rows::{best_of_even, compared, greatest_ahead, settle, settled, sliding};

impl Evaluation<'_> {
    /// Margins of a condition on these rows of a row set that is not all objects; NaN where it is unknown.
    pub fn margins(&self, id: NodeId, row_set: RowSet, rows: Range<usize>) -> Vec<f64> {
        let Some((own, home)) = self.home(id, row_set) else { return vec![f64::NAN; rows.len()] };
        if home != row_set {
            let by = self.layout.segment(row_set).row - self.layout.segment(home).row;
            return self.margins(own, home, rows.start + by..rows.end + by);
        }
        let op = &self.plan.node(id).op;
        match op {
            Op::Not(a) => return self.margins(*a, row_set, rows).into_iter().map(|m| -m).collect(),
            Op::Compare { op, left, right, scale } => {
                let (a, b) = (self.numbers(*left, row_set), self.numbers(*right, row_set));
                let mut out = compared(*op, &a, &b, *scale, rows.clone());
                if self.is_noisy_difference(*op, *left, *right, row_set)
                    && let Some((truth, by)) = self.seen(id, row_set)
                {
                    settle(&mut out, &truth, by + rows.start);
                }
                return out;
            }
            Op::Before(a) => {
                let first = rows.start.saturating_sub(1)..rows.end.saturating_sub(1);
                let unknown = usize::from(rows.start == 0 && !rows.is_empty());
                return [vec![f64::NAN; unknown], self.margins(*a, row_set, first)].concat();
            }
            Op::AtKeyframe(a) => {
                let at = self.keyframe_row(row_set).map(|k| self.margins(*a, row_set, k..k + 1)[0]);
                return vec![at.unwrap_or(f64::NAN); rows.len()];
            }
            Op::Previously(a, None) => return self.ever_before(id, *a, row_set)[rows].to_vec(),
            Op::AtLeast { .. } | Op::Since(..) | Op::Until(..) if !self.plan.node(id).needs_episode => {
                return self.in_blocks(id, row_set, rows);
            }
            _ => {}
        }
        self.computed_margins(id, row_set, rows)
    }

    fn computed_margins(&self, id: NodeId, row_set: RowSet, rows: Range<usize>) -> Vec<f64> {
        match &self.plan.node(id).op {
            Op::Since(a, b) => self.of_since(id, (*a, *b), row_set, rows),
            Op::Until(a, b) => self.of_until(id, (*a, *b), row_set, rows),
            _ => self.settled_margins(id, row_set, rows),
        }
    }

    /// Margins that agree with the truth, from those of the operands.
    fn settled_margins(&self, id: NodeId, row_set: RowSet, rows: Range<usize>) -> Vec<f64> {
        let Some((truth, by)) = self.seen(id, row_set) else { return vec![f64::NAN; rows.len()] };
        let op = &self.plan.node(id).op;
        let mut out = self.raw_margins(op, row_set, rows.clone(), &|i| truth.at(by + i));
        settle(&mut out, &truth, by + rows.start);
        out
    }

    /// [`Self::computed_margins`], block by block, each of which is kept: counts ask all objects, `since` and `until`
    /// ask rows far away, and episodes and operators over time ask for the same rows again and again.
    fn in_blocks(&self, id: NodeId, row_set: RowSet, rows: Range<usize>) -> Vec<f64> {
        let n = self.layout.len(row_set);
        let mut out = Vec::with_capacity(rows.len());
        let size = match &self.plan.node(id).op {
            Op::AtLeast { .. } => COUNT_ROWS,
            _ => CHAIN_ROWS,
        };
        for block in rows.start / size..rows.end.div_ceil(size) {
            let all = block * size..((block + 1) * size).min(n);
            let known = self.block_margins.borrow().get(&(id, (row_set, block))).cloned();
            let of_all = known.unwrap_or_else(|| {
                let of_all = Rc::new(self.computed_margins(id, row_set, all.clone()));
                self.block_margins.borrow_mut().insert((id, (row_set, block)), of_all.clone());
                of_all
            });
            let wanted = rows.start.max(all.start)..rows.end.min(all.end);
            out.extend_from_slice(&of_all[wanted.start - all.start..wanted.end - all.start]);
        }
        out
    }

    /// The truth of a condition, and with which row of it the row set begins: that of all objects is not cut, where it
    /// is at hand. `None` where the node is not a condition.
    fn seen(&self, id: NodeId, row_set: RowSet) -> Option<(Truth, usize)> {
        if let (RowSet::Object(i), false) = (row_set, self.plan.node(id).needs_episode)
            && let Some(NodeValue::Truth(of_all)) = self.of_all_objects(id)
        {
            return Some((of_all, self.layout.objects[i].start));
        }
        match self.value(id, row_set) {
            NodeValue::Truth(truth) => Some((truth, 0)),
            _ => None,
        }
    }

    /// The least or greatest of these conditions' margins.
    fn of_each(
        &self,
        all: &[NodeId],
        row_set: RowSet,
        rows: &Range<usize>,
        start: f64,
        pick: impl Fn(f64, f64) -> f64,
    ) -> Vec<f64> {
        let mut out = vec![start; rows.len()];
        for id in all {
            let of = self.margins(*id, row_set, rows.clone());
            out.iter_mut().zip(of).for_each(|(o, m)| *o = pick(*o, m));
        }
        out
    }

    /// Before they are adjusted to agree with the truth.
    fn raw_margins(
        &self,
        op: &Op,
        row_set: RowSet,
        rows: Range<usize>,
        truth: &dyn Fn(usize) -> Tri,
    ) -> Vec<f64> {
        let n = rows.len();
        match op {
            Op::And(all) => self.of_each(all, row_set, &rows, MARGIN_LIMIT, f64::min),
            Op::Or(all) => self.of_each(all, row_set, &rows, -MARGIN_LIMIT, f64::max),
            Op::For(a, d) => self.of_for(*a, row_set, rows, *d),
            Op::Within(a, d) => {
                let on = self.rows_of(row_set);
                let horizon = |i: usize| on[i].time + *d + CLOCK_TOLERANCE;
                // Windows only ever move forward, and so does where they end.
                let mut end = rows.start;
                let ends: Vec<usize> = rows
                    .clone()
                    .map(|i| {
                        while end < on.len() && on[end].time <= horizon(i) {
                            end += 1;
                        }
                        end - rows.start
                    })
                    .collect();
                let to = ends.last().map_or(rows.end, |end| rows.start + end);
                greatest_ahead(&self.margins(*a, row_set, rows.start..to), &ends)
            }
            Op::Previously(a, Some(d)) => {
                let on = self.rows_of(row_set);
                let start =
                    |i: usize| (0..i).rev().take_while(|&j| reaches(on, i, j, *d)).last().unwrap_or(i);
                let from = if rows.is_empty() { rows.start } else { start(rows.start) };
                let of = self.margins(*a, row_set, from..rows.end);
                let mut begin = from;
                let windows = rows.map(|i| {
                    while begin < i && !reaches(on, i, begin, *d) {
                        begin += 1;
                    }
                    (begin - from, i - from)
                });
                sliding(&of, windows, f64::NEG_INFINITY, |x, y| x > y)
            }
            Op::Bridge(a, d) => self.of_bridge(*a, row_set, rows, *d),
            Op::AtLeast { of, count, subject } => self.of_count(*of, *count, *subject, rows),
            Op::AtLeastNear { of, count, subject } => {
                self.of_near_count(*of, (*count, *subject), row_set, rows)
            }
            Op::InMatch(a) => {
                let of = self.match_rows(row_set).map(|m| self.margins(*a, row_set, m)).unwrap_or_default();
                vec![of.into_iter().fold(f64::NEG_INFINITY, f64::max); n]
            }
            // Flags and categories are true or false without degree.
            _ => rows.map(|i| if truth(i) == Tri::True { MARGIN_LIMIT } else { -MARGIN_LIMIT }).collect(),
        }
    }

    fn rows_of(&self, row_set: RowSet) -> &[Row] {
        let segment = self.layout.segment(row_set);
        &self.layout.rows[segment.row..segment.row + segment.len]
    }

    /// The best window of length `d` around the row, judged by its worst row.
    fn of_for(&self, a: NodeId, row_set: RowSet, rows: Range<usize>, d: Nanos) -> Vec<f64> {
        let on = self.rows_of(row_set);
        let enough = |from: usize, to: usize| on[to - 1].end - on[from].time + CLOCK_TOLERANCE >= d;
        if rows.is_empty() {
            return Vec::new();
        }
        let first =
            (0..rows.start).rev().take_while(|&s| !enough(s, rows.start)).last().unwrap_or(rows.start);
        // Windows by where they begin; from some row on, the rest is too short for one.
        let mut ends = Vec::with_capacity(rows.end - first);
        let mut end = first;
        for start in first..rows.end {
            end = end.max(start + 1);
            while end < on.len() && !enough(start, end) {
                end += 1;
            }
            if !enough(start, end) {
                break;
            }
            ends.push(end);
        }
        let reach = first..ends.last().copied().unwrap_or(rows.end).max(rows.end);
        let of = self.margins(a, row_set, reach);
        let width = ends.first().map_or(0, |end| end - first);
        let best = if width > 0 && ends.iter().enumerate().all(|(k, end)| end - first - k == width) {
            best_of_even(&of, width, ends.len(), rows.start - first..rows.end - first)
        } else {
            let windows = ends.iter().enumerate().map(|(k, end)| (k, end - first));
            let worst = sliding(&of, windows, f64::INFINITY, |x, y| x < y);
            let mut begin = 0;
            let around = rows.clone().map(|i| {
                while begin < ends.len() && ends[begin] <= i {
                    begin += 1;
                }
                (begin, (i + 1 - first).min(ends.len()).max(begin))
            });
            sliding(&worst, around.collect::<Vec<_>>().into_iter(), f64::NEG_INFINITY, |x, y| x > y)
        };
        let own = |i: usize| of[i - first].min(0.0);
        rows.zip(best).map(|(i, b)| if b.is_finite() { b } else { own(i) }).collect()
    }

    /// The row's own margin or, if that is better, the lesser one of two rows that fill the break around it.
    fn of_bridge(&self, a: NodeId, row_set: RowSet, rows: Range<usize>, d: Nanos) -> Vec<f64> {
        let on = self.rows_of(row_set);
        let close = |from: Nanos, to: Nanos| to - from <= d + CLOCK_TOLERANCE;
        let (Some(lowest), Some(highest)) = (rows.clone().next(), rows.clone().last()) else {
            return Vec::new();
        };
        let before = |i: usize| (0..i).rev().take_while(move |&j| close(on[j].end, on[i].end));
        let first = before(lowest).last().unwrap_or(lowest);
        let after = (highest + 1..on.len()).take_while(|&k| close(on[highest].time, on[k].time));
        let reach = first..after.last().unwrap_or(highest) + 1;
        let (of, truth) = (self.margins(a, row_set, reach.clone()), self.truth(a, row_set));
        let cell = |i: usize| (truth.at(i), of[i - reach.start]);
        let each = rows.map(|i| {
            let mut best = cell(i).1.max(-MARGIN_LIMIT);
            for j in before(i) {
                for k in (i + 1..reach.end).take_while(|&k| close(on[j].end, on[k].time)) {
                    let (x, y) = (cell(j), cell(k));
                    best = best.max(settled(x.0.and(y.0), x.1.min(y.1)));
                }
            }
            best
        });
        each.collect()
    }

    /// The margin of the object that is needed last to reach the number.
    fn of_count(&self, of: NodeId, count: usize, subject: Subject, rows: Range<usize>) -> Vec<f64> {
        let mut deciding = Deciding::new(count, rows.len());
        let deciding_alone = self.flags_that_decide(of);
        for (i, object) in self.layout.objects.iter().enumerate() {
            let (from, to) = (rows.start.max(object.row), rows.end.min(object.row + object.len));
            if from < to && subject.admits(self.signals.targets[i].class) {
                let own = object.start + from - object.row..object.start + to - object.row;
                if deciding_alone.iter().any(|flag| is_nowhere(flag, own.clone())) {
                    (from..to).for_each(|k| deciding.add(k - rows.start, -MARGIN_LIMIT));
                    continue;
                }
                let of = self.margins(of, RowSet::Object(i), from - object.row..to - object.row);
                deciding.add_all(from - rows.start, &of);
            }
        }
        deciding.finish()
    }

    /// The parts of a condition on objects that are true or false without degree, for all objects: where one of them is
    /// false, so is the condition, with the least margin that there is. None where some part could have a lesser one.
    fn flags_that_decide(&self, of: NodeId) -> Vec<Truth> {
        let all = self.plan.conjuncts(of);
        let could_be_less = |id: &NodeId| {
            self.plan.any_below(*id, &|op| {
                matches!(op, Op::Previously(..) | Op::Since(..) | Op::Until(..) | Op::InMatch(_))
            })
        };
        if self.plan.node(of).needs_episode || all.iter().any(could_be_less) {
            return Vec::new();
        }
        let is_flag = |id: &&NodeId| {
            let node = self.plan.node(**id);
            matches!(node.op, Op::Signal(_) | Op::Member(..)) && node.scope == ValueScope::Target
        };
        all.iter().filter(is_flag).map(|id| self.truth(*id, RowSet::Objects)).collect()
    }

    /// The best margin of all rows before: for all rows at once, and kept.
    fn ever_before(&self, id: NodeId, a: NodeId, row_set: RowSet) -> Rc<Vec<f64>> {
        if let Some(done) = self.margins.borrow().get(&(id, row_set)) {
            return done.clone();
        }
        let n = self.layout.len(row_set);
        let truth = self.truth(id, row_set);
        let mut best = f64::NEG_INFINITY;
        let mut out = Vec::with_capacity(n);
        for (i, m) in self.margins(a, row_set, 0..n).into_iter().enumerate() {
            out.push(settled(truth.at(i), best));
            best = best.max(m);
        }
        let out = Rc::new(out);
        self.margins.borrow_mut().insert((id, row_set), out.clone());
        out
    }

    /// Looks back, ever farther, until earlier rows no longer matter, which is nearly always soon.
    fn of_since(&self, id: NodeId, of: (NodeId, NodeId), row_set: RowSet, rows: Range<usize>) -> Vec<f64> {
        let (truth, by) = self.seen(id, row_set).unwrap_or_else(|| (Truth::unknown(rows.end), 0));
        let (mut parts, mut from, mut stride) =
            (vec![self.cells(of, row_set, rows.clone())], rows.start, STRIDE);
        loop {
            let before = from.checked_sub(1).map_or(Tri::Unknown, |i| truth.at(by + i));
            let cells = || parts.iter().rev().flatten();
            if let Some(mut out) = settles(before, rows.start - from, cells) {
                return out.split_off(rows.start - from);
            }
            let begin = from.saturating_sub(stride);
            parts.push(self.cells(of, row_set, begin..from));
            (from, stride) = (begin, 2 * stride);
        }
    }

    /// As [`Self::of_since`], in the other direction of time.
    fn of_until(&self, id: NodeId, of: (NodeId, NodeId), row_set: RowSet, rows: Range<usize>) -> Vec<f64> {
        let n = self.layout.len(row_set);
        let (truth, by) = self.seen(id, row_set).unwrap_or_else(|| (Truth::unknown(n), 0));
        let (mut parts, mut to, mut stride) = (vec![self.cells(of, row_set, rows.clone())], rows.end, STRIDE);
        loop {
            let after = if to < n { truth.at(by + to) } else { Tri::Unknown };
            let cells = || parts.iter().rev().flat_map(|p| p.iter().rev());
            if let Some(mut out) = settles(after, to - rows.end, cells) {
                out.reverse();
                out.truncate(rows.len());
                return out;
            }
            let end = (to + stride).min(n);
            parts.push(self.cells(of, row_set, to..end));
            (to, stride) = (end, 2 * stride);
        }
    }

    fn cells(&self, (a, b): (NodeId, NodeId), row_set: RowSet, rows: Range<usize>) -> Vec<Cell> {
        let (of_a, of_b) = (self.margins(a, row_set, rows.clone()), self.margins(b, row_set, rows.clone()));
        let cut = |id| self.seen(id, row_set).unwrap_or_else(|| (Truth::unknown(rows.end), 0));
        let ((a, from_a), (b, from_b)) = (cut(a), cut(b));
        let cell = |(i, (m, n))| Cell { a: (a.at(from_a + i), m), b: (b.at(from_b + i), n) };
        rows.clone().zip(of_a.into_iter().zip(of_b)).map(cell).collect()
    }
}

/// True where a condition is known to be false in all of these rows.
fn is_nowhere(of: &Truth, rows: Range<usize>) -> bool {
    !of.yes.any_in(rows.clone()) && of.known.count_in(rows.clone()) == rows.len()
}

/// Rows of which margins of a count are kept together.
const COUNT_ROWS: usize = 256;
/// The same of `since` and `until`.
const CHAIN_ROWS: usize = 64;

/// How far `since` and `until` first look ahead for a row that decides them.
const STRIDE: usize = 32;

/// The operands of `since` or `until` in one row.
struct Cell {
    a: (Tri, f64),
    b: (Tri, f64),
}

/// The margins along these cells where the `wanted`th does not depend on the rows before the first, of which the truth
/// is `before`: a margin is a growing function of the one before it, so it is the same for all if it is the same for
/// the least and the greatest that there could have been. An unknown one has no margin at all.
fn settles<'c, C: Iterator<Item = &'c Cell>>(
    before: Tri,
    wanted: usize,
    cells: impl Fn() -> C,
) -> Option<Vec<f64>> {
    let (least, greatest) = match before {
        Tri::Unknown => return Some(along((before, f64::NAN), cells()).collect()),
        Tri::True => (0.0, f64::INFINITY),
        Tri::False => (f64::NEG_INFINITY, 0.0),
    };
    let low: Vec<f64> = along((before, least), cells()).collect();
    let high = along((before, greatest), cells()).nth(wanted);
    // No row is wanted, or the same margin (bit for bit: an unknown one is NaN both times).
    let same = low.get(wanted).map(|m| m.to_bits()) == high.map(f64::to_bits);
    same.then_some(low)
}

/// At each row: b, or a and the answer at the row that came before.
fn along<'c>(mut answer: (Tri, f64), cells: impl Iterator<Item = &'c Cell>) -> impl Iterator<Item = f64> {
    cells.map(move |Cell { a, b }| {
        let truth = a.0.and(answer.0);
        let carried = settled(truth, a.1.min(answer.1));
        let truth = b.0.or(truth);
        answer = (truth, settled(truth, b.1.max(carried)));
        answer.1
    })
}
