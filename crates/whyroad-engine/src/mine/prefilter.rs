//! Decisions from the file's statistics before a value is read: a rule whose condition cannot hold. Never changes a
//! result: *not observable* follows from the same statistics; otherwise the rule is run.

use std::collections::{BTreeMap, BTreeSet};
use whyroad_lake::signals::Range;
use whyroad_mining::episode::kinds::Kinds;
use whyroad_mining::fast::Plan;
use whyroad_mining::fast::plan::PlanRule;
use whyroad_mining::fast::search::lacking;
use whyroad_mining::language::program::{NodeId, Op, Subject};
use whyroad_mining::language::syntax::CompareOp;

/// Statistics of the signals that a drive has, by name; `None` where the file has none.
pub type Ranges<'a> = BTreeMap<&'a str, Option<Range>>;

/// Knowledge about a rule without reading values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It finds nothing; not observable for lack of these, if any.
    Settled(BTreeSet<String>),
    /// It finds nothing, and could be decided if this signal is known for any object that the rule considers.
    SettledIfKnown(String),
    /// It has to be run.
    Open,
}

impl Verdict {
    /// The deciding signal.
    pub fn asks(&self) -> Option<&str> {
        match self {
            Self::SettledIfKnown(signal) => Some(signal),
            _ => None,
        }
    }
}

/// Evaluates one rule. `kinds`: what is known in part only, or of some objects only.
pub fn verdict(plan: &Plan<'_>, rule: &PlanRule<'_>, ranges: &Ranges<'_>, kinds: Kinds<'_>) -> Verdict {
    let when = rule.node(rule.rule.when);
    let bounds = Bounds { plan, ranges };
    if !bounds.never(when) {
        return Verdict::Open;
    }
    let shown = kinds.shown_to(rule.rule.subject);
    let lacking = lacking(rule, |s| ranges.contains_key(s) && shown(s));
    if !lacking.is_empty() {
        return Verdict::Settled(lacking);
    }
    // A part that is known to be false somewhere makes the whole known there.
    let parts = plan.conjuncts(when);
    let false_parts = || parts.iter().filter_map(|id| bounds.false_where_known(*id));
    let everywhere = |(_, range): &(&str, Range)| range.known == range.rows;
    if false_parts().any(|part| everywhere(&part)) {
        return Verdict::Settled(BTreeSet::new());
    }
    let of_objects = |name: &str| name.starts_with("target.");
    for (name, _) in false_parts() {
        match (rule.rule.subject, &rule.rule.second) {
            (None, _) if !of_objects(name) => return Verdict::Settled(BTreeSet::new()),
            (Some(Subject::Any), None) if of_objects(name) => return Verdict::Settled(BTreeSet::new()),
            (Some(_), None) if of_objects(name) => return Verdict::SettledIfKnown(name.to_owned()),
            _ => {}
        }
    }
    Verdict::Open
}

struct Bounds<'p, 'r> {
    plan: &'p Plan<'p>,
    ranges: &'p Ranges<'r>,
}

impl<'p> Bounds<'p, '_> {
    /// True when the condition cannot be true in any row.
    fn never(&self, id: NodeId) -> bool {
        match &self.plan.node(id).op {
            Op::Truth(value) => !value,
            Op::And(all) => all.iter().any(|a| self.never(*a)),
            Op::Or(all) => all.iter().all(|a| self.never(*a)),
            Op::For(a, _)
            | Op::Within(a, _)
            | Op::Previously(a, _)
            | Op::Before(a)
            | Op::Bridge(a, _)
            | Op::Since(_, a)
            | Op::Until(_, a) => self.never(*a),
            Op::Member(a, _) => self.unknown(*a),
            _ => self.unknown(id) || self.false_where_known(id).is_some(),
        }
    }

    /// True for a signal that is nowhere known, or compared where it is.
    fn unknown(&self, id: NodeId) -> bool {
        match &self.plan.node(id).op {
            Op::Signal(name) | Op::SecondSignal(name) => match self.ranges.get(name.as_str()) {
                Some(range) => range.is_some_and(|r| r.known == 0),
                None => true,
            },
            Op::Compare { left, right, .. } => self.unknown(*left) || self.unknown(*right),
            _ => false,
        }
    }

    /// For a comparison of a signal with a number, or a flag, that is false wherever the signal is known, and it is
    /// known somewhere: the signal.
    fn false_where_known(&self, id: NodeId) -> Option<(&'p str, Range)> {
        let constant = |id: NodeId| match self.plan.node(id).op {
            Op::Constant(x) => Some(x),
            _ => None,
        };
        match &self.plan.node(id).op {
            Op::Compare { op, left, right, .. } => match (constant(*left), constant(*right)) {
                (None, Some(bound)) => self.signal(*left).filter(|(_, r)| impossible(*op, r.bounds, bound)),
                (Some(bound), None) => {
                    self.signal(*right).filter(|(_, r)| impossible(op.mirrored(), r.bounds, bound))
                }
                _ => None,
            },
            Op::Signal(_) | Op::SecondSignal(_) => {
                self.signal(id).filter(|(_, r)| r.bounds.is_some_and(|(_, greatest)| greatest == 0.0))
            }
            Op::Not(a) => self.signal(*a).filter(|(_, r)| r.bounds.is_some_and(|(least, _)| least == 1.0)),
            _ => None,
        }
    }

    fn signal(&self, id: NodeId) -> Option<(&'p str, Range)> {
        match &self.plan.node(id).op {
            Op::Signal(name) | Op::SecondSignal(name) => {
                let range = (*self.ranges.get(name.as_str())?)?;
                (range.known > 0).then_some((name.as_str(), range))
            }
            _ => None,
        }
    }
}

/// True when the comparison holds for no value in the bounds.
fn impossible(op: CompareOp, bounds: Option<(f64, f64)>, bound: f64) -> bool {
    let Some((least, greatest)) = bounds else { return false };
    match op {
        CompareOp::Less => least >= bound,
        CompareOp::LessOrEqual => least > bound,
        CompareOp::Greater => greatest <= bound,
        CompareOp::GreaterOrEqual => greatest < bound,
        CompareOp::Equal => bound < least || bound > greatest,
        CompareOp::NotEqual => least == bound && greatest == bound,
    }
}
