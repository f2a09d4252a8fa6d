//! Every error of an expression. Checking stops at the first one; here the parts of a wrong expression are checked one
//! by one, so that the user sees all errors at once. A whole is reported only if its parts are correct.

use super::super::Fault;
use super::super::syntax::{ArithmeticOp, CompareOp, Expr, ExprKind};
use super::{Checker, Meaning};

/// Required type of an expression.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Condition,
    Number,
    Anything,
    Duration,
    Moment,
}

impl Checker<'_> {
    /// All faults of an expression of any type of which `first` is one, in the order of the text.
    pub fn every_fault(&mut self, expr: &Expr, first: Fault) -> Vec<Fault> {
        self.every(expr, Wanted::Anything, first)
    }

    /// All faults of a moment of which `first` is one, in the order of the text.
    pub fn every_fault_of_moment(&mut self, expr: &Expr, first: Fault) -> Vec<Fault> {
        self.every(expr, Wanted::Moment, first)
    }

    fn every(&mut self, expr: &Expr, wanted: Wanted, first: Fault) -> Vec<Fault> {
        let mut found = Vec::new();
        self.gather(expr, wanted, &mut found);
        // A condition that is one only as a whole (a match is not there yet in `when`) has no faulty part.
        if found.is_empty() {
            found.push(first);
        }
        found.sort_by_key(|f| (f.span.start, f.span.end));
        found.dedup();
        found
    }

    fn probe(&mut self, expr: &Expr, wanted: Wanted) -> Result<(), Fault> {
        match wanted {
            Wanted::Condition => self.condition(expr).map(|_| ()),
            Wanted::Number => self.number(expr).map(|_| ()),
            Wanted::Anything => self.lower(expr).map(|_| ()),
            Wanted::Duration => self.duration(expr).map(|_| ()),
            Wanted::Moment => self.moment(expr).map(|_| ()),
        }
    }

    fn gather(&mut self, expr: &Expr, wanted: Wanted, found: &mut Vec<Fault>) {
        let Err(fault) = self.probe(expr, wanted) else { return };
        let before = found.len();
        match (&expr.kind, wanted) {
            (_, Wanted::Duration) => {}
            (ExprKind::Arithmetic(ArithmeticOp::Add | ArithmeticOp::Subtract, of, time), Wanted::Moment) => {
                self.gather(of, Wanted::Moment, found);
                self.gather(time, Wanted::Duration, found);
            }
            (ExprKind::Call(name, arguments), _) => self.gather_call(name, arguments, wanted, found),
            (ExprKind::Compare(first, rest), _) => self.gather_comparison(first, rest, found),
            (ExprKind::In(of, members), _) => {
                self.gather(of, Wanted::Anything, found);
                if found.len() == before {
                    for member in members {
                        let one = ExprKind::In(of.clone(), vec![member.clone()]);
                        found.extend(self.lower(&Expr { kind: one, span: expr.span }).err());
                    }
                }
            }
            (ExprKind::Number(_) | ExprKind::Name(_), _) => {}
            (ExprKind::Negate(of), _) => self.gather(of, Wanted::Number, found),
            (ExprKind::Arithmetic(_, a, b), _) => {
                self.gather(a, Wanted::Number, found);
                self.gather(b, Wanted::Number, found);
            }
            (ExprKind::Not(of), _) => self.gather(of, Wanted::Condition, found),
            (ExprKind::Known(of), _) => {
                let outer = std::mem::replace(&mut self.asks_if_known, true);
                self.gather(of, Wanted::Anything, found);
                self.asks_if_known = outer;
            }
            (ExprKind::At(of), _) => self.gather(of, Wanted::Anything, found),
            (ExprKind::And(all) | ExprKind::Or(all), _) => {
                for part in all {
                    self.gather(part, Wanted::Condition, found);
                }
            }
            (ExprKind::For(of, time) | ExprKind::Within(of, time) | ExprKind::Gaps(of, time), _) => {
                self.gather(of, Wanted::Condition, found);
                self.gather(time, Wanted::Duration, found);
            }
            (ExprKind::Since(a, b, time) | ExprKind::Until(a, b, time), _) => {
                self.gather(a, Wanted::Condition, found);
                self.gather(b, Wanted::Condition, found);
                if let Some(time) = time {
                    self.gather(time, Wanted::Duration, found);
                }
            }
            (ExprKind::Then(a, b, time), _) => {
                self.gather(a, Wanted::Condition, found);
                self.gather(b, Wanted::Condition, found);
                self.gather(time, Wanted::Duration, found);
            }
        }
        if found.len() == before {
            found.push(fault);
        }
    }

    fn gather_call(&mut self, name: &str, arguments: &[Expr], wanted: Wanted, found: &mut Vec<Fault>) {
        use Wanted::{Condition, Duration, Moment, Number};
        let outer = self.meaning;
        let all: Vec<Wanted> = match (name, arguments.len()) {
            ("min" | "max", n) if wanted == Moment && n > 1 => vec![Moment; n],
            ("abs" | "least" | "greatest", 1) => vec![Number],
            ("min" | "max", 2) => vec![Number, Duration],
            ("share" | "previously", 2) => vec![Condition, Duration],
            ("rises" | "falls" | "previously" | "first" | "last", 1) => vec![Condition],
            // The kind of object is a separate word.
            ("exists" | "forall" | "count", 1 | 2) => {
                self.meaning = Meaning::Counted;
                vec![Condition]
            }
            _ => vec![],
        };
        for (argument, wanted) in arguments.iter().zip(all) {
            self.gather(argument, wanted, found);
        }
        self.meaning = outer;
    }

    /// Pair by pair; a name on the other side of an error may be a value of the wrong part.
    fn gather_comparison(&mut self, first: &Expr, rest: &[(CompareOp, Expr)], found: &mut Vec<Fault>) {
        let mut left = first;
        for (op, right) in rest {
            if let Err(fault) = self.compare(*op, left, right) {
                let before = found.len();
                for side in [left, right] {
                    let value = matches!(&side.kind, ExprKind::Name(name) if !name.contains('.'));
                    let elsewhere = side.span.end <= fault.span.start || fault.span.end <= side.span.start;
                    if !(value && elsewhere) {
                        self.gather_side(side, found);
                    }
                }
                if found.len() == before {
                    found.push(fault);
                }
            }
            left = right;
        }
    }

    /// A side of a comparison: a count or an extreme is valid there and nowhere else.
    fn gather_side(&mut self, side: &Expr, found: &mut Vec<Fault>) {
        match &side.kind {
            ExprKind::Call(name, arguments) if matches!(name.as_str(), "count" | "least" | "greatest") => {
                self.gather_call(name, arguments, Wanted::Anything, found);
            }
            _ => self.gather(side, Wanted::Anything, found),
        }
    }
}
