//! Which objects a rule binds: `target: vehicle`, or `roles: { lead: vehicle, obstacle: any }`.

use super::SecondRole;
use super::source::Compiler;
use crate::language::check::RoleNames;
use crate::language::program::Subject;
use crate::language::{Fault, Span};
use whyroad_model::yaml::{Entry, Node};

/// The objects of a rule.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Bound {
    /// What the target can be; `None` for a rule about the ego alone.
    pub target: Option<Subject>,
    /// The second role.
    pub second: Option<SecondRole>,
}

/// Words with another meaning in a rule. (`lead` is allowed as a role: there, `lead.` means the role.)
const TAKEN: &[&str] = &[
    "ego",
    "target",
    "target_vehicle",
    "target_vru",
    "map",
    "light",
    "match",
    "keyframe",
    "context",
    "object",
    "pair",
    "reverse",
];

/// Names of the roles in a block: with `target:`, all roles beside it; else the first is the target.
pub(super) fn names<'n>(target_is_given: bool, roles: impl IntoIterator<Item = &'n Entry>) -> RoleNames {
    let mut names = roles.into_iter().map(|e| e.key.clone());
    let first = if target_is_given { None } else { names.next() };
    RoleNames { first, second: names.next() }
}

impl Compiler<'_> {
    /// The roles of a block, which the checker is given too.
    pub(super) fn roles(&mut self, target: Option<&Node>, roles: &[&Entry]) -> Bound {
        self.checker.roles = names(target.is_some(), roles.iter().copied());
        let mut kinds = Vec::new();
        for entry in roles {
            let (name, kind) = (&entry.key, &entry.node);
            if TAKEN.contains(&name.as_str()) || name.contains('.') {
                let fault = Fault::new(
                    "rule.target",
                    Span::default(),
                    format!("角色不能叫 '{name}'"),
                    format!("a role cannot be called '{name}'"),
                )
                .hint("例如 obstacle", "call it `obstacle`, for instance");
                self.report_key(entry, fault);
            }
            if kind.text().is_none() {
                let fault = Fault::new(
                    "rule.target",
                    Span::default(),
                    "角色写作 名称: 种类",
                    "a role is written name: kind, as in `obstacle: any`",
                );
                self.report_key(entry, fault);
            } else if let Some(subject) = self.subject(kind) {
                kinds.push((name.clone(), subject));
            }
        }
        let most = if target.is_some() { 1 } else { 2 };
        if let Some(surplus) = roles.get(most) {
            let fault = Fault::new(
                "rule.target",
                Span::default(),
                "一条规则最多两个角色：目标与另一个对象",
                "a rule has at most two roles: its target and one other object",
            );
            self.report_key(surplus, fault);
        }
        let stated = target.and_then(|node| self.subject(node));
        let mut kinds = kinds.into_iter();
        let target = if target.is_some() { stated } else { kinds.next().map(|(_, subject)| subject) };
        Bound { target, second: kinds.next().map(|(name, subject)| SecondRole { name, subject }) }
    }

    fn subject(&mut self, node: &Node) -> Option<Subject> {
        let word = node.text().unwrap_or_default().trim();
        let subject = Subject::from_word(word);
        if subject.is_none() {
            let fault = Fault::new(
                "rule.target",
                Span::default(),
                format!("没有名为 '{word}' 的目标种类"),
                format!("'{word}' is not a kind of target"),
            )
            .hint(
                "可用：vehicle, large_vehicle, vru, any，或一个类别，如 bicycle",
                "use one of vehicle, large_vehicle, vru, any, or a class, such as bicycle",
            );
            self.report(node, fault);
        }
        subject
    }
}
