//! From a YAML tree to Rust types through serde: for files with a simple form, where reporting the first mistake is
//! enough. The error keeps its position. Files that people edit often are read with [`super::Fields`], which reports
//! every mistake.

use super::tree::{Entry, Mark, Node, Scalar, Style, SyntaxCause, SyntaxError, Value, parse};
use crate::serde_text::in_chinese;
use crate::{Bilingual, Diagnostic, Location};
use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, MapAccess, SeqAccess, VariantAccess, Visitor,
};
use serde::{Deserialize, forward_to_deserialize_any};
use std::fmt;

/// Why a text or a tree is not a value of the required type. The message quotes the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecodeError {
    /// What is wrong, in serde's words.
    pub message: String,
    /// Where, as far as known.
    pub mark: Option<Mark>,
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.mark {
            Some(m) => write!(f, "{} at line {} column {}", self.message, m.line, m.column),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for DecodeError {}

impl serde::de::Error for DecodeError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self { message: message.to_string(), mark: None }
    }
}

impl From<SyntaxError> for DecodeError {
    fn from(e: SyntaxError) -> Self {
        let message = match &e.cause {
            SyntaxCause::Malformed(message) => message.clone(),
            _ => e.message().en,
        };
        Self { message, mark: Some(e.mark) }
    }
}

impl DecodeError {
    /// This error as a diagnostic at its place in `file`. `what` names the content of the file, as the beginning of a
    /// sentence: "the word list".
    pub fn diagnostic(&self, code: &'static str, file: &str, what: Bilingual) -> Diagnostic {
        let location = Location {
            file: Some(file.to_owned()),
            line: self.mark.map(|m| m.line),
            column: self.mark.map(|m| m.column),
            ..Location::default()
        };
        let message = Bilingual::new(
            format!("{}无法读取：{}", what.zh, in_chinese(&self.message)),
            format!("{} cannot be read: {}", what.en, self.message),
        );
        Diagnostic::error(code, message).at(location)
    }

    fn at(mut self, mark: Mark) -> Self {
        self.mark.get_or_insert(mark);
        self
    }
}

/// Reads a value from a text.
///
/// # Errors
/// If the text is not YAML that [`parse`] accepts, or is not of the wanted form.
pub fn from_str<T: DeserializeOwned>(text: &str) -> Result<T, DecodeError> {
    from_node(&parse(text)?)
}

/// Reads a value from a tree.
///
/// # Errors
/// If the tree is not of the wanted form.
pub fn from_node<'n, T: Deserialize<'n>>(node: &'n Node) -> Result<T, DecodeError> {
    T::deserialize(Decoder(node)).map_err(|e| e.at(node.mark))
}

#[derive(Clone, Copy)]
struct Decoder<'n>(&'n Node);

impl<'n> Decoder<'n> {
    fn located<T>(self, result: Result<T, DecodeError>) -> Result<T, DecodeError> {
        result.map_err(|e| e.at(self.0.mark))
    }

    fn text<V: Visitor<'n>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        match &self.0.value {
            Value::Scalar(s) => self.located(visitor.visit_borrowed_str(&s.text)),
            _ => self.deserialize_any(visitor),
        }
    }
}

/// A plain scalar may be a flag or a number (YAML 1.2 core schema, decimal only).
fn plain<'n, V: Visitor<'n>>(scalar: &'n Scalar, visitor: V) -> Result<V::Value, DecodeError> {
    let text = scalar.text.as_str();
    if scalar.style == Style::Plain {
        match text {
            "true" | "True" | "TRUE" => return visitor.visit_bool(true),
            "false" | "False" | "FALSE" => return visitor.visit_bool(false),
            ".nan" | ".NaN" | ".NAN" => return visitor.visit_f64(f64::NAN),
            ".inf" | "+.inf" => return visitor.visit_f64(f64::INFINITY),
            "-.inf" => return visitor.visit_f64(f64::NEG_INFINITY),
            _ => {}
        }
        let digits = text.trim_start_matches(['-', '+']);
        if digits.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            if let Ok(n) = text.parse::<u64>() {
                return visitor.visit_u64(n);
            }
            if let Ok(n) = text.parse::<i64>() {
                return visitor.visit_i64(n);
            }
            if let Ok(n) = text.parse::<f64>() {
                return visitor.visit_f64(n);
            }
        }
    }
    visitor.visit_borrowed_str(text)
}

impl<'de> Deserializer<'de> for Decoder<'de> {
    type Error = DecodeError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        self.located(match &self.0.value {
            Value::Null => visitor.visit_unit(),
            Value::Scalar(s) => plain(s, visitor),
            Value::List(items) => visitor.visit_seq(Items(items.iter())),
            Value::Map(entries) => visitor.visit_map(Entries { all: entries, next: 0 }),
        })
    }

    // A text may look like a number: `version: 2.0` is text where text is wanted.
    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        self.text(visitor)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        self.text(visitor)
    }

    fn deserialize_identifier<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        self.text(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        match self.0.value {
            Value::Null => visitor.visit_none(),
            _ => self.located(visitor.visit_some(self)),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        self.located(match &self.0.value {
            Value::Scalar(s) => visitor.visit_enum(StrDeserializer::new(&s.text)),
            Value::Map(entries) if entries.len() == 1 => visitor.visit_enum(Variant(&entries[0])),
            _ => return self.deserialize_any(visitor),
        })
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct ignored_any
    }
}

struct Items<'n>(std::slice::Iter<'n, Node>);

impl<'n> SeqAccess<'n> for Items<'n> {
    type Error = DecodeError;
    fn next_element_seed<T: DeserializeSeed<'n>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, DecodeError> {
        self.0.next().map(|node| seed.deserialize(Decoder(node))).transpose()
    }
}

struct Entries<'n> {
    all: &'n [Entry],
    next: usize,
}

impl<'n> MapAccess<'n> for Entries<'n> {
    type Error = DecodeError;

    fn next_key_seed<K: DeserializeSeed<'n>>(&mut self, seed: K) -> Result<Option<K::Value>, DecodeError> {
        let Some(entry) = self.all.get(self.next) else { return Ok(None) };
        if self.all[..self.next].iter().any(|e| e.key == entry.key) {
            let message = format!("key '{}' is written twice", entry.key);
            return Err(DecodeError { message, mark: Some(entry.mark) });
        }
        let key = serde::de::value::BorrowedStrDeserializer::new(&entry.key);
        seed.deserialize(key).map(Some).map_err(|e: DecodeError| e.at(entry.mark))
    }

    fn next_value_seed<V: DeserializeSeed<'n>>(&mut self, seed: V) -> Result<V::Value, DecodeError> {
        let Some(entry) = self.all.get(self.next) else {
            return Err(serde::de::Error::custom("a value without its key"));
        };
        self.next += 1;
        seed.deserialize(Decoder(&entry.node)).map_err(|e| e.at(entry.node.mark))
    }
}

/// `variant: value`.
struct Variant<'n>(&'n Entry);

impl<'n> EnumAccess<'n> for Variant<'n> {
    type Error = DecodeError;
    type Variant = Self;
    fn variant_seed<V: DeserializeSeed<'n>>(self, seed: V) -> Result<(V::Value, Self), DecodeError> {
        let key = serde::de::value::BorrowedStrDeserializer::new(&self.0.key);
        Ok((seed.deserialize(key).map_err(|e: DecodeError| e.at(self.0.mark))?, self))
    }
}

impl<'n> VariantAccess<'n> for Variant<'n> {
    type Error = DecodeError;
    fn unit_variant(self) -> Result<(), DecodeError> {
        <()>::deserialize(Decoder(&self.0.node))
    }
    fn newtype_variant_seed<T: DeserializeSeed<'n>>(self, seed: T) -> Result<T::Value, DecodeError> {
        seed.deserialize(Decoder(&self.0.node))
    }
    fn tuple_variant<V: Visitor<'n>>(self, _: usize, visitor: V) -> Result<V::Value, DecodeError> {
        Decoder(&self.0.node).deserialize_any(visitor)
    }
    fn struct_variant<V: Visitor<'n>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        Decoder(&self.0.node).deserialize_any(visitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value as Json, json};

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Rules {
        version: String,
        #[serde(default)]
        limit: Option<f64>,
        levels: Vec<Level>,
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Level {
        Low,
        Above(u32),
    }

    #[test]
    fn scalars_have_the_types_of_the_core_schema() {
        let text = "a: 1\nb: -2.5\nc: true\nd: '1'\ne: ~\nf: [x, 1e3, 2026-01-15]\ng: {h: no}\n";
        let value: Json = from_str(text).unwrap();
        assert_eq!(
            value,
            json!({"a": 1, "b": -2.5, "c": true, "d": "1", "e": null, "f": ["x", 1000.0, "2026-01-15"], "g": {"h": "no"}})
        );
    }

    #[test]
    fn a_struct_reads_text_that_looks_like_a_number() {
        let read: Rules = from_str("version: 2.0\nlevels: [low, {above: 3}]\n").unwrap();
        assert_eq!(
            read,
            Rules { version: "2.0".into(), limit: None, levels: vec![Level::Low, Level::Above(3)] }
        );
    }

    #[test]
    fn errors_have_the_position_of_what_is_wrong() {
        // Line and column counted by hand.
        for (text, part, line, column) in [
            ("version: 1\nlimt: 2\nlevels: []\n", "unknown field `limt`", 2, 1),
            ("version: 1\nlimit: x\nlevels: []\n", "invalid type: string \"x\"", 2, 8),
            ("version: 1\nlevels: [low, hgh]\n", "unknown variant `hgh`", 2, 15),
            ("version: 1\nversion: 2\nlevels: []\n", "key 'version' is written twice", 2, 1),
            ("version: 1\n", "missing field `levels`", 1, 1),
        ] {
            let e = from_str::<Rules>(text).unwrap_err();
            assert!(e.message.contains(part), "{e}");
            assert_eq!(e.mark.map(|m| (m.line, m.column)), Some((line, column)), "{text}{e}");
        }
    }
}
