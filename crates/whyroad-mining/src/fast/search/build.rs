//! One match to its episode, as `crate::episode` defines it: keyframe, the conditions there, time range, score. Times
//! are searched by bisection and in packed bits; margins are computed only here.

use crate::episode::moment::{REACH, Sought};
use crate::episode::{Episode, Rank, deciding, response};
use crate::fast::evaluation::Evaluation;
use crate::fast::layout::RowSet;
use crate::fast::plan::PlanRule;
use crate::fast::signals::NodeValue;
use crate::fast::truth::Truth;
use crate::interpret::{Moments, Row};
use crate::language::program::{Atom, Moment, NodeId};
use crate::rule::Listed;
use serde_json::Value as Json;
use std::collections::BTreeMap;
use std::ops::Range;
use whyroad_model::messages::{EgoResponse, MatchedCondition};
use whyroad_model::{Bilingual, FrameRange, Nanos, Tri};

/// The episode of the match from the first to the last of these rows; `None` where a requirement is not met.
pub(super) fn episode(
    evaluation: &Evaluation<'_>,
    of: &PlanRule<'_>,
    row_set: RowSet,
    when: &Truth,
    (first, last): (usize, usize),
) -> Option<Episode> {
    let rule = &of.rule;
    let clock = Clock { evaluation };
    evaluation.set_episode(None);
    let mut building = Building { evaluation, of, row_set, first, last, keyframe: None };
    let rows = building.rows();
    // Rows of a match begin and end with a frame: a gap is never true.
    let matched = FrameRange::new(rows[first].frame?, rows[last].frame? + 1);
    let (keyframe_time, keyframe_rule) = building.keyframe();
    let keyframe = clock.frame_at(keyframe_time);
    building.keyframe = Some(clock.time(keyframe));
    // A keyframe may lie outside the match: the conditions are evaluated at the nearest frame of the match.
    let judged = keyframe.clamp(matched.start, matched.end - 1);
    evaluation.set_episode(Some(Moments { keyframe: judged, matched }));
    let row = evaluation.layout.position(row_set, judged)?;
    for id in &rule.require {
        if building.truth_at(*id, row) != Tri::True {
            return None;
        }
    }
    let mut margin = building.mean_margin(when);
    for id in &rule.require {
        margin = margin.min(evaluation.margins(of.node(*id), row_set, row..row + 1)[0]);
    }
    let bound = |ways: &[Moment], sought, default: Nanos| {
        ways.iter().find_map(|m| building.resolve(m, sought)).unwrap_or(default)
    };
    let start = bound(&rule.timing.start, Sought::Start, clock.time(matched.start));
    let end = bound(&rule.timing.end, Sought::End, clock.end(matched.end - 1));
    let until = bound(rule.timing.after_until.as_slice(), Sought::End, Nanos(i64::MAX));
    let start = start.min(clock.time(keyframe));
    // The time range holds the keyframe's own frame.
    let end = end.max(clock.end(keyframe));
    let after = (end + rule.timing.after).min(until.max(end));
    let second = rule.timing.second_keyframe.iter().find_map(|m| building.resolve(m, Sought::Keyframe));
    let id = |i: usize| evaluation.signals.targets[i].id.clone();
    let target = match row_set {
        RowSet::Object(i) | RowSet::Pair(i, _) => Some(id(i)),
        RowSet::Drive | RowSet::Objects | RowSet::Pairs => None,
    };
    let roles = match (&rule.second, row_set) {
        (Some(role), RowSet::Pair(a, b)) => {
            BTreeMap::from([(rule.target_role.clone(), id(a)), (role.name.clone(), id(b))])
        }
        _ => BTreeMap::new(),
    };
    Some(Episode {
        scenario: rule.scenario.clone(),
        target,
        roles,
        matched,
        kind: rule.timing.kind,
        keyframe,
        second_keyframe: second.map(|t| clock.frame_at(t)),
        range: clock.range(start, end),
        context: clock.range(start - rule.timing.before, after),
        keyframe_rule,
        response: building.answered(FrameRange::new(matched.start, clock.range(start, end).end)),
        score: rule.margin_score(margin),
        share: None,
        conditions: building.conditions(row),
        signals: of.signals.iter().cloned().collect(),
        rank: Rank::Primary,
    })
}

/// A match that is being turned into an episode.
struct Building<'e, 'a> {
    evaluation: &'e Evaluation<'a>,
    of: &'e PlanRule<'e>,
    row_set: RowSet,
    first: usize,
    last: usize,
    /// Time of the keyframe, once it is known.
    keyframe: Option<Nanos>,
}

impl<'e> Building<'e, '_> {
    fn rows(&self) -> &'e [Row] {
        let segment = self.evaluation.layout.segment(self.row_set);
        &self.evaluation.layout.rows[segment.row..segment.row + segment.len]
    }

    fn truth(&self, id: NodeId) -> Truth {
        self.evaluation.truth(self.of.node(id), self.row_set)
    }

    fn truth_at(&self, id: NodeId, row: usize) -> Tri {
        self.truth(id).at(row)
    }

    /// The first expression that finds the keyframe, with its rule in words.
    fn keyframe(&self) -> (Nanos, Bilingual) {
        let timing = &self.of.rule.timing;
        for (moment, words) in &timing.keyframe {
            if let Some(time) = self.resolve(moment, Sought::Keyframe) {
                return (time, words.clone());
            }
        }
        (self.rows()[self.first].time, timing.at_match_start.clone())
    }

    /// The moment's time, or `None` where the episode has no such moment.
    fn resolve(&self, moment: &Moment, sought: Sought) -> Option<Nanos> {
        let inner = |m: &Moment| self.resolve(m, sought);
        let time = |row: usize| self.rows()[row].time;
        match moment {
            Moment::Keyframe => self.keyframe,
            Moment::MatchStart => Some(time(self.first)),
            Moment::MatchEnd => Some(self.rows()[self.last].end),
            Moment::Offset(of, by) => inner(of).map(|t| t + *by),
            Moment::Earliest(all) => all.iter().map(inner).collect::<Option<Vec<_>>>()?.into_iter().min(),
            Moment::Latest(all) => all.iter().map(inner).collect::<Option<Vec<_>>>()?.into_iter().max(),
            Moment::First(c) => self.truth(*c).yes.positions(self.matched()).next().map(time),
            Moment::Last(c) => self.truth(*c).yes.last_in(self.matched()).map(time),
            Moment::Nearest(c) => {
                let (truth, reach) = (self.truth(*c), self.reach(sought));
                let row = match sought {
                    Sought::Start => truth.yes.last_in(reach),
                    Sought::Keyframe | Sought::End => truth.yes.positions(reach).next(),
                };
                row.map(time)
            }
            Moment::Least(x) => self.extreme(*x, |a, b| a < b).map(time),
            Moment::Greatest(x) => self.extreme(*x, |a, b| a > b).map(time),
        }
    }

    fn matched(&self) -> Range<usize> {
        self.first..self.last + 1
    }

    /// Rows in which a moment is searched.
    fn reach(&self, sought: Sought) -> Range<usize> {
        let (from, to) = match (sought, self.keyframe) {
            (Sought::Start, Some(keyframe)) => (keyframe - REACH, keyframe),
            (Sought::End, Some(keyframe)) => (keyframe, keyframe + REACH),
            _ => return self.matched(),
        };
        let rows = self.rows();
        let start = rows.partition_point(|r| r.time < from);
        start..rows.partition_point(|r| r.time <= to).max(start)
    }

    fn extreme(&self, x: NodeId, better: fn(f64, f64) -> bool) -> Option<usize> {
        let NodeValue::Numbers(v) = self.evaluation.value(self.of.node(x), self.row_set) else { return None };
        let known = self.matched().filter(|&i| !v.at(i).is_nan());
        known.reduce(|best, i| if better(v.at(i), v.at(best)) { i } else { best })
    }

    /// Mean over the rows of the match in which the condition held.
    fn mean_margin(&self, when: &Truth) -> f64 {
        let id = self.of.node(self.of.rule.when);
        let margins = self.evaluation.margins(id, self.row_set, self.matched());
        let held = when.yes.positions(self.matched()).map(|i| margins[i - self.first]);
        let (sum, n) = held.fold((0.0, 0), |(sum, n), m| (sum + m, n + 1));
        sum / f64::from(n)
    }

    /// Whether the ego responded in these frames.
    fn answered(&self, range: FrameRange) -> EgoResponse {
        let Some(asked) = self.of.rule.response else { return EgoResponse::Observed };
        let rows = if asked.of_target { self.row_set } else { RowSet::Drive };
        let truth = self.evaluation.truth(self.of.node(asked.condition), rows);
        response(range, |frame| self.evaluation.layout.position(rows, frame).map(|row| truth.at(row)))
    }

    fn conditions(&self, row: usize) -> Vec<MatchedCondition> {
        let listed =
            |a: &&Atom| self.of.rule.listed == Listed::All || self.truth_at(a.condition, row) == Tri::True;
        let atoms: Vec<&'e Atom> = self.of.rule.atoms.iter().filter(listed).collect();
        let margin = |a: &&'e Atom| {
            let margins = self.evaluation.margins(self.of.node(a.condition), self.row_set, row..row + 1);
            (a.text.as_str(), margins[0])
        };
        let margins: Vec<(&str, f64)> = atoms.iter().map(margin).collect();
        let one = |i: usize| atoms[i].matched(self.measured(atoms[i], row));
        deciding(&margins).into_iter().map(one).collect()
    }

    /// The measured value in the atom's unit; null when unknown or infinite.
    fn measured(&self, atom: &Atom, row: usize) -> Json {
        match self.evaluation.value(self.of.node(atom.measured), self.row_set) {
            NodeValue::Numbers(v) => atom.number(v.at(row)),
            NodeValue::Truth(t) => t.at(row).known().map_or(Json::Null, Json::Bool),
            NodeValue::Words(w) => {
                let code = usize::from(w.codes()[row]);
                w.names.get(code).map_or(Json::Null, |n| Json::String(n.clone()))
            }
        }
    }
}

/// Frames of the drive by time.
struct Clock<'e, 'a> {
    evaluation: &'e Evaluation<'a>,
}

impl Clock<'_, '_> {
    fn time(&self, frame: usize) -> Nanos {
        self.evaluation.signals.times[frame]
    }

    fn end(&self, frame: usize) -> Nanos {
        let layout = &self.evaluation.layout;
        layout.rows[layout.row_of_frame[frame]].end
    }

    /// The frame that begins nearest to `time`; the earlier one of two that are equally near.
    fn frame_at(&self, time: Nanos) -> usize {
        let times = &self.evaluation.signals.times;
        let after = times.partition_point(|t| *t < time);
        match (after.checked_sub(1), times.get(after)) {
            (Some(before), Some(next)) if (time - times[before]).0 > (*next - time).0 => after,
            (Some(before), _) => before,
            (None, _) => 0,
        }
    }

    /// Frames from `start` until `end`, clamped to the drive.
    fn range(&self, start: Nanos, end: Nanos) -> FrameRange {
        let n = self.evaluation.signals.times.len();
        let from = self.frame_at(start);
        let beyond =
            n.checked_sub(1).is_none_or(|l| (self.end(l).0 - end.0).abs() <= (self.time(l).0 - end.0).abs());
        // A frame before a gap may have ended although it begins nearer to `end` than the next one.
        let nearest = self.frame_at(end);
        let to = if beyond { n } else { nearest + usize::from(self.end(nearest) <= end) };
        FrameRange::new(from, to.max(from + 1))
    }
}
