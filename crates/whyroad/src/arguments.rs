//! Values of options that several commands have.

use crate::output::reason::{Reason, reason};
use whyroad_model::{Lang, Nanos};

pub(crate) fn not_a_number() -> Reason {
    reason("不是数", "not a number")
}

/// A share, 0 to 1.
pub(crate) fn share(text: &str) -> Result<f64, Reason> {
    let value: f64 = text.parse().map_err(|_| not_a_number())?;
    let fits = (0.0..=1.0).contains(&value);
    fits.then_some(value).ok_or_else(|| reason("应在 0 与 1 之间", "must be between 0 and 1"))
}

/// A time with its offset from UTC.
pub(crate) fn time(text: &str) -> Result<Nanos, Reason> {
    Nanos::parse_iso(text).map_err(|e| e.text().into())
}

/// A language of the user interface.
pub(crate) fn lang(text: &str) -> Result<Lang, Reason> {
    text.to_ascii_lowercase().parse().map_err(|e: String| reason(format!("没有语言 '{text}'（zh 或 en）"), e))
}
