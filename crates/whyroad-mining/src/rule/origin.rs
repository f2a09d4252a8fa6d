//! Where a rule's text stands in its file. The YAML reader tells where a block begins; where in it an
//! expression stands is found by its text, so that a fault is shown on the line that has to be changed.

use crate::language::Fault;
use whyroad_model::{Diagnostic, Place};

/// A block of a file.
#[derive(Clone, Debug)]
pub struct Origin<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// The whole file.
    pub text: &'a str,
    /// Line of the block, from 1.
    pub line: usize,
    /// JSON pointer of what the block belongs to: `/leaves/urgent`, or nothing for the L2.
    pub owner: String,
}

impl Origin<'_> {
    /// The diagnostic for a fault in `expression`, which stands under `key` of the owner.
    pub fn diagnose(&self, key: &str, expression: &str, fault: Fault) -> Diagnostic {
        let pointer = format!("{}{key}", self.owner);
        let start = fault.span.start.min(expression.len());
        let marked = &expression[start..fault.span.end.clamp(start, expression.len())];
        let at = self
            .find(expression)
            .map(|i| i + start)
            // An expression that is folded over lines is not found whole, its faulty part is.
            .or_else(|| self.find(marked.lines().next().unwrap_or_default()));
        let Some(at) = at else {
            let origin = Place {
                file: Some(self.file.to_owned()),
                line: Some(self.line),
                pointer: Some(pointer),
                ..Place::default()
            };
            return fault.about(expression, &origin);
        };
        let line_start = self.text[..at].rfind('\n').map_or(0, |i| i + 1);
        fault.at(Place {
            file: Some(self.file.to_owned()),
            line: Some(self.text[..at].matches('\n').count() + 1),
            column: Some(self.text[line_start..at].chars().count() + 1),
            pointer: Some(pointer),
            snippet: self.text[line_start..].lines().next().map(str::to_owned),
            snippet_start: 0,
            span: marked.lines().next().unwrap_or_default().chars().count().max(1),
        })
    }

    /// The place of the block itself.
    pub fn place(&self, key: &str) -> Place {
        Place {
            file: Some(self.file.to_owned()),
            line: Some(self.line),
            pointer: Some(format!("{}{key}", self.owner)),
            ..Place::default()
        }
    }

    /// First occurrence from the block's line on, else anywhere (a leaf's rule inherits from the L2's above it).
    fn find(&self, part: &str) -> Option<usize> {
        if part.trim().is_empty() {
            return None;
        }
        let block: usize =
            self.text.split_inclusive('\n').take(self.line.saturating_sub(1)).map(str::len).sum();
        self.text[block..].find(part).map(|i| i + block).or_else(|| self.text.find(part))
    }
}
