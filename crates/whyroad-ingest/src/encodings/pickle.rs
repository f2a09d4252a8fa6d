//! Python pickles as plain data: dicts, lists, numbers, texts and numpy arrays. **Nothing that a pickle names is ever
//! called or imported**: there is a closed list of names whose meaning is known here (numpy's reconstructors, plain
//! containers), and a pickle that asks for any other is refused with that name.
//!
//! Protocols 2 to 5 (PEP 307, 3154, 574; the opcodes of CPython's `pickletools`). Objects live in one arena and refer
//! to each other by number: a pickle that refers to one object a million times costs a million small numbers, cycles
//! are harmless, and nothing recurses over what the file nests. Bytes and texts stay where they are in the file.

mod array;
mod construct;
mod machine;
mod names;

pub(crate) use array::{Array, Dtype, Kind};

use std::borrow::Cow;
use std::ops::Range;

/// Number of an object in the arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Ref(u32);

/// Why a pickle was not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum PickleError {
    /// It wants something imported that is not plain data.
    #[error("it asks for '{0}', which is not plain data")]
    Forbidden(String),
    /// The file ends too early.
    #[error("it ends too early, at byte {0}")]
    Truncated(usize),
    /// Not a pickle, or one that no writer makes.
    #[error("{what} at byte {at}")]
    Malformed { what: String, at: usize },
    /// More objects than a recording has.
    #[error("it makes more than {0} objects")]
    TooLarge(usize),
}

/// One object.
#[derive(Clone, Debug)]
enum Node {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    /// UTF-8 where the pickle is sound.
    Text(Bytes),
    Bytes(Bytes),
    /// Lists, tuples and sets.
    List(Vec<Ref>),
    Dict(Vec<(Ref, Ref)>),
    Array(Box<Array>),
    Dtype(Dtype),
    Name(names::Name),
}

/// Bytes in the file, or in what was decoded from it.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Bytes {
    File(Range<usize>),
    Decoded(Range<usize>),
}

/// A pickle that was read.
pub(crate) struct Pickle<'a> {
    file: &'a [u8],
    decoded: Vec<u8>,
    nodes: Vec<Node>,
    root: Ref,
}

impl<'a> Pickle<'a> {
    /// Reads a pickle.
    pub fn read(file: &'a [u8]) -> Result<Self, PickleError> {
        machine::run(file)
    }

    fn bytes(&self, b: &Bytes) -> &[u8] {
        let (all, range) = match b {
            Bytes::File(r) => (self.file, r),
            Bytes::Decoded(r) => (self.decoded.as_slice(), r),
        };
        all.get(range.clone()).unwrap_or_default()
    }

    /// The outermost object.
    pub fn root(&self) -> Value<'_> {
        Value { pickle: self, at: self.root }
    }
}

/// An object of a pickle, to be asked what it is. Answers are `None` where it is something else.
#[derive(Clone, Copy)]
pub(crate) struct Value<'p> {
    pickle: &'p Pickle<'p>,
    at: Ref,
}

impl<'p> Value<'p> {
    fn node(&self) -> &'p Node {
        &self.pickle.nodes[self.at.0 as usize]
    }

    fn value(&self, at: Ref) -> Value<'p> {
        Value { pickle: self.pickle, at }
    }

    /// Text, also of a numpy string.
    pub fn text(&self) -> Option<Cow<'p, str>> {
        match self.node() {
            Node::Text(b) => Some(String::from_utf8_lossy(self.pickle.bytes(b))),
            Node::Array(a) if a.is_scalar() => a.text(self.pickle, 0).map(Cow::Owned),
            _ => None,
        }
    }

    /// Text or whole number, as ids are either.
    pub fn id(&self) -> Option<String> {
        match self.node() {
            Node::Int(i) => Some(i.to_string()),
            Node::Array(a) if a.is_scalar() && a.dtype.kind != Kind::Text => {
                a.number(self.pickle, 0).filter(|v| v.fract() == 0.0).map(|v| format!("{v:.0}"))
            }
            _ => self.text().map(Cow::into_owned),
        }
    }

    /// A number, also a numpy scalar; truth values are 0 and 1.
    pub fn number(&self) -> Option<f64> {
        match self.node() {
            Node::Int(i) => Some(*i as f64),
            Node::Float(f) => Some(*f),
            Node::Bool(b) => Some(f64::from(*b)),
            Node::Array(a) if a.is_scalar() => a.number(self.pickle, 0),
            _ => None,
        }
    }

    /// The number of an element of an array of objects. Looks no deeper: such an array may hold itself.
    fn number_of_object(&self) -> Option<f64> {
        match self.node() {
            Node::Array(_) => None,
            _ => self.number(),
        }
    }

    fn text_of_object(&self) -> Option<String> {
        match self.node() {
            Node::Array(_) => None,
            _ => self.text().map(Cow::into_owned),
        }
    }

    pub fn truth(&self) -> Option<bool> {
        self.number().map(|v| v != 0.0)
    }

    /// Entries of a dict in the order of the file.
    pub fn entries(&self) -> Option<impl Iterator<Item = (Value<'p>, Value<'p>)> + use<'p>> {
        let Node::Dict(all) = self.node() else { return None };
        let here = *self;
        Some(all.iter().map(move |&(k, v)| (here.value(k), here.value(v))))
    }

    /// The value under a text key. Of two with one key the last, as in Python.
    pub fn get(&self, key: &str) -> Option<Value<'p>> {
        let Node::Dict(all) = self.node() else { return None };
        all.iter()
            .rev()
            .find(|(k, _)| self.value(*k).text().is_some_and(|t| t == key))
            .map(|&(_, v)| self.value(v))
    }

    /// Elements of a list, tuple or set.
    pub fn items(&self) -> Option<impl ExactSizeIterator<Item = Value<'p>> + use<'p>> {
        let Node::List(all) = self.node() else { return None };
        let here = *self;
        Some(all.iter().map(move |&v| here.value(v)))
    }

    /// The array, when it is one.
    pub fn array(&self) -> Option<&'p Array> {
        if let Node::Array(a) = self.node() { Some(a) } else { None }
    }

    /// Rows of numbers: an array of one or two dimensions, a list of numbers, or a list of such. Never more numbers
    /// than the file has bytes, so that a file of references cannot grow into more than memory holds.
    pub fn rows(&self) -> Option<Vec<Vec<f64>>> {
        if let Some(a) = self.array() {
            let (rows, columns) = match a.shape[..] {
                [n] => (n, 1),
                [n, m] => (n, m),
                _ => return None,
            };
            if a.is_empty() {
                return Some(Vec::new());
            }
            let row =
                |i: usize| (0..columns).map(|j| a.number_at(self.pickle, i, j)).collect::<Option<Vec<f64>>>();
            return (0..rows).map(row).collect();
        }
        let mut budget = self.pickle.file.len();
        self.items()?
            .map(|item| {
                let row = match (item.number(), item.array()) {
                    (Some(v), _) => vec![v],
                    (None, Some(a)) if a.shape.len() == 1 && a.len() <= budget => {
                        (0..a.len()).map(|i| a.number(self.pickle, i)).collect::<Option<_>>()?
                    }
                    (None, Some(_)) => return None,
                    (None, None) => {
                        let inner = item.items()?;
                        if inner.len() > budget {
                            return None;
                        }
                        inner.map(|v| v.number()).collect::<Option<_>>()?
                    }
                };
                budget = budget.checked_sub(row.len())?;
                Some(row)
            })
            .collect()
    }

    /// One number a row: [`Value::rows`] of which only the first column counts.
    pub fn column(&self) -> Option<Vec<f64>> {
        self.rows()?.into_iter().map(|r| r.first().copied()).collect()
    }

    /// Texts of a list or an array of strings; `None` elements stay `None`.
    pub fn texts(&self) -> Option<Vec<Option<String>>> {
        if let Some(a) = self.array() {
            return (a.shape.len() == 1).then(|| (0..a.len()).map(|i| a.text(self.pickle, i)).collect());
        }
        Some(self.items()?.map(|v| v.text().map(Cow::into_owned)).collect())
    }
}

#[cfg(test)]
mod tests;
