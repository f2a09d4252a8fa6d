//! Syntax to program: names looked up, types and units checked, values converted. All errors of a rule are found here,
//! when it is read; evaluation cannot fail.

mod atoms;
mod calls;
mod compare;
mod define;
mod describe;
mod displayed;
mod every;
mod memo;
mod moments;
mod names;
mod never;
mod pairs;
mod structure;
mod wording;
mod words;

pub use atoms::PartText;
pub use names::nearest;
pub use structure::{Join, Structure};

use memo::Memo;
use words::{kind_en, kind_zh, mismatch};

use super::Fault;
use super::program::{Atom, NodeId, Op, Program, Subject, ValueKind, ValueScope};
use super::syntax::{ArithmeticOp, Expr, ExprKind, Extent, Quantity, Span};
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::units::Dimension;
use whyroad_model::{Bilingual, Nanos};
use whyroad_signals::catalog::{Catalog, SignalDef, SignalKind, TargetRestriction};

/// Turns expressions into nodes of one program.
pub struct Checker<'a> {
    pub(crate) catalog: &'a Catalog,
    /// Named numbers of the rule.
    pub parameters: BTreeMap<String, Quantity>,
    /// Named conditions or numbers of the rule that others may use.
    pub(crate) definitions: BTreeMap<String, Definition>,
    /// Names of definitions that come after the one that is being read.
    pub(crate) later: BTreeSet<String>,
    /// Displayed texts of definitions.
    pub names: BTreeMap<String, Bilingual>,
    /// Conditions that are displayed at length because nothing in them has a name, by the definition that could
    /// have one.
    pub(crate) lengthy: BTreeMap<String, Bilingual>,
    /// Values of categories that have been compared with: they cannot also be other names.
    values: BTreeSet<String>,
    /// The nodes built so far.
    pub program: Program,
    /// Restriction of the target by prefixes such as `target_vehicle.`.
    pub subject: Option<Subject>,
    /// Names of the rule's roles.
    pub roles: RoleNames,
    /// The current meaning of `target.`.
    meaning: Meaning,
    /// Only whether a condition is known is asked for, not whether it holds: one that never does, such as `ego.speed <
    /// 0 m/s within 3 s`, shows where the record ends.
    asks_if_known: bool,
    /// A definition is being read: it may be used inside `exists`, where there is a second object.
    defining: bool,
    /// Words of definitions, as far as they have been asked for.
    said: wording::Said,
    /// Words of conditions.
    worded: Memo<Bilingual>,
    /// Texts of conditions with all names replaced; unset where they are long.
    whole: Memo<Option<String>>,
    /// Conditions with what is measured for them.
    shown: Memo<Atom>,
    /// Definitions as atoms.
    named: BTreeMap<String, Atom>,
}

/// Names of the objects that a rule binds. `target.` always names the first one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RoleNames {
    /// Another name of the target, such as `lead`.
    pub first: Option<String>,
    /// Name of the second role, such as `obstacle`.
    pub second: Option<String>,
}

/// Meaning of a name of the rule.
#[derive(Clone, Debug)]
pub(crate) struct Definition {
    expr: Expr,
    node: NodeId,
    extent: Extent,
    text: describe::DefinitionText,
}

/// Meaning of `target.`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    /// The object in the rule's first role.
    Role,
    /// Each object in turn, inside `count`, `exists` and `forall`.
    Counted,
}

type Lowered = Result<NodeId, Fault>;

impl<'a> Checker<'a> {
    /// A checker with an empty program.
    pub fn new(catalog: &'a Catalog) -> Self {
        Self {
            catalog,
            parameters: BTreeMap::new(),
            definitions: BTreeMap::new(),
            later: BTreeSet::new(),
            names: BTreeMap::new(),
            lengthy: BTreeMap::new(),
            values: BTreeSet::new(),
            program: Program::default(),
            subject: None,
            roles: RoleNames::default(),
            meaning: Meaning::Role,
            asks_if_known: false,
            defining: false,
            said: wording::Said::default(),
            worded: Memo::default(),
            whole: Memo::default(),
            shown: Memo::default(),
            named: BTreeMap::new(),
        }
    }

    /// The node of an expression that must be a condition.
    pub fn condition(&mut self, expr: &Expr) -> Lowered {
        let id = self.lower(expr)?;
        match &self.program.node(id).kind {
            ValueKind::Condition => Ok(id),
            other => {
                let fault = Fault::new(
                    "rule.type",
                    expr.span,
                    format!("此处应为条件，而不是{}", kind_zh(other)),
                    format!("expected a condition, not {}", kind_en(other)),
                );
                Err(match other {
                    ValueKind::Number(dimension) => {
                        let unit = dimension.base().symbol;
                        let such = if unit.is_empty() { "> 5".to_owned() } else { format!("> 5 {unit}") };
                        fault.hint(
                            format!("请与某个值比较，例如 {such}"),
                            format!("compare it with something, as in {such}"),
                        )
                    }
                    ValueKind::Category(names) => {
                        let such = format!("== {}", names.first().map_or("", String::as_str));
                        fault.hint(
                            format!("请与某个取值比较，例如 {such}"),
                            format!("compare it with one of its values, as in {such}"),
                        )
                    }
                    ValueKind::Condition => fault,
                })
            }
        }
    }

    fn number(&mut self, expr: &Expr) -> Result<(NodeId, Dimension), Fault> {
        let id = self.lower(expr)?;
        match &self.program.node(id).kind {
            ValueKind::Number(d) => Ok((id, *d)),
            other => Err(Fault::new(
                "rule.type",
                expr.span,
                format!("此处应为数，而不是{}", kind_zh(other)),
                format!("expected a number, not {}", kind_en(other)),
            )),
        }
    }

    /// A time that is not negative: a literal or a parameter.
    fn duration(&self, expr: &Expr) -> Result<Nanos, Fault> {
        let quantity = match &expr.kind {
            ExprKind::Number(q) => Some(*q),
            ExprKind::Name(name) => self.parameters.get(name).copied(),
            _ => None,
        };
        match quantity {
            Some(q) if q.unit.dimension == Dimension::Time && q.value >= 0.0 => {
                Ok(Nanos::from_secs_f64(q.base()))
            }
            None if matches!(&expr.kind, ExprKind::Name(_)) => self.unknown_duration(expr),
            _ => Err(Fault::new("rule.unit.mismatch", expr.span, "此处应为时长", "expected a time")
                .hint("例如 0.5 s", "such as 0.5 s")),
        }
    }

    /// A name where a time is needed that is not a parameter: either unknown, or the name of something else.
    fn unknown_duration(&self, expr: &Expr) -> Result<Nanos, Fault> {
        if let ExprKind::Name(name) = &expr.kind
            && self.catalog.get(name).is_none()
            && !self.definitions.contains_key(name)
        {
            let own = self.parameters.keys().map(String::as_str);
            return Err(names::unknown(self.catalog, name, expr.span, own));
        }
        Err(Fault::new("rule.unit.mismatch", expr.span, "此处应为固定的时长", "expected a fixed time")
            .hint("例如 0.5 s 或参数名", "such as 0.5 s, or a parameter's name"))
    }

    /// The node of an expression of any type.
    pub fn lower(&mut self, expr: &Expr) -> Lowered {
        match &expr.kind {
            ExprKind::Number(q) => {
                Ok(self.program.add(Op::Constant(q.base()), ValueKind::Number(q.unit.dimension)))
            }
            ExprKind::Name(name) => self.name(name, expr.span),
            ExprKind::Call(name, arguments) => self.call(name, arguments, expr.span),
            ExprKind::Negate(of) => {
                let (id, d) = self.number(of)?;
                Ok(self.program.add(Op::Negate(id), ValueKind::Number(d)))
            }
            ExprKind::Arithmetic(op, a, b) => self.arithmetic(*op, a, b, expr.span),
            ExprKind::Not(of) => {
                let id = self.condition(of)?;
                Ok(self.flag(Op::Not(id)))
            }
            ExprKind::And(all) => {
                let all: Vec<NodeId> = all.iter().map(|e| self.condition(e)).collect::<Result<_, _>>()?;
                self.possible_together(&all, expr.span)?;
                Ok(self.flag(Op::And(all)))
            }
            ExprKind::Or(all) => {
                let all = all.iter().map(|e| self.condition(e)).collect::<Result<_, _>>()?;
                Ok(self.flag(Op::Or(all)))
            }
            ExprKind::Compare(first, rest) => {
                let mut left = first.as_ref();
                let mut all = Vec::new();
                for (op, right) in rest {
                    all.push(self.compare(*op, left, right)?);
                    left = right;
                }
                self.possible_together(&all, expr.span)?;
                Ok(if all.len() == 1 { all[0] } else { self.flag(Op::And(all)) })
            }
            ExprKind::In(of, members) => self.membership(of, members),
            ExprKind::Known(of) => {
                let outer = std::mem::replace(&mut self.asks_if_known, true);
                let id = self.lower(of);
                self.asks_if_known = outer;
                Ok(self.flag(Op::Known(id?)))
            }
            ExprKind::For(of, time) => {
                let (id, time) = (self.condition(of)?, self.duration(time)?);
                Ok(self.flag(Op::For(id, time)))
            }
            ExprKind::Within(of, time) => {
                let (id, time) = (self.condition(of)?, self.duration(time)?);
                Ok(self.flag(Op::Within(id, time)))
            }
            ExprKind::Gaps(of, time) => {
                let (id, time) = (self.condition(of)?, self.duration(time)?);
                Ok(self.flag(Op::Bridge(id, time)))
            }
            ExprKind::Since(a, b, time) => {
                let (a, b) = (self.condition(a)?, self.condition(b)?);
                let since = self.flag(Op::Since(a, b));
                let Some(time) = time else { return Ok(since) };
                let earlier = Op::Previously(b, Some(self.duration(time)?));
                let earlier = self.flag(earlier);
                let recent = self.flag(Op::Or(vec![b, earlier]));
                Ok(self.flag(Op::And(vec![recent, since])))
            }
            ExprKind::Until(a, b, time) => {
                let (a, b) = (self.condition(a)?, self.condition(b)?);
                let until = self.flag(Op::Until(a, b));
                let Some(time) = time else { return Ok(until) };
                let soon = Op::Within(b, self.duration(time)?);
                let soon = self.flag(soon);
                Ok(self.flag(Op::And(vec![soon, until])))
            }
            ExprKind::Then(first, second, time) => {
                let (a, b) = (self.condition(first)?, self.condition(second)?);
                let time = self.duration(time)?;
                let before = self.flag(Op::Previously(a, Some(time)));
                Ok(self.flag(Op::And(vec![b, before])))
            }
            ExprKind::At(of) => {
                let id = self.lower(of)?;
                let kind = self.program.node(id).kind.clone();
                Ok(self.program.add(Op::AtKeyframe(id), kind))
            }
        }
    }

    fn flag(&mut self, op: Op) -> NodeId {
        self.program.add(op, ValueKind::Condition)
    }

    fn name(&mut self, name: &str, span: Span) -> Lowered {
        if let Some(q) = self.parameters.get(name) {
            return Ok(self.program.add(Op::Constant(q.base()), ValueKind::Number(q.unit.dimension)));
        }
        if let Some(definition) = self.definitions.get(name) {
            let node = definition.node;
            return if self.speaks_of_nobody(node) { Err(names::no_other(name, span)) } else { Ok(node) };
        }
        if let "true" | "false" = name {
            return Ok(self.flag(Op::Truth(name == "true")));
        }
        if let Some(node) = self.of_pair(name, span)? {
            return Ok(node);
        }
        if let Some((role, signal)) = name.split_once('.') {
            let is = |r: &Option<String>| r.as_deref() == Some(role);
            if is(&self.roles.second) || is(&self.roles.first) {
                return self.of_role(role, signal, span);
            }
        }
        let (def, restriction) = self.catalog.resolve(name).ok_or_else(|| {
            if self.later.contains(name) {
                return names::defined_later(name, span);
            }
            let own = self.parameters.keys().chain(self.definitions.keys()).map(String::as_str);
            names::unknown(self.catalog, name, span, own)
        })?;
        let restriction = match restriction {
            TargetRestriction::Any => None,
            TargetRestriction::Vehicle => Some(Subject::Vehicle),
            TargetRestriction::Vru => Some(Subject::Vru),
        };
        if let Some(r) = restriction {
            if self.subject.is_some_and(|s| s != r) {
                return Err(Fault::new(
                    "rule.target",
                    span,
                    "一条规则只能有一种目标",
                    "a rule has one kind of target: target_vehicle and target_vru cannot be mixed",
                ));
            }
            self.subject = Some(r);
        }
        let (name, kind) = (def.name.clone(), kind_of(def));
        Ok(self.program.add(Op::Signal(name), kind))
    }

    /// `obstacle.gap`: a target signal of the object in that role.
    fn of_role(&mut self, role: &str, signal: &str, span: Span) -> Lowered {
        if self.meaning == Meaning::Counted {
            return Err(Fault::new(
                "rule.target",
                span,
                format!("count、exists、forall 之内只能用 target.*，不能用角色 '{role}'"),
                format!("inside count, exists and forall there is only target.*, not the role '{role}'"),
            ));
        }
        let Some(def) = self.catalog.get(&format!("target.{signal}")) else {
            return Err(names::unknown_of_role(self.catalog, role, signal, span));
        };
        let (name, kind) = (def.name.clone(), kind_of(def));
        let second = self.roles.second.as_deref() == Some(role);
        Ok(self.program.add(if second { Op::SecondSignal(name) } else { Op::Signal(name) }, kind))
    }

    fn arithmetic(&mut self, op: ArithmeticOp, a: &Expr, b: &Expr, span: Span) -> Lowered {
        let ((x, dx), (y, dy)) = (self.number(a)?, self.number(b)?);
        match op {
            ArithmeticOp::Multiply => {
                let d = match (dx, dy) {
                    (Dimension::Ratio, d) | (d, Dimension::Ratio) => d,
                    _ => {
                        return Err(Fault::new(
                            "rule.unit.mismatch",
                            span,
                            "乘法的一边须为无单位的数",
                            "one side of `*` must be a number without a unit",
                        ));
                    }
                };
                Ok(self.program.add(Op::Multiply(x, y), ValueKind::Number(d)))
            }
            _ if dx != dy => Err(mismatch(span, dx, dy)),
            ArithmeticOp::Add => Ok(self.program.add(Op::Add(x, y), ValueKind::Number(dx))),
            ArithmeticOp::Subtract => Ok(self.program.add(Op::Subtract(x, y), ValueKind::Number(dx))),
        }
    }

    /// Typical magnitude of a number: that of the first signal in it.
    fn scale(&self, id: NodeId) -> Option<f64> {
        match &self.program.node(id).op {
            Op::Signal(name) | Op::PairSignal { name, .. } => self.catalog.get(name).map(|d| d.scale),
            op => op.operands().into_iter().find_map(|o| self.scale(o)),
        }
    }

    /// True when the node's value belongs to an object.
    pub fn is_of_target(&self, id: NodeId) -> bool {
        self.program.node(id).scope != ValueScope::Frame
    }
}

fn kind_of(def: &SignalDef) -> ValueKind {
    match &def.kind {
        SignalKind::Number(d) => ValueKind::Number(*d),
        SignalKind::Flag => ValueKind::Condition,
        SignalKind::Category(names) => ValueKind::Category(names.to_vec()),
    }
}
