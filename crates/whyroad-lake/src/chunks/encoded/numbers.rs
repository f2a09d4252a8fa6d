//! Numbers: plain where they rarely repeat, else as codes into a dictionary.

use super::{Encoded, Hybrid, PAGE_ROWS, Pages, levels};
use crate::file::repeats;
use crate::signals::bitmap::{Bitmap, low};
use parquet::basic::Encoding;
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::statistics::Statistics;
use parquet::schema::types::ColumnDescPtr;
use std::ops::Range;

/// Bytes that are compressed to see whether a column becomes shorter: samples of a fixed length from several positions.
const SAMPLE_BYTES: usize = 4096;
const SAMPLES: usize = 4;
/// Numbers that are copied to a page at once.
const PLAIN_AT_ONCE: usize = 64;

/// Numbers; those become null of which the bits of `known`, for up to 64 rows, are not set.
pub(in crate::chunks) fn numbers(
    values: &[f64],
    known: impl Fn(Range<usize>) -> u64,
    column: ColumnDescPtr,
) -> ParquetResult<Encoded> {
    let nullable = column.max_def_level() > 0;
    let mut pages: Vec<(Bitmap, usize)> = Vec::with_capacity(values.len().div_ceil(PAGE_ROWS));
    // The known ones of all pages.
    let mut numbers: Vec<f64> = Vec::with_capacity(values.len());
    let mut row = 0;
    for some in values.chunks(PAGE_ROWS) {
        let mut bits = Bitmap::with_capacity(some.len());
        for some in some.chunks(64) {
            let mut word = known(row..row + some.len());
            bits.push_word(word, some.len());
            // Mostly all rows are known, or none.
            if word == low(some.len()) {
                numbers.extend_from_slice(some);
            } else {
                while word != 0 {
                    numbers.push(some[word.trailing_zeros() as usize]);
                    word &= word - 1;
                }
            }
            row += some.len();
        }
        if !nullable && bits.ones < bits.len {
            return Err(ParquetError::General("a number is missing that must be there".into()));
        }
        pages.push((bits, numbers.len()));
    }
    let places = repeats(values).then(|| Places::of(&numbers)).flatten();
    let encoding = if places.is_some() { Encoding::RLE_DICTIONARY } else { Encoding::PLAIN };
    let mut runs = places.iter().flat_map(|p| &p.runs).copied();
    let mut run = (0, 0);
    let mut before = 0;
    let mut bodies = Vec::with_capacity(pages.len());
    for (bits, end) in &pages {
        let mut page = if nullable { levels(bits)? } else { Vec::new() };
        match &places {
            Some(places) => {
                let mut hybrid = Hybrid::of_places(places.entries.len());
                let mut left = *end - before;
                while left > 0 {
                    if run.1 == 0 {
                        run = runs.next().unwrap_or((0, left));
                    }
                    let taken = left.min(run.1);
                    hybrid.push(run.0, taken);
                    (left, run.1) = (left - taken, run.1 - taken);
                }
                page.extend_from_slice(&hybrid.finish());
            }
            None => {
                let plain = &numbers[before..*end];
                page.reserve_exact(8 * plain.len());
                // Eight bytes at once, and many eights: an iterator over the bytes would go byte by byte.
                for some in plain.chunks(PLAIN_AT_ONCE) {
                    let mut bytes = [0; 8 * PLAIN_AT_ONCE];
                    let (eights, _) = bytes.as_chunks_mut::<8>();
                    eights.iter_mut().zip(some).for_each(|(eight, x)| *eight = x.to_le_bytes());
                    page.extend_from_slice(&bytes[..8 * some.len()]);
                }
            }
        }
        bodies.push((page, bits.len));
        before = *end;
    }
    let mut out = Pages::new(encoding);
    out.snappy = bodies.first().and_then(|(page, _)| worth_compressing(page));
    if let Some(Places { entries, .. }) = &places {
        out.dictionary(entries.iter().flat_map(|x| x.to_le_bytes()).collect(), entries.len())?;
    }
    for (page, rows) in bodies {
        out.data(page, rows)?;
    }
    let nulls = values.len() - numbers.len();
    let extremes = range(places.as_ref().map_or(&numbers, |p| &p.entries));
    let statistics =
        Statistics::double(extremes.map(|r| r.0), extremes.map(|r| r.1), None, Some(nulls as u64), false);
    out.finish(column, statistics)
}

/// What compresses the column, if some parts of its first page become a tenth shorter by it.
fn worth_compressing(page: &[u8]) -> Option<snap::raw::Encoder> {
    let mut snappy = snap::raw::Encoder::new();
    let step = (page.len() / SAMPLES).max(SAMPLE_BYTES);
    let (mut raw, mut packed) = (0, 0);
    let mut room = vec![0; snap::raw::max_compress_len(SAMPLE_BYTES)];
    for some in page.chunks(step) {
        let some = &some[..some.len().min(SAMPLE_BYTES)];
        raw += some.len();
        packed += snappy.compress(some, &mut room).ok()?;
    }
    (10 * packed < 9 * raw).then_some(snappy)
}

/// Least and greatest number; zeros have the sign that includes both (as the format asks for). `None` without any.
fn range(numbers: &[f64]) -> Option<(f64, f64)> {
    const LANES: usize = 8;
    // Several at a time: no number waits for the one before it. A comparison with NaN is false, which leaves it out.
    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    let (eights, rest) = numbers.as_chunks::<LANES>();
    for eight in eights {
        for (k, x) in eight.iter().enumerate() {
            low[k] = if *x < low[k] { *x } else { low[k] };
            high[k] = if *x > high[k] { *x } else { high[k] };
        }
    }
    let least = low.iter().chain(rest).fold(f64::INFINITY, |a, x| if *x < a { *x } else { a });
    let greatest = high.iter().chain(rest).fold(f64::NEG_INFINITY, |a, x| if *x > a { *x } else { a });
    let signed = |x: f64, zero: f64| if x == 0.0 { zero } else { x };
    (least <= greatest).then(|| (signed(least, -0.0), signed(greatest, 0.0)))
}

/// Of up to 64 numbers, which are not NaN.
pub(in crate::chunks) fn known(numbers: &[f64]) -> u64 {
    // Mostly all are, which is seen without a bit per number.
    if numbers.iter().fold(true, |all, x| all & !x.is_nan()) {
        return low(numbers.len());
    }
    numbers.iter().enumerate().fold(0, |word, (i, x)| word | u64::from(!x.is_nan()) << i)
}

/// Numbers by their indices in a dictionary.
struct Places {
    /// The numbers, in the order of first occurrence.
    entries: Vec<f64>,
    /// The indices of the values, each with the number of values one after another that have it.
    runs: Vec<(u32, usize)>,
}

impl Places {
    /// `None` where the dictionary would have more than half as many entries as there are values, or none.
    fn of(values: &[f64]) -> Option<Self> {
        const FREE: u32 = u32::MAX;
        let most = values.len() / 2;
        // Open addressing: a power of two, at least twice as many slots as entries.
        let mut slots = vec![FREE; 64];
        let (mut entries, mut runs) = (Vec::<f64>::new(), Vec::new());
        let start = |bits: u64, slots: usize| {
            // The high bits of a product depend on all bits.
            let hash = (bits ^ bits >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            (hash >> 32) as usize & (slots - 1)
        };
        for same in values.chunk_by(|a, b| a.to_bits() == b.to_bits()) {
            let (value, bits) = (same[0], same[0].to_bits());
            let mut at = start(bits, slots.len());
            while slots[at] != FREE && entries[slots[at] as usize].to_bits() != bits {
                at = (at + 1) & (slots.len() - 1);
            }
            if slots[at] == FREE {
                if entries.len() >= most {
                    return None;
                }
                slots[at] = entries.len() as u32;
                entries.push(value);
                if 2 * entries.len() > slots.len() {
                    slots = vec![FREE; 2 * slots.len()];
                    for (place, entry) in entries.iter().enumerate() {
                        let mut at = start(entry.to_bits(), slots.len());
                        while slots[at] != FREE {
                            at = (at + 1) & (slots.len() - 1);
                        }
                        slots[at] = place as u32;
                    }
                }
                runs.push((entries.len() as u32 - 1, same.len()));
                continue;
            }
            runs.push((slots[at], same.len()));
        }
        (!entries.is_empty()).then_some(Self { entries, runs })
    }
}
