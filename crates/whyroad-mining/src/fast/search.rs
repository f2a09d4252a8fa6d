//! Where the rules of a plan hold on one drive: runs of true in packed columns, and the result of each.

mod build;

use super::bits::Bits;
use super::evaluation::Evaluation;
use super::layout::{RowSet, Segment};
use super::plan::{Plan, PlanRule};
use super::signals::Signals;
use super::truth::Truth;
use crate::drive::{DriveEpisodes, arbitrated};
use crate::episode::Found;
use crate::episode::observable::lacking_signals;
use crate::interpret::{CLOCK_TOLERANCE, Row};
use crate::rule::{Rule, RuleSet};
use std::collections::BTreeSet;
use std::ops::Range;
use whyroad_model::SignalTable;

/// The matches of one rule on one row set, in order.
struct Matches {
    row_set: RowSet,
    /// First and last row of each.
    rows: Vec<(usize, usize)>,
}

/// State of one rule before episodes are built.
struct Candidates {
    /// Index of the rule in the plan.
    rule: usize,
    matches: Vec<Matches>,
    decided: Decided,
}

/// How much of the rule's condition was known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Decided {
    /// It had rows.
    asked: bool,
    /// In one of them it was known.
    known: bool,
}

/// Rules of a plan on one drive, matches found, episodes not yet built: for these, more columns may be needed.
pub struct Search<'a> {
    evaluation: Evaluation<'a>,
    candidates: Vec<Candidates>,
}

impl<'a> Search<'a> {
    /// Looks for matches of these rules of the plan. `signals` must hold what their conditions read.
    pub fn new(plan: &'a Plan<'a>, signals: &'a Signals<'a>, rules: impl IntoIterator<Item = usize>) -> Self {
        let evaluation = Evaluation::new(plan, signals);
        let of_rule = |rule| candidates(&evaluation, rule);
        let candidates = rules.into_iter().map(of_rule).collect();
        Self { evaluation, candidates }
    }

    /// Signals that the drive has and that are needed to build the episodes, beyond those at hand.
    pub fn wanted(&self) -> BTreeSet<String> {
        let signals = self.evaluation.signals;
        let found = self.candidates.iter().filter(|c| !c.matches.is_empty());
        let later = found.flat_map(|c| &self.evaluation.plan.rules[c.rule].later_signals);
        later.filter(|s| signals.present.contains_key(*s) && !signals.holds(s)).cloned().collect()
    }

    /// The results of each rule, in the given order.
    pub fn found(&self) -> Vec<Found> {
        self.candidates.iter().map(|c| self.found_of(c)).collect()
    }

    fn found_of(&self, candidates: &Candidates) -> Found {
        let rule = &self.evaluation.plan.rules[candidates.rule];
        let mut found = Found::default();
        for matches in &candidates.matches {
            let when = self.evaluation.truth(rule.node(rule.rule.when), matches.row_set);
            for rows in &matches.rows {
                found.episodes.extend(build::episode(&self.evaluation, rule, matches.row_set, &when, *rows));
            }
        }
        found.missing = missing(rule, self.evaluation.signals, candidates.decided);
        found
    }
}

/// As in [`crate::episode::find`].
fn missing(rule: &PlanRule<'_>, signals: &Signals<'_>, decided: Decided) -> BTreeSet<String> {
    let lacking = lacking(rule, signals.shown_to(rule.rule.subject));
    if !lacking.is_empty() || !decided.asked || decided.known {
        return lacking;
    }
    let of = |wanted: Option<bool>| -> BTreeSet<String> {
        rule.needs.iter().filter(|s| signals.present.get(*s).copied() == wanted).cloned().collect()
    };
    let absent = of(None);
    if absent.is_empty() { of(Some(false)) } else { absent }
}

/// Signals that the rule needs and the drive does not have; none where it can be decided without them.
pub fn lacking(rule: &PlanRule<'_>, has: impl Fn(&str) -> bool) -> BTreeSet<String> {
    lacking_signals(&rule.rule, &rule.needs, has)
}

fn candidates(evaluation: &Evaluation<'_>, rule: usize) -> Candidates {
    let of = &evaluation.plan.rules[rule];
    let when = of.node(of.rule.when);
    // Where the drive cannot show the class, whether a row is known decides nothing.
    let blind = !lacking(of, evaluation.signals.shown_to(of.rule.subject)).is_empty();
    let mut out = Candidates { rule, matches: Vec::new(), decided: Decided::default() };
    let Some(subject) = of.rule.subject else {
        let truth = evaluation.truth(when, RowSet::Drive);
        let segment = evaluation.layout.segment(RowSet::Drive);
        out.take(&of.rule, RowSet::Drive, &truth, segment, &evaluation.layout.rows);
        return out;
    };
    let admitted = |i: usize| subject.admits(evaluation.signals.targets[i].class);
    let rows = &evaluation.layout.rows;
    if of.rule.second.is_some() {
        let pairs = Pairs {
            evaluation,
            of,
            target: evaluation.conjunction(&of.alone, RowSet::Objects).possible(),
            second: evaluation.conjunction(&of.alone_second, RowSet::Objects).possible(),
        };
        for (i, object) in evaluation.layout.objects.iter().enumerate().filter(|(i, _)| admitted(*i)) {
            if pairs.target.any_in(object.range()) {
                out.take_pairs(&pairs, i);
            } else {
                // False in every row for the target alone: no pair with it can match.
                out.decide(object.len > 0, object.len > 0);
            }
        }
        return out;
    }
    let truth = evaluation.truth(when, RowSet::Objects);
    let nowhere = truth.yes.none();
    for (i, object) in evaluation.layout.objects.iter().enumerate().filter(|(i, _)| admitted(*i)) {
        // Once some row is known, rows without a match give no further information.
        if nowhere && (out.decided.known || blind) {
            break;
        }
        out.take(&of.rule, RowSet::Object(i), &truth, *object, rows);
    }
    out
}

impl Candidates {
    fn decide(&mut self, asked: bool, known: bool) {
        self.decided.asked |= asked;
        self.decided.known |= known;
    }

    /// The matches of all pairs with this target.
    fn take_pairs(&mut self, pairs: &Pairs<'_, '_>, target: usize) {
        let Pairs { evaluation, of, .. } = pairs;
        let Some(role) = &of.rule.second else { return };
        let targets = &evaluation.signals.targets;
        for second in evaluation.layout.seen_with(target) {
            if targets[second].first_row == targets[target].first_row
                || !role.subject.admits(targets[second].class)
            {
                continue;
            }
            let row_set = RowSet::Pair(target, second);
            let segment = evaluation.layout.segment(row_set);
            if pairs.hopeless(target, second, segment) {
                self.decide(segment.len > 0, segment.len > 0);
                continue;
            }
            let truth = evaluation.truth(of.node(of.rule.when), row_set);
            self.take(&of.rule, row_set, &truth, segment, &evaluation.layout.rows);
            if self.matches.last().is_none_or(|m| m.row_set != row_set) {
                evaluation.forget_pairs();
            }
        }
    }

    /// The matches in one stretch of a column.
    fn take(&mut self, rule: &Rule, row_set: RowSet, truth: &Truth, segment: Segment, rows: &[Row]) {
        let rows = &rows[segment.row..segment.row + segment.len];
        let known = !self.decided.known && truth.known.any_in(segment.range());
        self.decide(segment.len > 0, known);
        let found = matches(rule, truth, segment.range(), rows);
        if !found.is_empty() {
            self.matches.push(Matches { row_set, rows: found });
        }
    }
}

/// A rule that binds two objects, and the rows where its conditions on each alone are possible. A crowded drive has
/// many pairs, and nearly all fail for one of the two.
struct Pairs<'p, 'a> {
    evaluation: &'p Evaluation<'a>,
    of: &'p PlanRule<'p>,
    target: Bits,
    second: Bits,
}

impl Pairs<'_, '_> {
    /// True when in every row of the pair one of the two is known not to qualify.
    fn hopeless(&self, target: usize, second: usize, rows: Segment) -> bool {
        let of_object = |bits: &Bits, i: usize| {
            let object = self.evaluation.layout.objects[i];
            let start = object.start + rows.row - object.row;
            bits.slice(start..start + rows.len)
        };
        let mut both = of_object(&self.target, target);
        both.and_with(&of_object(&self.second, second));
        both.none()
    }
}

/// Runs of true as first and last row of the stretch, near ones merged, too short and too long ones dropped.
fn matches(rule: &Rule, truth: &Truth, stretch: Range<usize>, rows: &[Row]) -> Vec<(usize, usize)> {
    let mut out: Vec<(usize, usize)> = Vec::new();
    for run in truth.yes.runs(stretch.clone()) {
        let (first, last) = (run.start - stretch.start, run.end - 1 - stretch.start);
        match out.last_mut() {
            Some((_, before)) if rows[first].time - rows[*before].end <= rule.merge_gap => *before = last,
            _ => out.push((first, last)),
        }
    }
    out.retain(|&(first, last)| {
        let lasts = rows[last].end - rows[first].time;
        lasts + CLOCK_TOLERANCE >= rule.min_duration
            && rule.max_duration.is_none_or(|max| lasts <= max + CLOCK_TOLERANCE)
    });
    out
}

/// The results of each rule of the plan on the signals of one drive, all of which are available.
pub fn find_all<'a>(plan: &'a Plan<'a>, signals: &'a Signals<'a>) -> Vec<Found> {
    Search::new(plan, signals, 0..plan.rules.len()).found()
}

/// All rules over the signals of one drive, arbitrated.
pub fn mine_drive(rules: &RuleSet, table: &SignalTable) -> DriveEpisodes {
    mine_planned(rules, &Plan::of(rules), table)
}

/// The same with the `plan` of these rules, which serves many drives.
pub(crate) fn mine_planned(rules: &RuleSet, plan: &Plan<'_>, table: &SignalTable) -> DriveEpisodes {
    let signals = Signals::of_table(table);
    arbitrated(rules, &table.drive_id, &table.times, find_all(plan, &signals))
}
