//! The signal table of a case: 10 Hz, the target first, then other objects by name.

use super::file::{CaseText, Reason};
use super::trace::time as duration;
use super::trace::{self, Segment, segments};
use crate::interpret::STEP;
use crate::language::check::nearest;
use crate::language::program::Subject;
use std::collections::BTreeMap;
use std::sync::Arc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::signal::TargetSpan;
use whyroad_model::units::Dimension;
use whyroad_model::{Bilingual, Column, FrameRange, Nanos, SignalId, SignalTable, Tri};
use whyroad_signals::{Catalog, SignalKind};

/// The table that the case describes.
pub(super) fn table(
    case: &CaseText,
    base: &BTreeMap<String, String>,
    catalog: &Catalog,
) -> Result<SignalTable, Reason> {
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
    let lacks = |name: &String| case.lacks.contains(name);
    for (name, text) in &stated(case, base) {
        let (object, signal) = signal_of(case, name);
        if lacks(&signal) {
            continue;
        }
        let def = catalog.get(&signal).ok_or_else(|| no_signal(name, &signal, catalog))?;
        let of_object = def.name.starts_with("target.");
        if of_object && object == "target" && case.target.is_none() {
            continue;
        }
        let column = column(&segments(text)?, &def.kind, n)
            .map_err(|e| Bilingual::new(format!("{name}：{}", e.zh), format!("{name}: {}", e.en)))?;
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
    // The classes of a case's objects state which are large.
    if let Some(name) = Subject::LargeVehicle.signal()
        && !table.targets.is_empty()
        && !table.target_columns.contains_key(name)
        && !lacks(&name.to_owned())
    {
        let of = |t: &TargetSpan| vec![t.class.large_vehicle(); t.frames.end - t.frames.start];
        let large = table.targets.iter().flat_map(of).collect();
        table.target_columns.insert(name.to_owned(), Column::Flag(large));
    }
    for name in &case.lacks {
        let needs = SignalId::from_name(name).map(SignalId::needs).unwrap_or_default();
        table.unavailable.insert(name.clone(), needs.to_vec());
    }
    Ok(table)
}

/// The signals that a case states, with those that all cases of its file have in common.
fn stated(case: &CaseText, base: &BTreeMap<String, String>) -> BTreeMap<String, String> {
    let mut all = base.clone();
    all.extend(case.signals.clone());
    all
}

/// The object and the signal that a name stands for: `obstacle.gap` is `target.gap` of an object of the case.
fn signal_of<'n>(case: &CaseText, name: &'n str) -> (&'n str, String) {
    match name.split_once('.') {
        Some((object, rest)) if case.objects.contains_key(object) => (object, format!("target.{rest}")),
        _ => ("target", name.to_owned()),
    }
}

/// True where the case states a signal whose entry in the catalog has an error, which is reported there.
pub(super) fn lacks_signals(case: &CaseText, base: &BTreeMap<String, String>, catalog: &Catalog) -> bool {
    stated(case, base).keys().any(|name| catalog.lacks(&signal_of(case, name).1))
}

/// What is wrong with a value that all cases have in common; the signals of objects are those of single cases.
pub(super) fn fault_of_base(name: &str, text: &str, catalog: &Catalog) -> Option<Reason> {
    let def = catalog.get(name)?;
    let read = segments(text).and_then(|segments| column(&segments, &def.kind, 1));
    read.err().map(|e| Bilingual::new(format!("{name}：{}", e.zh), format!("{name}: {}", e.en)))
}

pub(super) fn frame_of(t: Nanos) -> usize {
    usize::try_from(t.0 / STEP.0).unwrap_or(0)
}

pub(super) fn frames(seen: Option<&[String; 2]>, n: usize) -> Result<FrameRange, Reason> {
    match seen {
        Some([from, to]) => Ok(FrameRange::new(frame_of(duration(from)?), frame_of(duration(to)?).min(n))),
        None => Ok(FrameRange::new(0, n)),
    }
}

pub(super) fn column(segments: &[Segment], kind: &SignalKind, n: usize) -> Result<Column, Reason> {
    let values = trace::expand(segments, n);
    match kind {
        SignalKind::Number(dimension) => {
            let number = |v: &trace::TraceValue| match v {
                trace::TraceValue::Number(x, unit) if unit == dimension => Ok(*x),
                trace::TraceValue::Number(_, unit) => Err(units_differ(*dimension, *unit)),
                trace::TraceValue::Word(w) if w == "unknown" => Ok(f64::NAN),
                trace::TraceValue::Word(w) if w == "never" => Ok(f64::INFINITY),
                trace::TraceValue::Word(w) => {
                    Err(Bilingual::new(format!("'{w}' 不是数"), format!("'{w}' is not a number")))
                }
            };
            values.iter().map(number).collect::<Result<_, _>>().map(Column::Number)
        }
        SignalKind::Flag => {
            let flag = |v: &trace::TraceValue| match v {
                trace::TraceValue::Word(w) if w == "true" => Ok(Tri::True),
                trace::TraceValue::Word(w) if w == "false" => Ok(Tri::False),
                trace::TraceValue::Word(w) if w == "unknown" => Ok(Tri::Unknown),
                _ => {
                    Err(Bilingual::new("应为 true、false 或 unknown", "it is a flag: true, false or unknown"))
                }
            };
            values.iter().map(flag).collect::<Result<_, _>>().map(Column::Flag)
        }
        SignalKind::Category(names) => {
            let code = |v: &trace::TraceValue| match v {
                trace::TraceValue::Word(w) if w == "unknown" => Some(UNKNOWN_CODE),
                trace::TraceValue::Word(w) => {
                    names.iter().position(|n| n == w).and_then(|i| u16::try_from(i).ok())
                }
                trace::TraceValue::Number(..) => None,
            };
            let all = names.join(", ");
            let codes = values.iter().map(code).collect::<Option<_>>().ok_or_else(|| {
                Bilingual::new(
                    format!("应为 {all} 或 unknown 之一"),
                    format!("it is a category: one of {all}, or unknown"),
                )
            })?;
            Ok(Column::Category { codes, names: Arc::clone(names) })
        }
    }
}

fn units_differ(wanted: Dimension, written: Dimension) -> Reason {
    let (wanted, written) = (wanted.base().symbol, written.base().symbol);
    let name = |symbol: &'static str, zh: bool| match symbol {
        "" if zh => "无单位",
        "" => "no unit",
        symbol => symbol,
    };
    Bilingual::new(
        format!("单位不一致：信号为 {}，此处为 {}", name(wanted, true), name(written, true)),
        format!(
            "units do not match: the signal has {}, this has {}",
            name(wanted, false),
            name(written, false)
        ),
    )
}

fn no_signal(written: &str, meant: &str, catalog: &Catalog) -> Reason {
    let near = nearest(meant, catalog.iter().map(|d| d.name.as_str()));
    let (zh, en) = match near {
        Some(near) => (format!("；是否想写 '{near}'？"), format!("; did you mean '{near}'?")),
        None => (String::new(), String::new()),
    };
    Bilingual::new(format!("没有名为 '{written}' 的信号{zh}"), format!("signal '{written}' not found{en}"))
}

/// A column like `like` for all objects, in which all values are unknown.
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

/// Writes an object's rows: those of the frames in which it is observed.
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
