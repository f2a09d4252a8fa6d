//! Results about expressions that are asked for again: each condition of a rule is shown as a comparison, as a part and
//! in the structure of a part.

use crate::language::syntax::Expr;
use std::cell::RefCell;
use std::collections::HashMap;

/// By the position of an expression in its text: expressions there, and the result for each. Definitions have texts of
/// their own, so that there may be several.
#[derive(Debug)]
pub(super) struct Memo<T>(RefCell<HashMap<(usize, usize), Made<T>>>);

/// What was made of each expression.
type Made<T> = Vec<(Expr, T)>;

impl<T> Default for Memo<T> {
    fn default() -> Self {
        Self(RefCell::default())
    }
}

impl<T: Clone> Memo<T> {
    /// The result for this expression, if it is known.
    pub fn get(&self, expr: &Expr) -> Option<T> {
        let known = self.0.borrow();
        let here = known.get(&(expr.span.start, expr.span.end))?;
        here.iter().find(|(e, _)| e == expr).map(|(_, result)| result.clone())
    }

    /// Keeps the result for an expression for which none is known.
    pub fn put(&self, expr: &Expr, result: T) -> T {
        let mut known = self.0.borrow_mut();
        known.entry((expr.span.start, expr.span.end)).or_default().push((expr.clone(), result.clone()));
        result
    }
}
