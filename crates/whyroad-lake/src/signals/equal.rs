//! Columns of a drive that have equal values: they are stored once. Mostly these are standard deviations (ten signals
//! are distances and share theirs) and columns in which nothing is known or nothing happens.

use std::collections::HashMap;
use whyroad_model::Column;
use whyroad_model::column::UNKNOWN_CODE;

/// Rows that are compared before whole columns are.
const SAMPLES: usize = 48;

/// For each column, the first one before it that has the same values, bit by bit, and is of the same type. All
/// representations of unknown count as one value. Columns that a drive does not have equal no other column.
pub(super) fn earlier_equals(columns: &[Option<&Column>]) -> Vec<Option<usize>> {
    let mut alike: HashMap<Sample, Vec<usize>> = HashMap::new();
    let mut out = vec![None; columns.len()];
    for (at, column) in columns.iter().enumerate() {
        let Some(column) = column else { continue };
        let before = alike.entry(sample(column)).or_default();
        let same = |of: &usize| columns[*of].is_some_and(|other| equal(other, column));
        match before.iter().copied().find(same) {
            Some(of) => out[at] = Some(of),
            None => before.push(at),
        }
    }
    out
}

/// Values of some rows of a column, after its type.
type Sample = (u8, Vec<u64>);

fn sample(column: &Column) -> Sample {
    let step = column.len().div_ceil(SAMPLES).max(1);
    match column {
        Column::Number(values) => (0, values.iter().step_by(step).map(|x| bits(*x)).collect()),
        Column::Flag(flags) => (1, flags.iter().step_by(step).map(|f| *f as u64).collect()),
        Column::Category { codes, .. } => (2, codes.iter().step_by(step).map(|c| u64::from(*c)).collect()),
    }
}

/// The bits of a number; the same for all that are unknown.
fn bits(number: f64) -> u64 {
    if number.is_nan() { f64::NAN.to_bits() } else { number.to_bits() }
}

fn equal(a: &Column, b: &Column) -> bool {
    match (a, b) {
        (Column::Number(a), Column::Number(b)) => {
            // Blocks without a branch per value: equal columns are compared to their end.
            let alike = |a: &[f64], b: &[f64], bits: fn(f64) -> u64| {
                a.iter().zip(b).fold(true, |all, (a, b)| all & (bits(*a) == bits(*b)))
            };
            // Mostly even the bits of what is unknown are the same.
            let same = |a: &[f64], b: &[f64]| alike(a, b, f64::to_bits) || alike(a, b, bits);
            a.len() == b.len() && a.chunks(256).zip(b.chunks(256)).all(|(a, b)| same(a, b))
        }
        (Column::Flag(a), Column::Flag(b)) => a == b,
        (Column::Category { codes: a, names: m }, Column::Category { codes: b, names: n }) => {
            a == b && (m == n || a.iter().all(|c| *c == UNKNOWN_CODE))
        }
        _ => false,
    }
}
