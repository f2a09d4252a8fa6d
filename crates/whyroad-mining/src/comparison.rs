//! The comparison of two numbers: its truth and its margin.

use crate::language::syntax::CompareOp;
use whyroad_model::Tri;

/// Margins are cut off here; flags and categories, which are true or false without degree, have this margin.
pub const MARGIN_LIMIT: f64 = 2.0;

/// Truth and margin of one comparison; unknown when a side is NaN.
pub(crate) fn compare(op: CompareOp, a: f64, b: f64, scale: f64) -> (Tri, f64) {
    if a.is_nan() || b.is_nan() {
        return (Tri::Unknown, f64::NAN);
    }
    let (truth, raw) = match op {
        CompareOp::Less => (a < b, b - a),
        CompareOp::LessOrEqual => (a <= b, b - a),
        CompareOp::Greater => (a > b, a - b),
        CompareOp::GreaterOrEqual => (a >= b, a - b),
        CompareOp::Equal => (a == b, if a == b { f64::INFINITY } else { -(a - b).abs() }),
        CompareOp::NotEqual => (a != b, if a == b { f64::NEG_INFINITY } else { (a - b).abs() }),
    };
    // Infinity against infinity: neither is closer.
    let raw = if raw.is_nan() { 0.0 } else { raw };
    (Tri::from(truth), (raw / scale).clamp(-MARGIN_LIMIT, MARGIN_LIMIT))
}
