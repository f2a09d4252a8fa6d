//! Comparisons: of numbers, categories and conditions; and of bounds on many numbers (a count over objects, an extreme
//! over the match), which become conditions that can be unknown.

use super::super::Fault;
use super::super::program::{NodeId, Op, ValueKind};
use super::super::syntax::{CompareOp, Expr, ExprKind, Span};
use super::words::{kind_en, kind_zh, mismatch};
use super::{Checker, Lowered, names, nearest};
use whyroad_model::units::Dimension;

impl Checker<'_> {
    pub(super) fn compare(&mut self, op: CompareOp, a: &Expr, b: &Expr) -> Lowered {
        if let Some(special) = self.compare_count(op, a, b).or_else(|| self.compare_extreme(op, a, b)) {
            return special;
        }
        let left = self.lower(a)?;
        if let ValueKind::Category(members) = self.program.node(left).kind.clone() {
            return self.compare_category(op, left, &members, b, a.span.to(b.span));
        }
        let right = self.lower(b)?;
        let span = a.span.to(b.span);
        let (l, r) = (self.program.node(left).kind.clone(), self.program.node(right).kind.clone());
        match (l, r) {
            // Nothing is measured, so that there is no value to show.
            (ValueKind::Number(x), ValueKind::Number(y))
                if x == y && self.quantity(a).is_some() && self.quantity(b).is_some() =>
            {
                Err(Fault::new(
                    "rule.type",
                    span,
                    "这里比较的是两个固定值：结果永远相同".to_owned(),
                    "this compares two fixed values: its result is always the same".to_owned(),
                )
                .hint(
                    "比较信号与固定值；区间写成 5 m/s < ego.speed < 10 m/s，信号在中间",
                    "compare a signal with a fixed value; a range has the signal in the middle: 5 m/s < ego.speed < 10 m/s",
                ))
            }
            (ValueKind::Number(x), ValueKind::Number(y)) if x == y => {
                let scale = self.scale(left).or_else(|| self.scale(right)).unwrap_or(1.0);
                Ok(self.flag(Op::Compare { op, left, right, scale }))
            }
            (ValueKind::Number(x), ValueKind::Number(Dimension::Ratio))
                if matches!(b.kind, ExprKind::Number(_)) =>
            {
                let base = x.base().symbol;
                Err(mismatch(span, x, Dimension::Ratio)
                    .hint(format!("请写上单位，例如 {base}"), format!("write the unit, such as {base}")))
            }
            (ValueKind::Number(x), ValueKind::Number(y)) => Err(mismatch(span, x, y)),
            (ValueKind::Condition, ValueKind::Condition)
                if op == CompareOp::Equal || op == CompareOp::NotEqual =>
            {
                let (both, neither) = {
                    let (nl, nr) = (self.flag(Op::Not(left)), self.flag(Op::Not(right)));
                    (self.flag(Op::And(vec![left, right])), self.flag(Op::And(vec![nl, nr])))
                };
                let same = self.flag(Op::Or(vec![both, neither]));
                Ok(if op == CompareOp::Equal { same } else { self.flag(Op::Not(same)) })
            }
            (l, r) => Err(Fault::new(
                "rule.type",
                span,
                format!("{}不能与{}比较", kind_zh(&l), kind_zh(&r)),
                format!("cannot compare {} with {}", kind_en(&l), kind_en(&r)),
            )),
        }
    }

    fn compare_category(
        &mut self,
        op: CompareOp,
        of: NodeId,
        members: &[String],
        b: &Expr,
        span: Span,
    ) -> Lowered {
        let (ExprKind::Name(word), CompareOp::Equal | CompareOp::NotEqual) = (&b.kind, op) else {
            return Err(Fault::new(
                "rule.type",
                span,
                "类别只能用 ==、!= 或 in 与名称比较",
                "a category is compared with a name, by ==, != or `in`",
            ));
        };
        let id = self.member(of, members, &[(word.clone(), b.span)])?;
        Ok(if op == CompareOp::Equal { id } else { self.flag(Op::Not(id)) })
    }

    pub(super) fn membership(&mut self, of: &Expr, members: &[(String, Span)]) -> Lowered {
        let id = self.lower(of)?;
        match self.program.node(id).kind.clone() {
            ValueKind::Category(known) => self.member(id, &known, members),
            other => Err(Fault::new(
                "rule.type",
                of.span,
                format!("`in` 只用于类别，而不是{}", kind_zh(&other)),
                format!("`in` is for categories, not {}", kind_en(&other)),
            )),
        }
    }

    fn member(&mut self, of: NodeId, known: &[String], members: &[(String, Span)]) -> Lowered {
        for (word, span) in members {
            if self.is_own(word) {
                return Err(names::also_a_value(word, *span));
            }
            self.values.insert(word.clone());
            if !known.contains(word) {
                let all = known.join(", ");
                let fault = Fault::new(
                    "rule.member.unknown",
                    *span,
                    format!("没有名为 '{word}' 的取值"),
                    format!("'{word}' is not one of the values here"),
                );
                return Err(match nearest(word, known.iter().map(String::as_str)) {
                    Some(n) => fault.hint(
                        format!("是否想写 '{n}'？可用取值：{all}"),
                        format!("did you mean '{n}'? Values: {all}"),
                    ),
                    None => fault.hint(format!("可用取值：{all}"), format!("values: {all}")),
                });
            }
        }
        let mut words: Vec<String> = members.iter().map(|(w, _)| w.clone()).collect();
        words.sort();
        words.dedup();
        Ok(self.flag(Op::Member(of, words)))
    }

    /// `count(c) >= 2` and the like; `None` where neither side is a count.
    fn compare_count(&mut self, op: CompareOp, a: &Expr, b: &Expr) -> Option<Lowered> {
        let is_count = |e: &Expr| matches!(&e.kind, ExprKind::Call(n, _) if n == "count");
        let (op, count, number) = match (is_count(a), is_count(b)) {
            (true, _) => (op, a, b),
            (false, true) => (op.mirrored(), b, a),
            (false, false) => return None,
        };
        Some(self.bounded_count(op, count, number))
    }

    fn bounded_count(&mut self, op: CompareOp, count: &Expr, number: &Expr) -> Lowered {
        let whole = self
            .quantity(number)
            .filter(|q| q.unit.dimension == Dimension::Ratio && q.base() >= 0.0 && q.base().fract() == 0.0);
        let Some(n) = whole.map(|q| q.base() as usize) else {
            return Err(Fault::new(
                "rule.type",
                number.span,
                "count 只能与非负整数比较",
                "a count is compared with a whole number, zero or more",
            )
            .hint("例如 count(target.gap < 20 m) >= 2", "as in count(target.gap < 20 m) >= 2"));
        };
        if n == 0 && op == CompareOp::Less && !self.asks_if_known {
            return Err(Fault::new(
                "rule.never",
                count.span.to(number.span),
                "这个条件永远不会成立",
                "this condition is never true",
            )
            .hint(
                "个数不会小于 0；一个也没有写作 count(…) == 0",
                "a count is never less than 0; none at all is count(...) == 0",
            ));
        }
        let ExprKind::Call(name, arguments) = &count.kind else { return self.lower(count) };
        let counted = self.counted(name, arguments, count.span)?;
        let (n, over) = (self.at_least(counted, n), self.at_least(counted, n + 1));
        Ok(match op {
            CompareOp::GreaterOrEqual => n,
            CompareOp::Greater => over,
            CompareOp::Less => self.flag(Op::Not(n)),
            CompareOp::LessOrEqual => self.flag(Op::Not(over)),
            CompareOp::Equal | CompareOp::NotEqual => {
                let not_over = self.flag(Op::Not(over));
                let equal = self.flag(Op::And(vec![n, not_over]));
                if op == CompareOp::Equal { equal } else { self.flag(Op::Not(equal)) }
            }
        })
    }

    /// `least(x) < 2 s` and the like over the match; `None` where neither side is such an extreme.
    fn compare_extreme(&mut self, op: CompareOp, a: &Expr, b: &Expr) -> Option<Lowered> {
        let (op, extreme, value) = match (extreme_of(a), extreme_of(b)) {
            (Some(e), _) => (op, e, b),
            (None, Some(e)) => (op.mirrored(), e, a),
            (None, None) => return None,
        };
        Some(self.bounded_extreme(op, extreme, value))
    }

    fn bounded_extreme(&mut self, op: CompareOp, (which, of): (Extreme, &Expr), value: &Expr) -> Lowered {
        let span = of.span.to(value.span);
        let bound = self.lower(value)?;
        if self.varies(bound) {
            return Err(Fault::new(
                "rule.type",
                value.span,
                "least、greatest 只能与固定的值（或 at keyframe 的值）比较",
                "least and greatest are compared with a fixed value, or one at the keyframe",
            ));
        }
        if matches!(op, CompareOp::Equal | CompareOp::NotEqual) {
            return Err(Fault::new(
                "rule.type",
                span,
                "least、greatest 只能用 <、<=、>、>= 比较",
                "least and greatest are compared by <, <=, > or >=",
            ));
        }
        let each = self.compare(op, of, value)?;
        let below = matches!(op, CompareOp::Less | CompareOp::LessOrEqual);
        // The least is below a value when some frame is; it is above when every frame is.
        if (which == Extreme::Least) == below {
            return Ok(self.flag(Op::InMatch(each)));
        }
        let breaks = self.flag(Op::Not(each));
        let somewhere = self.flag(Op::InMatch(breaks));
        Ok(self.flag(Op::Not(somewhere)))
    }

    /// True when the node can differ from frame to frame of one episode.
    fn varies(&self, id: NodeId) -> bool {
        match &self.program.node(id).op {
            Op::Signal(_) | Op::SecondSignal(_) | Op::PairSignal { .. } => true,
            op if op.is_of_episode() => false,
            op => op.operands().into_iter().any(|o| self.varies(o)),
        }
    }
}

/// End of a range.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Extreme {
    Least,
    Greatest,
}

/// `least(x)` or `greatest(x)`, with its x.
pub(super) fn extreme_of(expr: &Expr) -> Option<(Extreme, &Expr)> {
    let ExprKind::Call(name, arguments) = &expr.kind else { return None };
    match (name.as_str(), arguments.as_slice()) {
        ("least", [x]) => Some((Extreme::Least, x)),
        ("greatest", [x]) => Some((Extreme::Greatest, x)),
        _ => None,
    }
}
