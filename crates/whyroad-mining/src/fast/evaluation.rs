//! The values of a plan's nodes on one drive: each is computed once for all rows of the drive or of all its
//! objects, and cut from there. Truth only; margins are computed for episodes alone ([`super::margin`]).

use super::bits::Bits;
use super::compare::pack_all;
use super::numbers::Numbers;
use super::places::{Place, Places};
use super::plan::Plan;
use super::signals::{Signals, Value};
use super::temporal::{self, Stretches};
use super::truth::Truth;
use super::windows;
use crate::evaluate::Moments;
use crate::language::program::{NodeId, Op, Scope, Subject};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;
use whyroad_model::column::UNKNOWN_CODE;

/// Values by node and place.
type Memo<V> = RefCell<HashMap<(NodeId, Place), V>>;

/// A plan on a drive. Keeps what it has computed.
pub struct Evaluation<'a> {
    pub(super) plan: &'a Plan<'a>,
    pub(super) signals: &'a Signals<'a>,
    /// The rows of the drive and of its objects.
    pub places: Places,
    of_drive: RefCell<Vec<Option<Value<'a>>>>,
    of_objects: RefCell<Vec<Option<Value<'a>>>>,
    of_one: Memo<Value<'a>>,
    of_pair: Memo<Value<'a>>,
    of_episode: Memo<Value<'a>>,
    pub(super) margins: Memo<Rc<Vec<f64>>>,
    pub(super) episode: Cell<Option<Moments>>,
}

impl<'a> Evaluation<'a> {
    /// An evaluation that has computed nothing yet.
    pub fn new(plan: &'a Plan<'a>, signals: &'a Signals<'a>) -> Self {
        let n = plan.nodes.len();
        Self {
            plan,
            signals,
            places: Places::new(&signals.times, &signals.targets),
            of_drive: RefCell::new(vec![None; n]),
            of_objects: RefCell::new(vec![None; n]),
            of_one: RefCell::default(),
            of_pair: RefCell::default(),
            of_episode: RefCell::default(),
            margins: RefCell::default(),
            episode: Cell::new(None),
        }
    }

    /// Turns to another episode, or to none: values that depend on it are forgotten.
    pub fn set_episode(&self, episode: Option<Moments>) {
        self.episode.set(episode);
        self.of_episode.borrow_mut().clear();
        self.margins.borrow_mut().retain(|(id, _), _| !self.plan.node(*id).needs_episode);
    }

    /// Where a node has its own rows, seen from a place, and the node that stands for it there. `None` where
    /// nobody has the role that it speaks of.
    pub(super) fn home(&self, id: NodeId, place: Place) -> Option<(NodeId, Place)> {
        let node = self.plan.node(id);
        match (node.scope, place) {
            (Scope::Frame, _) => Some((id, Place::Drive)),
            (Scope::Target, Place::Objects | Place::Object(_)) => Some((id, place)),
            (Scope::Target, Place::Pair(target, _)) => Some((id, Place::Object(target))),
            (Scope::Second, Place::Pair(_, second)) => Some((node.as_target?, Place::Object(second))),
            (Scope::Pair, Place::Pair(..)) => Some((id, place)),
            _ => None,
        }
    }

    /// The values of a node on the rows of a place.
    pub fn value(&self, id: NodeId, place: Place) -> Value<'a> {
        let Some((own, home)) = self.home(id, place) else {
            return Value::Numbers(Numbers::Same(f64::NAN, self.places.len(place)));
        };
        if let Some(done) = self.remembered(id, place) {
            return done;
        }
        let value = match (home == place, home, place) {
            (true, ..) => self.compute(own, home),
            (false, Place::Drive, Place::Objects) => self.spread(self.value(own, Place::Drive)),
            _ => {
                let (from, to) = (self.places.segment(home), self.places.segment(place));
                let start = to.row - from.row.min(to.row);
                self.value(own, home).slice(start..start + to.len)
            }
        };
        self.remember(id, place, &value);
        value
    }

    fn remembered(&self, id: NodeId, place: Place) -> Option<Value<'a>> {
        if self.plan.node(id).needs_episode {
            return self.of_episode.borrow().get(&(id, place)).cloned();
        }
        match place {
            Place::Drive => self.of_drive.borrow()[id.0].clone(),
            Place::Objects => self.of_objects.borrow()[id.0].clone(),
            Place::Object(i) => {
                if let Some(of_all) = &self.of_objects.borrow()[id.0] {
                    return Some(of_all.slice(self.places.objects[i].range()));
                }
                self.of_one.borrow().get(&(id, place)).cloned()
            }
            Place::Pair(..) => self.of_pair.borrow().get(&(id, place)).cloned(),
        }
    }

    /// The values of a node for all objects, where they have been computed.
    pub(super) fn of_all_objects(&self, id: NodeId) -> Option<Value<'a>> {
        self.of_objects.borrow()[id.0].clone()
    }

    fn remember(&self, id: NodeId, place: Place, value: &Value<'a>) {
        if self.plan.node(id).needs_episode {
            self.of_episode.borrow_mut().insert((id, place), value.clone());
            return;
        }
        match place {
            Place::Drive => self.of_drive.borrow_mut()[id.0] = Some(value.clone()),
            Place::Objects => self.of_objects.borrow_mut()[id.0] = Some(value.clone()),
            Place::Object(_) => drop(self.of_one.borrow_mut().insert((id, place), value.clone())),
            Place::Pair(..) => drop(self.of_pair.borrow_mut().insert((id, place), value.clone())),
        }
    }

    /// Forgets what was computed for single pairs: there may be very many.
    pub fn forget_pairs(&self) {
        self.of_pair.borrow_mut().clear();
    }

    /// Values of the drive's rows, repeated for each object.
    fn spread(&self, of_drive: Value<'a>) -> Value<'a> {
        let n = self.places.object_rows;
        let objects = &self.places.objects;
        let bits = |from: &Bits| {
            let mut out = Bits::zeros(n);
            for s in objects {
                out.copy_from(from, s.row..s.row + s.len, s.start);
            }
            Rc::new(out)
        };
        match of_drive {
            Value::Truth(t) => Value::Truth(Truth { yes: bits(&t.yes), known: bits(&t.known) }),
            Value::Numbers(Numbers::Same(x, _)) => Value::Numbers(Numbers::Same(x, n)),
            Value::Numbers(v) => {
                let v = v.values();
                let all = objects.iter().flat_map(|s| v[s.row..s.row + s.len].iter().copied());
                Value::Numbers(Numbers::of(all.collect::<Vec<_>>()))
            }
            Value::Words(w) => {
                let codes = w.codes();
                let all = objects.iter().flat_map(|s| codes[s.row..s.row + s.len].iter().copied());
                Value::Words(super::signals::Words::of(all.collect(), w.names.clone()))
            }
        }
    }

    /// The numbers of a node; NaN where it has none.
    pub fn numbers(&self, id: NodeId, place: Place) -> Numbers<'a> {
        match self.value(id, place) {
            Value::Numbers(v) => v,
            _ => Numbers::Same(f64::NAN, self.places.len(place)),
        }
    }

    /// The truth of a condition; unknown where the node is none.
    pub fn truth(&self, id: NodeId, place: Place) -> Truth {
        match self.value(id, place) {
            Value::Truth(t) => t,
            _ => Truth::unknown(self.places.len(place)),
        }
    }

    fn compute(&self, id: NodeId, place: Place) -> Value<'a> {
        let n = self.places.len(place);
        let node = self.plan.node(id);
        let numbers = |id: &NodeId| self.numbers(*id, place);
        let truth = |id: &NodeId| self.truth(*id, place);
        let segments = self.places.segments(place);
        let on = Stretches { rows: &self.places.rows, segments: &segments };
        match &node.op {
            Op::Constant(x) => Value::Numbers(Numbers::Same(*x, n)),
            Op::Signal(name) => self
                .signals
                .value(name, &self.places, place)
                .unwrap_or(Value::Numbers(Numbers::Same(f64::NAN, n))),
            // Its rows are always those of its twin.
            Op::SecondSignal(_) => Value::Numbers(Numbers::Same(f64::NAN, n)),
            Op::Negate(a) => Value::Numbers(numbers(a).map(|x| -x)),
            Op::Absolute(a) => Value::Numbers(numbers(a).map(f64::abs)),
            Op::Add(a, b) => Value::Numbers(numbers(a).zip(&numbers(b), |x, y| x + y)),
            Op::Subtract(a, b) => Value::Numbers(numbers(a).zip(&numbers(b), |x, y| x - y)),
            Op::Multiply(a, b) => Value::Numbers(numbers(a).zip(&numbers(b), |x, y| x * y)),
            Op::Least(a, d) => Value::Numbers(windows::past_extreme(&numbers(a), on, *d, |x, y| x < y)),
            Op::Greatest(a, d) => Value::Numbers(windows::past_extreme(&numbers(a), on, *d, |x, y| x > y)),
            Op::Share(c, d) => Value::Numbers(windows::past_share(&truth(c), on, *d)),
            Op::MatchLeast(a) => self.extreme_in_match(*a, place, f64::min),
            Op::MatchGreatest(a) => self.extreme_in_match(*a, place, f64::max),
            Op::AtKeyframe(a) => self.at_keyframe(*a, place),
            Op::Truth(b) => Value::Truth(Truth::constant(*b, n)),
            Op::Compare { op, left, right, .. } => Value::Truth(numbers(left).compare(*op, &numbers(right))),
            Op::Member(a, words) => Value::Truth(member(&self.value(*a, place), words, n)),
            Op::Known(a) => Value::Truth(Truth::certain(known(&self.value(*a, place)))),
            Op::Not(a) => Value::Truth(truth(a).negated()),
            Op::And(all) => Value::Truth(self.conjunction(all, place)),
            Op::Or(all) => Value::Truth(self.disjunction(all, place)),
            Op::For(a, d) => Value::Truth(temporal::held_for(&truth(a), on, *d)),
            Op::Within(a, d) => Value::Truth(temporal::within(&truth(a), on, *d)),
            Op::Previously(a, Some(d)) => Value::Truth(temporal::previously(&truth(a), on, *d)),
            Op::Previously(a, None) => Value::Truth(temporal::ever_before(&truth(a), on)),
            Op::Since(a, b) => Value::Truth(temporal::since(&truth(a), &truth(b), on)),
            Op::Until(a, b) => Value::Truth(temporal::until(&truth(a), &truth(b), on)),
            Op::Bridge(a, d) => Value::Truth(temporal::bridged(&truth(a), on, *d)),
            Op::AtLeast { of, count, subject } => Value::Truth(self.at_least(*of, *count, *subject)),
            Op::Before(a) => Value::Truth(temporal::before(&truth(a), on)),
            Op::InMatch(a) => Value::Truth(self.in_match(*a, place)),
        }
    }

    /// What has fewer rows comes first: often it settles the whole, and the rest is never computed.
    fn in_order<'n>(&self, all: &'n [NodeId]) -> impl Iterator<Item = &'n NodeId> {
        let mut all: Vec<&NodeId> = all.iter().collect();
        all.sort_by_key(|id| self.plan.node(**id).scope);
        all.into_iter()
    }

    /// Kleene conjunction of these conditions on the rows of a place.
    pub fn conjunction(&self, all: &[NodeId], place: Place) -> Truth {
        let mut out = Truth::constant(true, self.places.len(place));
        for id in self.in_order(all) {
            out = if out.is_everywhere() { self.truth(*id, place) } else { out.and(&self.truth(*id, place)) };
            if out.is_nowhere() {
                break;
            }
        }
        out
    }

    fn disjunction(&self, all: &[NodeId], place: Place) -> Truth {
        let mut out = Truth::constant(false, self.places.len(place));
        for id in self.in_order(all) {
            out = if out.is_nowhere() { self.truth(*id, place) } else { out.or(&self.truth(*id, place)) };
            if out.is_everywhere() {
                break;
            }
        }
        out
    }

    /// At least `count` of the objects that are seen at a frame meet the condition: a counter a row.
    fn at_least(&self, of: NodeId, count: usize, subject: Subject) -> Truth {
        let n = self.places.rows.len();
        if !self.counts_can_be_told(of) {
            return Truth::unknown(n);
        }
        let (mut sure, mut possible) = (vec![0u32; n], vec![0u32; n]);
        for (i, object) in self.places.objects.iter().enumerate() {
            if !subject.admits(self.signals.targets[i].class) {
                continue;
            }
            let truth = self.truth_of_object(of, i);
            for (counters, bits) in [(&mut sure, &*truth.yes), (&mut possible, &truth.possible())] {
                bits.positions(0..object.len).for_each(|k| counters[object.row + k] += 1);
            }
        }
        let enough = |counters: &[u32], hole: bool| {
            Bits::collect(n, |i| match self.places.rows[i].frame {
                Some(_) => counters[i] as usize >= count,
                // In a gap nothing is seen, and nothing known.
                None => hole,
            })
        };
        Truth::bounded(enough(&sure, false), &enough(&possible, true))
    }

    /// False where a signal of the condition is lacking: not even that there are no objects could be told.
    pub(super) fn counts_can_be_told(&self, of: NodeId) -> bool {
        let mut todo = vec![of];
        while let Some(id) = todo.pop() {
            match &self.plan.node(id).op {
                Op::Signal(name)
                    if name.starts_with("target.") && !self.signals.present.contains_key(name) =>
                {
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
            self.truth(of, Place::Objects);
        }
        self.truth(of, Place::Object(object))
    }

    fn at_keyframe(&self, of: NodeId, place: Place) -> Value<'a> {
        let n = self.places.len(place);
        let row = self.keyframe_row(place);
        match self.value(of, place) {
            Value::Truth(t) => Value::Truth(match row.map(|r| t.at(r)).and_then(whyroad_model::Tri::known) {
                Some(value) => Truth::constant(value, n),
                None => Truth::unknown(n),
            }),
            Value::Numbers(v) => Value::Numbers(Numbers::Same(row.map_or(f64::NAN, |r| v.at(r)), n)),
            Value::Words(w) => {
                let code = row.map_or(UNKNOWN_CODE, |r| w.codes()[r]);
                Value::Words(super::signals::Words::of(vec![code; n], w.names.clone()))
            }
        }
    }

    /// The keyframe as a row of a place.
    pub(super) fn keyframe_row(&self, place: Place) -> Option<usize> {
        self.places.position(place, self.episode.get()?.keyframe)
    }

    /// Rows of a place from the first to the last frame of the match.
    pub(super) fn match_rows(&self, place: Place) -> Option<std::ops::Range<usize>> {
        let matched = self.episode.get()?.matched;
        let from = self.places.position(place, matched.start)?;
        let to = self.places.position(place, matched.end.checked_sub(1)?)?;
        (from <= to).then_some(from..to + 1)
    }

    fn in_match(&self, of: NodeId, place: Place) -> Truth {
        let n = self.places.len(place);
        let Some(rows) = self.match_rows(place) else { return Truth::unknown(n) };
        let c = self.truth(of, place);
        if c.yes.any_in(rows.clone()) {
            Truth::constant(true, n)
        } else if c.known.count_in(rows.clone()) == rows.len() {
            Truth::constant(false, n)
        } else {
            Truth::unknown(n)
        }
    }

    fn extreme_in_match(&self, of: NodeId, place: Place, pick: fn(f64, f64) -> f64) -> Value<'a> {
        let v = self.numbers(of, place);
        let known = self.match_rows(place).into_iter().flatten().map(|i| v.at(i)).filter(|x| !x.is_nan());
        Value::Numbers(Numbers::Same(known.reduce(pick).unwrap_or(f64::NAN), v.len()))
    }
}

fn member(of: &Value<'_>, words: &[String], n: usize) -> Truth {
    let Value::Words(of) = of else { return Truth::unknown(n) };
    let wanted: Vec<bool> = of.names.iter().map(|name| words.contains(name)).collect();
    let yes = pack_all(of.codes(), |c| wanted.get(usize::from(c)).copied().unwrap_or(false));
    Truth::new(yes, pack_all(of.codes(), |c| usize::from(c) < wanted.len()))
}

fn known(of: &Value<'_>) -> Bits {
    match of {
        Value::Truth(t) => (*t.known).clone(),
        Value::Numbers(v) => (*v.known()).clone(),
        Value::Words(w) => pack_all(w.codes(), |c| c != UNKNOWN_CODE),
    }
}
