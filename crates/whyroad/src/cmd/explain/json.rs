//! An explanation as JSON: the verdict, and every condition over time as spans of frames of the clip.

use super::Shown;
use super::moments::Moments;
use serde_json::{Value, json};
use whyroad_mining::explain::{Cell, ConditionCourse, Course, Duration, Outcome, PartCourse};
use whyroad_mining::language::check::Join;
use whyroad_mining::rule::PartPlace;
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{Nanos, Tri};

/// The whole document.
pub(super) fn document(shown: &Shown<'_>) -> Value {
    let e = shown.explanation;
    // A moment that a class explains is not one of `other`.
    let is_explained = shown.moments.as_ref().is_some_and(Moments::all_explained);
    let (outcome, matched) =
        if is_explained { ("explained", false) } else { (outcome(e.outcome), e.outcome == Outcome::Matched) };
    let mut out = json!({
        "class": shown.class.to_string(),
        "clip": shown.clip,
        "outcome": outcome,
        "matched": matched,
        "roles": e.roles,
        "candidates": e.candidates,
        "frame_rate_hz": FRAME_RATE_HZ,
        "frames": e.when.cells.len(),
        "frame": e.moment,
        "seconds": e.moment.map(|frame| shown.seconds(frame)),
        "times_s": shown.times_s,
        "duration": e.duration.map(duration),
        "missing_signals": e.missing,
        "when": course(&e.when),
        "conditions": e.parts.iter().map(part).collect::<Vec<_>>(),
    });
    if !shown.variants.is_empty() {
        let one = |v: &super::Variant| json!({ "class": v.class.to_string(), "frame": v.frame, "seconds": v.frame.map(|f| shown.seconds(f)) });
        out["reported_as"] = shown.variants.iter().map(one).collect();
    }
    if let Some(moments) = &shown.moments {
        out["moments"] = json!(moments);
    }
    out
}

fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::NoCandidate => "no_candidate",
        Outcome::Undecided => "undecided",
        Outcome::NotTogether => "not_together",
        Outcome::WrongDuration => "wrong_duration",
        Outcome::NotAtKeyframe => "not_at_keyframe",
        Outcome::Matched => "matched",
    }
}

fn part(p: &PartCourse) -> Value {
    let place = match p.place {
        PartPlace::When => "when",
        PartPlace::Require => "require",
    };
    let mut out = condition(&p.condition);
    out["place"] = place.into();
    out
}

/// A condition with its members. `actual` is null where it is unknown or infinite; the truth beside it distinguishes
/// the two.
fn condition(c: &ConditionCourse) -> Value {
    let join = match c.join {
        Join::Single => None,
        Join::All => Some("all"),
        Join::Any => Some("any"),
        Join::Not => Some("not"),
        Join::OverTime => Some("over_time"),
    };
    let mut out = json!({ "text": c.text, "description": c.words, "course": course(&c.course) });
    if let Some(name) = &c.definition {
        out["definition"] = name.as_str().into();
    }
    match join {
        None => {
            out["actual"] = c.actual.clone();
            out["unit"] = c.unit.into();
        }
        Some(join) => {
            out["join"] = join.into();
            out["conditions"] = c.members.iter().map(condition).collect();
            out["listed_above"] = c.is_listed_above.into();
        }
    }
    out
}

fn duration(d: Duration) -> Value {
    let seconds = |t: Nanos| t.0 as f64 / 1e9;
    json!({ "held_s": seconds(d.held), "min_s": seconds(d.least), "max_s": d.most.map(seconds) })
}

/// Truth and margin at the explained frame, and the truth of all frames as half-open spans. A margin that is unknown or
/// infinite is null.
fn course(c: &Course) -> Value {
    let margin = c.margin.is_finite().then_some(c.margin);
    json!({ "truth": word(Cell::Known(c.truth)), "margin": margin, "spans": spans(&c.cells) })
}

fn spans(cells: &[Cell]) -> Vec<Value> {
    let mut start = 0;
    let mut out = Vec::new();
    for run in cells.chunk_by(|a, b| a == b) {
        let end = start + run.len();
        out.push(json!({ "start": start, "end": end, "truth": word(run[0]) }));
        start = end;
    }
    out
}

fn word(cell: Cell) -> &'static str {
    match cell {
        Cell::Known(Tri::True) => "true",
        Cell::Known(Tri::False) => "false",
        Cell::Known(Tri::Unknown) => "unknown",
        Cell::Absent => "absent",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_frames_become_one_half_open_span() {
        let (yes, no) = (Cell::Known(Tri::True), Cell::Known(Tri::False));
        let found = spans(&[no, no, yes, Cell::Absent]);
        let expected = [(0, 2, "false"), (2, 3, "true"), (3, 4, "absent")]
            .map(|(start, end, truth)| json!({ "start": start, "end": end, "truth": truth }));
        assert_eq!(found, expected);
        assert!(spans(&[]).is_empty());
    }
}
