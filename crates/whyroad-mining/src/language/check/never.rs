//! Conditions that are never true together: bounds of one number that leave no value, names of one category that
//! exclude each other, a condition and its negation. A rule with them would be searched and never found.

use super::super::Fault;
use super::super::program::{NodeId, Op};
use super::super::syntax::{CompareOp, Span};
use super::Checker;
use std::collections::{BTreeMap, BTreeSet};

/// Values of a number that are left.
#[derive(Clone, Copy)]
struct Left {
    low: f64,
    high: f64,
    with_low: bool,
    with_high: bool,
}

impl Left {
    const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY, with_low: true, with_high: true };

    fn is_empty(self) -> bool {
        self.low > self.high || (self.low == self.high && !(self.with_low && self.with_high))
    }

    fn at_least(&mut self, value: f64, with: bool) {
        if value > self.low || (value == self.low && !with) {
            (self.low, self.with_low) = (value, with);
        }
    }

    fn at_most(&mut self, value: f64, with: bool) {
        if value < self.high || (value == self.high && !with) {
            (self.high, self.with_high) = (value, with);
        }
    }

    fn restrict(&mut self, op: CompareOp, value: f64) {
        match op {
            CompareOp::Less => self.at_most(value, false),
            CompareOp::LessOrEqual => self.at_most(value, true),
            CompareOp::Greater => self.at_least(value, false),
            CompareOp::GreaterOrEqual => self.at_least(value, true),
            CompareOp::Equal => {
                self.at_least(value, true);
                self.at_most(value, true);
            }
            CompareOp::NotEqual => {}
        }
    }
}

impl Checker<'_> {
    /// A fault at `span` where these conditions, joined by `and`, are never true.
    pub(crate) fn possible_together(&self, all: &[NodeId], span: Span) -> Result<(), Fault> {
        let mut parts = BTreeSet::new();
        for id in all {
            self.joined(*id, &mut parts);
        }
        let mut numbers: BTreeMap<NodeId, Left> = BTreeMap::new();
        let mut names: BTreeMap<NodeId, BTreeSet<&String>> = BTreeMap::new();
        for id in &parts {
            let never = match &self.program.node(*id).op {
                Op::Compare { op, left, right, .. } => {
                    let bound = match (self.fixed(*left), self.fixed(*right)) {
                        (None, Some(value)) => Some((*left, *op, value)),
                        (Some(value), None) => Some((*right, op.mirrored(), value)),
                        _ => None,
                    };
                    bound.is_some_and(|(of, op, value)| {
                        let left = numbers.entry(of).or_insert(Left::ALL);
                        left.restrict(op, value);
                        left.is_empty()
                    })
                }
                Op::Member(of, words) => {
                    let left = names.entry(*of).or_insert_with(|| words.iter().collect());
                    left.retain(|word| words.contains(word));
                    left.is_empty()
                }
                Op::Not(of) => parts.contains(of),
                _ => false,
            };
            if never {
                return Err(Fault::new(
                    "rule.never",
                    span,
                    "这些条件永远不会同时成立",
                    "these conditions are never true together",
                )
                .hint(
                    "改正其中一个界限或取值；若为几种可能之一，用 or 连接",
                    "correct one of the bounds or values; alternatives are joined by `or`",
                ));
            }
        }
        Ok(())
    }

    /// The conditions that `and` joins.
    fn joined(&self, id: NodeId, out: &mut BTreeSet<NodeId>) {
        match &self.program.node(id).op {
            Op::And(all) => all.iter().for_each(|id| self.joined(*id, out)),
            _ => {
                out.insert(id);
            }
        }
    }

    /// The value of a number of the rule.
    fn fixed(&self, id: NodeId) -> Option<f64> {
        match &self.program.node(id).op {
            Op::Constant(value) => Some(*value),
            Op::Negate(of) => self.fixed(*of).map(|value| -value),
            _ => None,
        }
    }
}
