//! Protobuf messages as JSON values, by the `FileDescriptorSet` that an MCAP file carries. Fields that a message leaves
//! out have proto3's default; messages that it leaves out are absent.

use crate::encodings::protobuf::{Field, Fields, Wire};
use serde_json::{Map, Number, Value};
use std::collections::BTreeMap;

const MAX_DEPTH: usize = 20;
/// `FieldDescriptorProto.Type`
const DOUBLE: i64 = 1;
const FLOAT: i64 = 2;
const BOOL: i64 = 8;
const STRING: i64 = 9;
const MESSAGE: i64 = 11;
const BYTES: i64 = 12;
const REPEATED: i64 = 3;

#[derive(Default)]
struct FieldType {
    name: String,
    label: i64,
    kind: i64,
    message: String,
}

/// All message types of a schema, by full name with a dot before it.
pub(crate) struct MessageTypes(BTreeMap<String, BTreeMap<u32, FieldType>>);

impl MessageTypes {
    /// `None` when the bytes are not a descriptor set.
    pub fn parse(set: &[u8]) -> Option<Self> {
        let mut all = BTreeMap::new();
        for file in Fields::new(set) {
            let file = file.ok()?;
            if file.number != 1 {
                continue;
            }
            let fields: Vec<Field<'_>> = file.fields().ok()?.collect::<Result<_, _>>().ok()?;
            let package = fields.iter().find(|f| f.number == 2).and_then(|f| f.text().ok());
            let scope = package.filter(|p| !p.is_empty()).map_or(String::new(), |p| format!(".{p}"));
            for f in fields.iter().filter(|f| f.number == 4) {
                message_type(f, &scope, &mut all, 0)?;
            }
        }
        Some(Self(all))
    }

    /// A message of the type with this full name.
    pub fn decode(&self, name: &str, message: &[u8]) -> Option<Value> {
        self.message(&format!(".{name}"), message, 0)
    }

    fn message(&self, name: &str, message: &[u8], depth: usize) -> Option<Value> {
        let types = self.0.get(name).filter(|_| depth <= MAX_DEPTH)?;
        let mut out = Map::new();
        for t in types.values().filter(|t| t.label != REPEATED && t.kind != MESSAGE) {
            let default = match t.kind {
                BOOL => Value::Bool(false),
                STRING | BYTES => Value::String(String::new()),
                _ => 0.into(),
            };
            out.insert(t.name.clone(), default);
        }
        for t in types.values().filter(|t| t.label == REPEATED) {
            out.insert(t.name.clone(), Value::Array(Vec::new()));
        }
        for f in Fields::new(message) {
            let f = f.ok()?;
            let Some(t) = types.get(&f.number) else { continue };
            if t.label != REPEATED {
                out.insert(t.name.clone(), self.one(t, &f, depth)?);
            } else if let Some(Value::Array(list)) = out.get_mut(&t.name) {
                match f.wire {
                    Wire::Bytes(packed) if !matches!(t.kind, STRING | MESSAGE | BYTES) => {
                        unpack(t.kind, packed, &f, list)?
                    }
                    _ => list.push(self.one(t, &f, depth)?),
                }
            }
        }
        Some(Value::Object(out))
    }

    fn one(&self, t: &FieldType, f: &Field<'_>, depth: usize) -> Option<Value> {
        Some(match t.kind {
            MESSAGE => self.message(&t.message, f.bytes().ok()?, depth + 1)?,
            STRING => Value::String(f.text().ok()?),
            // No field used here has raw bytes.
            BYTES => Value::Null,
            _ => scalar(t.kind, f.wire)?,
        })
    }
}

fn message_type(
    f: &Field<'_>,
    scope: &str,
    all: &mut BTreeMap<String, BTreeMap<u32, FieldType>>,
    depth: usize,
) -> Option<()> {
    let parts: Vec<Field<'_>> = f.fields().ok()?.collect::<Result<_, _>>().ok()?;
    let name = parts.iter().find(|p| p.number == 1).and_then(|p| p.text().ok())?;
    let full = format!("{scope}.{name}");
    let mut fields = BTreeMap::new();
    for p in parts.iter().filter(|p| p.number == 2) {
        let (mut number, mut t) = (0, FieldType::default());
        for part in p.fields().ok()? {
            let part = part.ok()?;
            match part.number {
                1 => t.name = part.text().ok()?,
                3 => number = u32::try_from(part.int().ok()?).ok()?,
                4 => t.label = part.int().ok()?,
                5 => t.kind = part.int().ok()?,
                6 => t.message = part.text().ok()?,
                _ => {}
            }
        }
        fields.insert(number, t);
    }
    for p in parts.iter().filter(|p| p.number == 3) {
        (depth < MAX_DEPTH).then_some(())?;
        message_type(p, &full, all, depth + 1)?;
    }
    all.insert(full, fields);
    Some(())
}

fn scalar(kind: i64, wire: Wire<'_>) -> Option<Value> {
    let zigzag = |v: u64| (v >> 1) as i64 ^ -((v & 1) as i64);
    Some(match (kind, wire) {
        (DOUBLE, Wire::Fixed64(v)) => Number::from_f64(f64::from_bits(v)).map_or(Value::Null, Value::Number),
        (FLOAT, Wire::Fixed32(v)) => {
            Number::from_f64(f64::from(f32::from_bits(v))).map_or(Value::Null, Value::Number)
        }
        (BOOL, Wire::Varint(v)) => Value::Bool(v != 0),
        // uint64, uint32; sint32, sint64; the other whole numbers and enums.
        (4 | 13, Wire::Varint(v)) => v.into(),
        (17 | 18, Wire::Varint(v)) => zigzag(v).into(),
        (_, Wire::Varint(v)) => (v as i64).into(),
        (16, Wire::Fixed64(v)) => (v as i64).into(),
        (15, Wire::Fixed32(v)) => (v as i32).into(),
        (6, Wire::Fixed64(v)) => v.into(),
        (7, Wire::Fixed32(v)) => v.into(),
        _ => return None,
    })
}

fn unpack(kind: i64, packed: &[u8], f: &Field<'_>, out: &mut Vec<Value>) -> Option<()> {
    match kind {
        DOUBLE | 6 | 16 => {
            for c in packed.chunks(8) {
                out.push(scalar(kind, Wire::Fixed64(u64::from_le_bytes(c.try_into().ok()?)))?);
            }
        }
        FLOAT | 7 | 15 => {
            for c in packed.chunks(4) {
                out.push(scalar(kind, Wire::Fixed32(u32::from_le_bytes(c.try_into().ok()?)))?);
            }
        }
        _ => {
            let mut ints = Vec::new();
            f.ints(&mut ints).ok()?;
            for v in ints {
                out.push(scalar(kind, Wire::Varint(v as u64))?);
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    proptest::proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..200)) {
            if let Some(types) = super::MessageTypes::parse(&bytes) {
                let _ = types.decode("a", &bytes);
            }
        }
    }
}
