//! Objects of a pickle as seen by an adapter.

use super::arena::{Node, Pickle};
use super::array::{Array, Data, ElementKind};
use super::reference::Ref;
use std::borrow::Cow;

impl Pickle<'_> {
    /// The outermost object.
    pub fn root(&self) -> Value<'_> {
        Value { pickle: self, at: self.root }
    }
}

/// An object of a pickle. Accessors return `None` where it has another type.
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
            Node::Array(a) if a.is_scalar() && a.dtype.kind != ElementKind::Text => {
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

    /// One number per row: [`Value::rows`] of which only the first column counts.
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

impl Array {
    /// Element of a table in row `i`, column `j`.
    pub fn number_at(&self, pickle: &Pickle<'_>, i: usize, j: usize) -> Option<f64> {
        let (rows, columns) = match self.shape[..] {
            [rows] => (rows, 1),
            [rows, columns] => (rows, columns),
            _ => return None,
        };
        self.number(pickle, if self.fortran { j * rows + i } else { i * columns + j })
    }

    fn element<'p>(&self, pickle: &'p Pickle<'_>, index: usize) -> Option<&'p [u8]> {
        let Data::Raw(raw) = &self.data else { return None };
        let start = index.checked_mul(self.dtype.size)?;
        pickle.bytes(raw).get(start..start + self.dtype.size)
    }

    /// Element by its place in memory.
    pub fn number(&self, pickle: &Pickle<'_>, index: usize) -> Option<f64> {
        if let Data::Objects(all) = &self.data {
            return Value { pickle, at: *all.get(index)? }.number_of_object();
        }
        let raw = self.element(pickle, index)?;
        let mut le = [0u8; 8];
        for (k, slot) in le.iter_mut().take(raw.len()).enumerate() {
            *slot = raw[if self.dtype.big_endian { raw.len() - 1 - k } else { k }];
        }
        let bits = u64::from_le_bytes(le);
        let unused = 64 - 8 * raw.len().clamp(1, 8) as u32;
        Some(match self.dtype.kind {
            ElementKind::Bool => f64::from(bits != 0),
            ElementKind::Unsigned => bits as f64,
            // Shifted up and down again, so that the sign of the short number is the sign of the long one.
            ElementKind::Signed => ((bits << unused) as i64 >> unused) as f64,
            ElementKind::Float if raw.len() == 4 => f64::from(f32::from_bits(bits as u32)),
            ElementKind::Float => f64::from_bits(bits),
            ElementKind::Text | ElementKind::Object => return None,
        })
    }

    /// Element as text, without the zeros that fill it up.
    pub fn text(&self, pickle: &Pickle<'_>, index: usize) -> Option<String> {
        if let Data::Objects(all) = &self.data {
            return Value { pickle, at: *all.get(index)? }.text_of_object();
        }
        if self.dtype.kind != ElementKind::Text {
            return None;
        }
        let points = self.element(pickle, index)?.chunks_exact(4).map(|c| {
            let word = [c[0], c[1], c[2], c[3]];
            if self.dtype.big_endian { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) }
        });
        points.take_while(|&p| p != 0).map(char::from_u32).collect()
    }
}
