//! A condition as people read it: its text, and the single comparisons of a chain.

use super::super::syntax::{Expr, ExprKind};
use whyroad_model::Bilingual;

/// A condition as text.
pub(super) struct Displayed {
    pub words: Bilingual,
    /// The words are the name of its definition.
    pub is_name: bool,
}

/// The comparisons of two operands of which a comparison consists.
pub(super) fn pairs(expr: &Expr) -> Vec<Expr> {
    let ExprKind::Compare(first, rest) = &expr.kind else { return vec![expr.clone()] };
    let mut left = first.as_ref();
    let mut out = Vec::with_capacity(rest.len());
    for (op, right) in rest {
        let kind = ExprKind::Compare(Box::new(left.clone()), vec![(*op, right.clone())]);
        out.push(Expr { kind, span: expr.span });
        left = right;
    }
    out
}
