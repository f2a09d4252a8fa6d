//! A checked program: an arena of operations over signals, all numbers in base units. Equal operations are
//! one node, so that a condition that several leaves share is evaluated once per drive.

use super::syntax::CompareOp;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::messages::MatchedCondition;
use whyroad_model::signal::is_of_object;
use whyroad_model::units::{Dimension, Unit};
use whyroad_model::{Bilingual, Nanos, ObjectClass};

/// Index of a node in its program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub usize);

/// The rows for which a node has a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ValueScope {
    /// One value per frame of the drive.
    Frame,
    /// One value per frame of each object that can be the rule's target (its first role).
    Target,
    /// One value per frame of each object that can take the rule's second role.
    Second,
    /// One value for each pair of a target and another object and frame in which both are observed.
    Pair,
}

impl ValueScope {
    /// The rows of a node whose operands have these rows.
    #[must_use]
    pub fn join(self, other: ValueScope) -> ValueScope {
        match (self, other) {
            (ValueScope::Frame, s) | (s, ValueScope::Frame) => s,
            (a, b) if a == b => a,
            _ => ValueScope::Pair,
        }
    }
}

/// Which objects can be the target of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// Everything that is tracked.
    Any,
    /// Motor vehicles.
    Vehicle,
    /// Trucks, buses and the like.
    LargeVehicle,
    /// Vulnerable road users.
    Vru,
    /// Objects of one class.
    Class(ObjectClass),
}

/// Viewpoint of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairSide {
    /// The object in the first role: `pair.`.
    First,
    /// The object in the second role: `reverse.`.
    Second,
}

impl Subject {
    /// Its name in a rule file.
    pub fn from_word(word: &str) -> Option<Self> {
        match word {
            "any" => Some(Self::Any),
            "vehicle" => Some(Self::Vehicle),
            "large_vehicle" => Some(Self::LargeVehicle),
            "vru" => Some(Self::Vru),
            _ => ObjectClass::from_id(word).filter(|c| *c != ObjectClass::Unknown).map(Self::Class),
        }
    }

    /// True when an object of this class can be the target.
    pub fn admits(self, class: ObjectClass) -> bool {
        match self {
            Self::Any => true,
            Self::Vehicle => class.is_vehicle(),
            Self::LargeVehicle => class.is_large_vehicle(),
            Self::Vru => class.is_vru(),
            Self::Class(only) => class == only,
        }
    }

    /// The signal without which it is unknown which objects it admits; the class of an object alone shows the others.
    pub fn signal(self) -> Option<&'static str> {
        (self == Self::LargeVehicle).then_some("target.large_vehicle")
    }
}

/// Type of a node's value.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueKind {
    /// A number in the dimension's base unit.
    Number(Dimension),
    /// Three-valued truth.
    Condition,
    /// One of a closed set of names.
    Category(Vec<String>),
}

/// What a node computes. Operands come before their users in the arena.
#[derive(Clone, Debug, PartialEq)]
pub enum Op {
    /// A number of the rule.
    Constant(f64),
    /// `true` or `false` of the rule.
    Truth(bool),
    /// A signal of any kind, by its name in the catalog; `target.*` and `object.*` are of the object in the first
    /// role.
    Signal(String),
    /// A `target.*` or `object.*` signal of the object in the second role, by its name in the catalog.
    SecondSignal(String),
    /// A `pair.*` signal of the two, by its name in the catalog.
    PairSignal {
        /// Name.
        name: String,
        /// Viewpoint.
        seen_from: PairSide,
    },
    /// `-a`.
    Negate(NodeId),
    /// `a + b`.
    Add(NodeId, NodeId),
    /// `a - b`.
    Subtract(NodeId, NodeId),
    /// `a * b`.
    Multiply(NodeId, NodeId),
    /// `abs(a)`.
    Absolute(NodeId),
    /// `min(a, 3 s)`: least value in the past window, now included.
    Least(NodeId, Nanos),
    /// `max(a, 3 s)`: greatest value in the past window, now included.
    Greatest(NodeId, Nanos),
    /// `share(c, 3 s)`: part of the past window, now included, in which the condition was true.
    Share(NodeId, Nanos),
    /// Comparison of two numbers; `scale` turns their difference into a margin.
    Compare {
        /// Operator.
        op: CompareOp,
        /// Left side.
        left: NodeId,
        /// Right side.
        right: NodeId,
        /// Typical magnitude of the compared number, in its base unit.
        scale: f64,
    },
    /// Category in a set of names.
    Member(NodeId, Vec<String>),
    /// The operand has a known value.
    Known(NodeId),
    /// Kleene negation.
    Not(NodeId),
    /// Kleene conjunction.
    And(Vec<NodeId>),
    /// Kleene disjunction.
    Or(Vec<NodeId>),
    /// Belongs to a run of true that lasts at least this time.
    For(NodeId, Nanos),
    /// True now or at some frame within this time after now.
    Within(NodeId, Nanos),
    /// True at some earlier frame, at most this time ago where a time is given.
    Previously(NodeId, Option<Nanos>),
    /// `a since b`: b now or at some earlier frame, and a at every frame after that one, now included.
    /// A time limit is lowered to a conjunction: `(b or previously(b, d)) and (a since b)`.
    Since(NodeId, NodeId),
    /// `a until b`: b now or at some later frame, and a at every frame before that one, now included.
    /// A time limit is lowered to `(b within d) and (a until b)`.
    Until(NodeId, NodeId),
    /// True, and also in breaks of at most this time between two frames at which it is true.
    Bridge(NodeId, Nanos),
    /// At least `count` objects that are observed at the frame meet a condition of [`ValueScope::Target`], in which the
    /// target is each of them in turn. The value is of [`ValueScope::Frame`].
    AtLeast {
        /// The condition.
        of: NodeId,
        /// How many.
        count: usize,
        /// Which objects are counted.
        subject: Subject,
    },
    /// At least `count` of the objects that are near the object in the first role at the frame meet a condition of
    /// [`ValueScope::Second`] or [`ValueScope::Pair`], in which each of them takes the second role in turn. The value
    /// is of [`ValueScope::Target`].
    AtLeastNear {
        /// The condition.
        of: NodeId,
        /// How many.
        count: usize,
        /// Which objects are counted.
        subject: Subject,
    },
    /// The operand's value at the frame before.
    Before(NodeId),
    /// The operand's value at the episode's keyframe, at every frame.
    AtKeyframe(NodeId),
    /// True at some frame of the episode's match, at every frame.
    InMatch(NodeId),
    /// Least known value in the episode's match, at every frame: for display, never part of a condition (comparisons
    /// with it are lowered to [`Op::InMatch`], which answers unknown where a frame is not known).
    MatchLeast(NodeId),
    /// Greatest known value in the episode's match, at every frame; as [`Op::MatchLeast`].
    MatchGreatest(NodeId),
}

/// A node.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// What it computes.
    pub op: Op,
    /// Type of its value.
    pub kind: ValueKind,
    /// Rows of its value.
    pub scope: ValueScope,
    /// True when the value depends on an episode: on where its keyframe or its match is.
    pub needs_episode: bool,
}

/// A moment of the labeling spec. The rows that "true" ranges over (the match, before or after the keyframe) depend on
/// where it is resolved: see [`crate::episode::moment`].
#[derive(Clone, Debug, PartialEq)]
pub enum Moment {
    /// The keyframe.
    Keyframe,
    /// First frame of the match.
    MatchStart,
    /// One past the last frame of the match.
    MatchEnd,
    /// First frame of the match at which it is true.
    First(NodeId),
    /// Last frame of the match at which it is true.
    Last(NodeId),
    /// A bare condition: the frame nearest to the keyframe; the first one when the keyframe itself is sought.
    Nearest(NodeId),
    /// First frame of the match with the least value.
    Least(NodeId),
    /// First frame of the match with the greatest value.
    Greatest(NodeId),
    /// The earliest of several; missing when one of them is.
    Earliest(Vec<Moment>),
    /// The latest of several; missing when one of them is.
    Latest(Vec<Moment>),
    /// Another moment moved in time.
    Offset(Box<Moment>, Nanos),
}

impl Moment {
    /// The conditions and numbers that it reads.
    pub fn conditions(&self) -> Vec<NodeId> {
        match self {
            Moment::Keyframe | Moment::MatchStart | Moment::MatchEnd => vec![],
            Moment::First(c)
            | Moment::Last(c)
            | Moment::Nearest(c)
            | Moment::Least(c)
            | Moment::Greatest(c) => {
                vec![*c]
            }
            Moment::Earliest(all) | Moment::Latest(all) => all.iter().flat_map(Moment::conditions).collect(),
            Moment::Offset(of, _) => of.conditions(),
        }
    }
}

/// The measured part of a condition, for display: `target.ttc < 3s` and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Atom {
    /// As written, parameters replaced by their values.
    pub text: String,
    /// In words.
    pub words: Bilingual,
    /// Truth of the atom.
    pub condition: NodeId,
    /// The measured number or category; the condition itself where nothing is measured.
    pub measured: NodeId,
    /// The signals it reads.
    pub signals: BTreeSet<String>,
    /// Unit in which the measured number is shown.
    pub unit: &'static Unit,
    /// Displayed names of the values of a measured category.
    pub value_names: BTreeMap<String, Bilingual>,
    /// The fixed number that it is compared with, in `unit`.
    pub threshold: Option<f64>,
    /// The condition holds where the measured flag is false, as in `ego.standstill == false`.
    pub is_denied: bool,
}

/// Text for a condition that holds, or does not.
pub fn truth_in_words(holds: bool) -> Bilingual {
    if holds { Bilingual::new("成立", "holds") } else { Bilingual::new("不成立", "does not hold") }
}

/// The largest number of decimals of a measured value.
const MOST_PLACES: i32 = 8;

/// A value to this number of decimals, or to more where it would otherwise change sides: 4.998 is not shown as 5 beside
/// "< 5 m".
fn rounded(value: f64, places: i32, threshold: Option<f64>) -> f64 {
    let to = |places: i32| {
        let scale = 10_f64.powi(places);
        (value * scale).round() / scale
    };
    let Some(threshold) = threshold else { return to(places) };
    // Values that differ by less are equal but for the last bits.
    let same = |x: f64| (x - threshold).abs() <= 1e-9 * threshold.abs().max(1.0);
    let side = |x: f64| if same(x) { None } else { Some(x < threshold) };
    (places..=MOST_PLACES).map(to).find(|x| side(*x) == side(value)).unwrap_or(value)
}

impl Atom {
    /// The condition as an episode lists it, with its value.
    pub fn matched(&self, actual_value: Value) -> MatchedCondition {
        let actual_words = self.value_in_words(&actual_value);
        let (condition, description) = (self.text.clone(), Some(self.words.clone()));
        MatchedCondition { condition, actual_value, description, actual_words }
    }

    /// A measured number, in the base unit of its dimension, as messages have it: in `unit`, to four decimals or as
    /// many as are needed to be on the same side of the threshold. Null when it is unknown or infinite.
    pub fn number(&self, base: f64) -> Value {
        let value = rounded(base / self.unit.to_base, 4, self.threshold);
        serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number)
    }

    /// A measured value as text; `None` where there is none.
    pub fn value_in_words(&self, value: &Value) -> Option<Bilingual> {
        match value {
            Value::Bool(holds) => Some(truth_in_words(*holds != self.is_denied)),
            Value::Number(n) => {
                let shown = self.unit.displayed();
                let value = self.unit.convert(n.as_f64()?, shown);
                // Curvatures are hundredths.
                let places = if value.abs() < 0.1 { 4 } else { 2 };
                let threshold = self.threshold.map(|t| self.unit.convert(t, shown));
                let rounded = rounded(value, places, threshold);
                Some(Bilingual::same(shown.of(&(rounded + 0.0).to_string().replace('-', "−"))))
            }
            Value::String(word) => Some(
                self.value_names
                    .get(word)
                    .cloned()
                    .unwrap_or_else(|| Bilingual::same(word.replace('_', " "))),
            ),
            _ => None,
        }
    }
}

/// All nodes of one rule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// Operands before users.
    pub nodes: Vec<Node>,
}

impl Program {
    /// The node.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0]
    }

    /// Adds a node, or finds the equal one.
    pub fn add(&mut self, op: Op, kind: ValueKind) -> NodeId {
        if let Some(i) = self.nodes.iter().position(|n| n.op == op && n.kind == kind) {
            return NodeId(i);
        }
        let operands = op.operands();
        let joined =
            || operands.iter().map(|o| self.node(*o).scope).fold(ValueScope::Frame, ValueScope::join);
        let scope = op.own_scope().unwrap_or_else(joined);
        let needs_episode = op.is_of_episode() || operands.iter().any(|o| self.node(*o).needs_episode);
        self.nodes.push(Node { op, kind, scope, needs_episode });
        NodeId(self.nodes.len() - 1)
    }

    /// Names of all signals that `root` reads.
    pub fn signals(&self, root: NodeId) -> BTreeSet<String> {
        self.signals_of([root])
    }

    /// Names of all signals that any of `roots` reads.
    pub fn signals_of(&self, roots: impl IntoIterator<Item = NodeId>) -> BTreeSet<String> {
        self.reached_from(roots).into_iter().filter_map(|id| self.own_signal(id)).collect()
    }

    /// Names of the signals of the object in the first role that `root` reads.
    pub fn signals_of_first(&self, root: NodeId) -> BTreeSet<String> {
        let name = |id: NodeId| match &self.node(id).op {
            Op::Signal(name) if is_of_object(name) => Some(name.clone()),
            _ => None,
        };
        self.reached(root).into_iter().filter_map(name).collect()
    }

    /// True when a node reads a `target.` signal.
    pub fn reads_targets(&self, root: NodeId) -> bool {
        self.signals(root).iter().any(|s| s.starts_with("target."))
    }

    /// Names of all signals that any node reads.
    pub fn all_signals(&self) -> BTreeSet<String> {
        (0..self.nodes.len()).filter_map(|i| self.own_signal(NodeId(i))).collect()
    }

    /// Names of the signals without which it is unknown whether all of `roots` hold: all that they read, except where a
    /// test `x is known` decides in their absence: below the test itself, and in the other parts of its `and`, which is
    /// false without them, or of an `or` with `x is unknown`, which is true.
    pub fn needs(&self, roots: &[NodeId]) -> BTreeSet<String> {
        let mut done = BTreeMap::new();
        self.needs_of_all(roots, &mut done)
    }

    fn needs_of_all(
        &self,
        parts: &[NodeId],
        done: &mut BTreeMap<NodeId, BTreeSet<String>>,
    ) -> BTreeSet<String> {
        let mut needs = BTreeSet::new();
        for part in parts {
            needs.extend(self.needs_of(*part, done));
        }
        for part in parts {
            let tests = match &self.node(*part).op {
                Op::And(inner) => inner.as_slice(),
                _ => std::slice::from_ref(part),
            };
            for test in tests {
                if let Op::Known(of) = self.node(*test).op {
                    needs = &needs - &self.signals(of);
                }
            }
        }
        needs
    }

    fn needs_of(&self, id: NodeId, done: &mut BTreeMap<NodeId, BTreeSet<String>>) -> BTreeSet<String> {
        if let Some(known) = done.get(&id) {
            return known.clone();
        }
        let needs = match &self.node(id).op {
            Op::Known(_) => BTreeSet::new(),
            Op::And(parts) => self.needs_of_all(parts, done),
            Op::Or(parts) => {
                let mut needs = self.needs_of_operands(id, done);
                for part in parts {
                    if let Op::Not(test) = self.node(*part).op
                        && let Op::Known(of) = self.node(test).op
                    {
                        needs = &needs - &self.signals(of);
                    }
                }
                needs
            }
            _ => self.needs_of_operands(id, done),
        };
        done.insert(id, needs.clone());
        needs
    }

    fn needs_of_operands(
        &self,
        id: NodeId,
        done: &mut BTreeMap<NodeId, BTreeSet<String>>,
    ) -> BTreeSet<String> {
        let mut needs: BTreeSet<String> = self.own_signal(id).into_iter().collect();
        for operand in self.node(id).op.operands() {
            needs.extend(self.needs_of(operand, done));
        }
        needs
    }

    /// The signal that a node is, if it is one.
    fn own_signal(&self, id: NodeId) -> Option<String> {
        match &self.node(id).op {
            Op::Signal(name) | Op::SecondSignal(name) | Op::PairSignal { name, .. } => Some(name.clone()),
            _ => None,
        }
    }

    /// True when a comparison of numbers affects the value of `root`.
    pub fn compares_numbers(&self, root: NodeId) -> bool {
        self.reached(root).into_iter().any(|id| matches!(self.node(id).op, Op::Compare { .. }))
    }

    /// A node and all nodes that it reads, each once, ascending.
    fn reached(&self, root: NodeId) -> Vec<NodeId> {
        self.reached_from([root])
    }

    /// The same of several nodes together.
    fn reached_from(&self, roots: impl IntoIterator<Item = NodeId>) -> Vec<NodeId> {
        let mut reached = vec![false; self.nodes.len()];
        roots.into_iter().for_each(|root| reached[root.0] = true);
        // Operands come before their users.
        for at in (0..self.nodes.len()).rev() {
            if reached[at] {
                self.nodes[at].op.each_operand(|of| reached[of.0] = true);
            }
        }
        (0..reached.len()).filter(|at| reached[*at]).map(NodeId).collect()
    }
}

impl Op {
    /// The rows of an operation that are not those of its operands joined.
    pub fn own_scope(&self) -> Option<ValueScope> {
        match self {
            Op::Signal(name) if is_of_object(name) => Some(ValueScope::Target),
            Op::SecondSignal(_) => Some(ValueScope::Second),
            Op::PairSignal { .. } => Some(ValueScope::Pair),
            Op::AtLeast { .. } => Some(ValueScope::Frame),
            Op::AtLeastNear { .. } => Some(ValueScope::Target),
            _ => None,
        }
    }

    /// True for the operations that read an episode's keyframe or match.
    pub fn is_of_episode(&self) -> bool {
        matches!(self, Op::AtKeyframe(_) | Op::InMatch(_) | Op::MatchLeast(_) | Op::MatchGreatest(_))
    }

    /// The nodes it reads.
    pub fn operands(&self) -> Vec<NodeId> {
        let mut operands = Vec::new();
        self.each_operand(|of| operands.push(of));
        operands
    }

    /// Calls `visit` with each node that it reads, in order.
    pub fn each_operand(&self, mut visit: impl FnMut(NodeId)) {
        match self {
            Op::Constant(_) | Op::Truth(_) | Op::Signal(_) | Op::SecondSignal(_) | Op::PairSignal { .. } => {}
            Op::Negate(a)
            | Op::Absolute(a)
            | Op::Least(a, _)
            | Op::Greatest(a, _)
            | Op::Share(a, _)
            | Op::Member(a, _)
            | Op::Known(a)
            | Op::Not(a)
            | Op::For(a, _)
            | Op::Within(a, _)
            | Op::Previously(a, _)
            | Op::Bridge(a, _)
            | Op::AtLeast { of: a, .. }
            | Op::AtLeastNear { of: a, .. }
            | Op::Before(a)
            | Op::AtKeyframe(a)
            | Op::InMatch(a)
            | Op::MatchLeast(a)
            | Op::MatchGreatest(a) => visit(*a),
            Op::Add(a, b) | Op::Subtract(a, b) | Op::Multiply(a, b) | Op::Since(a, b) | Op::Until(a, b) => {
                visit(*a);
                visit(*b);
            }
            Op::Compare { left, right, .. } => {
                visit(*left);
                visit(*right);
            }
            Op::And(all) | Op::Or(all) => all.iter().copied().for_each(visit),
        }
    }
}
