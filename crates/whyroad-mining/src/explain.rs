//! Why a rule matched or did not in one clip: its parts one by one over time, and the moment at which it matched or
//! came nearest to a match. Uses the reference evaluator, which keeps the truth of every part.

mod nearest;

pub use nearest::{NearClass, UndecidedClass, UnmetCondition, nearest, undecided};

use crate::episode::build::{locate, matches, measured, truth_at};
use crate::episode::{Episode, find, pairs};
use crate::interpret::{Evaluator, Pass, Roles, Row, Series, Truths};
use crate::language::program::{Atom, NodeId, Op};
use crate::rule::{PartPlace, Rule};
use serde_json::Value;
use std::collections::BTreeMap;
use std::rc::Rc;
use whyroad_model::messages::EgoResponse;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Bilingual, FrameRange, SignalTable, TrackId, Tri};

/// How far a rule was met, from least to most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// No possible target is observed in the clip.
    NoCandidate,
    /// No frame of the clip could be decided.
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
    /// As written, names replaced by their definitions.
    pub text: String,
    /// In words.
    pub words: Bilingual,
    /// Its truth over time.
    pub course: Course,
    /// Its comparisons.
    pub atoms: Vec<AtomCourse>,
}

/// A comparison in a part.
#[derive(Clone, Debug, PartialEq)]
pub struct AtomCourse {
    /// As written.
    pub text: String,
    /// In words.
    pub words: Bilingual,
    /// Its truth over time.
    pub course: Course,
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
}

/// Explains a rule on the frames `clip` of a drive; for one target, or for the best candidate.
pub fn explain(rule: &Rule, table: &SignalTable, clip: FrameRange, wanted: Option<&TrackId>) -> Explanation {
    let mut evaluator = Evaluator::new(&rule.program, table);
    let all = candidates(rule, table, clip, wanted);
    let mut best: Option<(Reached, Roles<'_>)> = None;
    for roles in &all {
        let reached = reach(rule, *roles, clip, &mut evaluator);
        // The first of equals, so that the answer depends only on the drive.
        if best.as_ref().is_none_or(|(b, _)| reached.beats(b)) {
            best = Some((reached, *roles));
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
        out.missing = find(rule, table).missing.into_iter().collect();
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

fn reach<'a>(rule: &'a Rule, roles: Roles<'a>, clip: FrameRange, evaluator: &mut Evaluator<'a>) -> Reached {
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
    let parts: Vec<Rc<Series>> = rule
        .parts
        .iter()
        .filter(|p| p.place == PartPlace::When)
        .map(|p| evaluator.series(p.condition, &mut pass))
        .collect();
    let holds =
        |part: &Rc<Series>, i: usize| matches!(part.as_ref(), Series::Truths(t) if t.value[i] == Tri::True);
    for i in (0..rows.len()).filter(|&i| inside(i) && when.value[i] != Tri::Unknown) {
        let outcome = if when.value[i] == Tri::True { Outcome::WrongDuration } else { Outcome::NotTogether };
        let held = parts.iter().filter(|part| holds(part, i)).count();
        let reached = Reached { outcome, held, margin: when.margin[i], row: Some(i), matched: None };
        if reached.beats(&best) {
            best = reached;
        }
    }
    best
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
    let course = |id: NodeId, evaluator: &mut Evaluator<'a>, pass: &mut Pass<'a>| {
        let n = rows.len();
        let truths = match evaluator.series(id, pass).as_ref() {
            Series::Truths(t) => t.clone(),
            _ => Truths::unknown(n),
        };
        over_clip(&truths, &rows, clip, reached.row)
    };
    let when = course(rule.when, evaluator, &mut pass);
    let mut parts = Vec::new();
    for part in &rule.parts {
        let mut atoms = Vec::new();
        for atom in &part.atoms {
            let actual = reached.row.map_or(Value::Null, |row| measured(atom, row, evaluator, &mut pass));
            let of_atom = course(atom.condition, evaluator, &mut pass);
            atoms.push(AtomCourse {
                text: atom.text.clone(),
                words: atom.words.clone(),
                course: of_atom,
                actual_words: atom.value_in_words(&actual),
                actual,
                unit: atom.unit.symbol,
                values: curve(atom, &rows, clip, evaluator, &mut pass),
                threshold: threshold(rule, atom),
            });
        }
        let of_part = course(part.condition, evaluator, &mut pass);
        let (text, words) = (part.text.clone(), part.words.clone());
        parts.push(PartCourse { place: part.place, text, words, course: of_part, atoms });
    }
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
    }
}

/// The measured number over the frames of the clip.
fn curve<'a>(
    atom: &Atom,
    rows: &[Row],
    clip: FrameRange,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> Vec<f64> {
    let series = evaluator.series(atom.measured, pass);
    let Series::Numbers(numbers) = series.as_ref() else { return Vec::new() };
    let mut out = vec![f64::NAN; clip.end - clip.start];
    for (row, value) in rows.iter().zip(numbers) {
        if let Some(f) = row.frame.filter(|f| clip.contains(*f)) {
            out[f - clip.start] = value / atom.unit.to_base;
        }
    }
    out
}

/// The constant of a comparison, in the unit of its atom.
fn threshold(rule: &Rule, atom: &Atom) -> Option<f64> {
    let Op::Compare { left, right, .. } = &rule.program.node(atom.condition).op else { return None };
    [right, left].into_iter().find_map(|id| match rule.program.node(*id).op {
        Op::Constant(value) => Some(value / atom.unit.to_base),
        _ => None,
    })
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
    }
}
