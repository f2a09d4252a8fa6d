//! One rule on one drive: its matches, and an episode for each that also meets `require` at its keyframe.

use super::kinds::Kinds;
use super::moment::{Known, Sought, resolve};
use super::observable::lacking_signals;
use super::pairs;
use super::{Episode, Rank};
use crate::interpret::{CLOCK_TOLERANCE, Evaluator, Moments, Pass, Roles, Row, Series, Truths};
use crate::language::program::{Atom, Moment, NodeId};
use crate::rule::{Listed, Rule};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::messages::{EgoResponse, MatchedCondition};
use whyroad_model::{Bilingual, Column, FrameRange, Nanos, SignalTable, TrackId, Tri};

/// The results of one rule on one drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// Episodes in order of targets, then time.
    pub episodes: Vec<Episode>,
    /// Signals that the rule needs and the drive does not have, where it cannot be decided without them (also where an
    /// alternative found episodes); where no row could be decided, those that are never known. Empty: the drive was
    /// searched for the class.
    pub missing: BTreeSet<String>,
}

/// Runs one rule over one drive.
pub fn find(rule: &Rule, table: &SignalTable) -> Found {
    let mut evaluator = Evaluator::new(&rule.program, table);
    let mut found = Found::default();
    let mut decided = Decided::default();
    let Some(subject) = rule.subject else {
        on_rows(rule, Roles::default(), &mut evaluator, &mut found.episodes, &mut decided);
        return finished(found, rule, table, &decided);
    };
    for span in table.targets.iter().filter(|t| subject.admits(t.class)) {
        let alone = Roles { target: Some(span), second: None };
        let Some(role) = &rule.second else {
            on_rows(rule, alone, &mut evaluator, &mut found.episodes, &mut decided);
            continue;
        };
        if let Some(rows) = pairs::hopeless(rule, alone, &mut evaluator) {
            decided.rows += rows;
            decided.known += rows;
            continue;
        }
        for second in pairs::partners(span, role, table) {
            let pair = Roles { second: Some(second), ..alone };
            on_rows(rule, pair, &mut evaluator, &mut found.episodes, &mut decided);
        }
    }
    finished(found, rule, table, &decided)
}

fn finished(mut found: Found, rule: &Rule, table: &SignalTable, decided: &Decided) -> Found {
    found.missing = missing(rule, table, decided);
    found
}

/// How much of the rule's condition was known.
#[derive(Default)]
struct Decided {
    rows: usize,
    known: usize,
}

/// Signals that the rule needs and the drive does not have, where it cannot be decided without them, whatever else
/// happens in the drive: one without braking would otherwise count as searched for stops at a light that it does not
/// show, and one with braking would not, so that rates were wrong. Where no row could be decided, those that it does
/// not have, or else those that are never known.
fn missing(rule: &Rule, table: &SignalTable, decided: &Decided) -> BTreeSet<String> {
    let lacking = lacking(rule, table);
    if !lacking.is_empty() || decided.rows == 0 || decided.known > 0 {
        return lacking;
    }
    let absent = absent(rule, table);
    if !absent.is_empty() {
        return absent;
    }
    let never_known = |s: &String| column(s, table).is_some_and(|c| c.known_count() == 0);
    rule.needs().into_iter().filter(never_known).collect()
}

/// Signals that the rule needs and the drive does not have; none where it can be decided without them.
pub(crate) fn lacking(rule: &Rule, table: &SignalTable) -> BTreeSet<String> {
    let shown = Kinds::of(table).shown_to(rule.subject);
    lacking_signals(rule, &rule.needs(), |s| column(s, table).is_some() && shown(s))
}

fn absent(rule: &Rule, table: &SignalTable) -> BTreeSet<String> {
    rule.needs().into_iter().filter(|s| column(s, table).is_none()).collect()
}

fn column<'a>(signal: &str, table: &'a SignalTable) -> Option<&'a Column> {
    let of_pair = || table.pairs.as_ref().and_then(|p| p.columns.get(signal));
    table.frame_columns.get(signal).or_else(|| table.target_columns.get(signal)).or_else(of_pair)
}

fn on_rows<'a>(
    rule: &'a Rule,
    roles: Roles<'a>,
    evaluator: &mut Evaluator<'a>,
    out: &mut Vec<Episode>,
    decided: &mut Decided,
) {
    let mut pass = evaluator.pass_of(roles);
    let series = evaluator.series(rule.when, &mut pass);
    let Series::Truths(when) = series.as_ref() else { return };
    decided.rows += when.value.len();
    decided.known += when.value.iter().filter(|t| **t != Tri::Unknown).count();
    for (first, last) in matches(when, evaluator.rows(&pass), rule) {
        out.extend(episode(rule, roles, when, (first, last), evaluator, &mut pass));
    }
}

/// Runs of true as first and last row, near ones merged, too short and too long ones dropped.
pub(crate) fn matches(when: &Truths, rows: &[Row], rule: &Rule) -> Vec<(usize, usize)> {
    let mut runs = runs(when, rows, rule);
    runs.retain(|&(first, last)| {
        let lasts = rows[last].end - rows[first].time;
        lasts + CLOCK_TOLERANCE >= rule.min_duration
            && rule.max_duration.is_none_or(|max| lasts <= max + CLOCK_TOLERANCE)
    });
    runs
}

/// Runs of true as first and last row, near ones merged.
pub(crate) fn runs(when: &Truths, rows: &[Row], rule: &Rule) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (i, t) in when.value.iter().enumerate() {
        if *t != Tri::True {
            continue;
        }
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == i || rows[i].time - rows[*last].end <= rule.merge_gap => {
                *last = i
            }
            _ => runs.push((i, i)),
        }
    }
    runs
}

/// A match with its keyframe.
pub(crate) struct Located<'a> {
    times: Times,
    known: Known,
    /// Frame of the drive.
    pub(crate) keyframe: usize,
    keyframe_rule: Bilingual,
    /// The pass for this episode.
    pub(crate) at: Pass<'a>,
    /// The row at which the conditions are evaluated.
    pub(crate) row: usize,
}

/// Where the keyframe of a match is.
pub(crate) fn locate<'a>(
    rule: &'a Rule,
    (first, last): (usize, usize),
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> Option<Located<'a>> {
    let times = Times::of(evaluator, pass, (first, last))?;
    let mut known = Known { first, last, keyframe: None };
    let (keyframe_time, keyframe_rule) = keyframe(rule, known, evaluator, pass);
    let keyframe = times.frame_at(keyframe_time);
    known.keyframe = Some(times.time(keyframe));
    // A keyframe may lie outside the match (0.5 s before the turn): the conditions are evaluated at the nearest frame
    // of the match.
    let judged = keyframe.clamp(times.matched.start, times.matched.end - 1);
    let at = evaluator.at_episode(pass, Moments { keyframe: judged, matched: times.matched });
    let row = evaluator.rows(&at).iter().position(|r| r.frame == Some(judged))?;
    Some(Located { times, known, keyframe, keyframe_rule, at, row })
}

fn episode<'a>(
    rule: &'a Rule,
    roles: Roles<'a>,
    when: &Truths,
    (first, last): (usize, usize),
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> Option<Episode> {
    let Located { times, known, keyframe, keyframe_rule, mut at, row } =
        locate(rule, (first, last), evaluator, pass)?;
    let mut margin = mean_margin(when, first, last);
    for id in &rule.require {
        let (truth, m) = truth_at(*id, row, evaluator, &mut at);
        if truth != Tri::True {
            return None;
        }
        margin = margin.min(m);
    }
    let conditions = conditions(rule, row, evaluator, &mut at);
    let second = rule.timing.second_keyframe.iter();
    let second = second.filter_map(|m| resolve(m, Sought::Keyframe, known, evaluator, &mut at)).next();
    let mut bound = |ways: &[Moment], sought, default: Nanos| {
        ways.iter().find_map(|m| resolve(m, sought, known, evaluator, &mut at)).unwrap_or(default)
    };
    let start = bound(&rule.timing.start, Sought::Start, times.time(times.matched.start));
    let end = bound(&rule.timing.end, Sought::End, times.end(times.matched.end - 1));
    let until = bound(rule.timing.after_until.as_slice(), Sought::End, Nanos(i64::MAX));
    let start = start.min(times.time(keyframe));
    // The time range holds the keyframe's own frame.
    let end = end.max(times.end(keyframe));
    let range = times.range(start, end);
    let after = (end + rule.timing.after).min(until.max(end));
    let answered_in = FrameRange::new(times.matched.start, range.end);
    let response = answered(rule, answered_in, evaluator, &mut at);
    Some(Episode {
        scenario: rule.scenario.clone(),
        target: roles.target.map(|s| s.id.clone()),
        roles: named(rule, roles),
        matched: times.matched,
        kind: rule.timing.kind,
        keyframe,
        second_keyframe: second.map(|t| times.frame_at(t)),
        range,
        context: times.range(start - rule.timing.before, after),
        keyframe_rule,
        response,
        score: rule.margin_score(margin),
        share: None,
        conditions,
        signals: rule.signals().into_iter().collect(),
        rank: Rank::Primary,
    })
}

/// Whether the ego responded in these frames.
fn answered<'a>(
    rule: &'a Rule,
    range: FrameRange,
    evaluator: &mut Evaluator<'a>,
    at: &mut Pass<'a>,
) -> EgoResponse {
    let Some(asked) = rule.response else { return EgoResponse::Observed };
    let mut drive = evaluator.pass(None);
    let pass = if asked.of_target { at } else { &mut drive };
    let series = evaluator.series(asked.condition, pass);
    let Series::Truths(truths) = series.as_ref() else { return EgoResponse::Unknown };
    let by_frame: BTreeMap<usize, Tri> = evaluator
        .rows(pass)
        .iter()
        .zip(&truths.value)
        .filter_map(|(row, truth)| row.frame.map(|frame| (frame, *truth)))
        .collect();
    super::response(range, |frame| by_frame.get(&frame).copied())
}

/// Object for each role, for a rule that binds two objects.
fn named(rule: &Rule, roles: Roles<'_>) -> BTreeMap<String, TrackId> {
    match (&rule.second, roles.target, roles.second) {
        (Some(role), Some(a), Some(b)) => {
            BTreeMap::from([(rule.target_role.clone(), a.id.clone()), (role.name.clone(), b.id.clone())])
        }
        _ => BTreeMap::new(),
    }
}

/// The first expression that finds the keyframe, with its rule in words.
fn keyframe<'a>(
    rule: &'a Rule,
    known: Known,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> (Nanos, Bilingual) {
    for (moment, words) in &rule.timing.keyframe {
        if let Some(time) = resolve(moment, Sought::Keyframe, known, evaluator, pass) {
            return (time, words.clone());
        }
    }
    (evaluator.rows(pass)[known.first].time, rule.timing.at_match_start.clone())
}

/// Mean over the rows of the match in which the condition held.
fn mean_margin(when: &Truths, first: usize, last: usize) -> f64 {
    let held: Vec<f64> =
        (first..=last).filter(|&i| when.value[i] == Tri::True).map(|i| when.margin[i]).collect();
    held.iter().sum::<f64>() / held.len() as f64
}

pub(crate) fn truth_at<'a>(
    id: NodeId,
    row: usize,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> (Tri, f64) {
    match evaluator.series(id, pass).as_ref() {
        Series::Truths(t) => (t.value[row], t.margin[row]),
        _ => (Tri::Unknown, f64::NAN),
    }
}

fn conditions<'a>(
    rule: &'a Rule,
    row: usize,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> Vec<MatchedCondition> {
    let mut listed: Vec<(&Atom, f64)> = Vec::new();
    for atom in &rule.atoms {
        let (holds, margin) = truth_at(atom.condition, row, evaluator, pass);
        if rule.listed == Listed::All || holds == Tri::True {
            listed.push((atom, margin));
        }
    }
    let margins: Vec<(&str, f64)> = listed.iter().map(|(atom, m)| (atom.text.as_str(), *m)).collect();
    let one = |i: usize| {
        let atom = listed[i].0;
        let actual_value = measured(atom, row, evaluator, pass);
        atom.matched(actual_value)
    };
    super::deciding(&margins).into_iter().map(one).collect()
}

/// The conditions of a rule as an episode lists them, but at any frame of a match: `frame`, of the drive. `None` where
/// the target is not observed there.
pub fn conditions_at(
    rule: &Rule,
    table: &SignalTable,
    target: Option<&TrackId>,
    (frame, matched): (usize, FrameRange),
) -> Option<Vec<MatchedCondition>> {
    let mut evaluator = Evaluator::new(&rule.program, table);
    let target = match target {
        Some(id) => Some(table.targets.iter().find(|t| t.id == *id)?),
        None => None,
    };
    let pass = evaluator.pass_of(Roles { target, second: None });
    let mut pass = evaluator.at_episode(&pass, Moments { keyframe: frame, matched });
    let row = evaluator.rows(&pass).iter().position(|r| r.frame == Some(frame))?;
    Some(conditions(rule, row, &mut evaluator, &mut pass))
}

/// The measured value in the atom's unit; null when unknown or infinite.
pub(crate) fn measured<'a>(
    atom: &Atom,
    row: usize,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> Value {
    match evaluator.series(atom.measured, pass).as_ref() {
        Series::Numbers(v) => atom.number(v[row]),
        Series::Truths(t) => t.value[row].known().map_or(Value::Null, Value::Bool),
        Series::Categories(codes, names) => {
            names.get(usize::from(codes[row])).map_or(Value::Null, |n| Value::String(n.clone()))
        }
    }
}

/// [`measured`], and the same as text: with its unit, or as infinite.
pub(crate) fn measured_in_words<'a>(
    atom: &Atom,
    row: usize,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> (Value, Option<Bilingual>) {
    let infinite = match evaluator.series(atom.measured, pass).as_ref() {
        Series::Numbers(v) if v[row] == f64::INFINITY => Some(Bilingual::new("无穷大", "infinite")),
        Series::Numbers(v) if v[row] == f64::NEG_INFINITY => {
            Some(Bilingual::new("负无穷大", "negative infinity"))
        }
        _ => None,
    };
    let value = measured(atom, row, evaluator, pass);
    let words = infinite.or_else(|| atom.value_in_words(&value));
    (value, words)
}

/// Frames of the drive by time.
struct Times {
    /// Rows of the drive that are frames, by frame.
    frames: Vec<Row>,
    matched: FrameRange,
}

impl Times {
    fn of(evaluator: &Evaluator<'_>, pass: &Pass<'_>, (first, last): (usize, usize)) -> Option<Times> {
        let rows = evaluator.rows(pass);
        // Rows of a match begin and end with a frame: a gap is never true.
        let matched = FrameRange::new(rows[first].frame?, rows[last].frame? + 1);
        let drive = evaluator.pass(None);
        let frames = evaluator.rows(&drive).iter().filter(|r| r.frame.is_some()).copied().collect();
        Some(Times { frames, matched })
    }

    fn time(&self, frame: usize) -> Nanos {
        self.frames[frame].time
    }

    fn end(&self, frame: usize) -> Nanos {
        self.frames[frame].end
    }

    /// The frame that begins nearest to `time`; the earlier one of two that are equally near.
    fn frame_at(&self, time: Nanos) -> usize {
        let distance = |i: &usize| (self.frames[*i].time.0 - time.0).abs();
        (0..self.frames.len()).min_by_key(distance).unwrap_or(0)
    }

    /// Frames from `start` until `end`, clamped to the drive.
    fn range(&self, start: Nanos, end: Nanos) -> FrameRange {
        let from = self.frame_at(start);
        let beyond = self.frames.last().is_none_or(|l| (l.end.0 - end.0).abs() <= (l.time.0 - end.0).abs());
        // A frame before a gap may have ended although it begins nearer to `end` than the next one.
        let nearest = self.frame_at(end);
        let to = if beyond { self.frames.len() } else { nearest + usize::from(self.end(nearest) <= end) };
        FrameRange::new(from, to.max(from + 1))
    }
}
