//! Conditions that are never true together: bounds of one number that leave no value, names of one category that
//! exclude each other, a condition and its negation, or a bound beyond what a number can be (a share above 1, a speed
//! below 0). A rule with them would be searched and never found.

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

    /// From `low` to `high`, both included.
    fn within(low: f64, high: f64) -> Self {
        Self { low, high, ..Self::ALL }
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
        for id in parts.iter().filter(|_| !self.asks_if_known) {
            self.within_range(*id, span)?;
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

    /// A fault where a number is compared with a value that it can never have.
    fn within_range(&self, id: NodeId, span: Span) -> Result<(), Fault> {
        let Op::Compare { op, left, right, .. } = &self.program.node(id).op else { return Ok(()) };
        let (of, op, value) = match (self.fixed(*left), self.fixed(*right)) {
            (None, Some(value)) => (*left, *op, value),
            (Some(value), None) => (*right, op.mirrored(), value),
            _ => return Ok(()),
        };
        let range = self.range(of);
        let mut left = range;
        left.restrict(op, value);
        if !left.is_empty() {
            return Ok(());
        }
        let is_share = matches!(self.program.node(of).op, Op::Share(..));
        let fault = Fault::new("rule.never", span, "这个条件永远不会成立", "this condition is never true");
        Err(if is_share {
            fault.hint("share 的值从 0 到 1：50 % 写作 0.5", "a share is from 0 to 1: 50 % is 0.5")
        } else {
            let bound = if range.high.is_finite() { range.high } else { range.low };
            let (zh, en) = if range.high.is_finite() { ("大于", "more") } else { ("小于", "less") };
            fault.hint(
                format!("这个数不会{zh} {bound}；改正界限或比较符"),
                format!("the number is never {en} than {bound}: correct the bound or the comparison"),
            )
        })
    }

    /// Values that a number can have, in its base unit.
    fn range(&self, id: NodeId) -> Left {
        let of_signal = |name: &str| {
            let least = self.catalog.get(name).and_then(|def| def.least);
            Left::within(least.unwrap_or(f64::NEG_INFINITY), f64::INFINITY)
        };
        match &self.program.node(id).op {
            Op::Share(..) => Left::within(0.0, 1.0),
            Op::Absolute(_) => Left::within(0.0, f64::INFINITY),
            Op::Signal(name) | Op::SecondSignal(name) | Op::PairSignal { name, .. } => of_signal(name),
            Op::Least(of, _) | Op::Greatest(of, _) | Op::Before(of) | Op::AtKeyframe(of) => self.range(*of),
            Op::MatchLeast(of) | Op::MatchGreatest(of) => self.range(*of),
            Op::Negate(of) => {
                let of = self.range(*of);
                Left::within(-of.high, -of.low)
            }
            _ => Left::ALL,
        }
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
