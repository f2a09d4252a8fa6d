//! Causal texts that other tools wrote, as drafts of labels. One file per source format: it takes the content and
//! returns a [`Reading`]; [`draft`] assigns its texts to moments of a drive. Nothing here opens a file: tables come as
//! rows, texts as strings.
//!
//! These sources have only a text. None states a decision of our closed sets (their meta actions state how the car
//! moved, not what it decided), so the decisions of a draft are null, and what cannot be converted is counted by field.

pub mod alpamayo2;
pub mod auto_labeler;
mod draft;
mod findings;
pub mod lerobot;
pub mod ood_reasoning;
#[cfg(test)]
mod tests;

pub use draft::{Place, draft};
pub use findings::{CODES, drive_unknown, fields, unreadable};

use serde_json::{Map, Value};
use std::collections::BTreeMap;
use whyroad_model::{Diagnostic, Nanos};

/// A row of a table, by column.
pub type Row = Map<String, Value>;

/// One causal text with its moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Reasoning {
    /// Source: file and row or event.
    pub origin: String,
    /// Clip, as named by the source.
    pub clip: String,
    /// Moment of the decision, us since the clip's time 0.
    pub at_us: i64,
    /// End of the described period, us since the clip's time 0.
    pub until_us: Option<i64>,
    /// The text.
    pub text: String,
    /// Descriptions of critical components.
    pub components: Vec<String>,
    /// Versions of what it was made with: prompt, name of the model.
    pub versions: BTreeMap<String, String>,
}

/// Content of a source.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// Texts, in the source's order.
    pub found: Vec<Reasoning>,
    /// Number of values for which a label has no field, by field.
    pub left_out: BTreeMap<String, usize>,
    /// Everything to report.
    pub diagnostics: Vec<Diagnostic>,
}

impl Reading {
    /// Adds the content of another file of the source.
    pub fn append(&mut self, other: Reading) {
        self.found.extend(other.found);
        self.diagnostics.extend(other.diagnostics);
        for (field, n) in other.left_out {
            *self.left_out.entry(field).or_default() += n;
        }
    }

    fn leave_out(&mut self, field: impl Into<String>) {
        *self.left_out.entry(field.into()).or_default() += 1;
    }

    /// Counts the fields that are not in `known`; null and empty ones contain no data.
    fn leave_out_others(&mut self, prefix: &str, fields: &Map<String, Value>, known: &[&str]) {
        for (name, value) in fields {
            let empty = match value {
                Value::Null => true,
                Value::String(s) => s.trim().is_empty(),
                Value::Array(a) => a.is_empty(),
                Value::Object(o) => o.is_empty(),
                _ => false,
            };
            if !empty && !known.contains(&name.as_str()) {
                self.leave_out(format!("{prefix}{name}"));
            }
        }
    }
}

/// A text that is not blank.
fn text(value: Option<&Value>) -> Option<String> {
    value.and_then(Value::as_str).map(str::trim).filter(|s| !s.is_empty()).map(str::to_owned)
}

/// A whole number, also if it is written as a float.
fn whole(value: Option<&Value>) -> Option<i64> {
    let value = value?;
    value.as_i64().or_else(|| value.as_f64().filter(|f| f.fract() == 0.0 && f.abs() < 9e15).map(|f| f as i64))
}

/// The causal text of an event: both spellings are in use, and some tools write both.
fn cot_or_coc(event: &Map<String, Value>, origin: &str, reading: &mut Reading) -> Option<String> {
    let (coc, cot) = (text(event.get("coc")), text(event.get("cot")));
    if let (Some(coc), Some(cot)) = (&coc, &cot)
        && coc != cot
    {
        reading.diagnostics.push(findings::conflict(origin));
    }
    coc.or(cot)
}

/// Keys of the causal text.
const TEXTS: [&str; 2] = ["coc", "cot"];
/// Frame period of the sources' own grids, us: 10 Hz.
const FRAME_US: i64 = 100_000;

/// Time 0 of a clip in a drive: `stated`, else `default` where the drive contains it, else the drive's first frame.
pub fn time_zero(times: &[Nanos], stated: Option<Nanos>, default: Nanos) -> Option<Nanos> {
    let (first, last) = (*times.first()?, *times.last()?);
    Some(stated.unwrap_or(if (first..=last).contains(&default) { default } else { first }))
}
