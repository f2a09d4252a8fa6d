//! Operators that are written as calls.

use super::super::Fault;
use super::super::program::{NodeId, Op, Subject, ValueKind};
use super::super::syntax::{Expr, ExprKind, Span};
use super::pairs::Among;
use super::words::unknown_call;
use super::{Checker, Lowered, Meaning};
use whyroad_model::units::Dimension;

impl Checker<'_> {
    pub(super) fn call(&mut self, name: &str, arguments: &[Expr], span: Span) -> Lowered {
        match (name, arguments) {
            ("abs", [x]) => {
                let (id, d) = self.number(x)?;
                Ok(self.program.add(Op::Absolute(id), ValueKind::Number(d)))
            }
            ("min" | "max", [x, time]) => {
                let ((id, d), time) = (self.number(x)?, self.duration(time)?);
                let op = if name == "min" { Op::Least(id, time) } else { Op::Greatest(id, time) };
                Ok(self.program.add(op, ValueKind::Number(d)))
            }
            ("share", [c, time]) => {
                let (id, time) = (self.condition(c)?, self.duration(time)?);
                Ok(self.program.add(Op::Share(id, time), ValueKind::Number(Dimension::Ratio)))
            }
            ("rises" | "falls", [c]) => {
                let now = self.condition(c)?;
                let before = self.flag(Op::Before(now));
                let (now, before) = if name == "rises" {
                    (now, self.flag(Op::Not(before)))
                } else {
                    (self.flag(Op::Not(now)), before)
                };
                Ok(self.flag(Op::And(vec![now, before])))
            }
            ("previously", [c]) => {
                let id = self.condition(c)?;
                Ok(self.flag(Op::Previously(id, None)))
            }
            ("previously", [c, time]) => {
                let (id, time) = (self.condition(c)?, self.duration(time)?);
                Ok(self.flag(Op::Previously(id, Some(time))))
            }
            ("exists", [_] | [_, _]) => {
                let counted = self.counted(name, arguments, span)?;
                Ok(self.at_least(counted, 1))
            }
            ("forall", [_] | [_, _]) => {
                let (of, subject, among) = self.counted(name, arguments, span)?;
                let of = self.flag(Op::Not(of));
                let exception = self.at_least((of, subject, among), 1);
                Ok(self.flag(Op::Not(exception)))
            }
            ("count", [_] | [_, _]) => Err(Fault::new(
                "rule.type",
                span,
                "count(…) 须与整数比较",
                "a count is compared with a whole number",
            )
            .hint("例如 count(target.gap < 20 m) >= 2", "as in count(target.gap < 20 m) >= 2")),
            ("least" | "greatest", [_]) => Err(Fault::new(
                "rule.type",
                span,
                format!("{name}(…) 须直接与一个值比较，或单独作为时刻"),
                format!("{name}(..) is compared directly with a value, or is a moment by itself"),
            )
            .hint(format!("例如 {name}(target.ttc) < 2 s"), format!("as in {name}(target.ttc) < 2 s"))),
            _ => Err(unknown_call(name, arguments.len(), span)),
        }
    }

    /// The counted condition and the counted objects: `count(c)`, `count(c, vru)`. Inside, `target.` is each object in
    /// turn; where the condition uses `pair.` or `other.`, these are for the rule's object and each object near it in
    /// turn.
    pub(super) fn counted(
        &mut self,
        name: &str,
        arguments: &[Expr],
        span: Span,
    ) -> Result<(NodeId, Subject, Among), Fault> {
        let ([of] | [of, _]) = arguments else { return Err(unknown_call(name, arguments.len(), span)) };
        let stated = arguments.get(1).map(kind_of_object).transpose()?;
        let outer = (self.subject.take(), self.meaning);
        self.meaning = Meaning::Counted;
        let id = self.condition(of);
        let prefix = self.subject;
        (self.subject, self.meaning) = outer;
        let id = id?;
        let among = self.among(name, id, of)?;
        if among == Among::Near && self.meaning == Meaning::Counted {
            return Err(Fault::new(
                "rule.target",
                span,
                format!("{name} 说到 pair.* 或 other.* 时不能嵌套在另一个 exists、forall 或 count 之内"),
                format!(
                    "{name} uses pair.* or other.* and cannot be nested in another exists, forall or count"
                ),
            ));
        }
        Ok((id, stated.or(prefix).unwrap_or(Subject::Any), among))
    }
}

fn kind_of_object(word: &Expr) -> Result<Subject, Fault> {
    let subject = match &word.kind {
        ExprKind::Name(n) => Subject::from_word(n),
        _ => None,
    };
    subject.ok_or_else(|| {
        Fault::new("rule.target", word.span, "此处应为目标种类", "expected a kind of target").hint(
            "可用：vehicle, large_vehicle, vru, any，或一个类别，如 bicycle",
            "use vehicle, large_vehicle, vru, any, or a class, such as bicycle",
        )
    })
}
