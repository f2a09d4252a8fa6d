//! Names that refer to any two objects: `object.` is the object that the rule is about, `other.` the second one (each
//! object near it in turn, inside `exists`, `forall` and `count`), `pair.` the two seen from the first, `reverse.` the
//! same seen from the second.

use super::super::Fault;
use super::super::program::{NodeId, Op, PairSide, Subject, ValueScope};
use super::super::syntax::{Expr, Span};
use super::{Checker, Meaning, kind_of, names};
use whyroad_model::signal::is_on_demand;

/// The counted objects: all objects of the drive, or among those near the object that the rule is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Among {
    /// All that are observed.
    All,
    /// Those near the rule's own object.
    Near,
}

impl Checker<'_> {
    /// The node of `pair.x`, `reverse.x` or `other.x`; `None` for any other name.
    pub(super) fn of_pair(&mut self, name: &str, span: Span) -> Result<Option<NodeId>, Fault> {
        let Some((prefix @ ("pair" | "reverse" | "other"), signal)) = name.split_once('.') else {
            return Ok(None);
        };
        let family = if prefix == "other" { "object" } else { "pair" };
        let Some(def) = self.catalog.get(&format!("{family}.{signal}")) else {
            return Err(names::unknown_of_family(self.catalog, (prefix, family), signal, span));
        };
        let (full, kind) = (def.name.clone(), kind_of(def));
        let op = match prefix {
            "other" => Op::SecondSignal(full),
            "pair" => Op::PairSignal { name: full, seen_from: PairSide::First },
            _ => Op::PairSignal { name: full, seen_from: PairSide::Second },
        };
        let node = self.program.add(op, kind);
        if self.speaks_of_nobody(node) { Err(names::no_other(name, span)) } else { Ok(Some(node)) }
    }

    /// True for a value of a second object where the rule has none.
    pub(super) fn speaks_of_nobody(&self, node: NodeId) -> bool {
        let scope = self.program.node(node).scope;
        matches!(scope, ValueScope::Second | ValueScope::Pair)
            && self.roles.second.is_none()
            && self.meaning == Meaning::Role
            && !self.defining
    }

    /// The objects that a condition inside `name` counts, by the names that it uses.
    pub(super) fn among(&self, name: &str, id: NodeId, of: &Expr) -> Result<Among, Fault> {
        let owns: Vec<String> = self.program.signals_of_first(id).into_iter().collect();
        match self.program.node(id).scope {
            ValueScope::Target if owns.iter().any(|s| is_on_demand(s)) => Err(Fault::new(
                "rule.target",
                of.span,
                format!("{name} 之内 object.* 仍指本规则的对象，条件没有说到别的对象"),
                format!("inside {name}, object.* is the rule's own object: the condition refers to no other"),
            )
            .hint(
                "另一对象写作 other.*，两者的关系写作 pair.*",
                "write other.* for the other object, pair.* for the two",
            )),
            ValueScope::Target => Ok(Among::All),
            ValueScope::Frame => Err(Fault::new(
                "rule.target",
                of.span,
                format!("{name} 的条件没有说到 target.* 或 pair.*"),
                format!("the condition in {name} does not use target.* or pair.*"),
            )
            .hint("例如 exists(target.gap < 20 m)", "as in exists(target.gap < 20 m)")),
            ValueScope::Second | ValueScope::Pair if self.program.reads_targets(id) => Err(Fault::new(
                "rule.target",
                of.span,
                format!("{name} 之内不能同时用 target.* 与 pair.*、other.*"),
                format!("target.* cannot be used with pair.* or other.* inside {name}"),
            )
            .hint(
                "本规则的对象写作 object.*，另一对象写作 other.*；target.* 请移到括号之外",
                "write object.* for the rule's own object and other.* for the other; move target.* outside",
            )),
            ValueScope::Second | ValueScope::Pair => Ok(Among::Near),
        }
    }

    /// At least `count` of those that are counted.
    pub(super) fn at_least(
        &mut self,
        (of, subject, among): (NodeId, Subject, Among),
        count: usize,
    ) -> NodeId {
        self.flag(match among {
            Among::All => Op::AtLeast { of, count, subject },
            Among::Near => Op::AtLeastNear { of, count, subject },
        })
    }
}
