//! All rules as one program: a condition shared by several rules is one node, evaluated once per drive.

use crate::language::program::{Moment, NodeId, Op, ValueScope};
use crate::rule::{Rule, RuleSet};
use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use whyroad_model::signal::deviation_name;

/// A node of the plan.
#[derive(Clone, Debug)]
pub struct PlanNode {
    /// What it computes; operands are nodes of the plan.
    pub op: Op,
    /// Rows of its value.
    pub scope: ValueScope,
    /// True when the value depends on an episode.
    pub needs_episode: bool,
    /// Of a node of [`ValueScope::Second`]: the same about the target. Its values for all objects serve both roles.
    pub as_target: Option<NodeId>,
    /// Of a signal: the name of the column with its standard deviations.
    pub deviation: Option<String>,
    /// How much its values cost, about: which of several conditions to ask first.
    pub cost: usize,
}

/// A rule and where its nodes are in the plan.
#[derive(Clone, Debug)]
pub struct PlanRule<'r> {
    /// The rule.
    pub rule: Cow<'r, Rule>,
    /// Node of the plan for each node of the rule's program.
    nodes: Vec<NodeId>,
    /// The conditions of `when` on the target alone, or on the drive, as parts that must all hold: for rules that bind
    /// two objects, which have many pairs.
    pub alone: Vec<NodeId>,
    /// Its conditions on the second object alone, expressed for a target.
    pub alone_second: Vec<NodeId>,
    /// Signals without which the absence of a match is unknown.
    pub needs: BTreeSet<String>,
    /// Signals that decide whether there is a match, sorted.
    pub signals: BTreeSet<String>,
    /// Signals that `when` reads.
    pub when_signals: BTreeSet<String>,
    /// Signals that are read only after a match.
    pub later_signals: BTreeSet<String>,
}

impl PlanRule<'_> {
    /// Every signal that the rule uses; some more than once.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let sets = [&self.needs, &self.signals, &self.when_signals, &self.later_signals];
        sets.into_iter().flatten().map(String::as_str)
    }

    /// The plan's node for a node of the rule.
    pub fn node(&self, id: NodeId) -> NodeId {
        self.nodes[id.0]
    }
}

/// The plan of a set of rules.
#[derive(Clone, Debug, Default)]
pub struct Plan<'r> {
    /// Operands before users.
    pub nodes: Vec<PlanNode>,
    /// The rules in their order.
    pub rules: Vec<PlanRule<'r>>,
    by_op: HashMap<String, NodeId>,
}

impl Plan<'static> {
    /// The plan of these rules, with its own copies of them: for callers that keep it. Making a plan of all bundled
    /// rules takes longer than searching a drive with it.
    pub fn owning(rules: &RuleSet) -> Self {
        Self::made(rules.rules.iter().cloned().map(Cow::Owned))
    }
}

impl<'r> Plan<'r> {
    /// The plan of these rules.
    pub fn of(rules: &'r RuleSet) -> Self {
        Self::of_rules(&rules.rules)
    }

    /// The plan of these rules.
    pub fn of_rules(rules: impl IntoIterator<Item = &'r Rule>) -> Self {
        Self::made(rules.into_iter().map(Cow::Borrowed))
    }

    fn made(rules: impl Iterator<Item = Cow<'r, Rule>>) -> Self {
        let mut plan = Self::default();
        for rule in rules {
            let mut nodes = Vec::with_capacity(rule.program.nodes.len());
            for node in &rule.program.nodes {
                nodes.push(plan.add(renamed(&node.op, |id| nodes_at(&nodes, id))));
            }
            let when_signals = rule.program.signals(rule.when);
            let (signals, needs) = (rule.signals(), rule.needs());
            let later = rule.program.signals_of(later_nodes(&rule));
            let later_signals = &later - &when_signals;
            let mut alone = plan.conjuncts(nodes[rule.when.0]);
            let alone_second = alone.iter().filter_map(|id| plan.node(*id).as_target).collect();
            alone.retain(|id| matches!(plan.node(*id).scope, ValueScope::Frame | ValueScope::Target));
            plan.rules.push(PlanRule {
                rule,
                nodes,
                alone,
                alone_second,
                needs,
                signals,
                when_signals,
                later_signals,
            });
        }
        plan
    }

    /// The node.
    pub fn node(&self, id: NodeId) -> &PlanNode {
        &self.nodes[id.0]
    }

    /// The parts of a condition that must all hold.
    pub fn conjuncts(&self, id: NodeId) -> Vec<NodeId> {
        match &self.node(id).op {
            Op::And(all) => all.iter().flat_map(|a| self.conjuncts(*a)).collect(),
            _ => vec![id],
        }
    }

    /// True if this is so of the operation of a node or of one that it reads.
    pub fn any_below(&self, id: NodeId, is: &dyn Fn(&Op) -> bool) -> bool {
        let op = &self.node(id).op;
        is(op) || op.operands().into_iter().any(|of| self.any_below(of, is))
    }

    fn add(&mut self, op: Op) -> NodeId {
        // Numbers print with all their digits, so equal texts are equal operations.
        let key = format!("{op:?}");
        if let Some(id) = self.by_op.get(&key) {
            return *id;
        }
        let operands = op.operands();
        let joined =
            || operands.iter().map(|o| self.node(*o).scope).fold(ValueScope::Frame, ValueScope::join);
        let scope = op.own_scope().unwrap_or_else(joined);
        let needs_episode = op.is_of_episode() || operands.iter().any(|o| self.node(*o).needs_episode);
        let as_target = (scope == ValueScope::Second).then(|| {
            let twin = |id: NodeId| self.nodes[id.0].as_target.unwrap_or(id);
            match &op {
                Op::SecondSignal(name) => Op::Signal(name.clone()),
                other => renamed(other, twin),
            }
        });
        let as_target = as_target.map(|op| self.add(op));
        let deviation = match &op {
            Op::Signal(name) | Op::SecondSignal(name) | Op::PairSignal { name, .. } => {
                Some(deviation_name(name))
            }
            _ => None,
        };
        let cost = own_cost(&op) + op.operands().iter().map(|o| self.node(*o).cost).sum::<usize>();
        self.nodes.push(PlanNode { op, scope, needs_episode, as_target, deviation, cost });
        let id = NodeId(self.nodes.len() - 1);
        self.by_op.insert(key, id);
        id
    }
}

/// Cost of an operation without its operands, in passes over packed truth values, about.
fn own_cost(op: &Op) -> usize {
    match op {
        Op::Constant(_) | Op::Truth(_) | Op::Not(_) | Op::And(_) | Op::Or(_) => 1,
        Op::Signal(_) | Op::SecondSignal(_) | Op::PairSignal { .. } | Op::Member(..) | Op::Known(_) => 2,
        Op::Compare { .. } | Op::Before(_) => 4,
        _ => 8,
    }
}

fn nodes_at(nodes: &[NodeId], id: NodeId) -> NodeId {
    nodes[id.0]
}

/// Nodes that are evaluated only after a match.
fn later_nodes(rule: &Rule) -> Vec<NodeId> {
    let timing = &rule.timing;
    let moments = timing.keyframe.iter().map(|(m, _)| m).chain(&timing.start).chain(&timing.end);
    let moments =
        moments.chain(&timing.second_keyframe).chain(&timing.after_until).flat_map(Moment::conditions);
    let atoms = rule.atoms.iter().flat_map(|a| [a.condition, a.measured]);
    let response = rule.response.map(|r| r.condition);
    rule.require.iter().copied().chain(response).chain(moments).chain(atoms).collect()
}

/// The same operation on other nodes.
fn renamed(op: &Op, to: impl Fn(NodeId) -> NodeId) -> Op {
    match op {
        Op::Constant(_) | Op::Truth(_) | Op::Signal(_) | Op::SecondSignal(_) | Op::PairSignal { .. } => {
            op.clone()
        }
        Op::Negate(a) => Op::Negate(to(*a)),
        Op::Add(a, b) => Op::Add(to(*a), to(*b)),
        Op::Subtract(a, b) => Op::Subtract(to(*a), to(*b)),
        Op::Multiply(a, b) => Op::Multiply(to(*a), to(*b)),
        Op::Absolute(a) => Op::Absolute(to(*a)),
        Op::Least(a, d) => Op::Least(to(*a), *d),
        Op::Greatest(a, d) => Op::Greatest(to(*a), *d),
        Op::Share(a, d) => Op::Share(to(*a), *d),
        Op::Compare { op, left, right, scale } => {
            Op::Compare { op: *op, left: to(*left), right: to(*right), scale: *scale }
        }
        Op::Member(a, words) => Op::Member(to(*a), words.clone()),
        Op::Known(a) => Op::Known(to(*a)),
        Op::Not(a) => Op::Not(to(*a)),
        Op::And(all) => Op::And(all.iter().map(|a| to(*a)).collect()),
        Op::Or(all) => Op::Or(all.iter().map(|a| to(*a)).collect()),
        Op::For(a, d) => Op::For(to(*a), *d),
        Op::Within(a, d) => Op::Within(to(*a), *d),
        Op::Previously(a, d) => Op::Previously(to(*a), *d),
        Op::Since(a, b) => Op::Since(to(*a), to(*b)),
        Op::Until(a, b) => Op::Until(to(*a), to(*b)),
        Op::Bridge(a, d) => Op::Bridge(to(*a), *d),
        Op::AtLeast { of, count, subject } => Op::AtLeast { of: to(*of), count: *count, subject: *subject },
        Op::AtLeastNear { of, count, subject } => {
            Op::AtLeastNear { of: to(*of), count: *count, subject: *subject }
        }
        Op::Before(a) => Op::Before(to(*a)),
        Op::AtKeyframe(a) => Op::AtKeyframe(to(*a)),
        Op::InMatch(a) => Op::InMatch(to(*a)),
        Op::MatchLeast(a) => Op::MatchLeast(to(*a)),
        Op::MatchGreatest(a) => Op::MatchGreatest(to(*a)),
    }
}
