//! Numpy arrays and scalars of a pickle: numbers, truth values and texts, read element by element from their bytes.

use super::{Bytes, Pickle, Ref};

/// What the elements are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Bool,
    Signed,
    Unsigned,
    Float,
    /// UCS-4 code points (`U`).
    Text,
    /// Python objects (`O`).
    Object,
}

/// Type of the elements of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Dtype {
    pub kind: Kind,
    /// Bytes of an element.
    pub size: usize,
    pub big_endian: bool,
}

impl Dtype {
    /// From numpy's short name without byte order: `f8`, `b1`, `U12`. `None` for types that hold no plain values here.
    pub fn parse(code: &str) -> Option<Dtype> {
        let (order, code) = match code.as_bytes().first()? {
            b'<' | b'|' | b'=' => (false, &code[1..]),
            b'>' => (true, &code[1..]),
            _ => (false, code),
        };
        let (letter, digits) = (code.chars().next()?, code.get(1..)?);
        let n: usize = if digits.is_empty() { 8 } else { digits.parse().ok()? };
        let (kind, size) = match (letter, n) {
            ('b', 1) => (Kind::Bool, 1),
            ('i', 1 | 2 | 4 | 8) => (Kind::Signed, n),
            ('u', 1 | 2 | 4 | 8) => (Kind::Unsigned, n),
            ('f', 4 | 8) => (Kind::Float, n),
            ('U', 1..=100_000) => (Kind::Text, 4 * n),
            // The elements are pickled objects; 8 is the size of a pointer and means nothing here.
            ('O', _) => (Kind::Object, 8),
            _ => return None,
        };
        Some(Dtype { kind, size, big_endian: order })
    }
}

#[derive(Clone, Debug)]
pub(super) enum Data {
    Raw(Bytes),
    Objects(Vec<Ref>),
}

/// An array; a scalar is one without dimensions.
#[derive(Clone, Debug)]
pub(crate) struct Array {
    pub dtype: Dtype,
    pub shape: Vec<usize>,
    /// Column by column rather than row by row.
    pub fortran: bool,
    pub(super) data: Data,
}

impl Array {
    /// An array whose bytes fit its shape; otherwise what is wrong.
    pub(super) fn new(
        dtype: Dtype,
        shape: Vec<usize>,
        fortran: bool,
        data: Data,
        have: usize,
    ) -> Result<Self, String> {
        let elements = shape.iter().try_fold(1usize, |n, &d| n.checked_mul(d));
        let wanted = match (&data, elements) {
            (Data::Raw(_), Some(n)) => n.checked_mul(dtype.size),
            (Data::Objects(_), n) => n,
            (Data::Raw(_), None) => None,
        };
        if wanted != Some(have) {
            return Err(format!("an array of shape {shape:?} with data for another"));
        }
        Ok(Self { dtype, shape, fortran, data })
    }

    pub fn is_scalar(&self) -> bool {
        self.shape.is_empty()
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    pub fn is_empty(&self) -> bool {
        self.shape.contains(&0)
    }

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
            return super::Value { pickle, at: *all.get(index)? }.number_of_object();
        }
        let raw = self.element(pickle, index)?;
        let mut le = [0u8; 8];
        for (k, slot) in le.iter_mut().take(raw.len()).enumerate() {
            *slot = raw[if self.dtype.big_endian { raw.len() - 1 - k } else { k }];
        }
        let bits = u64::from_le_bytes(le);
        let unused = 64 - 8 * raw.len().clamp(1, 8) as u32;
        Some(match self.dtype.kind {
            Kind::Bool => f64::from(bits != 0),
            Kind::Unsigned => bits as f64,
            // Shifted up and down again, so that the sign of the short number is the sign of the long one.
            Kind::Signed => ((bits << unused) as i64 >> unused) as f64,
            Kind::Float if raw.len() == 4 => f64::from(f32::from_bits(bits as u32)),
            Kind::Float => f64::from_bits(bits),
            Kind::Text | Kind::Object => return None,
        })
    }

    /// Element as text, without the zeros that fill it up.
    pub fn text(&self, pickle: &Pickle<'_>, index: usize) -> Option<String> {
        if let Data::Objects(all) = &self.data {
            return super::Value { pickle, at: *all.get(index)? }.text_of_object();
        }
        if self.dtype.kind != Kind::Text {
            return None;
        }
        let points = self.element(pickle, index)?.chunks_exact(4).map(|c| {
            let word = [c[0], c[1], c[2], c[3]];
            if self.dtype.big_endian { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) }
        });
        points.take_while(|&p| p != 0).map(char::from_u32).collect()
    }
}
