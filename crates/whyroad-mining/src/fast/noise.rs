//! Standard deviations of the numbers of a program (`crate::deviation` defines them) on the rows of a row set. Only
//! drives with noisy measurements have any; all others never use this module.

use super::evaluation::Evaluation;
use super::layout::RowSet;
use super::numbers::Numbers;
use super::signals::NodeValue;
use super::temporal::Stretches;
use super::threshold::Noise;
use super::windows;
use crate::deviation::{has_threshold, of_product};
use crate::language::program::{NodeId, Op, PairSide};
use crate::language::syntax::CompareOp;

impl<'a> Evaluation<'a> {
    /// Standard deviations of the difference of two sides of a comparison; `None` where both are exact or the operator
    /// has no threshold.
    pub(super) fn noise_of_difference(
        &self,
        op: CompareOp,
        left: NodeId,
        right: NodeId,
        row_set: RowSet,
    ) -> Option<Noise<'a>> {
        (self.signals.is_noisy() && has_threshold(op)).then(|| self.noise_of_sum(left, right, row_set))?
    }

    /// True where [`Self::noise_of_difference`] gives some.
    pub(super) fn is_noisy_difference(
        &self,
        op: CompareOp,
        left: NodeId,
        right: NodeId,
        row_set: RowSet,
    ) -> bool {
        let is_noisy = |id| self.is_noisy(id, row_set);
        self.signals.is_noisy() && has_threshold(op) && (is_noisy(left) || is_noisy(right))
    }

    /// True where [`Self::noise`] gives some.
    fn is_noisy(&self, id: NodeId, row_set: RowSet) -> bool {
        let node = self.plan.node(id);
        match (&node.op, &node.deviation) {
            (Op::PairSignal { .. }, Some(name)) => {
                self.signals.pairs.is_some_and(|p| p.columns.contains_key(name))
            }
            (_, Some(name)) => self.signals.has_numbers(name),
            (op, None) => self.is_noisy_result(op, id, row_set),
        }
    }

    fn is_noisy_result(&self, op: &Op, id: NodeId, row_set: RowSet) -> bool {
        match op {
            Op::Least(..) | Op::Greatest(..) | Op::AtKeyframe(_) => {
                let Some((own, home)) = self.home(id, row_set) else { return false };
                self.plan.node(own).op.operands().into_iter().any(|a| self.is_noisy(a, home))
            }
            Op::Negate(a) | Op::Absolute(a) => self.is_noisy(*a, row_set),
            Op::Add(a, b) | Op::Subtract(a, b) | Op::Multiply(a, b) => {
                self.is_noisy(*a, row_set) || self.is_noisy(*b, row_set)
            }
            _ => false,
        }
    }

    fn noise_of_sum(&self, a: NodeId, b: NodeId, row_set: RowSet) -> Option<Noise<'a>> {
        match (self.noise(a, row_set), self.noise(b, row_set)) {
            (Some(a), Some(b)) => Some(Noise::Sum(a.numbers(), b.numbers())),
            // Mostly the other side is exact: then the column is not copied.
            (one, other) => one.or(other),
        }
    }

    /// Standard deviations of a number on the rows of a row set, as they are stored: whoever reads them takes unknown
    /// ones for zero ([`crate::deviation::stated`]).
    fn noise(&self, id: NodeId, row_set: RowSet) -> Option<Noise<'a>> {
        let node = self.plan.node(id);
        match &node.op {
            Op::Signal(_) | Op::SecondSignal(_) => {
                self.noise_of_signal(id, node.deviation.as_deref()?, row_set).map(Noise::One)
            }
            Op::PairSignal { seen_from, .. } => {
                self.noise_of_pair(node.deviation.as_deref()?, *seen_from, row_set).map(Noise::One)
            }
            Op::Least(..) | Op::Greatest(..) | Op::AtKeyframe(_) => {
                self.noise_of_moment(id, row_set).map(Noise::One)
            }
            Op::Negate(a) | Op::Absolute(a) => self.noise(*a, row_set),
            Op::Add(a, b) | Op::Subtract(a, b) => self.noise_of_sum(*a, *b, row_set),
            Op::Multiply(a, b) => {
                let noise = |id| self.noise(id, row_set).map(Noise::numbers);
                let (of_a, of_b) = (noise(*a), noise(*b));
                of_a.as_ref().or(of_b.as_ref())?;
                let (x, y) = (self.numbers(*a, row_set), self.numbers(*b, row_set));
                let of = |sd: &Option<Numbers<'_>>, i: usize| sd.as_ref().map_or(0.0, |sd| sd.at(i));
                let product = |i| of_product((x.at(i), of(&of_a, i)), (y.at(i), of(&of_b, i)));
                Some(Noise::One(Numbers::of((0..x.len()).map(product).collect::<Vec<_>>())))
            }
            _ => None,
        }
    }

    fn noise_of_signal(&self, id: NodeId, name: &str, row_set: RowSet) -> Option<Numbers<'a>> {
        if !self.signals.holds(name) {
            return None;
        }
        let n = self.layout.len(row_set);
        let Some((_, home)) = self.home(id, row_set) else { return Some(Numbers::Same(f64::NAN, n)) };
        let is_repeated = home != row_set && matches!(row_set, RowSet::Objects | RowSet::Pairs);
        if is_repeated && let Some(known) = self.deviations.borrow().get(&(id, row_set)) {
            return Some(known.clone());
        }
        let at_home = self.signals.value(name, &self.layout, home)?;
        let there = self.moved_from_home(id, at_home, home, row_set)?;
        if is_repeated {
            self.deviations.borrow_mut().insert((id, row_set), there.clone());
        }
        Some(there)
    }

    /// Numbers of the rows where a node is at home, on those of a row set.
    fn moved_from_home(
        &self,
        id: NodeId,
        at_home: NodeValue<'a>,
        home: RowSet,
        row_set: RowSet,
    ) -> Option<Numbers<'a>> {
        let there = match (home == row_set, home, row_set) {
            (true, ..) => at_home,
            (false, RowSet::Drive, RowSet::Objects | RowSet::Pairs) => self.spread(at_home, row_set),
            (false, RowSet::Objects, RowSet::Pairs) => {
                self.spread_to_pairs(&at_home, self.plan.node(id).scope)
            }
            _ => {
                let (from, to) = (self.layout.segment(home), self.layout.segment(row_set));
                let start = to.row - from.row.min(to.row);
                at_home.slice(start..start + to.len)
            }
        };
        match there {
            NodeValue::Numbers(v) => Some(v),
            _ => None,
        }
    }

    fn noise_of_pair(&self, name: &str, side: PairSide, row_set: RowSet) -> Option<Numbers<'a>> {
        self.signals.pairs.filter(|p| p.columns.contains_key(name))?;
        let of_all = self.signals.of_pairs(name, side, &self.layout)?;
        let there = match row_set {
            RowSet::Pairs => Some(of_all),
            RowSet::Pair(a, b) => {
                let at = self.layout.pair(a, b);
                at.map(|i| of_all.slice(self.layout.segments(RowSet::Pairs)[i].range()))
            }
            _ => None,
        };
        match there {
            Some(NodeValue::Numbers(v)) => Some(v),
            _ => Some(Numbers::Same(f64::NAN, self.layout.len(row_set))),
        }
    }

    /// Standard deviations of a number taken from some row, such as an extreme.
    fn noise_of_moment(&self, id: NodeId, row_set: RowSet) -> Option<Numbers<'a>> {
        let (own, home) = self.home(id, row_set)?;
        let segments = self.layout.segments(home);
        let on = || Stretches { rows: &self.layout.rows, segments: &segments };
        let (of, rows) = match &self.plan.node(own).op {
            Op::Least(a, d) => {
                (*a, windows::past_extreme_rows(&self.numbers(*a, home), on(), *d, |x, y| x < y))
            }
            Op::Greatest(a, d) => {
                (*a, windows::past_extreme_rows(&self.numbers(*a, home), on(), *d, |x, y| x > y))
            }
            Op::AtKeyframe(a) => (*a, vec![self.keyframe_row(home); self.layout.len(home)]),
            _ => return None,
        };
        let noise = self.noise(of, home)?.numbers();
        let noise = noise.cut();
        let at_home: Vec<f64> = rows.into_iter().map(|r| r.map_or(f64::NAN, |r| noise[r])).collect();
        self.moved_from_home(id, NodeValue::Numbers(Numbers::of(at_home)), home, row_set)
    }
}
