//! Which objects a rule binds: `target: vehicle`, or `roles: { lead: vehicle, obstacle: any }`.

use super::SecondRole;
use super::source::Compiler;
use crate::language::check::RoleNames;
use crate::language::program::Subject;
use crate::language::{Fault, Span};
use serde_yaml_ng::{Mapping, Value};

/// The objects of a rule.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Bound {
    /// What the target can be; `None` for a rule about the ego alone.
    pub target: Option<Subject>,
    /// The second role.
    pub second: Option<SecondRole>,
}

/// Words that mean something else in a rule. (`lead` is a role that rules want: there, `lead.` means the role.)
const TAKEN: &[&str] =
    &["ego", "target", "target_vehicle", "target_vru", "map", "light", "match", "keyframe", "context"];

/// Names of the roles in a block: with `target:`, all roles beside it; else the first is the target.
pub(super) fn names(target_is_given: Option<&str>, roles: &Mapping) -> RoleNames {
    let mut names = roles.keys().filter_map(Value::as_str).map(str::to_owned);
    let first = if target_is_given.is_some() { None } else { names.next() };
    RoleNames { first, second: names.next() }
}

impl Compiler<'_> {
    /// The roles of a block; what the checker must know of them is told to it.
    pub(super) fn roles(&mut self, target: Option<&str>, roles: &Mapping) -> Bound {
        self.checker.roles = names(target, roles);
        let mut kinds = Vec::new();
        for (name, kind) in roles {
            let (Some(name), Some(kind)) = (name.as_str(), kind.as_str()) else {
                let fault = Fault::new(
                    "rule.target",
                    Span::default(),
                    "角色写作 名称: 种类",
                    "a role is written name: kind, as in `obstacle: any`",
                );
                self.report("/mining/roles", "", fault);
                continue;
            };
            if TAKEN.contains(&name) || name.contains('.') {
                let span = Span { start: 0, end: name.len() };
                let fault = Fault::new(
                    "rule.target",
                    span,
                    format!("角色不能叫 '{name}'"),
                    format!("a role cannot be called '{name}'"),
                )
                .hint("例如 obstacle", "call it `obstacle`, for instance");
                self.report(&format!("/mining/roles/{name}"), name, fault);
            }
            if let Some(subject) = self.kind(kind, &format!("/mining/roles/{name}")) {
                kinds.push((name.to_owned(), subject));
            }
        }
        let most = if target.is_some() { 1 } else { 2 };
        if roles.len() > most {
            let fault = Fault::new(
                "rule.target",
                Span::default(),
                "一条规则最多两个角色：目标与另一个对象",
                "a rule has two roles at most: its target and one other object",
            );
            self.report("/mining/roles", "", fault);
        }
        let stated = target.and_then(|word| self.kind(word, "/mining/target"));
        let mut kinds = kinds.into_iter();
        let target = if target.is_some() { stated } else { kinds.next().map(|(_, subject)| subject) };
        Bound { target, second: kinds.next().map(|(name, subject)| SecondRole { name, subject }) }
    }

    fn kind(&mut self, word: &str, key: &str) -> Option<Subject> {
        let subject = Subject::from_word(word);
        if subject.is_none() {
            let span = Span { start: 0, end: word.len() };
            let fault = Fault::new(
                "rule.target",
                span,
                format!("没有名为 '{word}' 的目标种类"),
                format!("'{word}' is not a kind of target"),
            )
            .hint("可用：vehicle, large_vehicle, vru, any", "there are vehicle, large_vehicle, vru, any");
            self.report(key, word, fault);
        }
        subject
    }
}
