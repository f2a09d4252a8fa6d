//! The text of a query with the span of every value.

use std::ops::Range;
use whyroad_framework::check::Origin;
use whyroad_framework::check::json::{JsonKind, Locator, Node, parse};
use whyroad_model::Location;

/// A query's JSON and its name in diagnostics.
pub(super) struct QueryText<'t> {
    text: &'t str,
    file: &'t str,
    /// `None` if the text is not JSON; then locations have no line.
    root: Option<Node<'t>>,
}

impl<'t> QueryText<'t> {
    pub fn new(text: &'t str, file: &'t str) -> Self {
        Self { text, file, root: parse(text).ok() }
    }

    fn node(&self, pointer: &str) -> Option<&Node<'t>> {
        self.root.as_ref().and_then(|root| root.pointer(pointer))
    }

    /// Location of the value at `pointer`.
    pub fn location(&self, pointer: &str) -> Location {
        self.at(pointer, self.node(pointer).map(Node::mark))
    }

    /// Location of a comparison: its field is shown.
    pub fn comparison(&self, pointer: &str) -> Location {
        let field = self.node(pointer).and_then(|node| node.pointer("/field"));
        self.at(pointer, field.or(self.node(pointer)).map(Node::mark))
    }

    /// Location of the bytes `part` of the text at `pointer`; of all of it if it has escapes.
    pub fn part(&self, pointer: &str, part: Range<usize>) -> Location {
        let Some(node) = self.node(pointer) else { return self.at(pointer, None) };
        let plain = matches!(&node.kind, JsonKind::Text(t) if t.len() + 2 == node.span.len());
        let start = node.span.start + 1;
        let span = if plain && !part.is_empty() { start + part.start..start + part.end } else { node.mark() };
        self.at(pointer, Some(span))
    }

    fn at(&self, pointer: &str, span: Option<Range<usize>>) -> Location {
        let file = Some(self.file.to_owned());
        match span {
            Some(span) => Location { file, ..Locator::new(self.text, &Origin::start()).place(span, pointer) },
            None => Location { file, pointer: Some(pointer.to_owned()), ..Location::default() },
        }
    }
}
