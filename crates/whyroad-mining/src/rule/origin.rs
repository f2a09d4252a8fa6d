//! From faults of the rule language to diagnostics at the position of the error. The YAML tree knows the position of
//! each text, and a fault knows the wrong part of the text.

use crate::language::Fault;
use whyroad_framework::ExpressionSource;
use whyroad_model::yaml::{Mark, Node};
use whyroad_model::{Diagnostic, Location, ScenarioId};

/// A file of rules.
#[derive(Clone, Copy, Debug)]
pub struct SourceFile<'a> {
    /// Its name in diagnostics.
    pub name: &'a str,
    /// Its text.
    pub text: &'a str,
}

/// Where a rule comes from.
#[derive(Clone, Copy, Debug)]
pub struct Origin<'a> {
    /// The file with the block.
    pub file: SourceFile<'a>,
    /// Position of the block's key.
    pub mark: Mark,
    /// The moments of labeling specs as written; a rule takes over those of its class.
    pub expressions: &'a [ExpressionSource],
}

impl SourceFile<'_> {
    /// The diagnostic for a fault in the text of `node`.
    pub fn diagnose(&self, node: &Node, fault: Fault) -> Diagnostic {
        let mark = node.part(fault.span.start..fault.span.end, self.text);
        self.at(mark, &node.pointer, fault)
    }

    /// The diagnostic for a fault at a position.
    pub fn at(&self, mark: Mark, pointer: &str, fault: Fault) -> Diagnostic {
        fault.at(self.location(mark, pointer))
    }

    /// A position in the file.
    pub fn location(&self, mark: Mark, pointer: &str) -> Location {
        Location {
            file: Some(self.name.to_owned()),
            line: Some(mark.line),
            column: Some(mark.column),
            pointer: Some(pointer.to_owned()),
            snippet: self.text.lines().nth(mark.line.saturating_sub(1)).map(str::to_owned),
            snippet_start: 0,
            span: mark.span,
        }
    }
}

impl Origin<'_> {
    /// The diagnostic for a fault in a moment that a rule of this class takes over: at the expression of the class, or
    /// else of the nearest level above that has it.
    pub fn diagnose_moment(&self, class: &ScenarioId, text: &str, fault: Fault) -> Diagnostic {
        let written = self
            .expressions
            .iter()
            .filter(|e| e.text() == text && class.is_within(&e.class))
            .max_by_key(|e| usize::from(e.class.l2.is_some()) + usize::from(e.class.l3.is_some()));
        match written {
            Some(e) => SourceFile { name: &e.file, text: &e.source }.diagnose(&e.expression, fault),
            None => {
                fault.about(text, &Location { file: Some(self.file.name.to_owned()), ..Location::default() })
            }
        }
    }
}
