//! The signal table of a case: 10 Hz, the target first, then other objects by name.

use super::trace::{self, Segment, segments};
use super::{CaseText, duration};
use crate::evaluate::STEP;
use std::collections::BTreeMap;
use std::sync::Arc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Column, FrameRange, Nanos, SignalTable, Tri};
use whyroad_signals::{Catalogue, SignalKind};

/// The table that the case describes.
pub(super) fn table(
    case: &CaseText,
    base: &BTreeMap<String, String>,
    catalogue: &Catalogue,
) -> Result<SignalTable, String> {
    let n = frame_of(duration(&case.duration)?);
    let mut table = SignalTable {
        drive_id: "case".into(),
        times: (0..n as i64).map(|i| Nanos(i * STEP.0)).collect(),
        ..SignalTable::default()
    };
    let target = case.target.map(|class| ("target", class, &case.seen));
    let others = case.objects.iter().map(|(name, o)| (name.as_str(), o.class, &o.seen));
    for (name, class, seen) in target.into_iter().chain(others) {
        let first_row = table.targets.last().map_or(0, |t| t.first_row + t.frames.end - t.frames.start);
        table.targets.push(TargetSpan {
            id: name.into(),
            class,
            first_row,
            frames: frames(seen.as_ref(), n)?,
        });
    }
    let mut all = base.clone();
    all.extend(case.signals.clone());
    let lacks = |name: &String| case.lacks.contains(name);
    for (name, text) in &all {
        let (object, signal) = match name.split_once('.') {
            Some((object, rest)) if case.objects.contains_key(object) => (object, format!("target.{rest}")),
            _ => ("target", name.clone()),
        };
        if lacks(&signal) {
            continue;
        }
        let def = catalogue.get(&signal).ok_or(format!("there is no signal '{name}'"))?;
        let of_object = def.name.starts_with("target.");
        if of_object && object == "target" && case.target.is_none() {
            continue;
        }
        let column = column(&segments(text)?, &def.kind, n).map_err(|e| format!("{name}: {e}"))?;
        if of_object {
            let spans = table.targets.clone();
            let rows = table
                .target_columns
                .entry(def.name.clone())
                .or_insert_with(|| nothing_known(&column, &spans));
            if let Some(span) = spans.iter().find(|s| s.id.as_str() == object) {
                fill(rows, &column, span);
            }
        } else {
            table.frame_columns.insert(def.name.clone(), column);
        }
    }
    for name in &case.lacks {
        table.unavailable.insert(name.clone(), vec!["the case says so".to_owned()]);
    }
    Ok(table)
}

fn frame_of(t: Nanos) -> usize {
    usize::try_from(t.0 / STEP.0).unwrap_or(0)
}

fn frames(seen: Option<&[String; 2]>, n: usize) -> Result<FrameRange, String> {
    match seen {
        Some([from, to]) => Ok(FrameRange::new(frame_of(duration(from)?), frame_of(duration(to)?).min(n))),
        None => Ok(FrameRange::new(0, n)),
    }
}

fn column(segments: &[Segment], kind: &SignalKind, n: usize) -> Result<Column, String> {
    let values = trace::expand(segments, n);
    match kind {
        SignalKind::Number(_) => {
            let number = |v: &trace::Value| match v {
                trace::Value::Number(x) => Ok(*x),
                trace::Value::Word(w) if w == "unknown" => Ok(f64::NAN),
                trace::Value::Word(w) if w == "never" => Ok(f64::INFINITY),
                trace::Value::Word(w) => Err(format!("'{w}' is not a number")),
            };
            values.iter().map(number).collect::<Result<_, _>>().map(Column::Number)
        }
        SignalKind::Flag => {
            let flag = |v: &trace::Value| match v {
                trace::Value::Word(w) if w == "true" => Ok(Tri::True),
                trace::Value::Word(w) if w == "false" => Ok(Tri::False),
                trace::Value::Word(w) if w == "unknown" => Ok(Tri::Unknown),
                other => Err(format!("{other:?} is neither true nor false")),
            };
            values.iter().map(flag).collect::<Result<_, _>>().map(Column::Flag)
        }
        SignalKind::Category(names) => {
            let code = |v: &trace::Value| match v {
                trace::Value::Word(w) if w == "unknown" => Ok(UNKNOWN_CODE),
                trace::Value::Word(w) => names
                    .iter()
                    .position(|n| n == w)
                    .and_then(|i| u16::try_from(i).ok())
                    .ok_or(format!("'{w}' is not one of {}", names.join(", "))),
                trace::Value::Number(x) => Err(format!("{x} is not a name")),
            };
            let codes = values.iter().map(code).collect::<Result<_, _>>()?;
            Ok(Column::Category { codes, names: Arc::clone(names) })
        }
    }
}

/// A column like `like` for all objects, in which nothing is said yet.
fn nothing_known(like: &Column, spans: &[TargetSpan]) -> Column {
    let rows = spans.iter().map(|s| s.frames.end - s.frames.start).sum();
    match like {
        Column::Number(_) => Column::Number(vec![f64::NAN; rows]),
        Column::Flag(_) => Column::Flag(vec![Tri::Unknown; rows]),
        Column::Category { names, .. } => {
            Column::Category { codes: vec![UNKNOWN_CODE; rows], names: Arc::clone(names) }
        }
    }
}

/// Writes an object's rows: those of the frames in which it is seen.
fn fill(rows: &mut Column, of_case: &Column, span: &TargetSpan) {
    let (from, to) = (span.frames.start, span.frames.end);
    let out = span.first_row..span.first_row + to - from;
    match (rows, of_case) {
        (Column::Number(a), Column::Number(b)) => a[out].copy_from_slice(&b[from..to]),
        (Column::Flag(a), Column::Flag(b)) => a[out].copy_from_slice(&b[from..to]),
        (Column::Category { codes: a, .. }, Column::Category { codes: b, .. }) => {
            a[out].copy_from_slice(&b[from..to]);
        }
        // One signal has one kind.
        _ => {}
    }
}
