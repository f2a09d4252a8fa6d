//! ROS messages as JSON values, by the message definition that a recording carries (`.msg` text, the definitions of
//! its parts behind lines of `=`): ROS 2 (CDR, little and big endian, as rosbag2 writes it) and ROS 1 (little endian,
//! without gaps).

use crate::file_reader::FileReader;
use serde_json::{Map, Number, Value};
use std::collections::BTreeMap;

/// Nothing in ROS nests deeper.
const MAX_DEPTH: usize = 20;
/// A message with more values is not a list of objects; point clouds are `byte` arrays of topics that are not read.
const MAX_VALUES: usize = 1 << 22;

#[derive(Clone, Debug)]
struct Field {
    name: String,
    kind: String,
    many: Many,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Many {
    One,
    Fixed(usize),
    Sequence,
}

/// A message type with all its parts.
pub(crate) struct MessageType {
    root: Vec<Field>,
    parts: BTreeMap<String, Vec<Field>>,
}

/// `package/msg/Type` and `package/Type` are one name.
fn plain(name: &str) -> String {
    name.replace("/msg/", "/")
}

fn is_builtin(kind: &str) -> bool {
    matches!(
        kind,
        "bool"
            | "byte"
            | "char"
            | "int8"
            | "uint8"
            | "int16"
            | "uint16"
            | "int32"
            | "uint32"
            | "int64"
            | "uint64"
            | "float32"
            | "float64"
            | "string"
            | "wstring"
    )
}

fn fields(text: &str, package: &str) -> Vec<Field> {
    let mut out = Vec::new();
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        let mut words = line.split_whitespace();
        let (Some(kind), Some(name)) = (words.next(), words.next()) else { continue };
        // `int32 NAME=1` and `int32 NAME = 1` are constants.
        if name.contains('=') || words.next().is_some_and(|w| w.starts_with('=')) {
            continue;
        }
        let (kind, many) = match kind.split_once('[') {
            None => (kind, Many::One),
            Some((kind, size)) => {
                let size = size.trim_end_matches(']');
                (kind, size.parse().map_or(Many::Sequence, Many::Fixed))
            }
        };
        // `string<=10` is a bounded string, written like any other.
        let kind = kind.split("<=").next().unwrap_or(kind);
        let kind = match kind {
            _ if is_builtin(kind) => kind.to_owned(),
            "Header" => "std_msgs/Header".to_owned(),
            // Of ROS 1; in ROS 2 they are messages.
            "time" | "duration" => format!("ros/{kind}"),
            _ if kind.contains('/') => plain(kind),
            _ => format!("{package}/{kind}"),
        };
        out.push(Field { name: name.to_owned(), kind, many });
    }
    out
}

impl MessageType {
    /// From the definition's text; `name` as in `nav_msgs/msg/Odometry`.
    pub fn parse(name: &str, text: &str) -> Self {
        let mut sections = vec![(plain(name), String::new())];
        for line in text.lines() {
            if line.len() > 10 && line.chars().all(|c| c == '=') {
                sections.push((String::new(), String::new()));
                continue;
            }
            let Some((title, body)) = sections.last_mut() else { continue };
            match line.strip_prefix("MSG:") {
                Some(part) => *title = plain(part.trim()),
                None => *body += &format!("{line}\n"),
            }
        }
        let package = |name: &str| name.split('/').next().unwrap_or_default().to_owned();
        let mut all = sections.into_iter().map(|(name, body)| {
            let f = fields(&body, &package(&name));
            (name, f)
        });
        let root = all.next().map(|(_, f)| f).unwrap_or_default();
        let mut parts: BTreeMap<String, Vec<Field>> = all.collect();
        let stamp = || fields("int32 sec\nuint32 nanosec", "");
        for builtin in ["builtin_interfaces/Time", "builtin_interfaces/Duration"] {
            parts.entry(builtin.to_owned()).or_insert_with(stamp);
        }
        parts.insert("ros/time".to_owned(), fields("uint32 sec\nuint32 nsec", ""));
        parts.insert("ros/duration".to_owned(), fields("int32 sec\nint32 nsec", ""));
        Self { root, parts }
    }

    /// A message; `None` when its bytes do not fit the definition.
    pub fn decode(&self, message: &[u8]) -> Option<Value> {
        let (&[_, order, _, _], body) = message.split_first_chunk::<4>()?;
        let mut r = Bytes { body, at: 0, little: order & 1 == 1, gaps: true, values: 0 };
        self.structure(&self.root, &mut r, 0)
    }

    /// A message of ROS 1; `None` when its bytes do not fit the definition.
    pub fn decode_ros1(&self, message: &[u8]) -> Option<Value> {
        let mut r = Bytes { body: message, at: 0, little: true, gaps: false, values: 0 };
        let value = self.structure(&self.root, &mut r, 0)?;
        (r.at == message.len()).then_some(value)
    }

    fn structure(&self, fields: &[Field], r: &mut Bytes<'_>, depth: usize) -> Option<Value> {
        if depth > MAX_DEPTH {
            return None;
        }
        let mut out = Map::new();
        for f in fields {
            let n = match f.many {
                Many::One => {
                    out.insert(f.name.clone(), self.one(&f.kind, r, depth)?);
                    continue;
                }
                Many::Fixed(n) => n,
                Many::Sequence => r.int::<4>()? as usize,
            };
            // An element has at least one byte, so a list length greater than the number of bytes is invalid.
            if n > r.body.len() - r.at.min(r.body.len()) || n > MAX_VALUES {
                return None;
            }
            let items = (0..n).map(|_| self.one(&f.kind, r, depth)).collect::<Option<_>>()?;
            out.insert(f.name.clone(), Value::Array(items));
        }
        Some(Value::Object(out))
    }

    fn one(&self, kind: &str, r: &mut Bytes<'_>, depth: usize) -> Option<Value> {
        // Lists of structures without fields take no bytes, and can nest.
        r.values += 1;
        if r.values > MAX_VALUES {
            return None;
        }
        Some(match kind {
            "bool" => Value::Bool(r.int::<1>()? != 0),
            "byte" | "char" | "uint8" => r.int::<1>()?.into(),
            "int8" => (r.int::<1>()? as i8).into(),
            "int16" => (r.int::<2>()? as i16).into(),
            "uint16" => r.int::<2>()?.into(),
            "int32" => (r.int::<4>()? as i32).into(),
            "uint32" => r.int::<4>()?.into(),
            "int64" => (r.int::<8>()? as i64).into(),
            "uint64" => r.int::<8>()?.into(),
            "float32" => number(f64::from(f32::from_bits(r.int::<4>()? as u32))),
            "float64" => number(f64::from_bits(r.int::<8>()?)),
            "string" => {
                let n = r.int::<4>()? as usize;
                let text = r.take(n)?;
                Value::String(String::from_utf8_lossy(text.strip_suffix(b"\0").unwrap_or(text)).into_owned())
            }
            "wstring" => return None,
            other => self.structure(self.parts.get(other)?, r, depth + 1)?,
        })
    }
}

/// JSON has no NaN: unknown.
fn number(v: f64) -> Value {
    Number::from_f64(v).map_or(Value::Null, Value::Number)
}

struct Bytes<'a> {
    body: &'a [u8],
    at: usize,
    little: bool,
    /// Whether values lie at multiples of their size.
    gaps: bool,
    /// Values read so far.
    values: usize,
}

impl<'a> Bytes<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let out = self.body.get(self.at..self.at.checked_add(n)?)?;
        self.at += n;
        Some(out)
    }

    /// In CDR, values lie at multiples of their size, counted from behind the four bytes of the header.
    fn int<const N: usize>(&mut self) -> Option<u64> {
        if self.gaps {
            self.at = self.at.next_multiple_of(N);
        }
        let raw = self.take(N)?;
        let mut wide = [0; 8];
        for (k, slot) in wide.iter_mut().take(N).enumerate() {
            *slot = raw[if self.little { k } else { N - 1 - k }];
        }
        Some(u64::from_le_bytes(wide))
    }
}

/// A part preceded by its length in two bytes, and the remaining bytes.
pub(crate) fn sized(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<2>()?;
    rest.split_at_checked(usize::from(u16::from_le_bytes(*length)))
}

/// For [`crate::readers`]: the length of a definition in two bytes, the definition, a message.
pub(crate) const READER: FileReader = FileReader {
    name: "ros-message",
    read: |bytes| {
        let Some((definition, message)) = sized(bytes) else { return false };
        let of = MessageType::parse("a/msg/A", &String::from_utf8_lossy(definition));
        of.decode(message).is_some() | of.decode_ros1(message).is_some()
    },
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_aligned_and_either_end_first() {
        // CDR by hand: uint8 7, three bytes of filling, uint32 1, string "ab" (length 3 with its zero), filling, double
        // 1.5.
        let t =
            MessageType::parse("a/msg/B", "uint8 x\nint32 C=5 # a constant\nuint32 y\nstring s\nfloat64 z");
        let little = b"\0\x01\0\0\x07\0\0\0\x01\0\0\0\x03\0\0\0ab\0\0\0\0\0\0\0\0\xf8\x3f";
        let big = b"\0\0\0\0\x07\0\0\0\0\0\0\x01\0\0\0\x03ab\0\0\x3f\xf8\0\0\0\0\0\0";
        let want = serde_json::json!({"x": 7, "y": 1, "s": "ab", "z": 1.5});
        assert_eq!((t.decode(little), t.decode(big)), (Some(want.clone()), Some(want)));
        assert_eq!(t.decode(&little[..20]), None);
    }

    #[test]
    fn ros1_has_no_gaps_and_its_own_times() {
        // By hand: uint8 7, uint32 1, string "ab" (length 2, no zero), time 5 s 6 ns, two floats 1.5, three bytes.
        let t = MessageType::parse("a/B", "uint8 x\nuint32 y\nstring s\ntime t\nfloat64[] z\nuint8[3] b");
        let bytes = b"\x07\x01\0\0\0\x02\0\0\0ab\x05\0\0\0\x06\0\0\0\x02\0\0\0\0\0\0\0\0\0\xf8\x3f\0\0\0\0\0\0\xf8\x3f\x01\x02\x03";
        let want = serde_json::json!(
            {"x": 7, "y": 1, "s": "ab", "t": {"sec": 5, "nsec": 6}, "z": [1.5, 1.5], "b": [1, 2, 3]}
        );
        assert_eq!(t.decode_ros1(bytes), Some(want));
        assert_eq!(t.decode_ros1(&bytes[..bytes.len() - 1]), None, "cut short");
        assert_eq!(t.decode_ros1(&[bytes.as_slice(), b"x"].concat()), None, "longer than its definition");
    }

    #[test]
    fn a_list_longer_than_the_message_is_refused_and_a_type_in_itself_ends() {
        let t = MessageType::parse("a/B", "B[] b\nuint8[] c");
        assert_eq!(t.decode(b"\0\x01\0\0\xff\xff\xff\x7f"), None);
    }

    proptest::proptest! {
        #[test]
        fn no_bytes_and_no_definition_make_it_panic(
            bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..200),
            text in "(uint8|float64|string|B|C)(\\[\\]|\\[3\\])? [a-c]\n(B|string\\[\\]) d\n={12}\nMSG: a/B\n(a/C|int16) e\n",
        ) {
            let t = MessageType::parse("a/msg/A", &text);
            let _ = (t.decode(&bytes), t.decode_ros1(&bytes));
        }
    }
}
