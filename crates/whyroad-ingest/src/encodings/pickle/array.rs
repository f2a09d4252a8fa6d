//! Numpy arrays and scalars of a pickle: numbers, truth values and texts, read element by element from their bytes.

use super::reference::{Bytes, Ref};

/// What the elements are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ElementKind {
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
    pub kind: ElementKind,
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
            ('b', 1) => (ElementKind::Bool, 1),
            ('i', 1 | 2 | 4 | 8) => (ElementKind::Signed, n),
            ('u', 1 | 2 | 4 | 8) => (ElementKind::Unsigned, n),
            ('f', 4 | 8) => (ElementKind::Float, n),
            ('U', 1..=100_000) => (ElementKind::Text, 4 * n),
            // The elements are pickled objects; 8 is the size of a pointer and means nothing here.
            ('O', _) => (ElementKind::Object, 8),
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
}
