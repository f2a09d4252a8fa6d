//! The values of a plan's nodes on one drive: each is computed once for all rows of the drive or of all its
//! objects, and cut from there. Truth only; margins are computed for episodes alone ([`super::margin`]).

use super::bits::Bits;
use super::compare::pack_all;
use super::layout::{RowLayout, RowSet, Segment};
use super::numbers::Numbers;
use super::plan::Plan;
use super::signals::{NodeValue, Signals};
use super::temporal::{self, Stretches};
use super::threshold::crossed;
use super::truth::Truth;
use super::windows;
use crate::interpret::Moments;
use crate::language::program::{NodeId, Op, Subject, ValueScope};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::signal::is_of_object;

/// Values by node and row set, or what else stands for rows.
type Memo<V, On = RowSet> = RefCell<HashMap<(NodeId, On), V>>;

/// A plan on a drive. Keeps what it has computed.
pub struct Evaluation<'a> {
    pub(super) plan: &'a Plan<'a>,
    pub(super) signals: &'a Signals<'a>,
    /// The rows of the drive and of its objects.
    pub layout: RowLayout,
    of_drive: RefCell<Vec<Option<NodeValue<'a>>>>,
    of_objects: RefCell<Vec<Option<NodeValue<'a>>>>,
    of_pairs: RefCell<Vec<Option<NodeValue<'a>>>>,
    of_one: Memo<NodeValue<'a>>,
    of_pair: Memo<NodeValue<'a>>,
    of_episode: Memo<NodeValue<'a>>,
    pub(super) margins: Memo<Rc<Vec<f64>>>,
    /// Margins of counts, of `since` and of `until` by blocks of rows.
    pub(super) block_margins: Memo<Rc<Vec<f64>>, (RowSet, usize)>,
    /// Standard deviations of frames, repeated for all objects or pairs.
    pub(super) deviations: Memo<Numbers<'a>>,
    pub(super) episode: Cell<Option<Moments>>,
}

impl<'a> Evaluation<'a> {
    /// An evaluation that has computed nothing yet.
    pub fn new(plan: &'a Plan<'a>, signals: &'a Signals<'a>) -> Self {
        let n = plan.nodes.len();
        let layout = RowLayout::new(&signals.times, &signals.targets);
        let layout = match signals.pairs {
            Some(pairs) => layout.with_pairs(pairs),
            None => layout,
        };
        Self {
            plan,
            signals,
            layout,
            of_drive: RefCell::new(vec![None; n]),
            of_objects: RefCell::new(vec![None; n]),
            of_pairs: RefCell::new(vec![None; n]),
            of_one: RefCell::default(),
            of_pair: RefCell::default(),
            of_episode: RefCell::default(),
            margins: RefCell::default(),
            block_margins: RefCell::default(),
            deviations: RefCell::default(),
            episode: Cell::new(None),
        }
    }

    /// Switches to another episode, or to none: values that depend on it are forgotten.
    pub fn set_episode(&self, episode: Option<Moments>) {
        self.episode.set(episode);
        self.of_episode.borrow_mut().clear();
        self.margins.borrow_mut().retain(|(id, _), _| !self.plan.node(*id).needs_episode);
    }

    /// Where a node has its own rows, seen from a row set, and the node that stands for it there. `None` where the role
    /// that it refers to is not taken.
    pub(super) fn home(&self, id: NodeId, row_set: RowSet) -> Option<(NodeId, RowSet)> {
        let node = self.plan.node(id);
        match (node.scope, row_set) {
            (ValueScope::Frame, _) => Some((id, RowSet::Drive)),
            (ValueScope::Target, RowSet::Objects | RowSet::Object(_)) => Some((id, row_set)),
            (ValueScope::Target, RowSet::Pair(target, _)) => Some((id, RowSet::Object(target))),
            (ValueScope::Target, RowSet::Pairs) => Some((id, RowSet::Objects)),
            (ValueScope::Second, RowSet::Pair(_, second)) => Some((node.as_target?, RowSet::Object(second))),
            (ValueScope::Second, RowSet::Pairs) => Some((node.as_target?, RowSet::Objects)),
            (ValueScope::Pair, RowSet::Pair(..) | RowSet::Pairs) => Some((id, row_set)),
            _ => None,
        }
    }

    /// The values of a node on the rows of a row set.
    pub fn value(&self, id: NodeId, row_set: RowSet) -> NodeValue<'a> {
        let Some((own, home)) = self.home(id, row_set) else {
            return NodeValue::Numbers(Numbers::Same(f64::NAN, self.layout.len(row_set)));
        };
        if let Some(done) = self.remembered(id, row_set) {
            return done;
        }
        let value = match (home == row_set, home, row_set) {
            (true, ..) => self.compute(own, home),
            (false, RowSet::Drive, RowSet::Objects | RowSet::Pairs) => {
                self.spread(self.value(own, RowSet::Drive), row_set)
            }
            (false, RowSet::Objects, RowSet::Pairs) => {
                self.spread_to_pairs(&self.value(own, RowSet::Objects), self.plan.node(id).scope)
            }
            _ => {
                let (from, to) = (self.layout.segment(home), self.layout.segment(row_set));
                let start = to.row - from.row.min(to.row);
                self.value(own, home).slice(start..start + to.len)
            }
        };
        self.remember(id, row_set, &value);
        value
    }

    fn remembered(&self, id: NodeId, row_set: RowSet) -> Option<NodeValue<'a>> {
        if self.plan.node(id).needs_episode {
            return self.of_episode.borrow().get(&(id, row_set)).cloned();
        }
        match row_set {
            RowSet::Drive => self.of_drive.borrow()[id.0].clone(),
            RowSet::Objects => self.of_objects.borrow()[id.0].clone(),
            RowSet::Object(i) => {
                if let Some(of_all) = &self.of_objects.borrow()[id.0] {
                    return Some(of_all.slice(self.layout.objects[i].range()));
                }
                self.of_one.borrow().get(&(id, row_set)).cloned()
            }
            RowSet::Pairs => self.of_pairs.borrow()[id.0].clone(),
            RowSet::Pair(a, b) => {
                if let (Some(of_all), Some(i)) = (&self.of_pairs.borrow()[id.0], self.layout.pair(a, b)) {
                    return Some(of_all.slice(self.layout.segments(RowSet::Pairs)[i].range()));
                }
                self.of_pair.borrow().get(&(id, row_set)).cloned()
            }
        }
    }

    /// True where a node's values have been computed for all rows of this kind.
    fn is_at_hand(&self, id: NodeId, row_set: RowSet) -> bool {
        let of_all = match row_set {
            RowSet::Drive => &self.of_drive,
            RowSet::Objects | RowSet::Object(_) => &self.of_objects,
            RowSet::Pairs | RowSet::Pair(..) => &self.of_pairs,
        };
        of_all.borrow()[id.0].is_some()
    }

    /// The values of a node for all objects, where they have been computed.
    pub(super) fn of_all_objects(&self, id: NodeId) -> Option<NodeValue<'a>> {
        self.of_objects.borrow()[id.0].clone()
    }

    fn remember(&self, id: NodeId, row_set: RowSet, value: &NodeValue<'a>) {
        if self.plan.node(id).needs_episode {
            self.of_episode.borrow_mut().insert((id, row_set), value.clone());
            return;
        }
        match row_set {
            RowSet::Drive => self.of_drive.borrow_mut()[id.0] = Some(value.clone()),
            RowSet::Objects => self.of_objects.borrow_mut()[id.0] = Some(value.clone()),
            RowSet::Pairs => self.of_pairs.borrow_mut()[id.0] = Some(value.clone()),
            RowSet::Object(_) => drop(self.of_one.borrow_mut().insert((id, row_set), value.clone())),
            RowSet::Pair(..) => drop(self.of_pair.borrow_mut().insert((id, row_set), value.clone())),
        }
    }

    /// Forgets what was computed for single pairs: there may be very many.
    pub fn forget_pairs(&self) {
        self.of_pair.borrow_mut().clear();
    }

    /// Values of the drive's rows, repeated for each object or pair.
    pub(super) fn spread(&self, of_drive: NodeValue<'a>, row_set: RowSet) -> NodeValue<'a> {
        let n = self.layout.len(row_set);
        let objects = &*self.layout.segments(row_set);
        let bits = |from: &Bits| {
            let mut out = Bits::zeros(n);
            for s in objects {
                out.copy_from(from, s.row..s.row + s.len, s.start);
            }
            Rc::new(out)
        };
        match of_drive {
            NodeValue::Truth(t) => NodeValue::Truth(Truth { yes: bits(&t.yes), known: bits(&t.known) }),
            NodeValue::Numbers(Numbers::Same(x, _)) => NodeValue::Numbers(Numbers::Same(x, n)),
            NodeValue::Numbers(v) => NodeValue::Numbers(Numbers::of(repeated(&v.values(), objects, n))),
            NodeValue::Words(w) => {
                let codes = repeated(w.codes(), objects, n);
                NodeValue::Words(super::signals::Words::of(codes, w.names.clone()))
            }
        }
    }

    /// The numbers of a node; NaN where it has none.
    pub fn numbers(&self, id: NodeId, row_set: RowSet) -> Numbers<'a> {
        match self.value(id, row_set) {
            NodeValue::Numbers(v) => v,
            _ => Numbers::Same(f64::NAN, self.layout.len(row_set)),
        }
    }

    /// The truth of a condition; unknown where the node is not a condition.
    pub fn truth(&self, id: NodeId, row_set: RowSet) -> Truth {
        match self.value(id, row_set) {
            NodeValue::Truth(t) => t,
            _ => Truth::unknown(self.layout.len(row_set)),
        }
    }

    fn compute(&self, id: NodeId, row_set: RowSet) -> NodeValue<'a> {
        let n = self.layout.len(row_set);
        let node = self.plan.node(id);
        let numbers = |id: &NodeId| self.numbers(*id, row_set);
        let truth = |id: &NodeId| self.truth(*id, row_set);
        let segments = self.layout.segments(row_set);
        let on = Stretches { rows: &self.layout.rows, segments: &segments };
        match &node.op {
            Op::Constant(x) => NodeValue::Numbers(Numbers::Same(*x, n)),
            Op::Signal(name) => self
                .signals
                .value(name, &self.layout, row_set)
                .unwrap_or(NodeValue::Numbers(Numbers::Same(f64::NAN, n))),
            Op::PairSignal { name, seen_from } => self.pair_signal(id, name, *seen_from, row_set),
            // Its rows are always those of its twin.
            Op::SecondSignal(_) => NodeValue::Numbers(Numbers::Same(f64::NAN, n)),
            Op::Negate(a) => NodeValue::Numbers(numbers(a).map(|x| -x)),
            Op::Absolute(a) => NodeValue::Numbers(numbers(a).map(f64::abs)),
            Op::Add(a, b) => NodeValue::Numbers(numbers(a).zip(&numbers(b), |x, y| x + y)),
            Op::Subtract(a, b) => NodeValue::Numbers(numbers(a).zip(&numbers(b), |x, y| x - y)),
            Op::Multiply(a, b) => NodeValue::Numbers(numbers(a).zip(&numbers(b), |x, y| x * y)),
            Op::Least(a, d) => NodeValue::Numbers(windows::past_extreme(&numbers(a), on, *d, |x, y| x < y)),
            Op::Greatest(a, d) => {
                NodeValue::Numbers(windows::past_extreme(&numbers(a), on, *d, |x, y| x > y))
            }
            Op::Share(c, d) => NodeValue::Numbers(windows::past_share(&truth(c), on, *d)),
            Op::MatchLeast(a) => self.extreme_in_match(*a, row_set, f64::min),
            Op::MatchGreatest(a) => self.extreme_in_match(*a, row_set, f64::max),
            Op::AtKeyframe(a) => self.at_keyframe(*a, row_set),
            Op::Truth(b) => NodeValue::Truth(Truth::constant(*b, n)),
            Op::Compare { op, left, right, .. } => {
                let (a, b) = (numbers(left), numbers(right));
                NodeValue::Truth(match self.noise_of_difference(*op, *left, *right, row_set) {
                    Some(noise) => crossed(*op, (&a, &b), noise, &segments),
                    None => a.compare(*op, &b),
                })
            }
            Op::Member(a, words) => NodeValue::Truth(member(&self.value(*a, row_set), words, n)),
            Op::Known(a) => NodeValue::Truth(Truth::certain(known(&self.value(*a, row_set)))),
            Op::Not(a) => NodeValue::Truth(truth(a).negated()),
            Op::And(all) => NodeValue::Truth(self.conjunction(all, row_set)),
            Op::Or(all) => NodeValue::Truth(self.disjunction(all, row_set)),
            Op::For(a, d) => NodeValue::Truth(temporal::held_for(&truth(a), on, *d)),
            Op::Within(a, d) => NodeValue::Truth(temporal::within(&truth(a), on, *d)),
            Op::Previously(a, Some(d)) => NodeValue::Truth(temporal::previously(&truth(a), on, *d)),
            Op::Previously(a, None) => NodeValue::Truth(temporal::ever_before(&truth(a), on)),
            Op::Since(a, b) => NodeValue::Truth(temporal::since(&truth(a), &truth(b), on)),
            Op::Until(a, b) => NodeValue::Truth(temporal::until(&truth(a), &truth(b), on)),
            Op::Bridge(a, d) => NodeValue::Truth(temporal::bridged(&truth(a), on, *d)),
            Op::AtLeast { of, count, subject } => NodeValue::Truth(self.at_least(*of, *count, *subject)),
            Op::AtLeastNear { of, count, subject } => {
                NodeValue::Truth(self.at_least_near(*of, (*count, *subject), row_set))
            }
            Op::Before(a) => NodeValue::Truth(temporal::before(&truth(a), on)),
            Op::InMatch(a) => NodeValue::Truth(self.in_match(*a, row_set)),
        }
    }

    /// Operands with fewer rows come first, then those that are at hand, then those that cost less: often they decide
    /// the result, and the rest is never computed.
    fn in_order<'n>(&self, all: &'n [NodeId], row_set: RowSet) -> impl Iterator<Item = &'n NodeId> {
        let mut all: Vec<&NodeId> = all.iter().collect();
        all.sort_by_cached_key(|id| {
            let node = self.plan.node(**id);
            (node.scope, !self.is_at_hand(**id, row_set), node.cost)
        });
        all.into_iter()
    }

    /// Kleene conjunction of these conditions on the rows of a row set.
    pub fn conjunction(&self, all: &[NodeId], row_set: RowSet) -> Truth {
        let mut out = Truth::constant(true, self.layout.len(row_set));
        for id in self.in_order(all, row_set) {
            out = if out.is_everywhere() {
                self.truth(*id, row_set)
            } else {
                out.and(&self.truth(*id, row_set))
            };
            if out.is_nowhere() {
                break;
            }
        }
        out
    }

    fn disjunction(&self, all: &[NodeId], row_set: RowSet) -> Truth {
        let mut out = Truth::constant(false, self.layout.len(row_set));
        for id in self.in_order(all, row_set) {
            out = if out.is_nowhere() { self.truth(*id, row_set) } else { out.or(&self.truth(*id, row_set)) };
            if out.is_everywhere() {
                break;
            }
        }
        out
    }

    /// At least `count` of the objects that are observed at a frame meet the condition: one counter per row.
    fn at_least(&self, of: NodeId, count: usize, subject: Subject) -> Truth {
        let n = self.layout.rows.len();
        if !self.counts_can_be_told(of) {
            return Truth::unknown(n);
        }
        let (mut sure, mut possible) = (vec![0u32; n], vec![0u32; n]);
        for (i, object) in self.layout.objects.iter().enumerate() {
            if !subject.admits(self.signals.targets[i].class) {
                continue;
            }
            let truth = self.truth_of_object(of, i);
            for (counters, bits) in [(&mut sure, &*truth.yes), (&mut possible, &truth.possible())] {
                bits.positions(0..object.len).for_each(|k| counters[object.row + k] += 1);
            }
        }
        let enough = |counters: &[u32], hole: bool| {
            Bits::collect(n, |i| match self.layout.rows[i].frame {
                Some(_) => counters[i] as usize >= count,
                // In a gap nothing is observed, so nothing is known.
                None => hole,
            })
        };
        Truth::bounded(enough(&sure, false), &enough(&possible, true))
    }

    /// False where a signal of the condition is missing: then even the absence of objects is unknown.
    pub(super) fn counts_can_be_told(&self, of: NodeId) -> bool {
        let mut todo = vec![of];
        while let Some(id) = todo.pop() {
            match &self.plan.node(id).op {
                Op::Signal(name) if is_of_object(name) && !self.signals.present.contains_key(name) => {
                    return false;
                }
                op => todo.extend(op.operands()),
            }
        }
        true
    }

    /// Of a condition about the target; all objects are computed at once unless it depends on an episode.
    pub(super) fn truth_of_object(&self, of: NodeId, object: usize) -> Truth {
        if !self.plan.node(of).needs_episode {
            self.truth(of, RowSet::Objects);
        }
        self.truth(of, RowSet::Object(object))
    }

    fn at_keyframe(&self, of: NodeId, row_set: RowSet) -> NodeValue<'a> {
        let n = self.layout.len(row_set);
        let row = self.keyframe_row(row_set);
        match self.value(of, row_set) {
            NodeValue::Truth(t) => {
                NodeValue::Truth(match row.map(|r| t.at(r)).and_then(whyroad_model::Tri::known) {
                    Some(value) => Truth::constant(value, n),
                    None => Truth::unknown(n),
                })
            }
            NodeValue::Numbers(v) => NodeValue::Numbers(Numbers::Same(row.map_or(f64::NAN, |r| v.at(r)), n)),
            NodeValue::Words(w) => {
                let code = row.map_or(UNKNOWN_CODE, |r| w.codes()[r]);
                NodeValue::Words(super::signals::Words::of(vec![code; n], w.names.clone()))
            }
        }
    }

    /// The keyframe as a row of a row set.
    pub(super) fn keyframe_row(&self, row_set: RowSet) -> Option<usize> {
        self.layout.position(row_set, self.episode.get()?.keyframe)
    }

    /// Rows of a row set from the first to the last frame of the match.
    pub(super) fn match_rows(&self, row_set: RowSet) -> Option<std::ops::Range<usize>> {
        let matched = self.episode.get()?.matched;
        let from = self.layout.position(row_set, matched.start)?;
        let to = self.layout.position(row_set, matched.end.checked_sub(1)?)?;
        (from <= to).then_some(from..to + 1)
    }

    fn in_match(&self, of: NodeId, row_set: RowSet) -> Truth {
        let n = self.layout.len(row_set);
        let Some(rows) = self.match_rows(row_set) else { return Truth::unknown(n) };
        let c = self.truth(of, row_set);
        if c.yes.any_in(rows.clone()) {
            Truth::constant(true, n)
        } else if c.known.count_in(rows.clone()) == rows.len() {
            Truth::constant(false, n)
        } else {
            Truth::unknown(n)
        }
    }

    fn extreme_in_match(&self, of: NodeId, row_set: RowSet, pick: fn(f64, f64) -> f64) -> NodeValue<'a> {
        let v = self.numbers(of, row_set);
        let known = self.match_rows(row_set).into_iter().flatten().map(|i| v.at(i)).filter(|x| !x.is_nan());
        NodeValue::Numbers(Numbers::Same(known.reduce(pick).unwrap_or(f64::NAN), v.len()))
    }
}

fn member(of: &NodeValue<'_>, words: &[String], n: usize) -> Truth {
    let NodeValue::Words(of) = of else { return Truth::unknown(n) };
    let wanted: Vec<bool> = of.names.iter().map(|name| words.contains(name)).collect();
    let yes = pack_all(of.codes(), |c| wanted.get(usize::from(c)).copied().unwrap_or(false));
    Truth::new(yes, pack_all(of.codes(), |c| usize::from(c) < wanted.len()))
}

fn known(of: &NodeValue<'_>) -> Bits {
    match of {
        NodeValue::Truth(t) => (*t.known).clone(),
        NodeValue::Numbers(v) => (*v.known()).clone(),
        NodeValue::Words(w) => pack_all(w.codes(), |c| c != UNKNOWN_CODE),
    }
}

/// The rows of `of_drive` during which each object is there, one object after the other; `n` rows.
fn repeated<T: Copy>(of_drive: &[T], objects: &[Segment], n: usize) -> Vec<T> {
    let mut all = Vec::with_capacity(n);
    objects.iter().for_each(|s| all.extend_from_slice(&of_drive[s.row..s.row + s.len]));
    all
}
