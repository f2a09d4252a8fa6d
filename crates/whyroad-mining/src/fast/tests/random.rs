//! Random signal tables and random rules. A program is built by instructions that take their operands from earlier
//! results, so that all kinds of operations are combined.

use crate::language::program::{Moment, NodeId, Op, PairSide, Program, Subject, ValueKind, ValueScope};
use crate::language::syntax::CompareOp;
use crate::rule::{Listed, ResponseCondition, Rule, SecondRole, Timing};
use proptest::prelude::*;
use std::collections::BTreeMap;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::pair::{PairSpan, PairTable};
use whyroad_model::signal::{TargetSpan, deviation_name};
use whyroad_model::units::{Dimension, Unit};
use whyroad_model::{Bilingual, Column, FrameRange, Nanos, ObjectClass, SignalTable, Tri};

/// `n` numbers, `f` flags, `c` categories; `x` is a number that some drives lack.
const NAMES: [&str; 4] = ["n", "f", "c", "x"];
const WORDS: [&str; 3] = ["left", "right", "none"];

/// Runs of values, as signals have them; some are so long that a value within noise of a threshold decides
/// (`crate::deviation::ROWS_ACROSS`).
fn runs<T: Clone + std::fmt::Debug + 'static>(
    value: impl Strategy<Value = T> + 'static,
) -> impl Strategy<Value = Vec<T>> {
    let long = prop_oneof![12 => 1usize..9, 1 => 18usize..30];
    prop::collection::vec((value, long), 1..24)
        .prop_map(|runs| runs.into_iter().flat_map(|(v, n)| std::iter::repeat_n(v, n)).collect())
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => (-3i32..4).prop_map(|x| f64::from(x) / 2.0),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
    ]
}

fn tri() -> impl Strategy<Value = Tri> {
    prop_oneof![3 => Just(Tri::True), 3 => Just(Tri::False), 1 => Just(Tri::Unknown)]
}

fn code() -> impl Strategy<Value = u16> {
    prop_oneof![6 => 0u16..3, 1 => Just(UNKNOWN_CODE)]
}

/// Enough values of each kind for a table; taken in turn.
fn stock() -> impl Strategy<Value = (Vec<f64>, Vec<Tri>, Vec<u16>)> {
    (runs(number()), runs(tri()), runs(code()))
}

fn taken<T: Copy>(from: &[T], skip: usize, n: usize) -> Vec<T> {
    from.iter().copied().cycle().skip(skip).take(n).collect()
}

type Stock = (Vec<f64>, Vec<Tri>, Vec<u16>);

fn columns(
    prefix: &str,
    (numbers, flags, codes): &Stock,
    rows: usize,
    lacks: bool,
) -> BTreeMap<String, Column> {
    let names: std::sync::Arc<[String]> = WORDS.map(str::to_owned).to_vec().into();
    let all = [
        Column::Number(taken(numbers, 0, rows)),
        Column::Flag(taken(flags, 0, rows)),
        Column::Category { codes: taken(codes, 0, rows), names },
        Column::Number(taken(numbers, 7, rows)),
    ];
    let named = NAMES.iter().zip(all).filter(|(n, _)| **n != "x" || !lacks);
    let mut out: BTreeMap<String, Column> = named.map(|(n, c)| (format!("{prefix}.{n}"), c)).collect();
    // Half of the drives are noisy in one of their numbers, a few in both; deviations may be zero or unknown.
    for (name, every) in [("n", 2), ("x", 5)] {
        let own = format!("{prefix}.{name}");
        if numbers.len() % every == 0 && out.contains_key(&own) {
            let noise = taken(numbers, 3, rows).into_iter().map(f64::abs).collect();
            out.insert(deviation_name(&own), Column::Number(noise));
        }
    }
    out
}

/// A table of 1 to 90 frames with up to five objects.
pub fn table() -> impl Strategy<Value = SignalTable> {
    let step = prop_oneof![12 => 98i64..=102, 1 => 200i64..900, 1 => 1i64..40];
    let object = (0usize..90, 1usize..90, 0usize..4);
    let lacks = (any::<bool>(), any::<bool>());
    // Half of the tables have pairs; which pairs, and when they are near, is taken from the flags.
    let pairs = (any::<bool>(), stock(), 0usize..24);
    (
        prop::collection::vec(step, 1..90),
        prop::collection::vec(object, 0..6),
        stock(),
        stock(),
        (lacks, pairs),
    )
        .prop_map(|(steps, objects, of_frames, of_targets, (lacks, (paired, of_pairs, skip)))| {
            let mut now = 1_700_000_000_000i64;
            let times: Vec<Nanos> = steps
                .iter()
                .map(|ms| {
                    now += ms;
                    Nanos(now * 1_000_000)
                })
                .collect();
            let mut first_row = 0;
            let classes =
                [ObjectClass::Car, ObjectClass::Truck, ObjectClass::Pedestrian, ObjectClass::Bicycle];
            let mut targets = Vec::new();
            for (i, (from, len, class)) in objects.into_iter().enumerate() {
                let from = from % times.len();
                let frames = FrameRange::new(from, (from + len).min(times.len()));
                targets.push(TargetSpan {
                    id: format!("t{i}").as_str().into(),
                    class: classes[class],
                    first_row,
                    frames,
                });
                first_row += frames.len();
            }
            let mut target_columns = columns("target", &of_targets, first_row, lacks.1);
            if paired && skip % 2 == 0 {
                let observed = taken(&of_targets.1, skip, first_row).into_iter();
                let observed = observed.map(|t| Tri::from(t != Tri::Unknown)).collect();
                target_columns.insert("object.observed".to_owned(), Column::Flag(observed));
            }
            let frame_columns = columns("ego", &of_frames, times.len(), lacks.0);
            // Of some drives a signal is known only where other data proves it.
            let first = frame_columns.keys().next().filter(|_| skip % 3 == 0);
            let partial =
                first.map(|name| (name.clone(), vec![whyroad_model::Need::Map])).into_iter().collect();
            SignalTable {
                drive_id: "random".into(),
                partial,
                without_boxes: [].into(),
                frame_columns,
                target_columns,
                pairs: paired.then(|| pairs_of(&targets, &of_pairs, skip)),
                times,
                targets,
                unavailable: BTreeMap::new(),
            }
        })
}

/// Pairs of some of these objects, each in both orders over the same frames.
fn pairs_of(targets: &[TargetSpan], of: &Stock, skip: usize) -> PairTable {
    let mut found = BTreeMap::new();
    for (i, a) in targets.iter().enumerate() {
        for (k, b) in targets.iter().enumerate().skip(i + 1) {
            let both = a.frames.intersect(b.frames);
            let near: Vec<bool> =
                taken(&of.1, skip + 5 * i + 3 * k, both.len()).into_iter().map(|t| t == Tri::True).collect();
            let first = near.iter().position(|n| *n);
            let Some((first, last)) = first.zip(near.iter().rposition(|n| *n)) else { continue };
            let frames = FrameRange::new(both.start + first, both.start + last + 1);
            for key in [(i, k), (k, i)] {
                found.insert(key, (frames, near[first..=last].to_vec()));
            }
        }
    }
    let mut table = PairTable::default();
    for ((first, second), (frames, near)) in found {
        table.spans.push(PairSpan { first, second, first_row: table.near.len(), frames });
        table.near.extend(near);
    }
    table.columns = columns("pair", of, table.near.len(), skip.is_multiple_of(3));
    table
}

fn duration() -> impl Strategy<Value = Nanos> {
    // Also shorter than a frame, and such that the clock's tolerance decides.
    prop_oneof![Just(0), Just(50), (1i64..20).prop_map(|k| k * 100), (1i64..20).prop_map(|k| k * 100 + 50)]
        .prop_map(|ms| Nanos(ms * 1_000_000))
}

/// An operation, two operands, a number.
type Instruction = (usize, usize, usize, i32, Nanos);

/// What has been built so far, by type.
struct Pool {
    program: Program,
    numbers: Vec<NodeId>,
    conditions: Vec<NodeId>,
    /// How many objects the rule binds.
    roles: usize,
}

const NUMBER: ValueKind = ValueKind::Number(Dimension::Speed);

impl Pool {
    /// The signals and a constant.
    fn new(roles: usize) -> Self {
        let mut pool = Pool { program: Program::default(), numbers: vec![], conditions: vec![], roles };
        let words = || ValueKind::Category(WORDS.map(str::to_owned).to_vec());
        let signal = |prefix: &str, name: &str, second: bool| {
            let name = format!("{prefix}.{name}");
            match (prefix, second) {
                ("pair", false) => Op::PairSignal { name, seen_from: PairSide::First },
                ("pair", true) => Op::PairSignal { name, seen_from: PairSide::Second },
                (_, false) => Op::Signal(name),
                (_, true) => Op::SecondSignal(name),
            }
        };
        // A rule about one object refers to others where it counts those near it.
        let all = [("ego", false), ("target", false), ("target", true), ("pair", false), ("pair", true)];
        for (prefix, second) in all.into_iter().take(if roles == 0 { 1 } else { 5 }) {
            for name in ["n", "x"] {
                let id = pool.program.add(signal(prefix, name, second), NUMBER);
                pool.numbers.push(id);
            }
            let flag = pool.program.add(signal(prefix, "f", second), ValueKind::Condition);
            let category = pool.program.add(signal(prefix, "c", second), words());
            let member = Op::Member(category, vec!["left".into(), "none".into()]);
            let known = pool.program.add(Op::Known(category), ValueKind::Condition);
            let member = pool.program.add(member, ValueKind::Condition);
            pool.conditions.extend([flag, member, known]);
        }
        pool
    }

    fn number(&self, i: usize) -> NodeId {
        self.numbers[i % self.numbers.len()]
    }

    fn condition(&self, i: usize) -> NodeId {
        // Recent results are used most often, so that trees become deep.
        self.conditions[self.conditions.len() - 1 - i % self.conditions.len()]
    }

    fn add_number(&mut self, op: Op) {
        let id = self.program.add(op, NUMBER);
        self.numbers.push(id);
    }

    fn add_condition(&mut self, op: Op) {
        let id = self.program.add(op, ValueKind::Condition);
        self.conditions.push(id);
    }

    fn run(&mut self, (op, a, b, x, d): Instruction) {
        let (m, n) = (self.number(a), self.number(b));
        let (p, q) = (self.condition(a), self.condition(b));
        let constant = self.program.add(Op::Constant(f64::from(x) / 2.0), NUMBER);
        let compare = [
            CompareOp::Less,
            CompareOp::LessOrEqual,
            CompareOp::Greater,
            CompareOp::GreaterOrEqual,
            CompareOp::Equal,
            CompareOp::NotEqual,
        ][b % 6];
        match op {
            0 => self.add_number(Op::Negate(m)),
            1 => self.add_number(Op::Add(m, n)),
            2 => self.add_number(Op::Subtract(m, n)),
            3 => self.add_number(Op::Multiply(m, constant)),
            4 => self.add_number(Op::Absolute(m)),
            5 => self.add_number(Op::Least(m, d)),
            6 => self.add_number(Op::Greatest(m, d)),
            7 => self.add_number(Op::Share(p, d)),
            8 => self.add_number(Op::MatchLeast(m)),
            9 => self.add_number(Op::AtKeyframe(m)),
            10 | 11 => self.add_condition(Op::Compare { op: compare, left: m, right: constant, scale: 1.5 }),
            12 => self.add_condition(Op::Compare { op: compare, left: constant, right: m, scale: 0.5 }),
            13 => self.add_condition(Op::Compare { op: compare, left: m, right: n, scale: 1.0 }),
            14 => self.add_condition(Op::Known(m)),
            15 => self.add_condition(Op::Known(p)),
            16 => self.add_condition(Op::Not(p)),
            17 => self.add_condition(Op::And(vec![p, q])),
            18 => self.add_condition(Op::Or(vec![p, q])),
            19 => self.add_condition(Op::For(p, d)),
            20 => self.add_condition(Op::Within(p, d)),
            21 => self.add_condition(Op::Previously(p, Some(d))),
            22 => self.add_condition(Op::Previously(p, None)),
            23 => self.add_condition(Op::Since(p, q)),
            24 => self.add_condition(Op::Until(p, q)),
            25 => self.add_condition(Op::Bridge(p, d)),
            26 => self.add_condition(Op::Before(p)),
            27 => self.add_condition(Op::AtKeyframe(p)),
            28 => self.add_condition(Op::InMatch(p)),
            29 if matches!(self.program.node(p).scope, ValueScope::Frame | ValueScope::Target) => {
                let subject = if a % 2 == 0 { Subject::Any } else { Subject::Vehicle };
                self.add_condition(Op::AtLeast { of: p, count: b % 3, subject });
            }
            31 | 32 if matches!(self.program.node(p).scope, ValueScope::Second | ValueScope::Pair) => {
                let subject = if a % 2 == 0 { Subject::Any } else { Subject::Vehicle };
                self.add_condition(Op::AtLeastNear { of: p, count: b % 3, subject });
            }
            30 => self.add_condition(Op::And(vec![p, q, self.condition(a + b)])),
            _ => self.add_condition(Op::Truth(a % 2 == 0)),
        }
    }

    /// False for a node about a second object in a rule that has none.
    fn is_usable(&self, id: NodeId) -> bool {
        self.roles == 2 || matches!(self.program.node(id).scope, ValueScope::Frame | ValueScope::Target)
    }

    /// The condition that was built last for which this holds, from the `skip`th on.
    fn last(&self, skip: usize, holds: impl Fn(&crate::language::program::Node) -> bool) -> Option<NodeId> {
        let usable = |id: &&NodeId| self.is_usable(**id) && holds(self.program.node(**id));
        let all = self.conditions.iter().rev().filter(usable);
        let all: Vec<NodeId> = all.copied().collect();
        (!all.is_empty()).then(|| all[skip % all.len()])
    }
}

/// A rule about the ego whose matches are its episodes.
pub fn plain_rule(program: Program, when: NodeId) -> Rule {
    Rule {
        scenario: "proactive.turn.straight".parse().expect("a class"),
        subject: None,
        target_role: "target".into(),
        second: None,
        program,
        when,
        require: vec![],
        response: None,
        atoms: vec![],
        parts: vec![],
        listed: Listed::Holding,
        min_duration: Nanos(0),
        max_duration: None,
        merge_gap: Nanos(0),
        lengthy: BTreeMap::new(),
        timing: Timing::of_match(),
    }
}

/// A rule of an ego, a target or a pair, with all its moments.
pub fn rule() -> impl Strategy<Value = Rule> {
    let instruction = (0usize..34, 0usize..40, 0usize..40, -3i32..4, duration());
    let picks = (0usize..4, 0usize..9, 0usize..9, 0usize..9, any::<bool>());
    let times = (duration(), duration(), duration());
    (0usize..3, prop::collection::vec(instruction, 1..18), picks, times).prop_map(
        |(roles, instructions, (when, a, b, c, bounded), (least, merge_gap, offset))| {
            let mut pool = Pool::new(roles);
            instructions.into_iter().for_each(|i| pool.run(i));
            // Before there is an episode, its moments cannot be used.
            let fallback = pool.conditions[0];
            let when = pool.last(when, |n| !n.needs_episode).unwrap_or(fallback);
            let require = pool.last(a, |_| true).into_iter().filter(|_| b % 3 == 0).collect();
            let moment = pool.last(b, |n| !n.needs_episode).unwrap_or(fallback);
            let late = pool.last(c, |_| true).unwrap_or(fallback);
            let number = pool.number(a);
            let fits = !pool.program.node(number).needs_episode && pool.is_usable(number);
            let number = if fits { number } else { pool.numbers[0] };
            let words = Bilingual::new("", "");
            let first = match c % 5 {
                0 => Moment::First(moment),
                1 => Moment::Last(moment),
                2 => Moment::Greatest(number),
                3 => Moment::Earliest(vec![Moment::Least(number), Moment::MatchEnd]),
                _ => Moment::Offset(Box::new(Moment::Nearest(moment)), Nanos(-offset.0)),
            };
            let timing = Timing {
                keyframe: vec![(first, words)],
                second_keyframe: vec![Moment::Last(late)],
                start: vec![
                    Moment::Nearest(late),
                    Moment::Offset(Box::new(Moment::Keyframe), Nanos(-offset.0)),
                ],
                end: vec![Moment::Latest(vec![Moment::Nearest(moment), Moment::Keyframe])],
                before: offset,
                after: least,
                after_until: bounded.then_some(Moment::Nearest(late)),
                ..Timing::of_match()
            };
            let unit = Unit::parse("m/s").expect("a unit");
            let atom = |condition, measured| crate::language::program::Atom {
                text: "atom".into(),
                words: Default::default(),
                value_names: Default::default(),
                condition,
                measured,
                signals: Default::default(),
                unit,
                threshold: None,
                is_denied: false,
            };
            let second = SecondRole { name: "other".into(), subject: Subject::Any };
            Rule {
                subject: [None, Some(Subject::Vehicle), Some(Subject::Any)][roles],
                second: (roles == 2).then_some(second),
                require,
                response: (b % 2 == 0)
                    .then_some(ResponseCondition { condition: moment, of_target: a % 2 == 0 || roles > 0 }),
                atoms: vec![atom(late, number), atom(moment, moment)],
                parts: vec![],
                listed: if bounded { Listed::All } else { Listed::Holding },
                min_duration: least,
                max_duration: bounded.then_some(Nanos(3_000_000_000)),
                merge_gap,
                timing,
                ..plain_rule(pool.program, when)
            }
        },
    )
}
