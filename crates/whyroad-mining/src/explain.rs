//! Why a rule matched or did not in one clip: its parts one by one over time, and the moment at which it matched or
//! came nearest to a match. Uses the reference evaluator, which keeps the truth of every part.

mod nearest;

pub use nearest::{NearClass, UndecidedClass, UnmetCondition, nearest, undecided};

use crate::episode::arbitrate::resolves;
use crate::episode::build::{locate, matches, measured_in_words, runs, truth_at};
use crate::episode::{Episode, find, pairs};
use crate::interpret::{Evaluator, Pass, Roles, Row, Series, Truths};
use crate::language::check::{Join, Structure};
use crate::language::program::{Atom, NodeId};
use crate::rule::{Part, PartPlace, Rule};
use serde_json::Value;
use std::collections::BTreeMap;
use std::rc::Rc;
use whyroad_model::messages::EgoResponse;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Bilingual, FrameRange, Nanos, SignalTable, TrackId, Tri};

/// How far a rule was met, from least to most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// No possible target is observed in the clip.
    NoCandidate,
    /// No frame of the clip could be decided, or none of those in which no condition is known to fail, and the drive
    /// lacks signals.
    Undecided,
    /// The conditions that must hold together never did.
    NotTogether,
    /// It held, but for too short (or too long) a time.
    WrongDuration,
    /// It held, but a condition that is required at the keyframe did not.
    NotAtKeyframe,
    /// It matched.
    Matched,
}

/// One frame of one condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Its truth.
    Known(Tri),
    /// There is no value: the target is not observed.
    Absent,
}

/// A condition over the frames of the clip.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// One per frame.
    pub cells: Vec<Cell>,
    /// Truth at the moment that is explained.
    pub truth: Tri,
    /// Margin there, in typical magnitudes; NaN where unknown.
    pub margin: f64,
}

/// A part of the rule.
#[derive(Clone, Debug, PartialEq)]
pub struct PartCourse {
    /// Where it must hold.
    pub place: PartPlace,
    /// The condition.
    pub condition: ConditionCourse,
}

/// A condition of a part with those that it is made of; see [`Structure`].
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionCourse {
    /// As written, names replaced by their definitions.
    pub text: String,
    /// In words.
    pub words: Bilingual,
    /// The definition of the rule that it is.
    pub definition: Option<String>,
    /// Its words are the name of that definition.
    pub is_named: bool,
    /// How its members decide it.
    pub join: Join,
    /// The conditions that it is made of.
    pub members: Vec<ConditionCourse>,
    /// Its members are listed above, in the same part.
    pub is_listed_above: bool,
    /// Its truth over time.
    pub course: Course,
    /// A number, a category or a flag is measured for it.
    pub is_measured: bool,
    /// The measured value at the moment that is explained, in `unit`; null when unknown or infinite.
    pub actual: Value,
    /// The same as text, with its unit.
    pub actual_words: Option<Bilingual>,
    /// Symbol of the unit.
    pub unit: &'static str,
    /// The compared number, by frame of the clip, in `unit`; NaN where it is unknown or there is no value. Empty where
    /// no number is compared.
    pub values: Vec<f64>,
    /// The fixed number that it is compared with, in `unit`.
    pub threshold: Option<f64>,
}

/// Why, or why not.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// How far it was met.
    pub outcome: Outcome,
    /// Object for each role: the best candidate.
    pub roles: BTreeMap<String, TrackId>,
    /// Number of candidate objects (or pairs) in the clip.
    pub candidates: usize,
    /// The explained frame of the clip: the keyframe, or the nearest miss.
    pub moment: Option<usize>,
    /// The rule's `when` as a whole.
    pub when: Course,
    /// Its parts.
    pub parts: Vec<PartCourse>,
    /// Signals for lack of which it could not be decided in this drive.
    pub missing: Vec<String>,
    /// For a match: whether the ego responded to the trigger.
    pub response: Option<EgoResponse>,
    /// For [`Outcome::WrongDuration`]: how long it held around the moment, and how long it must hold.
    pub duration: Option<Duration>,
}

/// How long a rule's conditions held together, breaks included that the rule allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Duration {
    /// How long they did.
    pub held: Nanos,
    /// How long they must at least.
    pub least: Nanos,
    /// How long they may.
    pub most: Option<Nanos>,
}

/// Explains a rule on the frames `clip` of a drive; for one target, or for the best candidate.
pub fn explain(rule: &Rule, table: &SignalTable, clip: FrameRange, wanted: Option<&TrackId>) -> Explanation {
    explain_one(rule, table, (clip, None), wanted)
}

/// Explains the match of a rule with this keyframe, a frame of the drive; the nearest miss where there is none.
pub fn explain_match(rule: &Rule, table: &SignalTable, clip: FrameRange, keyframe: usize) -> Explanation {
    explain_one(rule, table, (clip, Some(keyframe)), None)
}

/// The episodes of `leaves` that mining reports instead of the match of their L2's `rule` with this keyframe, a frame
/// of the drive, in the order of their keyframes: the variant is known there.
pub fn variants(rule: &Rule, leaves: &[Rule], table: &SignalTable, keyframe: usize) -> Vec<Episode> {
    if rule.scenario.is_leaf() {
        return Vec::new();
    }
    let own = find(rule, table).episodes;
    let own: Vec<&Episode> = own.iter().filter(|e| e.keyframe == keyframe).collect();
    let below =
        leaves.iter().filter(|leaf| leaf.scenario.is_leaf() && leaf.scenario.is_within(&rule.scenario));
    let found = below.flat_map(|leaf| find(leaf, table).episodes);
    let mut found: Vec<Episode> = found.filter(|leaf| own.iter().any(|e| resolves(leaf, e))).collect();
    found.sort_by(|a, b| (a.keyframe, &a.scenario).cmp(&(b.keyframe, &b.scenario)));
    found
}

fn explain_one(
    rule: &Rule,
    table: &SignalTable,
    (clip, keyframe): (FrameRange, Option<usize>),
    wanted: Option<&TrackId>,
) -> Explanation {
    let mut evaluator = Evaluator::new(&rule.program, table);
    let all = candidates(rule, table, clip, wanted);
    let mut best: Option<(Reached, Roles<'_>)> = None;
    for roles in &all {
        let reached = reach(rule, *roles, (clip, keyframe), &mut evaluator);
        // The first of equals, so that the answer depends only on the drive.
        if best.as_ref().is_none_or(|(b, _)| reached.beats(b)) {
            best = Some((reached, *roles));
        }
    }
    let missing = find(rule, table).missing;
    let is_open =
        best.as_ref().is_some_and(|(b, _)| b.outcome == Outcome::NotTogether && !missing.is_empty());
    for roles in all.iter().filter(|_| is_open) {
        let open = open(rule, *roles, clip, &mut evaluator);
        if let Some(open) = open
            && best.as_ref().is_none_or(|(b, _)| b.outcome != Outcome::Undecided || open.beats(b))
        {
            best = Some((open, *roles));
        }
    }
    let mut out = match best {
        Some((reached, roles)) => explanation_at(rule, roles, clip, &reached, &mut evaluator),
        None => nobody(clip),
    };
    out.candidates = all.len();
    if out.outcome == Outcome::Matched {
        let keyframe = out.moment.map(|frame| frame + clip.start);
        let of = |e: &&Episode| {
            Some(e.keyframe) == keyframe && e.target.iter().all(|t| out.roles.values().any(|r| r == t))
        };
        out.response = find(rule, table).episodes.iter().find(of).map(|e| e.response);
    } else {
        out.missing = missing.into_iter().collect();
    }
    out
}

fn candidates<'a>(
    rule: &'a Rule,
    table: &'a SignalTable,
    clip: FrameRange,
    wanted: Option<&TrackId>,
) -> Vec<Roles<'a>> {
    let Some(subject) = rule.subject else { return vec![Roles::default()] };
    let seen = |s: &&TargetSpan| !s.frames.intersect(clip).is_empty();
    let targets = table.targets.iter().filter(|t| subject.admits(t.class)).filter(seen);
    let targets = targets.filter(|t| wanted.is_none_or(|w| t.id == *w));
    let alone = |t: &'a TargetSpan| Roles { target: Some(t), second: None };
    match &rule.second {
        None => targets.map(alone).collect(),
        Some(role) => targets
            .flat_map(|t| {
                let others = pairs::partners(t, role, table)
                    .filter(move |o| !o.frames.intersect(t.frames).intersect(clip).is_empty());
                others.map(move |o| Roles { second: Some(o), ..alone(t) })
            })
            .collect(),
    }
}

/// How far one candidate met the rule.
struct Reached {
    outcome: Outcome,
    /// Conditions that hold together at the row, where not all of them do.
    held: usize,
    margin: f64,
    /// Row of the pass that is explained.
    row: Option<usize>,
    /// The match as rows, where there is one.
    matched: Option<(usize, usize)>,
}

impl Reached {
    fn beats(&self, other: &Reached) -> bool {
        let by_outcome = self.outcome.cmp(&other.outcome).then(self.held.cmp(&other.held));
        by_outcome.then(self.margin.total_cmp(&other.margin)).is_gt()
    }
}

/// How far a candidate met the rule in the clip; of several matches, the one with this keyframe where one is given.
fn reach<'a>(
    rule: &'a Rule,
    roles: Roles<'a>,
    (clip, keyframe): (FrameRange, Option<usize>),
    evaluator: &mut Evaluator<'a>,
) -> Reached {
    let mut pass = evaluator.pass_of(roles);
    let series = evaluator.series(rule.when, &mut pass);
    let rows = evaluator.rows(&pass).to_vec();
    let undecided =
        Reached { outcome: Outcome::Undecided, held: 0, margin: f64::NEG_INFINITY, row: None, matched: None };
    let Series::Truths(when) = series.as_ref() else { return undecided };
    let inside = |i: usize| rows[i].frame.is_some_and(|f| clip.contains(f));
    let mut best = undecided;
    let of_clip = matches(when, &rows, rule).into_iter().filter(|&(a, b)| (a..=b).any(inside));
    for matched in of_clip {
        let Some(mut located) = locate(rule, matched, evaluator, &mut pass) else { continue };
        if keyframe.is_some_and(|frame| frame != located.keyframe) {
            continue;
        }
        let required = rule.require.iter().map(|id| truth_at(*id, located.row, evaluator, &mut located.at));
        let (truth, margin) =
            required.fold((Tri::True, f64::INFINITY), |(t, m), (u, n)| (t.and(u), m.min(n)));
        let outcome = if truth == Tri::True { Outcome::Matched } else { Outcome::NotAtKeyframe };
        let reached = Reached { outcome, held: 0, margin, row: Some(located.row), matched: Some(matched) };
        if reached.beats(&best) {
            best = reached;
        }
    }
    if best.outcome > Outcome::WrongDuration {
        return best;
    }
    let held_at = held_parts(rule, evaluator, &mut pass);
    for i in (0..rows.len()).filter(|&i| inside(i) && when.value[i] != Tri::Unknown) {
        let outcome = if when.value[i] == Tri::True { Outcome::WrongDuration } else { Outcome::NotTogether };
        let reached =
            Reached { outcome, held: held_at(i), margin: when.margin[i], row: Some(i), matched: None };
        if reached.beats(&best) {
            best = reached;
        }
    }
    best
}

/// By row, the number of the conditions of `when` that hold.
fn held_parts<'a>(
    rule: &'a Rule,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> impl Fn(usize) -> usize + use<> {
    let when = rule.parts.iter().filter(|p| p.place == PartPlace::When);
    let parts: Vec<Rc<Series>> = when.map(|p| evaluator.series(p.condition, pass)).collect();
    let holds =
        |part: &Rc<Series>, i: usize| matches!(part.as_ref(), Series::Truths(t) if t.value[i] == Tri::True);
    move |i| parts.iter().filter(|part| holds(part, i)).count()
}

/// The row of the clip in which most conditions hold and none is known to fail, in a stretch that would be long enough
/// for a match.
fn open<'a>(
    rule: &'a Rule,
    roles: Roles<'a>,
    clip: FrameRange,
    evaluator: &mut Evaluator<'a>,
) -> Option<Reached> {
    let mut pass = evaluator.pass_of(roles);
    let series = evaluator.series(rule.when, &mut pass);
    let rows = evaluator.rows(&pass).to_vec();
    let Series::Truths(when) = series.as_ref() else { return None };
    let not_false = Truths::of_flags(when.value.iter().map(|t| Tri::from(*t != Tri::False)).collect());
    let inside = |i: usize| rows[i].frame.is_some_and(|f| clip.contains(f));
    let held_at = held_parts(rule, evaluator, &mut pass);
    let lasts = |(a, b): &(usize, usize)| rows[*b].end - rows[*a].time >= rule.min_duration;
    let possible = runs(&not_false, &rows, rule).into_iter().filter(lasts).flat_map(|(a, b)| a..=b);
    let unknown = possible.filter(|&i| inside(i) && when.value[i] == Tri::Unknown);
    // The first of equals.
    let row = unknown.min_by_key(|&i| std::cmp::Reverse(held_at(i)))?;
    let held = held_at(row);
    Some(Reached {
        outcome: Outcome::Undecided,
        held,
        margin: f64::NEG_INFINITY,
        row: Some(row),
        matched: None,
    })
}

fn explanation_at<'a>(
    rule: &'a Rule,
    roles: Roles<'a>,
    clip: FrameRange,
    reached: &Reached,
    evaluator: &mut Evaluator<'a>,
) -> Explanation {
    let mut pass = evaluator.pass_of(roles);
    if let Some(located) = reached.matched.and_then(|m| locate(rule, m, evaluator, &mut pass)) {
        pass = located.at;
    }
    let rows = evaluator.rows(&pass).to_vec();
    let frame = reached.row.and_then(|i| rows[i].frame);
    let when = AtRow { rows: &rows, clip, row: reached.row, evaluator, pass: &mut pass }.course(rule.when);
    let duration = (reached.outcome == Outcome::WrongDuration).then(|| Duration {
        held: reached.row.map_or(Nanos::default(), |row| lasted(rule, row, evaluator, &mut pass)),
        least: rule.min_duration,
        most: rule.max_duration,
    });
    let mut of = AtRow { rows: &rows, clip, row: reached.row, evaluator, pass: &mut pass };
    let part = |p: &'a Part| PartCourse { place: p.place, condition: of.condition(&p.structure) };
    let parts = rule.parts.iter().map(part).collect();
    let second = rule.second.as_ref().map(|r| r.name.clone());
    let named = [(Some(rule.target_role.clone()), roles.target), (second, roles.second)];
    Explanation {
        outcome: reached.outcome,
        roles: named.into_iter().filter_map(|(name, who)| Some((name?, who?.id.clone()))).collect(),
        candidates: 0,
        // A keyframe can lie in the clip before or after.
        moment: frame.filter(|f| clip.contains(*f)).map(|f| f - clip.start),
        when,
        parts,
        missing: Vec::new(),
        response: None,
        duration,
    }
}

/// How long the rule's condition holds around `row`.
fn lasted<'a>(rule: &'a Rule, row: usize, evaluator: &mut Evaluator<'a>, pass: &mut Pass<'a>) -> Nanos {
    let series = evaluator.series(rule.when, pass);
    let Series::Truths(when) = series.as_ref() else { return Nanos::default() };
    let rows = evaluator.rows(pass);
    let run = runs(when, rows, rule).into_iter().find(|&(first, last)| (first..=last).contains(&row));
    run.map_or(Nanos::default(), |(first, last)| rows[last].end - rows[first].time)
}

/// The explained row of a candidate, and its clip.
struct AtRow<'e, 'a> {
    rows: &'e [Row],
    clip: FrameRange,
    row: Option<usize>,
    evaluator: &'e mut Evaluator<'a>,
    pass: &'e mut Pass<'a>,
}

impl AtRow<'_, '_> {
    fn condition(&mut self, of: &Structure) -> ConditionCourse {
        let atom = &of.shown;
        let (actual, actual_words) = match self.row {
            Some(row) => measured_in_words(atom, row, self.evaluator, self.pass),
            None => (Value::Null, None),
        };
        ConditionCourse {
            text: atom.text.clone(),
            words: atom.words.clone(),
            definition: of.definition.clone(),
            is_named: of.is_named,
            join: of.join,
            members: of.members.iter().map(|m| self.condition(m)).collect(),
            is_listed_above: of.is_listed_above,
            course: self.course(atom.condition),
            is_measured: atom.measured != atom.condition,
            actual_words,
            actual,
            unit: atom.unit.symbol,
            values: self.curve(atom),
            threshold: atom.threshold,
        }
    }

    fn course(&mut self, id: NodeId) -> Course {
        let n = self.rows.len();
        let truths = match self.evaluator.series(id, self.pass).as_ref() {
            Series::Truths(t) => t.clone(),
            _ => Truths::unknown(n),
        };
        over_clip(&truths, self.rows, self.clip, self.row)
    }

    /// The measured number over the frames of the clip.
    fn curve(&mut self, atom: &Atom) -> Vec<f64> {
        let series = self.evaluator.series(atom.measured, self.pass);
        let Series::Numbers(numbers) = series.as_ref() else { return Vec::new() };
        let mut out = vec![f64::NAN; self.clip.end - self.clip.start];
        for (row, value) in self.rows.iter().zip(numbers) {
            if let Some(f) = row.frame.filter(|f| self.clip.contains(*f)) {
                out[f - self.clip.start] = value / atom.unit.to_base;
            }
        }
        out
    }
}

fn over_clip(truths: &Truths, rows: &[Row], clip: FrameRange, row: Option<usize>) -> Course {
    let mut cells = vec![Cell::Absent; clip.end - clip.start];
    for (r, t) in rows.iter().zip(&truths.value) {
        if let Some(f) = r.frame.filter(|f| clip.contains(*f)) {
            cells[f - clip.start] = Cell::Known(*t);
        }
    }
    Course {
        cells,
        truth: row.map_or(Tri::Unknown, |i| truths.value[i]),
        margin: row.map_or(f64::NAN, |i| truths.margin[i]),
    }
}

fn nobody(clip: FrameRange) -> Explanation {
    let cells = vec![Cell::Absent; clip.end - clip.start];
    Explanation {
        outcome: Outcome::NoCandidate,
        roles: BTreeMap::new(),
        candidates: 0,
        moment: None,
        when: Course { cells, truth: Tri::Unknown, margin: f64::NAN },
        parts: Vec::new(),
        missing: Vec::new(),
        response: None,
        duration: None,
    }
}

#[cfg(test)]
mod tests;
