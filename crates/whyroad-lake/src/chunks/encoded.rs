//! Flags, words and numbers to the pages of a column: which rows are known as runs and packed bits (the format's "RLE /
//! bit-packing hybrid"), flags as bits, words as codes into a dictionary, numbers as they are or as such codes.
//! Parquet's own writer does this value by value and looks each text up; here runs and 64 rows at a time are known
//! beforehand. Numbers are compressed where that helps, flags and words are not: there is little left.

mod numbers;

use crate::signals::bitmap::{Bitmap, low};
use bytes::Bytes;
pub(super) use numbers::{known, numbers};
use parquet::basic::{Compression, Encoding, PageType, Type};
use parquet::column::page::{CompressedPage, Page, PageWriter};
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::{ColumnChunkMetaData, PageEncodingStats};
use parquet::file::statistics::Statistics;
use parquet::file::writer::{SerializedPageWriter, TrackedWrite};
use parquet::schema::types::ColumnDescPtr;
use std::collections::HashMap;
use whyroad_model::Tri;

/// Rows per page.
const PAGE_ROWS: usize = 1 << 16;

/// A column with its entry in the footer; offsets are those in the bytes.
pub(super) type Encoded = (Bytes, ColumnChunkMetaData);

/// Flags; unknown becomes null.
pub(super) fn flags(values: &[Tri], column: ColumnDescPtr) -> ParquetResult<Encoded> {
    let mut pages = Pages::new(Encoding::PLAIN);
    let (mut yes, mut no, mut nulls) = (false, false, 0);
    for some in values.chunks(PAGE_ROWS) {
        let mut known = Bitmap::with_capacity(some.len());
        let mut bits = Bitmap::with_capacity(some.len());
        for flags in some.chunks(64) {
            let is_known = packed(flags, |flag| flag != Tri::Unknown);
            let is_true = packed(flags, |flag| flag == Tri::True);
            known.push_word(is_known, flags.len());
            let (bits_of_known, count) = gathered(is_true, is_known, flags.len());
            bits.push_word(bits_of_known, count);
        }
        (yes, no) = (yes || bits.ones > 0, no || bits.ones < bits.len);
        nulls += some.len() - known.ones;
        let mut page = levels(&known)?;
        page.extend_from_slice(&bytes_of(&bits));
        pages.data(page, some.len())?;
    }
    let range = (yes || no).then_some((!no, yes));
    let statistics =
        Statistics::boolean(range.map(|r| r.0), range.map(|r| r.1), None, Some(nulls as u64), false);
    pages.finish(column, statistics)
}

/// Words by their codes; what is unknown becomes null.
pub(super) fn words(codes: &[u16], names: &[String], column: ColumnDescPtr) -> ParquetResult<Encoded> {
    let runs = || codes.chunk_by(|a, b| a == b).map(|same| (same[0], same.len()));
    // The dictionary has the words that occur.
    let mut used = vec![false; names.len()];
    for (code, _) in runs() {
        if let Some(used) = used.get_mut(usize::from(code)) {
            *used = true;
        }
    }
    let mut texts: Vec<&str> = Vec::new();
    let mut places = vec![None; names.len()];
    for ((name, used), place) in names.iter().zip(used).zip(&mut places) {
        if used {
            *place = Some(texts.len() as u32);
            texts.push(name);
        }
    }
    let place = |code: u16| places.get(usize::from(code)).copied().flatten();
    placed(&texts, runs().map(|(code, rows)| (place(code), rows)), column)
}

/// Texts, each with its number of rows; nulls where the column has such.
pub(super) fn runs<'t>(
    runs: impl Iterator<Item = (Option<&'t str>, usize)>,
    column: ColumnDescPtr,
) -> ParquetResult<Encoded> {
    let (mut texts, mut places) = (Vec::new(), HashMap::new());
    let mut place = |text: &'t str| {
        *places.entry(text).or_insert_with(|| {
            texts.push(text);
            texts.len() as u32 - 1
        })
    };
    let runs: Vec<(Option<u32>, usize)> = runs.map(|(text, rows)| (text.map(&mut place), rows)).collect();
    placed(&texts, runs.into_iter(), column)
}

/// Texts by their indices in a dictionary.
fn placed(
    texts: &[&str],
    runs: impl Iterator<Item = (Option<u32>, usize)>,
    column: ColumnDescPtr,
) -> ParquetResult<Encoded> {
    // Some readers fail at a dictionary without entries.
    let nothing = texts.is_empty();
    let mut pages = Pages::new(if nothing { Encoding::PLAIN } else { Encoding::RLE_DICTIONARY });
    let nullable = column.max_def_level() > 0;
    let (mut known, mut hybrid) = (Bitmap::default(), Hybrid::of_places(texts.len()));
    let (mut nulls, mut has_dictionary) = (0, false);
    let mut end_page = |known: &mut Bitmap, hybrid: &mut Hybrid| -> ParquetResult<()> {
        if known.len == 0 {
            return Ok(());
        }
        if !nothing && !std::mem::replace(&mut has_dictionary, true) {
            pages.dictionary(of_texts(texts)?, texts.len())?;
        }
        let known = std::mem::take(known);
        nulls += known.len - known.ones;
        if !nullable && known.ones < known.len {
            return Err(ParquetError::General("a text is missing that must be there".into()));
        }
        let mut page = if nullable { levels(&known)? } else { Vec::new() };
        let places = std::mem::replace(hybrid, Hybrid::of_places(texts.len())).finish();
        if !nothing {
            page.extend_from_slice(&places);
        }
        pages.data(page, known.len)
    };
    for (place, rows) in runs {
        let mut left = rows;
        while left > 0 {
            let taken = left.min(PAGE_ROWS - known.len);
            known.push_run(place.is_some(), taken);
            if let Some(place) = place {
                hybrid.push(place, taken);
            }
            left -= taken;
            if known.len == PAGE_ROWS {
                end_page(&mut known, &mut hybrid)?;
            }
        }
    }
    end_page(&mut known, &mut hybrid)?;
    let stated = |text: Option<&&str>| text.map(|t| ByteArray::from(*t));
    let (least, greatest) = (stated(texts.iter().min()), stated(texts.iter().max()));
    let statistics = Statistics::byte_array(least, greatest, None, Some(nulls as u64), false);
    pages.finish(column, statistics)
}

/// A column in which nothing is known.
pub(super) fn nulls(rows: usize, column: ColumnDescPtr) -> ParquetResult<Encoded> {
    let count = Some(rows as u64);
    let statistics = match column.physical_type() {
        Type::BYTE_ARRAY => return placed(&[], std::iter::once((None, rows)), column),
        Type::BOOLEAN => Statistics::boolean(None, None, None, count, false),
        Type::INT32 => Statistics::int32(None, None, None, count, false),
        Type::INT64 => Statistics::int64(None, None, None, count, false),
        Type::DOUBLE => Statistics::double(None, None, None, count, false),
        other => return Err(ParquetError::General(format!("columns of {other} cannot be written"))),
    };
    if column.max_def_level() == 0 {
        return Err(ParquetError::General("a value is missing that must be there".into()));
    }
    let mut pages = Pages::new(Encoding::PLAIN);
    for start in (0..rows).step_by(PAGE_ROWS) {
        let rows = PAGE_ROWS.min(rows - start);
        let mut known = Bitmap::with_capacity(rows);
        known.push_run(false, rows);
        pages.data(levels(&known)?, rows)?;
    }
    pages.finish(column, statistics)
}

/// Of up to 64 flags, which are so: a byte for each first, which a compiler does several at a time.
fn packed(flags: &[Tri], is: impl Fn(Tri) -> bool) -> u64 {
    let mut bytes = [0_u8; 64];
    for (byte, flag) in bytes.iter_mut().zip(flags) {
        *byte = u8::from(is(*flag));
    }
    let (eights, _) = bytes.as_chunks::<8>();
    // The product moves byte i of eight to bit 56 + i, with no carry between them.
    let byte = |eight: &[u8; 8]| u64::from_le_bytes(*eight).wrapping_mul(0x0102_0408_1020_4080) >> 56;
    eights.iter().enumerate().fold(0, |word, (i, eight)| word | byte(eight) << (8 * i))
}

/// The bits of the known rows of up to 64, one after another, and how many these are.
fn gathered(bits: u64, known: u64, rows: usize) -> (u64, usize) {
    if known == low(rows) {
        return (bits, rows);
    }
    let (mut out, mut count, mut left) = (0, 0, known);
    while left != 0 {
        out |= (bits >> left.trailing_zeros() & 1) << count;
        count += 1;
        left &= left - 1;
    }
    (out, count)
}

fn bytes_of(bits: &Bitmap) -> Vec<u8> {
    let mut bytes: Vec<u8> = bits.words.iter().flat_map(|w| w.to_le_bytes()).collect();
    bytes.truncate(bits.len.div_ceil(8));
    bytes
}

/// Which rows are known, as at the beginning of a page: a length, then runs and packed bits.
fn levels(known: &Bitmap) -> ParquetResult<Vec<u8>> {
    // Shorter runs are packed.
    const LEAST_RUN_BYTES: usize = 4;
    let mut bytes = bytes_of(known);
    let rest = known.len % 8;
    if let Some(last) = bytes.last_mut().filter(|_| rest > 0 && known.get(known.len - 1)) {
        // The last bit is repeated to the end of its byte, so that it does not end a run.
        *last |= 0xff << rest;
    }
    let mut out = vec![0; 4];
    let (mut literals, mut at) = (0, 0);
    let pack = |from: usize, to: usize, out: &mut Vec<u8>| {
        if from < to {
            varint(((to - from) << 1 | 1) as u64, out);
            out.extend_from_slice(&bytes[from..to]);
        }
    };
    for same in bytes.chunk_by(|a, b| a == b) {
        if same.len() >= LEAST_RUN_BYTES && matches!(same[0], 0 | 0xff) {
            pack(literals, at, &mut out);
            let rows = (8 * same.len()).min(known.len - 8 * at);
            varint((rows << 1) as u64, &mut out);
            out.push(same[0] & 1);
            literals = at + same.len();
        }
        at += same.len();
    }
    pack(literals, at, &mut out);
    let length = u32::try_from(out.len() - 4).map_err(|e| ParquetError::General(e.to_string()))?;
    out[..4].copy_from_slice(&length.to_le_bytes());
    Ok(out)
}

fn varint(mut value: u64, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// Numbers of a width as the hybrid of runs and packed groups of eight.
struct Hybrid {
    out: Vec<u8>,
    width: usize,
    literals: Vec<u32>,
}

impl Hybrid {
    /// Indices into a dictionary with this number of entries, preceded by a byte with their width.
    fn of_places(entries: usize) -> Self {
        let width = (usize::BITS - entries.saturating_sub(1).leading_zeros()) as usize;
        Self { out: vec![width as u8], width, literals: Vec::new() }
    }

    /// The same number, repeated this many times.
    fn push(&mut self, value: u32, count: usize) {
        // Groups of eight are filled before a run begins.
        let fills = count.min(self.literals.len().next_multiple_of(8) - self.literals.len());
        self.literals.extend(std::iter::repeat_n(value, fills));
        let count = count - fills;
        if count < 8 {
            self.literals.extend(std::iter::repeat_n(value, count));
            return;
        }
        self.pack();
        varint((count << 1) as u64, &mut self.out);
        self.out.extend_from_slice(&value.to_le_bytes()[..self.width.div_ceil(8)]);
    }

    fn pack(&mut self) {
        if self.literals.is_empty() {
            return;
        }
        let groups = self.literals.len().div_ceil(8);
        varint((groups << 1 | 1) as u64, &mut self.out);
        self.literals.resize(8 * groups, 0);
        let (mut bits, mut count) = (0_u64, 0);
        for value in self.literals.drain(..) {
            bits |= u64::from(value) << count;
            count += self.width;
            while count >= 8 {
                self.out.push(bits as u8);
                bits >>= 8;
                count -= 8;
            }
        }
    }

    fn finish(mut self) -> Vec<u8> {
        self.pack();
        self.out
    }
}

/// The entries of a dictionary of texts.
fn of_texts(texts: &[&str]) -> ParquetResult<Vec<u8>> {
    let mut bytes = Vec::new();
    for text in texts {
        let length = u32::try_from(text.len()).map_err(|e| ParquetError::General(e.to_string()))?;
        bytes.extend_from_slice(&length.to_le_bytes());
        bytes.extend_from_slice(text.as_bytes());
    }
    Ok(bytes)
}

/// The pages of a column.
struct Pages {
    to: TrackedWrite<Vec<u8>>,
    encoding: Encoding,
    /// The compressor of the pages; `None` where they are not compressed.
    snappy: Option<snap::raw::Encoder>,
    /// Bytes that this takes off them.
    saved: i64,
    dictionary_at: Option<i64>,
    data_at: Option<i64>,
    rows: usize,
    pages: i32,
}

impl Pages {
    fn new(encoding: Encoding) -> Self {
        let to = TrackedWrite::new(Vec::new());
        Self { to, encoding, snappy: None, saved: 0, dictionary_at: None, data_at: None, rows: 0, pages: 0 }
    }

    /// The dictionary page, which comes first: its number of entries.
    fn dictionary(&mut self, bytes: Vec<u8>, entries: usize) -> ParquetResult<()> {
        let num_values = u32::try_from(entries).map_err(|e| ParquetError::General(e.to_string()))?;
        let raw = bytes.len();
        let (buf, encoding) = (self.packed(bytes)?, Encoding::PLAIN);
        let page = Page::DictionaryPage { buf, num_values, encoding, is_sorted: false };
        self.dictionary_at = Some(self.write(page, raw)?);
        Ok(())
    }

    fn data(&mut self, bytes: Vec<u8>, rows: usize) -> ParquetResult<()> {
        let raw = bytes.len();
        let page = Page::DataPage {
            buf: self.packed(bytes)?,
            num_values: rows as u32,
            encoding: self.encoding,
            def_level_encoding: Encoding::RLE,
            rep_level_encoding: Encoding::RLE,
            statistics: None,
        };
        let at = self.write(page, raw)?;
        self.data_at = self.data_at.or(Some(at));
        (self.rows, self.pages) = (self.rows + rows, self.pages + 1);
        Ok(())
    }

    /// What is written to the file for the bytes of a page.
    fn packed(&mut self, bytes: Vec<u8>) -> ParquetResult<Bytes> {
        let Some(snappy) = &mut self.snappy else { return Ok(bytes.into()) };
        let packed = snappy.compress_vec(&bytes).map_err(|e| ParquetError::General(e.to_string()))?;
        Ok(packed.into())
    }

    /// Writes a page that has this number of bytes when it is not compressed; returns its offset.
    fn write(&mut self, page: Page, raw: usize) -> ParquetResult<i64> {
        self.saved += raw as i64 - page.buffer().len() as i64;
        let written = SerializedPageWriter::new(&mut self.to).write_page(CompressedPage::new(page, raw))?;
        i64::try_from(written.offset).map_err(|e| ParquetError::General(e.to_string()))
    }

    fn finish(self, column: ColumnDescPtr, statistics: Statistics) -> ParquetResult<Encoded> {
        let data = (PageType::DATA_PAGE, self.encoding, self.pages);
        let dictionary = self.dictionary_at.map(|_| (PageType::DICTIONARY_PAGE, Encoding::PLAIN, 1));
        let stats = dictionary.into_iter().chain((self.pages > 0).then_some(data));
        let stats =
            stats.map(|(page_type, encoding, count)| PageEncodingStats { page_type, encoding, count });
        let mut encodings = vec![Encoding::PLAIN, Encoding::RLE];
        if self.encoding != Encoding::PLAIN {
            encodings.push(self.encoding);
        }
        let compression = if self.snappy.is_some() { Compression::SNAPPY } else { Compression::UNCOMPRESSED };
        let bytes = self.to.into_inner()?;
        let size = i64::try_from(bytes.len()).map_err(|e| ParquetError::General(e.to_string()))?;
        let metadata = ColumnChunkMetaData::builder(column)
            .set_compression(compression)
            .set_encodings(encodings)
            .set_page_encoding_stats(stats.collect())
            .set_total_compressed_size(size)
            .set_total_uncompressed_size(size + self.saved)
            .set_num_values(self.rows as i64)
            .set_data_page_offset(self.data_at.unwrap_or(0))
            .set_dictionary_page_offset(self.dictionary_at)
            .set_statistics(statistics)
            .build()?;
        Ok((bytes.into(), metadata))
    }
}

#[cfg(test)]
mod tests;
