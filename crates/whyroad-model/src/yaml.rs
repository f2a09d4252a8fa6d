//! YAML with source positions: a tree in which every key and value knows its line and column, so that all
//! problems of a file are reported where they are. Only reading; the caller gives it meaning.
//!
//! [`from_str`] returns any type that serde reads, with the position of the first mistake; [`to_string`] writes.
//! [`parse`] gives the tree. [`FileReport`] and [`Fields`] read mappings field by field and report what is missing,
//! misspelled, of the wrong type or written twice, each under the codes ([`FormCodes`]) of its family of files.

mod decode;
mod encode;
mod fields;
mod position;
mod tree;

pub use decode::{DecodeError, from_node, from_str};
pub use encode::to_string;
pub use fields::{Fields, FileReport, FormCodes};
pub use tree::{Entry, Mark, Node, Scalar, Style, SyntaxCause, SyntaxError, Value, parse};

use crate::Bilingual;

impl Value {
    /// Type and text of the value, for messages ("expected a list, found 'x'").
    pub fn description(&self) -> Bilingual {
        match self {
            Self::Null => Bilingual::new("空值", "null"),
            Self::Scalar(scalar) => Bilingual::same(format!("'{}'", scalar.text)),
            Self::List(_) => Bilingual::new("列表", "a list"),
            Self::Map(_) => Bilingual::new("映射", "a mapping"),
        }
    }
}

impl SyntaxError {
    /// What is wrong.
    pub fn message(&self) -> Bilingual {
        match &self.cause {
            SyntaxCause::Malformed(message) => Bilingual::same(message.clone()),
            SyntaxCause::Alias => {
                Bilingual::new("不支持 YAML 别名（*名称）", "YAML aliases (*name) are not supported")
            }
            SyntaxCause::SeveralDocuments => {
                Bilingual::new("文件含有多个 YAML 文档", "the file holds more than one YAML document")
            }
            SyntaxCause::KeyNotText => Bilingual::new("键必须是文本", "a key must be text"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_those_of_the_text() {
        let node = parse("a:\n  - id: x\n    n: { zh: 中, en: e }\n").unwrap();
        let item = &node.get("a").unwrap().items()[0];
        let n = &item.entries()[1];
        assert_eq!((n.key.as_str(), n.mark.line, n.mark.column), ("n", 3, 5));
        // Counted by hand on line 3: `    n: { zh: 中, en: e }`, the `e` of `en` is character 17.
        let en = &n.node.entries()[1];
        assert_eq!((en.mark.line, en.mark.column), (3, 17));
        assert_eq!(en.node.pointer, "/a/0/n/en");
    }

    #[test]
    fn a_syntax_error_has_its_position_and_cause() {
        let e = parse("a: [1, 2\nb: 3\n").unwrap_err();
        assert!(e.mark.line >= 1, "{e:?}");
        assert_eq!(parse("a: &b 1\nc: *b\n").unwrap_err().cause, SyntaxCause::Alias);
        assert_eq!(parse("--- 1\n--- 2\n").unwrap_err().cause, SyntaxCause::SeveralDocuments);
        assert_eq!(parse("? [a]\n: 1\n").unwrap_err().cause, SyntaxCause::KeyNotText);
    }

    #[test]
    fn quotes_make_text_and_an_empty_plain_value_is_null() {
        let node = parse("a: ''\nb: \nc: '1'\nd: 1\n").unwrap();
        let style = |key| match &node.get(key).unwrap().value {
            Value::Scalar(scalar) => Some(scalar.style),
            _ => None,
        };
        assert_eq!(
            [style("a"), style("b"), style("c"), style("d")],
            [Some(Style::Quoted), None, Some(Style::Quoted), Some(Style::Plain)]
        );
    }
}
