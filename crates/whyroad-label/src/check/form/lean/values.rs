//! Values of the fast reader: texts borrowed from the document, members of closed sets, records. Each accepts only what
//! is certainly valid; anything else is an error, and the slow path decides.

use serde::de::{Error, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;
use whyroad_framework::record_types::RecordValue;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::{KeyframeType, ProvenanceSource, SafetyAnswer, Uncertainty};

/// An `Option` whose key must be present.
pub(super) fn present<'de, D: Deserializer<'de>, T: Deserialize<'de>>(d: D) -> Result<Option<T>, D::Error> {
    Option::<T>::deserialize(d)
}

/// A text that is borrowed where it has no escapes.
pub(in crate::check) struct Text<'t>(pub Cow<'t, str>);

impl Text<'_> {
    /// White space or empty.
    pub fn is_blank(&self) -> bool {
        self.0.trim().is_empty()
    }
}

impl<'de: 't, 't> Deserialize<'de> for Text<'t> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = Text<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("text")
            }
            fn visit_borrowed_str<E: Error>(self, s: &'de str) -> Result<Self::Value, E> {
                Ok(Text(Cow::Borrowed(s)))
            }
            fn visit_str<E: Error>(self, s: &str) -> Result<Self::Value, E> {
                Ok(Text(Cow::Owned(s.to_owned())))
            }
        }
        d.deserialize_str(V)
    }
}

/// A member of a closed set, written as a string only: serde's own enums also accept `{"id": null}`.
pub(in crate::check) struct Id<T>(pub T);

/// The closed sets of a label.
trait Closed: Sized {
    fn of(id: &str) -> Option<Self>;
}

macro_rules! closed {
    ($($t:ty),+) => { $(impl Closed for $t { fn of(id: &str) -> Option<Self> { Self::from_id(id) } })+ };
}
closed!(KeyframeType, ProvenanceSource, SafetyAnswer, Uncertainty, Longitudinal, Lateral, LateralDirection);

impl<'de, T: Closed> Deserialize<'de> for Id<T> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V<T>(PhantomData<T>);
        impl<T: Closed> Visitor<'_> for V<T> {
            type Value = Id<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an identifier of a closed set")
            }
            fn visit_str<E: Error>(self, s: &str) -> Result<Self::Value, E> {
                T::of(s).map(Id).ok_or_else(|| E::invalid_value(Unexpected::Str(s), &self))
            }
        }
        d.deserialize_str(V(PhantomData))
    }
}

/// The records that have a value. Nested values are left to the slow path.
pub(in crate::check) struct Records<'t>(pub Vec<(Cow<'t, str>, LeanRecord<'t>)>);

/// A record's value.
pub(in crate::check) enum LeanRecord<'t> {
    /// Null or blank.
    Nothing,
    Flag(bool),
    Number(f64),
    Text(Cow<'t, str>),
}

impl LeanRecord<'_> {
    pub fn view(&self) -> Option<RecordValue<'_>> {
        Some(match self {
            Self::Nothing => return None,
            Self::Flag(b) => RecordValue::Flag(*b),
            Self::Number(n) => RecordValue::Number(*n),
            Self::Text(t) => RecordValue::Text(t),
        })
    }
}

impl<'de: 't, 't> Deserialize<'de> for Records<'t> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = Records<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("records")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut seen: Vec<(Cow<'de, str>, LeanRecord<'de>)> = Vec::new();
                while let Some(key) = map.next_key::<Text<'de>>()? {
                    let value = map.next_value::<LeanRecord<'de>>()?;
                    if seen.iter().any(|(k, _)| *k == key.0) {
                        return Err(A::Error::custom("duplicate record"));
                    }
                    seen.push((key.0, value));
                }
                Ok(Records(seen))
            }
        }
        d.deserialize_map(V)
    }
}

impl<'de: 't, 't> Deserialize<'de> for LeanRecord<'t> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = LeanRecord<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a plain value")
            }
            fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
                Ok(LeanRecord::Nothing)
            }
            fn visit_bool<E: Error>(self, b: bool) -> Result<Self::Value, E> {
                Ok(LeanRecord::Flag(b))
            }
            fn visit_i64<E: Error>(self, n: i64) -> Result<Self::Value, E> {
                Ok(LeanRecord::Number(n as f64))
            }
            fn visit_u64<E: Error>(self, n: u64) -> Result<Self::Value, E> {
                Ok(LeanRecord::Number(n as f64))
            }
            fn visit_f64<E: Error>(self, n: f64) -> Result<Self::Value, E> {
                Ok(LeanRecord::Number(n))
            }
            fn visit_borrowed_str<E: Error>(self, s: &'de str) -> Result<Self::Value, E> {
                Ok(text(Cow::Borrowed(s)))
            }
            fn visit_str<E: Error>(self, s: &str) -> Result<Self::Value, E> {
                Ok(text(Cow::Owned(s.to_owned())))
            }
        }
        d.deserialize_any(V)
    }
}

fn text(t: Cow<'_, str>) -> LeanRecord<'_> {
    if t.trim().is_empty() { LeanRecord::Nothing } else { LeanRecord::Text(t) }
}

/// Texts by name, without duplicate names.
pub(in crate::check) struct Texts<'t>(Vec<(Cow<'t, str>, Text<'t>)>);

impl Texts<'_> {
    /// One of the texts is blank.
    pub fn has_blank(&self) -> bool {
        self.0.iter().any(|(_, t)| t.is_blank())
    }
}

impl<'de: 't, 't> Deserialize<'de> for Texts<'t> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = Texts<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("texts by name")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut out: Vec<(Cow<'de, str>, Text<'de>)> = Vec::new();
                while let Some((key, text)) = map.next_entry::<Text<'de>, Text<'de>>()? {
                    if out.iter().any(|(k, _)| *k == key.0) {
                        return Err(A::Error::custom("duplicate name"));
                    }
                    out.push((key.0, text));
                }
                Ok(Texts(out))
            }
        }
        d.deserialize_map(V)
    }
}
