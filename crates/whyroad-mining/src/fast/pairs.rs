//! Pairs of near objects: their signals and counts of those near an object, for all pairs of the drive at once.

use super::bits::Bits;
use super::evaluation::Evaluation;
use super::layout::{RowSet, Segment};
use super::margin::Deciding;
use super::numbers::Numbers;
use super::signals::{NodeValue, Words};
use super::truth::Truth;
use crate::language::program::{NodeId, Op, PairSide, Subject, ValueScope};
use std::ops::Range;
use std::rc::Rc;
use whyroad_model::Tri;
use whyroad_model::signal::is_of_object;

impl<'a> Evaluation<'a> {
    /// A signal of pairs; for one pair, a part of the signal of all pairs.
    pub(super) fn pair_signal(
        &self,
        id: NodeId,
        name: &str,
        side: PairSide,
        row_set: RowSet,
    ) -> NodeValue<'a> {
        let unknown = || NodeValue::Numbers(Numbers::Same(f64::NAN, self.layout.len(row_set)));
        match row_set {
            RowSet::Pairs => self.signals.of_pairs(name, side, &self.layout).unwrap_or_else(unknown),
            RowSet::Pair(a, b) => match self.layout.pair(a, b) {
                Some(i) => {
                    let rows = self.layout.segments(RowSet::Pairs)[i].range();
                    self.value(id, RowSet::Pairs).slice(rows)
                }
                None => unknown(),
            },
            _ => unknown(),
        }
    }

    /// Values of all objects' rows, as those of all pairs: of the first or of the second object of each.
    pub(super) fn spread_to_pairs(&self, of_objects: &NodeValue<'a>, scope: ValueScope) -> NodeValue<'a> {
        let pairs = self.layout.pairs.as_deref().unwrap_or_default();
        let from = |p: &super::layout::PairRows| {
            let object = self.layout.objects[if scope == ValueScope::Second { p.second } else { p.first }];
            let start = object.start + p.segment.row - object.row;
            start..start + p.segment.len
        };
        let n = self.layout.len(RowSet::Pairs);
        let bits = |values: &Bits| {
            let mut out = Bits::zeros(n);
            pairs.iter().for_each(|p| out.copy_from(values, from(p), p.segment.start));
            Rc::new(out)
        };
        match of_objects {
            NodeValue::Truth(t) => NodeValue::Truth(Truth { yes: bits(&t.yes), known: bits(&t.known) }),
            NodeValue::Numbers(Numbers::Same(x, _)) => NodeValue::Numbers(Numbers::Same(*x, n)),
            NodeValue::Numbers(v) => {
                let v = v.values();
                let all = pairs.iter().flat_map(|p| v[from(p)].iter().copied());
                NodeValue::Numbers(Numbers::of(all.collect::<Vec<_>>()))
            }
            NodeValue::Words(w) => {
                let all = pairs.iter().flat_map(|p| w.codes()[from(p)].iter().copied());
                NodeValue::Words(Words::of(all.collect(), w.names.clone()))
            }
        }
    }

    /// At least `count` of the objects near the object at a frame meet the condition.
    pub(super) fn at_least_near(
        &self,
        of: NodeId,
        (count, subject): (usize, Subject),
        row_set: RowSet,
    ) -> Truth {
        match row_set {
            RowSet::Objects => {
                let n = self.layout.object_rows;
                let (mut yes, mut known) = (Bits::zeros(n), Bits::zeros(n));
                for (i, object) in self.layout.objects.iter().enumerate() {
                    let truth = self.enough_near(of, (count, subject), i);
                    yes.copy_from(&truth.yes, 0..object.len, object.start);
                    known.copy_from(&truth.known, 0..object.len, object.start);
                }
                Truth { yes: Rc::new(yes), known: Rc::new(known) }
            }
            RowSet::Object(i) => self.enough_near(of, (count, subject), i),
            _ => Truth::unknown(self.layout.len(row_set)),
        }
    }

    fn enough_near(&self, of: NodeId, (count, subject): (usize, Subject), object: usize) -> Truth {
        let own = self.layout.objects[object];
        if !self.pairs_can_be_told(of) {
            return Truth::unknown(own.len);
        }
        if !self.plan.node(of).needs_episode {
            self.truth(of, RowSet::Pairs);
        }
        let (mut sure, mut possible) = (vec![0u32; own.len], vec![0u32; own.len]);
        for (second, segment) in self.near(object, subject) {
            let truth = self.truth(of, RowSet::Pair(object, second));
            for k in (0..segment.len).filter(|k| self.is_near(object, second, segment.row + k)) {
                let at = segment.row + k - own.row;
                sure[at] += u32::from(truth.yes.get(k));
                possible[at] += u32::from(truth.yes.get(k) || !truth.known.get(k));
            }
        }
        let seen = |k: usize| self.is_seen(object, own.row + k);
        let enough = |counters: &[u32], hole: bool| {
            Bits::collect(own.len, |k| if seen(k) { counters[k] as usize >= count } else { hole })
        };
        Truth::bounded(enough(&sure, false), &enough(&possible, true))
    }

    /// Objects of this kind that come near one, with the rows of the pair.
    fn near(&self, object: usize, subject: Subject) -> impl Iterator<Item = (usize, Segment)> {
        let pairs = self.layout.pairs.as_deref().unwrap_or_default();
        let from = pairs.partition_point(|p| p.first < object);
        let of_object = pairs[from..].iter().take_while(move |p| p.first == object);
        let admitted =
            move |p: &&super::layout::PairRows| subject.admits(self.signals.targets[p.second].class);
        of_object.filter(admitted).map(|p| (p.second, p.segment))
    }

    /// Whether a pair is near in a row of the drive.
    fn is_near(&self, first: usize, second: usize, row: usize) -> bool {
        let Some(pairs) = self.signals.pairs else { return false };
        let Some(span) = pairs.find(first, second).map(|i| pairs.spans[i]) else { return false };
        let frame = self.layout.rows[row].frame.and_then(|f| f.checked_sub(span.frames.start));
        frame.is_some_and(|f| pairs.near[span.first_row + f])
    }

    /// Whether the object is observed in a row of the drive.
    fn is_seen(&self, object: usize, row: usize) -> bool {
        let Some(frame) = self.layout.rows[row].frame else { return false };
        match self.signals.flag_of_object("object.observed", object, frame) {
            Some(observed) => observed == Tri::True,
            None => true,
        }
    }

    /// False where a signal of the condition is missing: then it is even unknown whether nobody is near.
    fn pairs_can_be_told(&self, of: NodeId) -> bool {
        let mut todo = vec![of];
        while let Some(id) = todo.pop() {
            let there = match &self.plan.node(id).op {
                Op::Signal(name) | Op::SecondSignal(name) if is_of_object(name) => {
                    self.signals.present.contains_key(name)
                }
                Op::PairSignal { name, .. } => self.signals.present.contains_key(name),
                _ => true,
            };
            if !there {
                return false;
            }
            todo.extend(self.plan.node(id).op.operands());
        }
        self.signals.pairs.is_some()
    }

    /// Margins of such a count on these rows of the object: that of the object that is needed last to reach the number.
    pub(super) fn of_near_count(
        &self,
        of: NodeId,
        (count, subject): (usize, Subject),
        row_set: RowSet,
        rows: Range<usize>,
    ) -> Vec<f64> {
        let mut deciding = Deciding::new(count, rows.len());
        if let RowSet::Object(object) = row_set {
            let own = self.layout.objects[object];
            for (second, segment) in self.near(object, subject) {
                let begin = segment.row - own.row;
                let (from, to) = (rows.start.max(begin), rows.end.min(begin + segment.len));
                if from >= to {
                    continue;
                }
                let margins = self.margins(of, RowSet::Pair(object, second), from - begin..to - begin);
                for (k, m) in (from..to).zip(margins) {
                    if !m.is_nan() && self.is_near(object, second, own.row + k) {
                        deciding.add(k - rows.start, m);
                    }
                }
            }
        }
        deciding.finish()
    }
}
