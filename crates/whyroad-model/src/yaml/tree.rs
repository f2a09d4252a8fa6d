//! The tree of a YAML text. The build script includes this file too, so it uses nothing of the crate.

use saphyr_parser::{Event, Marker, Parser, ScalarStyle};

/// Position of a key or value in its file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mark {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Length in characters; 1 if the value takes several lines.
    pub span: usize,
}

/// A value and its position.
#[derive(Clone, Debug)]
pub struct Node {
    /// What it is.
    pub value: Value,
    /// Position of its first character.
    pub mark: Mark,
    /// JSON pointer (RFC 6901) inside the document.
    pub pointer: String,
}

/// What a value is. Scalars stay text: `version: 2.0` must not become a number.
#[derive(Clone, Debug)]
pub enum Value {
    /// Empty, `~` or `null`.
    Null,
    /// Text, number or flag.
    Scalar(Scalar),
    /// A sequence.
    List(Vec<Node>),
    /// A mapping, in file order; a key may occur twice.
    Map(Vec<Entry>),
}

/// A scalar's text and how it is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scalar {
    /// The text after unquoting and unfolding.
    pub text: String,
    /// Notation in the file.
    pub style: Style,
}

/// Notation of a scalar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Without quotes: may be meant as number or flag.
    Plain,
    /// In single or double quotes: text.
    Quoted,
    /// After `|` or `>`: text.
    Block,
}

/// A key with its value.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The key's text.
    pub key: String,
    /// Position of the key.
    pub mark: Mark,
    /// The value.
    pub node: Node,
}

/// Why a text is not a YAML document that this reader accepts.
#[derive(Clone, Debug)]
pub struct SyntaxError {
    /// What is wrong.
    pub cause: SyntaxCause,
    /// Where.
    pub mark: Mark,
}

/// The cause of a [`SyntaxError`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SyntaxCause {
    /// Not YAML; the parser's message.
    Malformed(String),
    /// `*name`: aliases are not supported.
    Alias,
    /// More than one document in the file.
    SeveralDocuments,
    /// A key that is a list or mapping.
    KeyNotText,
}

impl Value {
    /// The text of a scalar.
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Scalar(scalar) => Some(&scalar.text),
            _ => None,
        }
    }
}

impl Node {
    /// The text of a scalar.
    pub fn text(&self) -> Option<&str> {
        self.value.text()
    }

    /// The value under `key` of a mapping; the first, if the key occurs twice.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.entries().iter().find(|e| e.key == key).map(|e| &e.node)
    }

    /// True for equal values, regardless of position and notation.
    pub fn same_content(&self, other: &Node) -> bool {
        match (&self.value, &other.value) {
            (Value::Null, Value::Null) => true,
            (Value::Scalar(a), Value::Scalar(b)) => a.text == b.text,
            (Value::List(a), Value::List(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.same_content(b))
            }
            (Value::Map(a), Value::Map(b)) => {
                let found = |e: &Entry| b.iter().find(|o| o.key == e.key);
                a.len() == b.len() && a.iter().all(|e| found(e).is_some_and(|o| e.node.same_content(&o.node)))
            }
            _ => false,
        }
    }

    /// The items of a list; empty for anything else.
    pub fn items(&self) -> &[Node] {
        match &self.value {
            Value::List(items) => items,
            _ => &[],
        }
    }

    /// The entries of a mapping; empty for anything else.
    pub fn entries(&self) -> &[Entry] {
        match &self.value {
            Value::Map(entries) => entries,
            _ => &[],
        }
    }
}

/// A list or mapping under construction.
enum Open {
    List(Mark, Vec<Node>),
    Map(Mark, Vec<Entry>, Option<(String, Mark)>),
}

/// Parses one document. An empty text is [`Value::Null`].
///
/// # Errors
/// If the text is not YAML, or uses aliases, several documents, or keys that are not text.
pub fn parse(text: &str) -> Result<Node, SyntaxError> {
    let mut stack: Vec<Open> = Vec::new();
    let mut root: Option<Node> = None;
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|e| SyntaxError {
            cause: SyntaxCause::Malformed(e.info().to_owned()),
            mark: mark_of(e.marker(), 1),
        })?;
        let width = if span.end.line() == span.start.line() { span.end.col() - span.start.col() } else { 1 };
        let mark = mark_of(&span.start, width.max(1));
        let done = match event {
            Event::Scalar(text, style, _, _) => {
                Some(Node { value: scalar(&text, style), mark, pointer: String::new() })
            }
            Event::SequenceStart(..) => {
                stack.push(Open::List(Mark { span: 1, ..mark }, Vec::new()));
                None
            }
            Event::MappingStart(..) => {
                stack.push(Open::Map(Mark { span: 1, ..mark }, Vec::new(), None));
                None
            }
            Event::SequenceEnd | Event::MappingEnd => stack.pop().map(|open| match open {
                Open::List(mark, items) => Node { value: Value::List(items), mark, pointer: String::new() },
                Open::Map(mark, entries, _) => {
                    Node { value: Value::Map(entries), mark, pointer: String::new() }
                }
            }),
            Event::Alias(_) => return Err(SyntaxError { cause: SyntaxCause::Alias, mark }),
            Event::DocumentStart(_) if root.is_some() => {
                return Err(SyntaxError { cause: SyntaxCause::SeveralDocuments, mark });
            }
            _ => None,
        };
        let Some(node) = done else { continue };
        match stack.last_mut() {
            None => root = Some(node),
            Some(Open::List(_, items)) => items.push(node),
            Some(Open::Map(_, entries, pending)) => match pending.take() {
                Some((key, mark)) => entries.push(Entry { key, mark, node }),
                None => match node.value {
                    Value::Scalar(scalar) => *pending = Some((scalar.text, node.mark)),
                    Value::Null => *pending = Some(("null".to_owned(), node.mark)),
                    Value::List(_) | Value::Map(_) => {
                        return Err(SyntaxError { cause: SyntaxCause::KeyNotText, mark: node.mark });
                    }
                },
            },
        }
    }
    let mut root = root.unwrap_or(Node {
        value: Value::Null,
        mark: Mark { line: 1, column: 1, span: 1 },
        pointer: String::new(),
    });
    set_pointers(&mut root, String::new());
    Ok(root)
}

fn mark_of(marker: &Marker, span: usize) -> Mark {
    Mark { line: marker.line(), column: marker.col() + 1, span }
}

fn scalar(text: &str, style: ScalarStyle) -> Value {
    let style = match style {
        ScalarStyle::Plain => Style::Plain,
        ScalarStyle::SingleQuoted | ScalarStyle::DoubleQuoted => Style::Quoted,
        ScalarStyle::Literal | ScalarStyle::Folded => Style::Block,
    };
    if style == Style::Plain && matches!(text, "" | "~" | "null" | "Null" | "NULL") {
        return Value::Null;
    }
    Value::Scalar(Scalar { text: text.to_owned(), style })
}

/// Sets the pointers from `node` down.
fn set_pointers(node: &mut Node, pointer: String) {
    match &mut node.value {
        Value::List(items) => {
            for (i, item) in items.iter_mut().enumerate() {
                set_pointers(item, format!("{pointer}/{i}"));
            }
        }
        Value::Map(entries) => {
            for e in entries {
                set_pointers(
                    &mut e.node,
                    format!("{pointer}/{}", e.key.replace('~', "~0").replace('/', "~1")),
                );
            }
        }
        Value::Null | Value::Scalar(_) => {}
    }
    node.pointer = pointer;
}
