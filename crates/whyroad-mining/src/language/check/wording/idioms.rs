//! Common patterns of rules that are displayed in fewer words: guards against unknown values, a condition before or
//! after now, an event in a stretch of time.

use crate::language::syntax::{Expr, ExprKind};

/// The members of a conjunction without those that only require a value used by another one to be known.
pub(super) fn without_guards(all: &[Expr]) -> Vec<&Expr> {
    let is_guard = |i: usize, e: &Expr| match &e.kind {
        ExprKind::Known(of) => all.iter().enumerate().any(|(j, other)| j != i && contains(other, of)),
        _ => false,
    };
    let kept: Vec<&Expr> = all.iter().enumerate().filter(|(i, e)| !is_guard(*i, e)).map(|(_, e)| e).collect();
    if kept.is_empty() { all.iter().collect() } else { kept }
}

/// The members of a disjunction without those that another one, of a longer time, includes: `c or previously(c, 3 s)`.
pub(in crate::language::check) fn without_repeats(all: &[Expr]) -> Vec<&Expr> {
    let includes = |e: &Expr, c: &Expr| match &e.kind {
        ExprKind::Within(of, _) => same(of, c),
        ExprKind::Call(name, arguments) if name == "previously" => same(&arguments[0], c),
        _ => false,
    };
    all.iter().filter(|c| !all.iter().any(|e| includes(e, c))).collect()
}

/// `previously(c, 3 s)` and `c within 3 s`, in either order: the condition and the time.
pub(in crate::language::check) fn around<'e>(a: &'e Expr, b: &'e Expr) -> Option<(&'e Expr, &'e Expr)> {
    let one_way = |a: &'e Expr, b: &'e Expr| match (&a.kind, &b.kind) {
        (ExprKind::Within(of, time), ExprKind::Call(name, arguments)) if name == "previously" => {
            let [c, before] = arguments.as_slice() else { return None };
            (same(of, c) && same(time, before)).then_some((&**of, &**time))
        }
        _ => None,
    };
    one_way(a, b).or_else(|| one_way(b, a))
}

/// `a until b` and `a since b`, in either order: b happens in the present run of a.
pub(in crate::language::check) fn during<'e>(a: &'e Expr, b: &'e Expr) -> Option<(&'e Expr, &'e Expr)> {
    match (&a.kind, &b.kind) {
        (ExprKind::Until(a, b, _), ExprKind::Since(c, d, _))
        | (ExprKind::Since(a, b, _), ExprKind::Until(c, d, _)) => {
            (same(a, c) && same(b, d)).then_some((&**a, &**b))
        }
        _ => None,
    }
}

/// True where one expression is part of another, outside of `is known`.
fn contains(whole: &Expr, part: &Expr) -> bool {
    if matches!(whole.kind, ExprKind::Known(_)) {
        return false;
    }
    same(whole, part) || whole.parts().into_iter().any(|e| contains(e, part))
}

/// True for expressions that are written alike, in any position.
pub(super) fn same(a: &Expr, b: &Expr) -> bool {
    match (&a.kind, &b.kind) {
        (ExprKind::Name(x), ExprKind::Name(y)) => x == y,
        (ExprKind::Number(x), ExprKind::Number(y)) => x == y,
        (ExprKind::In(x, xs), ExprKind::In(y, ys)) => {
            same(x, y) && xs.iter().map(|(w, _)| w).eq(ys.iter().map(|(w, _)| w))
        }
        (ExprKind::Call(f, xs), ExprKind::Call(g, ys)) => {
            f == g && xs.len() == ys.len() && xs.iter().zip(ys).all(|(x, y)| same(x, y))
        }
        (ExprKind::Name(_) | ExprKind::Number(_) | ExprKind::In(..) | ExprKind::Call(..), _) => false,
        (x, y) if std::mem::discriminant(x) != std::mem::discriminant(y) => false,
        (ExprKind::Compare(_, xs), ExprKind::Compare(_, ys))
            if !xs.iter().map(|c| c.0).eq(ys.iter().map(|c| c.0)) =>
        {
            false
        }
        (ExprKind::Arithmetic(f, ..), ExprKind::Arithmetic(g, ..)) if f != g => false,
        _ => {
            let (xs, ys) = (a.parts(), b.parts());
            xs.len() == ys.len() && xs.into_iter().zip(ys).all(|(x, y)| same(x, y))
        }
    }
}
