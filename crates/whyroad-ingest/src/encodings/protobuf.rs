//! Fields of a protobuf message, one after the other, without a schema compiler: the adapter knows the numbers of the
//! few fields that it wants. Wire format: Protocol Buffers documentation, "Encoding". Groups (retired) are not read.

use super::cdr::sized;
use crate::file_reader::FileReader;

/// Value of a field as it is on the wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Wire<'a> {
    Varint(u64),
    Fixed64(u64),
    Bytes(&'a [u8]),
    Fixed32(u32),
}

/// What is wrong with a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum ProtoError {
    #[error("a message ends inside a field")]
    Truncated,
    #[error("a field has an encoding that is not known (wire type {0})")]
    WireType(u8),
    #[error("field {0} is of another type than the schema says")]
    Type(u32),
}

/// Iterates over the fields of a message.
pub(crate) struct Fields<'a> {
    rest: &'a [u8],
    failed: bool,
}

impl<'a> Fields<'a> {
    pub fn new(message: &'a [u8]) -> Self {
        Self { rest: message, failed: false }
    }

    fn varint(&mut self) -> Result<u64, ProtoError> {
        let mut value = 0u64;
        for (i, &b) in self.rest.iter().enumerate().take(10) {
            value |= u64::from(b & 0x7f) << (7 * i).min(63);
            if b & 0x80 == 0 {
                self.rest = &self.rest[i + 1..];
                return Ok(value);
            }
        }
        Err(ProtoError::Truncated)
    }

    fn take(&mut self, n: usize) -> Result<&'a [u8], ProtoError> {
        let (head, rest) = self.rest.split_at_checked(n).ok_or(ProtoError::Truncated)?;
        self.rest = rest;
        Ok(head)
    }

    fn field(&mut self) -> Result<Field<'a>, ProtoError> {
        let key = self.varint()?;
        let number = (key >> 3) as u32;
        let wire = match key & 7 {
            0 => Wire::Varint(self.varint()?),
            1 => Wire::Fixed64(u64::from_le_bytes(fixed(self.take(8)?))),
            2 => {
                let n = usize::try_from(self.varint()?).map_err(|_| ProtoError::Truncated)?;
                Wire::Bytes(self.take(n)?)
            }
            5 => Wire::Fixed32(u32::from_le_bytes(fixed(self.take(4)?))),
            other => return Err(ProtoError::WireType(other as u8)),
        };
        Ok(Field { number, wire })
    }
}

fn fixed<const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut out = [0; N];
    out.copy_from_slice(bytes);
    out
}

impl<'a> Iterator for Fields<'a> {
    type Item = Result<Field<'a>, ProtoError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed || self.rest.is_empty() {
            return None;
        }
        let field = self.field();
        self.failed = field.is_err();
        Some(field)
    }
}

/// One field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field<'a> {
    pub number: u32,
    pub wire: Wire<'a>,
}

impl<'a> Field<'a> {
    fn wrong<T>(&self) -> Result<T, ProtoError> {
        Err(ProtoError::Type(self.number))
    }

    /// `int32`, `int64`, `bool`, an enum.
    pub fn int(&self) -> Result<i64, ProtoError> {
        // A negative int32 is written as ten bytes, that is as an int64.
        if let Wire::Varint(v) = self.wire { Ok(v as i64) } else { self.wrong() }
    }

    /// `double` or `float`.
    pub fn number(&self) -> Result<f64, ProtoError> {
        match self.wire {
            Wire::Fixed64(v) => Ok(f64::from_bits(v)),
            Wire::Fixed32(v) => Ok(f64::from(f32::from_bits(v))),
            _ => self.wrong(),
        }
    }

    /// The bytes of a `string`, `bytes` or message.
    pub fn bytes(&self) -> Result<&'a [u8], ProtoError> {
        if let Wire::Bytes(b) = self.wire { Ok(b) } else { self.wrong() }
    }

    /// `string`; what is not UTF-8 shows as such.
    pub fn text(&self) -> Result<String, ProtoError> {
        Ok(String::from_utf8_lossy(self.bytes()?).into_owned())
    }

    /// The fields of a message.
    pub fn fields(&self) -> Result<Fields<'a>, ProtoError> {
        Ok(Fields::new(self.bytes()?))
    }

    /// Adds a `repeated` integer field, packed or one by one.
    pub fn ints(&self, out: &mut Vec<i64>) -> Result<(), ProtoError> {
        let Wire::Bytes(packed) = self.wire else {
            out.push(self.int()?);
            return Ok(());
        };
        let mut fields = Fields::new(packed);
        while !fields.rest.is_empty() {
            out.push(fields.varint()? as i64);
        }
        Ok(())
    }

    /// Adds a `repeated double` field, packed or one by one.
    pub fn doubles(&self, out: &mut Vec<f64>) -> Result<(), ProtoError> {
        let Wire::Bytes(packed) = self.wire else {
            out.push(self.number()?);
            return Ok(());
        };
        if !packed.len().is_multiple_of(8) {
            return self.wrong();
        }
        out.extend(packed.chunks_exact(8).map(|c| f64::from_le_bytes(fixed(c))));
        Ok(())
    }
}

pub(crate) mod messages;

/// For [`crate::readers`]: the length of a schema in two bytes, the schema, a message.
pub(crate) const READER: FileReader = FileReader {
    name: "protobuf-message",
    read: |bytes| {
        let Some((schema, message)) = sized(bytes) else { return false };
        messages::MessageTypes::parse(schema).is_some_and(|types| types.decode("a.A", message).is_some())
    },
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_of_the_encoding_guide() {
        // "Encoding": field 1 = 150 is 08 96 01; field 2 = "testing"; packed field 4 = [3, 270, 86942].
        let bytes = b"\x08\x96\x01\x12\x07testing\x22\x06\x03\x8e\x02\x9e\xa7\x05\x3d\x00\x00\x80\x3f";
        let fields: Vec<Field<'_>> = Fields::new(bytes).collect::<Result<_, _>>().unwrap();
        assert_eq!((fields[0].number, fields[0].int()), (1, Ok(150)));
        assert_eq!((fields[1].number, fields[1].text().unwrap().as_str()), (2, "testing"));
        let mut packed = Vec::new();
        fields[2].ints(&mut packed).unwrap();
        assert_eq!(packed, [3, 270, 86942]);
        assert_eq!(fields[3].number(), Ok(1.0));
        // Every beginning that ends inside a field says so.
        for n in [1, 2, 4, 6, 11, 14, 21] {
            assert!(Fields::new(&bytes[..n]).any(|f| f.is_err()), "{n}");
        }
    }

    proptest::proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..200)) {
            for field in Fields::new(&bytes).flatten() {
                let (mut ints, mut doubles) = (Vec::new(), Vec::new());
                let _ = (field.int(), field.number(), field.text(), field.ints(&mut ints), field.doubles(&mut doubles));
            }
        }
    }
}
