//! An expression as written: names not yet looked up, units not yet converted. Every part has its position.

use whyroad_model::units::Unit;

/// Bytes `start..end` of an expression's text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// From the start of `self` to the end of `other`.
    #[must_use]
    pub fn to(self, other: Span) -> Span {
        Span { start: self.start, end: other.end }
    }
}

/// A part of an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// Where it is in the text.
    pub span: Span,
}

/// Size of an expression, its names expanded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Number of expressions from the whole to its deepest part, each in the one before.
    pub height: usize,
    /// Number of expressions in it.
    pub size: usize,
}

impl Extent {
    /// Larger expressions are rejected: reading, printing and evaluating them is recursive, and definitions that name
    /// each other twice double at every step.
    pub const MOST: Extent = Extent { height: 100, size: 20_000 };

    /// True when it is within [`Extent::MOST`].
    pub fn is_sane(self) -> bool {
        self.height <= Self::MOST.height && self.size <= Self::MOST.size
    }
}

impl Expr {
    /// The size of this; `named` returns it for the meaning of a name.
    pub fn extent(&self, named: &dyn Fn(&str) -> Extent) -> Extent {
        let below = match &self.kind {
            ExprKind::Name(name) => named(name),
            _ => self.parts().into_iter().map(|e| e.extent(named)).fold(Extent::default(), |a, b| Extent {
                height: a.height.max(b.height),
                size: a.size.saturating_add(b.size),
            }),
        };
        Extent { height: below.height + 1, size: below.size.saturating_add(1) }
    }

    /// The value of `true` and `false`.
    pub fn truth(&self) -> Option<bool> {
        match &self.kind {
            ExprKind::Name(word) => word.parse().ok(),
            _ => None,
        }
    }

    /// Its direct parts.
    pub fn parts(&self) -> Vec<&Expr> {
        match &self.kind {
            ExprKind::Number(_) | ExprKind::Name(_) => vec![],
            ExprKind::Negate(a)
            | ExprKind::Not(a)
            | ExprKind::Known(a)
            | ExprKind::At(a)
            | ExprKind::In(a, _) => vec![a],
            ExprKind::Call(_, all) | ExprKind::And(all) | ExprKind::Or(all) => all.iter().collect(),
            ExprKind::Compare(a, rest) => {
                std::iter::once(a.as_ref()).chain(rest.iter().map(|(_, e)| e)).collect()
            }
            ExprKind::Arithmetic(_, a, b)
            | ExprKind::For(a, b)
            | ExprKind::Within(a, b)
            | ExprKind::Gaps(a, b) => vec![a, b],
            ExprKind::Then(a, b, c) => vec![a, b, c],
            ExprKind::Since(a, b, c) | ExprKind::Until(a, b, c) => {
                [a, b].into_iter().chain(c).map(Box::as_ref).collect()
            }
        }
    }
}

/// Kinds of expression.
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// `5 km/h`; no unit is a pure number.
    Number(Quantity),
    /// A signal, parameter, definition, member of a closed set, or moment.
    Name(String),
    /// `rises(x)`, `max(x, 3 s)`.
    Call(String, Vec<Expr>),
    /// `-x`.
    Negate(Box<Expr>),
    /// `not c`.
    Not(Box<Expr>),
    /// `a + b` and the like.
    Arithmetic(ArithmeticOp, Box<Expr>, Box<Expr>),
    /// `a and b and c`.
    And(Vec<Expr>),
    /// `a or b or c`.
    Or(Vec<Expr>),
    /// `a < b`, `a < b <= c`.
    Compare(Box<Expr>, Vec<(CompareOp, Expr)>),
    /// `x in {a, b}`.
    In(Box<Expr>, Vec<(String, Span)>),
    /// `x is known`.
    Known(Box<Expr>),
    /// `c for 0.5 s`.
    For(Box<Expr>, Box<Expr>),
    /// `c within 3 s`: now or later.
    Within(Box<Expr>, Box<Expr>),
    /// `c gaps 0.3 s`, only as the operand of a `for`: `c for 2 s gaps 0.3 s`.
    Gaps(Box<Expr>, Box<Expr>),
    /// `a then b within 3 s`: b now, and a before it.
    Then(Box<Expr>, Box<Expr>, Box<Expr>),
    /// `a since b`, `a since b within 3 s`.
    Since(Box<Expr>, Box<Expr>, Option<Box<Expr>>),
    /// `a until b`, `a until b within 3 s`.
    Until(Box<Expr>, Box<Expr>, Option<Box<Expr>>),
    /// `x at keyframe`.
    At(Box<Expr>),
}

/// A number with its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// In `unit`.
    pub value: f64,
    /// As written; the ratio's empty unit without one.
    pub unit: &'static Unit,
}

impl Quantity {
    /// In the dimension's base unit.
    pub fn base(self) -> f64 {
        self.value * self.unit.to_base
    }
}

/// Arithmetic of two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArithmeticOp {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`, where one side is a pure number.
    Multiply,
}

/// Comparison of two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompareOp {
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterOrEqual,
    /// `==`
    Equal,
    /// `!=`
    NotEqual,
}

impl CompareOp {
    /// The same comparison with its sides exchanged.
    #[must_use]
    pub fn mirrored(self) -> Self {
        match self {
            Self::Less => Self::Greater,
            Self::LessOrEqual => Self::GreaterOrEqual,
            Self::Greater => Self::Less,
            Self::GreaterOrEqual => Self::LessOrEqual,
            Self::Equal | Self::NotEqual => self,
        }
    }

    /// As written.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::LessOrEqual => "<=",
            Self::Greater => ">",
            Self::GreaterOrEqual => ">=",
            Self::Equal => "==",
            Self::NotEqual => "!=",
        }
    }
}
