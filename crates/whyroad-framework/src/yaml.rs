//! YAML with places: a tree in which every key and value knows its line and column, so that all problems of a
//! file can be reported where they are. Only reading; meaning is given by the `read` modules.
//!
//! serde is not used here because it stops at a file's first mistake and forgets where values stood.

mod fields;

pub(crate) use fields::{Family, Fields, Report};

use saphyr_parser::{Event, Marker, Parser, ScalarStyle};
use whyroad_model::Bilingual;

/// Line and column in characters, both from 1, and the length of what stands there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Mark {
    pub line: usize,
    pub column: usize,
    pub span: usize,
}

/// A value and where it stands.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub value: Value,
    pub mark: Mark,
    /// RFC 6901.
    pub pointer: String,
}

/// What a value is. Scalars stay text: `version: 2.0` must not become a number on the way.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    /// Empty, `~` or `null`.
    Null,
    Scalar(String),
    List(Vec<Node>),
    Map(Vec<Entry>),
}

/// A key with its value.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub key: String,
    pub mark: Mark,
    pub node: Node,
}

/// Why a text is not a YAML document that we read.
#[derive(Clone, Debug)]
pub(crate) struct SyntaxError {
    pub message: Bilingual,
    pub mark: Mark,
}

impl Value {
    /// Kind of value, for messages.
    pub fn kind(&self) -> Bilingual {
        match self {
            Value::Null => Bilingual::new("空值", "null"),
            Value::Scalar(text) => Bilingual::same(format!("'{text}'")),
            Value::List(_) => Bilingual::new("列表", "a list"),
            Value::Map(_) => Bilingual::new("映射", "a mapping"),
        }
    }
}

/// A list or mapping under construction.
enum Open {
    List(Mark, Vec<Node>),
    Map(Mark, Vec<Entry>, Option<(String, Mark)>),
}

/// Parses one document. An empty text is `Null`.
pub(crate) fn parse(text: &str) -> Result<Node, SyntaxError> {
    let mut stack: Vec<Open> = Vec::new();
    let mut root: Option<Node> = None;
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|e| SyntaxError {
            message: Bilingual::same(e.info().to_owned()),
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
            Event::Alias(_) => {
                return Err(SyntaxError {
                    message: Bilingual::new(
                        "不支持 YAML 别名（*名称）",
                        "YAML aliases (*name) are not supported",
                    ),
                    mark,
                });
            }
            Event::DocumentStart(_) if root.is_some() => {
                return Err(SyntaxError {
                    message: Bilingual::new(
                        "文件含有多个 YAML 文档",
                        "the file holds more than one YAML document",
                    ),
                    mark,
                });
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
                    Value::Scalar(text) => *pending = Some((text, node.mark)),
                    Value::Null => *pending = Some(("null".to_owned(), node.mark)),
                    Value::List(_) | Value::Map(_) => {
                        return Err(SyntaxError {
                            message: Bilingual::new("键必须是文本", "a key must be text"),
                            mark: node.mark,
                        });
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
    point(&mut root, String::new());
    Ok(root)
}

fn mark_of(marker: &Marker, span: usize) -> Mark {
    Mark { line: marker.line(), column: marker.col() + 1, span }
}

fn scalar(text: &str, style: ScalarStyle) -> Value {
    let quoted = style != ScalarStyle::Plain;
    if !quoted && matches!(text, "" | "~" | "null" | "Null" | "NULL") {
        return Value::Null;
    }
    Value::Scalar(text.to_owned())
}

/// Fills in the pointers from `node` down.
fn point(node: &mut Node, pointer: String) {
    match &mut node.value {
        Value::List(items) => {
            for (i, item) in items.iter_mut().enumerate() {
                point(item, format!("{pointer}/{i}"));
            }
        }
        Value::Map(entries) => {
            for e in entries {
                point(&mut e.node, format!("{pointer}/{}", e.key.replace('~', "~0").replace('/', "~1")));
            }
        }
        Value::Null | Value::Scalar(_) => {}
    }
    node.pointer = pointer;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_the_text() {
        let node = parse("a:\n  - id: x\n    n: { zh: 中, en: e }\n").unwrap();
        let Value::Map(top) = &node.value else { panic!() };
        let Value::List(items) = &top[0].node.value else { panic!() };
        let Value::Map(item) = &items[0].value else { panic!() };
        assert_eq!((item[1].key.as_str(), item[1].mark.line, item[1].mark.column), ("n", 3, 5));
        let Value::Map(names) = &item[1].node.value else { panic!() };
        // Counted by hand on line 3: `    n: { zh: 中, en: e }`, the `e` of `en` is character 17.
        assert_eq!((names[1].mark.line, names[1].mark.column), (3, 17));
        assert_eq!(names[1].node.pointer, "/a/0/n/en");
    }

    #[test]
    fn broken_text_says_where() {
        let e = parse("a: [1, 2\nb: 3\n").unwrap_err();
        assert!(e.mark.line >= 1, "{e:?}");
        assert!(parse("a: *b\n").is_err());
        assert!(parse("--- 1\n--- 2\n").is_err());
    }
}
