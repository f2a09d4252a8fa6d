//! A fleet's table as one of the layout: its columns under our names, in our units, axes and words, by a mapping.
//!
//! A cell that cannot be converted stays as it is, so that it is reported as any other bad cell.

use super::mapping::{Axes, ColumnMapping, ColumnSource, Dimension, Mapping, TableMapping, is_same};
use super::sheet::{Column, Sheet};
use std::collections::BTreeSet;
use whyroad_model::ObjectClass;

/// Columns that say the same thing in two forms: where the mapping names one, the file's other one is not read.
const EITHER: &[(&str, &str)] = &[
    ("timestamp_ns", "time"),
    ("timestamp_ns", "time_s"),
    ("time", "time_s"),
    ("heading_rad", "heading_deg"),
    ("facing_rad", "facing_deg"),
    ("speed_mps", "vx_mps"),
    ("speed_mps", "vy_mps"),
];

/// Vectors: x, y and z of each.
const VECTORS: &[[&str; 3]] = &[["x_m", "y_m", "z_m"], ["vx_mps", "vy_mps", ""]];
/// Columns of lines.
const LINES: &[&str] = &["centre_xyz_m", "left_xyz_m", "right_xyz_m", "boundary_xyz_m"];
const HEADINGS: &[&str] = &["heading_rad", "heading_deg", "facing_rad", "facing_deg"];
/// Kinds of signs and of states whose number is a speed.
const SPEED_KINDS: &[&str] = &["speed_limit", "nav_speed_limit"];

/// What a mapping found in a table.
pub(super) struct Mapped {
    pub sheet: Sheet,
    /// Names that the mapping has and the file lacks.
    pub absent: Vec<String>,
    /// Columns of the file that nothing reads.
    pub unread: Vec<String>,
}

/// Applies the mapping of a table that has the columns `known`.
pub(super) fn apply(sheet: Sheet, table: &TableMapping, mapping: &Mapping, known: &[&'static str]) -> Mapped {
    let Sheet { label, columns, rows, first_row } = sheet;
    let mut used = BTreeSet::new();
    let (mut out, mut absent) = (Vec::new(), Vec::new());
    for (&name, column) in &table.columns {
        if let ColumnSource::Column(source) = &column.source {
            match columns.iter().find(|c| c.name == *source) {
                Some(found) => {
                    used.insert(source.as_str());
                    let cells = found.cells.iter().map(|c| named(c.as_deref()?, column, table)).collect();
                    let is_ready = found.is_nanoseconds;
                    out.push(Column {
                        name: name.to_owned(),
                        shown: source.clone(),
                        cells,
                        is_nanoseconds: is_ready,
                    });
                }
                None => absent.push(source.clone()),
            }
        } else if let ColumnSource::Constant(value) = &column.source {
            out.push(Column::new(name, vec![Some(value.clone()); rows]));
        }
    }
    let is_replaced = |name: &str| {
        let mapped = |n: &str| table.columns.contains_key(n);
        EITHER.iter().any(|(a, b)| (*a == name && mapped(b)) || (*b == name && mapped(a)))
    };
    let mut unread = Vec::new();
    for column in columns.iter().filter(|c| !used.contains(c.name.as_str())) {
        let name = column.name.as_str();
        if known.contains(&name) && !table.columns.contains_key(name) && !is_replaced(name) {
            let mut column = column.clone();
            let is_unknown = |text: &String| table.unknown.contains(text);
            column.cells.iter_mut().for_each(|cell| *cell = cell.take().filter(|t| !is_unknown(t)));
            out.push(column);
        } else {
            unread.push(name.to_owned());
        }
    }
    let mut sheet = Sheet { label, columns: out, rows, first_row };
    constants_by_class(&mut sheet, table, mapping);
    for (&name, column) in &table.columns {
        convert(&mut sheet, name, column);
    }
    turn(&mut sheet, table);
    Mapped { sheet, absent, unread }
}

/// The cell in our words; `None` where it means unknown.
fn named(cell: &str, column: &ColumnMapping, table: &TableMapping) -> Option<String> {
    if table.unknown.iter().any(|u| u == cell) || column.unknown.iter().any(|u| is_same(cell, u)) {
        return None;
    }
    let word = column
        .words
        .get(cell)
        .or_else(|| column.words.iter().find(|(theirs, _)| is_same(cell, theirs)).map(|(_, ours)| ours));
    Some(word.map_or(cell, String::as_str).to_owned())
}

fn constants_by_class(sheet: &mut Sheet, table: &TableMapping, mapping: &Mapping) {
    let classes: Vec<Option<ObjectClass>> =
        sheet.texts("class").iter().map(|c| mapping.class(c.as_deref()?)).collect();
    for (&name, column) in &table.columns {
        if let ColumnSource::ByClass(values) = &column.source {
            let cells = classes.iter().map(|class| values.get(class.as_ref()?).cloned()).collect();
            sheet.columns.push(Column::new(name, cells));
        }
    }
}

/// Brings the numbers of a column to our unit.
fn convert(sheet: &mut Sheet, name: &'static str, column: &ColumnMapping) {
    let (Some((dimension, own)), true) =
        (Dimension::of_column(name), column.unit.is_some() || column.scale != 1.0 || column.offset != 0.0)
    else {
        return;
    };
    let factor = column.unit.map_or(1.0, |u| u.size / own);
    let value = |v: f64| (v * column.scale + column.offset) * factor;
    let kinds = (dimension == Dimension::SpeedOrLength).then(|| sheet.texts("kind"));
    let Some(target) = sheet.columns.iter_mut().find(|c| c.name == name) else { return };
    // Columns of times know their unit.
    if target.is_nanoseconds {
        return;
    }
    for (i, cell) in target.cells.iter_mut().enumerate() {
        if let (Some(kinds), Some(unit)) = (&kinds, column.unit) {
            let is_speed = kinds[i].as_deref().is_some_and(|k| SPEED_KINDS.contains(&k));
            if is_speed != (unit.dimension == Dimension::Speed) {
                continue;
            }
        }
        let Some(text) = cell.as_deref() else { continue };
        let converted = if name == "timestamp_ns" {
            whole(text, factor)
        } else if LINES.contains(&name) {
            line(text, |p| p.map(value))
        } else {
            text.parse().ok().filter(|v: &f64| v.is_finite()).map(|v| format!("{:?}", value(v)))
        };
        *cell = converted.or_else(|| cell.take());
    }
}

/// A decimal number times a power of ten, in whole nanoseconds: exact, as a time since 1970 has more digits than a
/// float.
fn whole(text: &str, factor: f64) -> Option<String> {
    let power = factor.log10().round() as usize;
    let (digits, part) = text.split_once('.').unwrap_or((text, ""));
    if !part.bytes().all(|b| b.is_ascii_digit()) || digits.parse::<i128>().is_err() {
        // An exponent: the number is a float already.
        let number = text.parse::<f64>().ok().filter(|v| v.is_finite())? * factor;
        return (number.abs() < 9e18).then(|| format!("{number:.0}"));
    }
    let part = format!("{part:0<power$}");
    let nanoseconds: i128 = format!("{digits}{}", &part[..power]).parse().ok()?;
    Some(nanoseconds.to_string())
}

/// `x y; x y` or `x y z; ...`, each point changed; `None` when it is not such a line.
fn line(text: &str, change: impl Fn([f64; 3]) -> [f64; 3]) -> Option<String> {
    let mut out = Vec::new();
    for point in text.split(';').filter(|p| !p.trim().is_empty()) {
        let v: Vec<f64> = point.split_whitespace().map(|n| n.parse().ok()).collect::<Option<_>>()?;
        out.push(match v[..] {
            [x, y] => {
                let [x, y, _] = change([x, y, 0.0]);
                format!("{x:?} {y:?}")
            }
            [x, y, z] => {
                let [x, y, z] = change([x, y, z]);
                format!("{x:?} {y:?} {z:?}")
            }
            _ => return None,
        });
    }
    Some(out.join("; "))
}

/// Turns vectors, lines and headings into the axes of the layout.
fn turn(sheet: &mut Sheet, table: &TableMapping) {
    if table.axes != Axes::EastNorthUp {
        for names in VECTORS {
            turn_vectors(sheet, *names, table.axes);
        }
        for column in sheet.columns.iter_mut().filter(|c| LINES.contains(&c.name.as_str())) {
            for text in column.cells.iter_mut().flatten() {
                if let Some(turned) = line(text, |p| table.axes.turned(p)) {
                    *text = turned;
                }
            }
        }
    }
    let number = |text: &str| text.parse().ok().filter(|v: &f64| v.is_finite());
    for column in &mut sheet.columns {
        let name = column.name.as_str();
        let change: Box<dyn Fn(f64) -> f64> = match name {
            _ if table.headings == Axes::default().headings() => break,
            "heading_deg" | "facing_deg" => {
                Box::new(|v: f64| table.headings.turned(v.to_radians()).to_degrees())
            }
            _ if HEADINGS.contains(&name) => Box::new(|v| table.headings.turned(v)),
            "yaw_rate_radps" => Box::new(|v| v * table.headings.turn_sign()),
            _ => continue,
        };
        for text in column.cells.iter_mut().flatten() {
            if let Some(v) = number(text) {
                *text = format!("{:?}", change(v));
            }
        }
    }
}

/// What the axes do to a vector they do to its columns: each of ours is one of theirs, or its negative.
fn turn_vectors(sheet: &mut Sheet, names: [&str; 3], axes: Axes) {
    let theirs = names.map(|name| sheet.columns.iter().position(|c| c.name == name));
    for (from, at) in theirs.into_iter().enumerate() {
        let Some(at) = at else { continue };
        let mut unit = [0.0; 3];
        unit[from] = 1.0;
        let turned = axes.turned(unit);
        let Some(to) = turned.iter().position(|v| *v != 0.0) else { continue };
        let column = &mut sheet.columns[at];
        column.name = names[to].to_owned();
        if turned[to] < 0.0 {
            for text in column.cells.iter_mut().flatten() {
                if let Ok(v) = text.parse::<f64>() {
                    *text = format!("{:?}", -v);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_keep_their_last_digit() {
        let of = |text: &str, factor: f64| whole(text, factor);
        assert_eq!(of("1700000000123456", 1e3).as_deref(), Some("1700000000123456000"));
        assert_eq!(of("1700000000.123456789", 1e9).as_deref(), Some("1700000000123456789"));
        assert_eq!(of("1700000000123", 1e6).as_deref(), Some("1700000000123000000"));
        assert_eq!(of("1700000000.5", 1e9).as_deref(), Some("1700000000500000000"));
        assert_eq!(of("1.7e9", 1e9).as_deref(), Some("1700000000000000000"));
        assert_eq!((of("soon", 1e6), of("", 1e6), of("-", 1e6)), (None, None, None));
    }
}
