//! Whether a drive can show a class at all: by the signals that it has, not by what happens in it.

use crate::language::program::{NodeId, Op, Program, Subject};
use crate::rule::Rule;

/// The truths that a condition can take; for a number or a category, both say whether it can be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Possible {
    yes: bool,
    no: bool,
}

impl Possible {
    fn both(known: bool) -> Self {
        Self { yes: known, no: known }
    }

    fn is_known(self) -> bool {
        self.yes || self.no
    }
}

/// True when all that the rule asks for can be known to hold, each alternative included, where only signals that `has`
/// accepts are known. A stop at a red light needs the light. What the rule excludes (`not`) need not be known
/// everywhere: what is excluded at ramps only can be looked for elsewhere.
pub(crate) fn is_decidable(rule: &Rule, has: impl Fn(&str) -> bool) -> bool {
    // Which objects are its targets is not a node of the rule.
    if rule.subject.and_then(Subject::signal).is_some_and(|signal| !has(signal)) {
        return false;
    }
    let possible = possible(&rule.program, has);
    let mut todo: Vec<NodeId> = std::iter::once(&rule.when).chain(&rule.require).copied().collect();
    while let Some(id) = todo.pop() {
        let shown = match &rule.program.node(id).op {
            Op::And(all) | Op::Or(all) => {
                todo.extend(all);
                true
            }
            Op::For(a, _)
            | Op::Within(a, _)
            | Op::Previously(a, _)
            | Op::Bridge(a, _)
            | Op::Before(a)
            | Op::AtKeyframe(a)
            | Op::InMatch(a) => {
                todo.push(*a);
                true
            }
            Op::Since(a, b) | Op::Until(a, b) => {
                todo.extend([*a, *b]);
                true
            }
            _ => possible[id.0].yes,
        };
        if !shown {
            return false;
        }
    }
    true
}

/// What each node can be. Operands come before their users.
fn possible(program: &Program, has: impl Fn(&str) -> bool) -> Vec<Possible> {
    let mut out: Vec<Possible> = Vec::with_capacity(program.nodes.len());
    for node in &program.nodes {
        let of = |id: &NodeId| out[id.0];
        let possible = match &node.op {
            Op::Constant(_) => Possible::both(true),
            Op::Truth(value) => Possible { yes: *value, no: !value },
            Op::Signal(name) | Op::SecondSignal(name) | Op::PairSignal { name, .. } => {
                Possible::both(has(name))
            }
            Op::Known(a) => Possible { yes: of(a).is_known(), no: true },
            Op::Not(a) => Possible { yes: of(a).no, no: of(a).yes },
            Op::And(all) => Possible { yes: all.iter().all(|a| of(a).yes), no: all.iter().any(|a| of(a).no) },
            Op::Or(all) => Possible { yes: all.iter().any(|a| of(a).yes), no: all.iter().all(|a| of(a).no) },
            // Before the start of the drive it may have held.
            Op::Previously(a, None) => Possible { yes: of(a).yes, no: false },
            Op::Since(a, b) | Op::Until(a, b) => Possible { yes: of(b).yes, no: of(a).no || of(b).no },
            // An object for which a signal is missing may or may not count.
            Op::AtLeast { of, .. } | Op::AtLeastNear { of, .. } => {
                Possible::both(program.signals(*of).iter().all(|s| has(s)))
            }
            Op::Negate(a)
            | Op::Absolute(a)
            | Op::Least(a, _)
            | Op::Greatest(a, _)
            | Op::For(a, _)
            | Op::Within(a, _)
            | Op::Previously(a, Some(_))
            | Op::Bridge(a, _)
            | Op::Before(a)
            | Op::AtKeyframe(a)
            | Op::InMatch(a)
            | Op::MatchLeast(a)
            | Op::MatchGreatest(a) => of(a),
            Op::Share(a, _) | Op::Member(a, _) => Possible::both(of(a).is_known()),
            Op::Add(a, b) | Op::Subtract(a, b) | Op::Multiply(a, b) => {
                Possible::both(of(a).is_known() && of(b).is_known())
            }
            Op::Compare { left, right, .. } => Possible::both(of(left).is_known() && of(right).is_known()),
        };
        out.push(possible);
    }
    out
}
