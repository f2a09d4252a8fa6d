//! One column of one row group from its bytes: pages are taken out and decompressed by the Parquet library, their
//! values decoded here ([`super::encodings`]), because rules need another layout than a table: the values of the known
//! rows one after another, and which rows these are as bits. Unknown rows take no space.

use super::bitmap::Bitmap;
use super::encodings::{bits, deltas, looked_up, plain, with_length};
use super::steps::Steps;
use bytes::{Buf, Bytes};
use parquet::basic::{Encoding, Type};
use parquet::column::page::Page;
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::{ChunkReader, Length};
use parquet::file::serialized_reader::SerializedPageReader;
use std::fmt::Display;
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;

/// The values of the known rows.
#[derive(Clone, Debug)]
pub(super) enum Values {
    /// Numbers.
    Numbers(Vec<f64>),
    /// Whole numbers.
    Integers(Steps),
    /// Flags.
    Flags(Bitmap),
    /// Indices into texts.
    Texts(Vec<u16>, Vec<String>),
}

/// A column of a row group.
#[derive(Clone, Debug)]
pub(super) struct Dense {
    /// The values of the known rows.
    pub values: Values,
    /// Which rows are known; `None` where all are.
    pub known: Option<Bitmap>,
}

/// Rows that a row group may have: a drive of an hour with a thousand objects at all times has a quarter of it. A file
/// of a few bytes can state any number, and runs of one value as long.
const MAX_ROWS: usize = 1 << 27;
/// Values for which memory is taken before they are read.
const RESERVED: usize = 1 << 24;

/// Reads a column of a row group with this number of rows. The error is a text.
pub(super) fn read(
    file: &mut (impl Read + Seek),
    column: &ColumnChunkMetaData,
    rows: usize,
) -> Result<Dense, String> {
    let (start, length) = column.byte_range();
    let words = |e: &dyn Display| format!("column {}: {e}", column.column_path());
    let length = usize::try_from(length).map_err(|e| words(&e))?;
    if rows > MAX_ROWS {
        return Err(words(&format!("{rows} rows are more than a drive can have")));
    }
    // The stated length is untrusted: memory use is limited by the size of the file.
    let mut bytes = Vec::with_capacity(length.min(RESERVED));
    file.seek(SeekFrom::Start(start)).map_err(|e| words(&e))?;
    file.by_ref().take(length as u64).read_to_end(&mut bytes).map_err(|e| words(&e))?;
    let descriptor = column.column_descr();
    if descriptor.max_rep_level() > 0 || descriptor.max_def_level() > 1 {
        return Err(words(&"its values are not PLAIN-encoded"));
    }
    let chunk = Arc::new(Chunk { start, bytes: bytes.into() });
    let pages = SerializedPageReader::new(chunk, column, rows, None).map_err(|e| words(&e))?;
    let mut decoder =
        Decoder::new(column.column_type(), rows).ok_or_else(|| words(&"its type is not supported"))?;
    let mut known = (descriptor.max_def_level() > 0).then(|| Bitmap::with_capacity(rows.min(RESERVED)));
    let mut done = 0;
    for page in pages {
        let page = page.map_err(|e| words(&e))?;
        let broken = || words(&format!("a page cannot be decoded ({})", page.encoding()));
        if page.is_dictionary_page() {
            decoder.dictionary(page.buffer(), page.num_values() as usize).ok_or_else(broken)?;
            continue;
        }
        let n = page.num_values() as usize;
        done += n;
        if done > rows {
            return Err(words(&format!("more than {rows} rows")));
        }
        let (values, there) = levels(&page, known.as_mut()).ok_or_else(broken)?;
        decoder.page(page.encoding(), values, there).ok_or_else(broken)?;
    }
    if done != rows {
        return Err(words(&format!("{done} of {rows} rows can be read")));
    }
    Ok(Dense { values: decoder.values, known: known.filter(|k| k.ones < rows) })
}

/// Takes the null information from the beginning of a page; returns the bytes of the values and their number.
fn levels<'p>(page: &'p Page, known: Option<&mut Bitmap>) -> Option<(&'p [u8], usize)> {
    let n = page.num_values() as usize;
    let before = known.as_ref().map_or(0, |k| k.ones);
    match page {
        Page::DataPage { buf, def_level_encoding, .. } => {
            let mut bytes = buf.as_ref();
            let Some(known) = known else { return Some((bytes, n)) };
            if *def_level_encoding != Encoding::RLE {
                return None;
            }
            bits(with_length(&mut bytes)?, n, known)?;
            Some((bytes, known.ones - before))
        }
        Page::DataPageV2 { buf, def_levels_byte_len, rep_levels_byte_len, num_nulls, .. } => {
            let (levels, bytes) =
                buf.split_at_checked((*def_levels_byte_len + *rep_levels_byte_len) as usize)?;
            let Some(known) = known else { return Some((bytes, n)) };
            if *num_nulls == 0 {
                known.push_run(true, n);
            } else {
                bits(levels.get(*rep_levels_byte_len as usize..)?, n, known)?;
            }
            Some((bytes, known.ones - before))
        }
        Page::DictionaryPage { .. } => None,
    }
}

/// Values so far, and the dictionary, if the column has one.
struct Decoder {
    values: Values,
    numbers: Vec<f64>,
    integers: Vec<i64>,
    physical: Type,
}

impl Decoder {
    fn new(physical: Type, rows: usize) -> Option<Self> {
        // The stated number of rows is untrusted, too.
        let rows = rows.min(RESERVED);
        let values = match physical {
            Type::DOUBLE => Values::Numbers(Vec::with_capacity(rows)),
            Type::INT32 | Type::INT64 => Values::Integers(Steps::default()),
            Type::BOOLEAN => Values::Flags(Bitmap::with_capacity(rows)),
            Type::BYTE_ARRAY => Values::Texts(Vec::with_capacity(rows), Vec::new()),
            Type::INT96 | Type::FLOAT | Type::FIXED_LEN_BYTE_ARRAY => return None,
        };
        Some(Self { values, numbers: Vec::new(), integers: Vec::new(), physical })
    }

    fn dictionary(&mut self, bytes: &[u8], n: usize) -> Option<()> {
        match &mut self.values {
            Values::Numbers(_) => plain(bytes, n, f64::from_le_bytes, &mut self.numbers),
            Values::Integers(_) => integers(self.physical, bytes, n, &mut self.integers),
            Values::Texts(_, texts) => {
                let mut bytes = bytes;
                for _ in 0..n {
                    texts.push(String::from_utf8(with_length(&mut bytes)?.to_vec()).ok()?);
                }
                Some(())
            }
            Values::Flags(_) => None,
        }
    }

    fn page(&mut self, encoding: Encoding, bytes: &[u8], n: usize) -> Option<()> {
        #[allow(deprecated)] // older writers name dictionaries so
        let by_code = matches!(encoding, Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY);
        match (&mut self.values, encoding) {
            (Values::Numbers(to), _) if by_code => looked_up(bytes, n, &self.numbers, to),
            (Values::Numbers(to), Encoding::PLAIN) => plain(bytes, n, f64::from_le_bytes, to),
            (Values::Integers(to), Encoding::DELTA_BINARY_PACKED) if self.physical == Type::INT64 => {
                deltas(bytes, n, to)
            }
            (Values::Integers(to), Encoding::DELTA_BINARY_PACKED) => {
                let mut own = Steps::default();
                deltas(bytes, n, &mut own)?;
                let fits = |x: i64| i32::try_from(x).is_ok();
                // Sums of 32 bits wrap around there; this is rare.
                let own = if own.all(fits) { own } else { own.mapped(|x| i64::from(x as i32)) };
                to.append(own);
                Some(())
            }
            (Values::Integers(to), encoding) => {
                let mut values = Vec::new();
                match encoding {
                    _ if by_code => looked_up(bytes, n, &self.integers, &mut values)?,
                    Encoding::PLAIN => integers(self.physical, bytes, n, &mut values)?,
                    _ => return None,
                }
                values.into_iter().for_each(|x| to.push(x));
                Some(())
            }
            (Values::Texts(to, texts), _) if by_code => {
                let codes: Vec<u16> = (0..u16::try_from(texts.len()).ok()?).collect();
                looked_up(bytes, n, &codes, to)
            }
            // A column in which nothing is known has no dictionary.
            (Values::Texts(..), Encoding::PLAIN) if n == 0 => Some(()),
            (Values::Flags(to), Encoding::PLAIN) => to.push_bytes(bytes, n),
            (Values::Flags(to), Encoding::RLE) => {
                let mut bytes = bytes;
                bits(with_length(&mut bytes)?, n, to)
            }
            _ => None,
        }
    }
}

fn integers(physical: Type, bytes: &[u8], n: usize, to: &mut Vec<i64>) -> Option<()> {
    match physical {
        Type::INT32 => plain(bytes, n, |v| i64::from(i32::from_le_bytes(v)), to),
        _ => plain(bytes, n, i64::from_le_bytes, to),
    }
}

/// A part of a file, at the offset that it has in the file.
pub(crate) struct Chunk {
    /// Offset of the first byte.
    pub start: u64,
    /// The bytes.
    pub bytes: Bytes,
}

impl Chunk {
    fn from(&self, start: u64) -> ParquetResult<Bytes> {
        let at = start.checked_sub(self.start).and_then(|at| usize::try_from(at).ok());
        let at = at.filter(|at| *at <= self.bytes.len());
        at.map(|at| self.bytes.slice(at..))
            .ok_or_else(|| ParquetError::EOF("the column ends too early".into()))
    }
}

impl Length for Chunk {
    fn len(&self) -> u64 {
        self.start + self.bytes.len() as u64
    }
}

impl ChunkReader for Chunk {
    type T = bytes::buf::Reader<Bytes>;

    fn get_read(&self, start: u64) -> ParquetResult<Self::T> {
        Ok(self.from(start)?.reader())
    }

    fn get_bytes(&self, start: u64, length: usize) -> ParquetResult<Bytes> {
        let bytes = self.from(start)?;
        if bytes.len() < length {
            return Err(ParquetError::EOF("the column ends too early".into()));
        }
        Ok(bytes.slice(..length))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
