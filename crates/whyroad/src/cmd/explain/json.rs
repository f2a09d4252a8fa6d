//! An explanation as JSON: the verdict, and every condition over time as spans of frames of the clip.

use super::{Shown, seconds};
use serde_json::{Value, json};
use whyroad_mining::explain::{AtomCourse, Cell, Course, Outcome, PartCourse};
use whyroad_mining::rule::PartPlace;
use whyroad_model::Tri;
use whyroad_model::scene::FRAME_RATE_HZ;

/// The whole document.
pub(super) fn document(shown: &Shown<'_>) -> Value {
    let e = shown.explanation;
    let mut out = json!({
        "class": shown.class.to_string(),
        "clip": shown.clip,
        "outcome": outcome(e.outcome),
        "matched": e.outcome == Outcome::Matched,
        "roles": e.roles,
        "candidates": e.candidates,
        "frame_rate_hz": FRAME_RATE_HZ,
        "frames": e.when.cells.len(),
        "frame": e.moment,
        "seconds": e.moment.map(seconds),
        "missing_signals": e.missing,
        "when": course(&e.when),
        "conditions": e.parts.iter().map(part).collect::<Vec<_>>(),
    });
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
    json!({
        "place": place,
        "text": p.text,
        "description": p.words,
        "course": course(&p.course),
        "comparisons": p.atoms.iter().map(comparison).collect::<Vec<_>>(),
    })
}

/// `actual` is null where it is unknown or infinite; the truth beside it distinguishes the two.
fn comparison(a: &AtomCourse) -> Value {
    json!({
        "text": a.text,
        "description": a.words,
        "actual": a.actual,
        "unit": a.unit,
        "course": course(&a.course),
    })
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
