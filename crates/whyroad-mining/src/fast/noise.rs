//! Standard deviations of the numbers of a program (`crate::deviation` defines them) on the rows of a row set. Only
//! drives with noisy measurements have any; all others never come here.

use super::evaluation::Evaluation;
use super::layout::RowSet;
use super::signals::NodeValue;
use crate::deviation::{has_threshold, of_product, of_sum};
use crate::language::program::{NodeId, Op};
use crate::language::syntax::CompareOp;
use whyroad_model::signal::deviation_name;

impl Evaluation<'_> {
    /// Standard deviations of the difference of two sides of a comparison; `None` where both are exact or the operator
    /// has no threshold.
    pub(super) fn noise_of_difference(
        &self,
        op: CompareOp,
        left: NodeId,
        right: NodeId,
        row_set: RowSet,
    ) -> Option<Vec<f64>> {
        (self.signals.is_noisy() && has_threshold(op)).then(|| self.noise_of_sum(left, right, row_set))?
    }

    fn noise_of_sum(&self, a: NodeId, b: NodeId, row_set: RowSet) -> Option<Vec<f64>> {
        let (a, b) = (self.noise(a, row_set), self.noise(b, row_set));
        match (a, b) {
            (None, None) => None,
            (Some(one), None) | (None, Some(one)) => Some(one.into_iter().map(|d| of_sum(d, 0.0)).collect()),
            (Some(a), Some(b)) => Some(a.into_iter().zip(b).map(|(a, b)| of_sum(a, b)).collect()),
        }
    }

    /// Standard deviations of a number on the rows of a row set.
    fn noise(&self, id: NodeId, row_set: RowSet) -> Option<Vec<f64>> {
        match &self.plan.node(id).op {
            Op::Signal(name) | Op::SecondSignal(name) => {
                self.noise_of_signal(id, &deviation_name(name), row_set)
            }
            Op::Negate(a) | Op::Absolute(a) => self.noise(*a, row_set),
            Op::Add(a, b) | Op::Subtract(a, b) => self.noise_of_sum(*a, *b, row_set),
            Op::Multiply(a, b) => {
                let (of_a, of_b) = (self.noise(*a, row_set), self.noise(*b, row_set));
                of_a.as_ref().or(of_b.as_ref())?;
                let (x, y) = (self.numbers(*a, row_set), self.numbers(*b, row_set));
                let of = |sd: &Option<Vec<f64>>, i: usize| sd.as_ref().map_or(0.0, |sd| sd[i]);
                let product = |i| of_product((x.at(i), of(&of_a, i)), (y.at(i), of(&of_b, i)));
                Some((0..x.len()).map(product).collect())
            }
            _ => None,
        }
    }

    fn noise_of_signal(&self, id: NodeId, name: &str, row_set: RowSet) -> Option<Vec<f64>> {
        if !self.signals.holds(name) {
            return None;
        }
        let n = self.layout.len(row_set);
        let Some((_, home)) = self.home(id, row_set) else { return Some(vec![f64::NAN; n]) };
        let at_home = self.signals.value(name, &self.layout, home)?;
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
            NodeValue::Numbers(v) => Some(v.cut().into_owned()),
            _ => None,
        }
    }
}
