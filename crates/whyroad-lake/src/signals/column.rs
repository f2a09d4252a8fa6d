//! A column in the form that rules use.

use super::StoredDrive;
use super::bitmap::Bitmap;
use super::pages::{Dense, Values};
use std::sync::Arc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::{Column, Tri};

/// A column as it was decoded. Bits are 64 rows per word, the first row in the lowest bit; those beyond the end are 0.
#[derive(Clone, Debug, PartialEq)]
pub enum StoredColumn {
    /// The numbers of those rows in which it is known, one after another; which rows these are, unless all are.
    Numbers(Vec<f64>, Option<Vec<u64>>),
    /// Which are true of those rows in which it is known, one after another; which rows these are, unless all are.
    Flags(Vec<u64>, Option<Vec<u64>>),
    /// Codes into words, one per row.
    Words(Vec<u16>, Arc<[String]>),
}

impl StoredColumn {
    /// The values read for a signal; `None` where the column's type is not a signal type.
    pub(super) fn of(dense: Dense, name: &str, of: &StoredDrive, rows: usize) -> Option<Self> {
        let Dense { values, known } = dense;
        Some(match values {
            Values::Numbers(values) => Self::Numbers(values, known.map(|k| k.words)),
            Values::Flags(bits) => Self::Flags(bits.words, known.map(|k| k.words)),
            Values::Texts(codes, texts) => {
                let words = words(of, name);
                // The file's own dictionary is in the order of first occurrence.
                let code = |text: &String| {
                    let at = words.iter().position(|w| w == text);
                    at.and_then(|i| u16::try_from(i).ok()).unwrap_or(UNKNOWN_CODE)
                };
                let of_text: Vec<u16> = texts.iter().map(code).collect();
                let codes: Vec<u16> = codes
                    .iter()
                    .map(|c| of_text.get(usize::from(*c)).copied().unwrap_or(UNKNOWN_CODE))
                    .collect();
                Self::Words(spread(codes, known.as_ref(), rows, UNKNOWN_CODE), words)
            }
            Values::Integers(_) => return None,
        })
    }

    /// As a column of a signal table with this number of rows.
    pub fn into_column(self, rows: usize) -> Column {
        let bitmap = |words| Bitmap { words, len: rows, ones: 0 };
        match self {
            Self::Numbers(v, known) => Column::Number(spread(v, known.map(bitmap).as_ref(), rows, f64::NAN)),
            Self::Flags(yes, known) => {
                let (yes, known) = (bitmap(yes), known.map(bitmap));
                let n = known.as_ref().map_or(rows, |k| (0..rows).filter(|i| k.get(*i)).count());
                let flags = (0..n).map(|i| Tri::from(yes.get(i))).collect();
                Column::Flag(spread(flags, known.as_ref(), rows, Tri::Unknown))
            }
            Self::Words(codes, names) => Column::Category { codes, names },
        }
    }
}

/// The words of a category, in the order of their codes.
pub(super) fn words(of: &StoredDrive, name: &str) -> Arc<[String]> {
    of.words.get(name).map(|w| w.as_slice().into()).unwrap_or_default()
}

/// A value per row: `hole` where nothing is known.
fn spread<T: Copy>(values: Vec<T>, known: Option<&Bitmap>, rows: usize, hole: T) -> Vec<T> {
    let Some(known) = known else { return values };
    let mut values = values.into_iter();
    (0..rows).map(|i| if known.get(i) { values.next().unwrap_or(hole) } else { hole }).collect()
}
