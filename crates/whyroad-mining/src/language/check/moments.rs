//! Moments of labeling specs: `min(rises(target.turn_signal in {left, right}), keyframe - 5 s)`. The same
//! grammar as conditions; what makes it a moment is its position in the rule.

use super::super::program::Moment;
use super::super::syntax::{ArithmeticOp, Expr, ExprKind};
use super::{Checker, Fault, names};
use whyroad_model::Nanos;

impl Checker<'_> {
    /// The moment that an expression means.
    pub fn moment(&mut self, expr: &Expr) -> Result<Moment, Fault> {
        match &expr.kind {
            ExprKind::Name(n) if n == "keyframe" => Ok(Moment::Keyframe),
            ExprKind::Name(n) if n == "match.start" => Ok(Moment::MatchStart),
            ExprKind::Name(n) if n == "match.end" => Ok(Moment::MatchEnd),
            ExprKind::Arithmetic(op @ (ArithmeticOp::Add | ArithmeticOp::Subtract), of, time) => {
                let (of, time) = (self.moment(of)?, self.duration(time)?);
                let time = if *op == ArithmeticOp::Add { time } else { Nanos(-time.0) };
                Ok(Moment::Offset(Box::new(of), time))
            }
            ExprKind::Call(name, arguments) => match (name.as_str(), arguments.as_slice()) {
                ("first", [c]) => Ok(Moment::First(self.condition(c)?)),
                ("last", [c]) => Ok(Moment::Last(self.condition(c)?)),
                ("least", [x]) => Ok(Moment::Least(self.number(x)?.0)),
                ("greatest", [x]) => Ok(Moment::Greatest(self.number(x)?.0)),
                ("min", all) if all.len() > 1 => {
                    Ok(Moment::Earliest(all.iter().map(|e| self.moment(e)).collect::<Result<_, _>>()?))
                }
                ("max", all) if all.len() > 1 => {
                    Ok(Moment::Latest(all.iter().map(|e| self.moment(e)).collect::<Result<_, _>>()?))
                }
                _ => Ok(Moment::Nearest(self.condition(expr)?)),
            },
            ExprKind::Name(name) => {
                let of = self.condition(expr).map_err(|fault| names::or_moment(name, fault))?;
                Ok(Moment::Nearest(of))
            }
            _ => Ok(Moment::Nearest(self.condition(expr)?)),
        }
    }
}
