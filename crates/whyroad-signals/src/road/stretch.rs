//! Ranges of the driven path.

/// Sampling step of the path, m.
pub const STEP_M: f64 = 0.5;

/// Part of the path, arc lengths in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
}
