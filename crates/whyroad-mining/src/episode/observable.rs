//! Whether a drive can show a class at all: by the signals that it has, not by what happens in it.

use crate::language::program::{NodeId, Op, Program, Subject};
use crate::rule::Rule;
use std::collections::BTreeSet;

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

/// What a drive can tell of a condition that has to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    /// It can be known to hold, each alternative included.
    Holding,
    /// It is known not to hold: it asks for a signal to be known that the drive does not have.
    Excluded,
    Unknown,
}

/// Signals of `needs` that the drive does not have; none where the rule can be decided without them. Where the rule can
/// only match with a signal that it tests with `is known` and the drive does not have: these.
pub(crate) fn lacking_signals(
    rule: &Rule,
    needs: &BTreeSet<String>,
    has: impl Fn(&str) -> bool,
) -> BTreeSet<String> {
    if is_decidable(rule, &has) {
        return BTreeSet::new();
    }
    let absent: BTreeSet<String> = needs.iter().filter(|s| !has(s)).cloned().collect();
    if absent.is_empty() { rule.signals().into_iter().filter(|s| !has(s)).collect() } else { absent }
}

/// True when all that the rule asks for can be known to hold, each alternative included, where only signals that `has`
/// accepts are known. A stop at a red light needs the light. An alternative that a test `x is known` leaves out is not
/// looked at. What the rule excludes (`not`) need not be known everywhere: what is excluded at ramps only can be looked
/// for elsewhere.
fn is_decidable(rule: &Rule, has: impl Fn(&str) -> bool) -> bool {
    // Which objects are its targets is not a node of the rule.
    if rule.subject.and_then(Subject::signal).is_some_and(|signal| !has(signal)) {
        return false;
    }
    let possible = possible(&rule.program, has);
    let mut roots = std::iter::once(&rule.when).chain(&rule.require);
    roots.all(|root| shown(&rule.program, &possible, *root) == Shown::Holding)
}

fn shown(program: &Program, possible: &[Possible], id: NodeId) -> Shown {
    let of = |id: &NodeId| shown(program, possible, *id);
    match &program.node(id).op {
        // `x is known and x` of what can be known only not to hold.
        Op::And(all) if all.iter().any(|a| is_tested(program, *a, all) && !possible[a.0].yes) => {
            Shown::Excluded
        }
        Op::And(all) => {
            let all: Vec<Shown> = all.iter().map(of).collect();
            [Shown::Excluded, Shown::Unknown].into_iter().find(|s| all.contains(s)).unwrap_or(Shown::Holding)
        }
        // `x is unknown`, of what cannot be known here, decides the rest.
        Op::Or(all) if all.iter().any(|a| is_unknown(program, possible, *a)) => Shown::Holding,
        Op::Or(all) => {
            let all: Vec<Shown> = all.iter().map(of).collect();
            [Shown::Unknown, Shown::Holding].into_iter().find(|s| all.contains(s)).unwrap_or(Shown::Excluded)
        }
        Op::For(a, _)
        | Op::Within(a, _)
        | Op::Previously(a, _)
        | Op::Bridge(a, _)
        | Op::Before(a)
        | Op::AtKeyframe(a)
        | Op::InMatch(a) => of(a),
        Op::Since(a, b) | Op::Until(a, b) => match (of(a), of(b)) {
            (_, Shown::Excluded) => Shown::Excluded,
            (Shown::Unknown, _) | (_, Shown::Unknown) => Shown::Unknown,
            _ => Shown::Holding,
        },
        _ => match possible[id.0] {
            Possible { yes: true, .. } => Shown::Holding,
            Possible { no: true, .. } => Shown::Excluded,
            _ => Shown::Unknown,
        },
    }
}

/// True where `x is known` is one of the parts beside x.
fn is_tested(program: &Program, x: NodeId, parts: &[NodeId]) -> bool {
    parts.iter().any(|part| matches!(program.node(*part).op, Op::Known(of) if of == x))
}

/// True for `x is unknown` where x cannot be known.
fn is_unknown(program: &Program, possible: &[Possible], id: NodeId) -> bool {
    let Op::Not(test) = program.node(id).op else { return false };
    matches!(program.node(test).op, Op::Known(of) if !possible[of.0].is_known())
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
                // Mostly all signals are there: what is needed of them need not be worked out.
                let all = |signals: BTreeSet<String>| signals.iter().all(|s| has(s));
                Possible::both(all(program.signals(*of)) || all(program.needs(&[*of])))
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
