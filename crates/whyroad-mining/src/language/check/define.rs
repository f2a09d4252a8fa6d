//! Names that a rule gives: to numbers (`parameters`) and to conditions or numbers made of others (`define`). A name
//! has one meaning in a rule, and a definition uses only earlier ones; so expansion always ends.

use super::super::Fault;
use super::super::parse;
use super::super::syntax::{Expr, ExprKind, Extent, Span};
use super::{Checker, Definition, names};

/// Words with a meaning in every rule.
const TAKEN: &[&str] = &["true", "false", "keyframe", "match", "known", "unknown", "gaps"];

impl Checker<'_> {
    /// Gives a condition or a number an unused name ([`Self::claim`]); later expressions can use it.
    pub fn define(&mut self, name: &str, text: &str) -> Result<(), Fault> {
        let expr = parse::parse(text)?;
        if let Some(span) = mention(&expr, name) {
            return Err(Fault::new(
                "rule.name",
                span,
                format!("定义 '{name}' 里又用到了 '{name}'"),
                format!("the definition of '{name}' refers to '{name}'"),
            )
            .hint(
                "定义只能用到写在它前面的名称；若指的是类别的取值，请给定义换一个名称",
                "a definition can use only earlier ones; if a value of a category is meant, give the definition another name",
            ));
        }
        let extent = self.extent(&expr);
        if !extent.is_sane() {
            return Err(parse::too_large(expr.span));
        }
        self.defining = true;
        let node = self.lower(&expr);
        self.defining = false;
        let node = node?;
        let text = self.definition_text(&expr, &self.program.node(node).kind);
        self.definitions.insert(name.to_owned(), Definition { expr, node, extent, text });
        Ok(())
    }

    /// Size of an expression when its names are replaced by their definitions.
    pub fn extent(&self, expr: &Expr) -> Extent {
        expr.extent(&|name| self.definitions.get(name).map(|d| d.extent).unwrap_or_default())
    }

    /// True for a name that the rule itself defines.
    pub(super) fn is_own(&self, name: &str) -> bool {
        self.parameters.contains_key(name) || self.definitions.contains_key(name)
    }

    /// A name that already has a meaning cannot be defined; the span is that of the whole name.
    pub fn claim(&self, name: &str) -> Result<(), Fault> {
        let span = Span { start: 0, end: name.len() };
        let taken = |zh: &str, en: &str| {
            Err(Fault::new("rule.name", span, format!("'{name}' {zh}"), format!("'{name}' {en}")))
        };
        if self.values.contains(name) {
            return Err(names::also_a_value(name, span));
        }
        if name.contains('.') || self.catalog.resolve(name).is_some() {
            return taken("是信号的名称", "is the name of a signal, or looks like one");
        }
        if TAKEN.contains(&name) || crate::language::token::KEYWORDS.contains(&name) {
            return taken("在规则里另有含义", "already has a meaning in every rule");
        }
        if self.is_own(name) {
            return taken("已经是另一个参数或定义的名称", "is already a parameter or a definition");
        }
        Ok(())
    }
}

/// Where an expression mentions a name, as a name or as a value of a category.
fn mention(expr: &Expr, name: &str) -> Option<Span> {
    match &expr.kind {
        ExprKind::Name(n) if n == name => Some(expr.span),
        ExprKind::In(of, words) => {
            let word = words.iter().find(|(w, _)| w == name).map(|(_, span)| *span);
            word.or_else(|| mention(of, name))
        }
        _ => expr.parts().into_iter().find_map(|e| mention(e, name)),
    }
}
