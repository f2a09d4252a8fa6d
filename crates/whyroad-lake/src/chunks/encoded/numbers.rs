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
    let mut before = 0;
    let mut bodies = Vec::with_capacity(pages.len());
    for (bits, end) in &pages {
        let mut page = if nullable { levels(bits)? } else { Vec::new() };
        match &places {
            Some(places) => {
                let mut hybrid = Hybrid::of_places(places.entries.len());
                let same = places.of_values[before..*end].chunk_by(|a, b| a == b);
                same.for_each(|same| hybrid.push(same[0], same.len()));
                page.extend_from_slice(&hybrid.finish());
            }
            None => {
                let plain = &numbers[before..*end];
                let start = page.len();
                page.reserve_exact(8 * plain.len());
                page.resize(start + 8 * plain.len(), 0);
                // Eight bytes at once; an iterator over the bytes would go byte by byte.
                let (eights, _) = page[start..].as_chunks_mut::<8>();
                eights.iter_mut().zip(plain).for_each(|(eight, x)| *eight = x.to_le_bytes());
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
    for some in page.chunks(step) {
        let some = &some[..some.len().min(SAMPLE_BYTES)];
        raw += some.len();
        packed += snappy.compress_vec(some).ok()?.len();
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
    /// The index of each value.
    of_values: Vec<u32>,
}

impl Places {
    /// `None` where the dictionary would have more than half as many entries as there are values, or none.
    fn of(values: &[f64]) -> Option<Self> {
        const FREE: u32 = u32::MAX;
        let most = values.len() / 2;
        // Open addressing: a power of two, at least twice as many slots as entries.
        let mut slots = vec![FREE; 64];
        let (mut entries, mut of_values) = (Vec::<f64>::new(), Vec::with_capacity(values.len()));
        let start = |bits: u64, slots: usize| {
            // The high bits of a product depend on all bits.
            let hash = (bits ^ bits >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            (hash >> 32) as usize & (slots - 1)
        };
        let mut last = None;
        for value in values {
            let bits = value.to_bits();
            if let Some((_, place)) = last.filter(|(of, _)| *of == bits) {
                of_values.push(place);
                continue;
            }
            let mut at = start(bits, slots.len());
            while slots[at] != FREE && entries[slots[at] as usize].to_bits() != bits {
                at = (at + 1) & (slots.len() - 1);
            }
            if slots[at] == FREE {
                if entries.len() >= most {
                    return None;
                }
                slots[at] = entries.len() as u32;
                entries.push(*value);
                if 2 * entries.len() > slots.len() {
                    slots = vec![FREE; 2 * slots.len()];
                    for (place, entry) in entries.iter().enumerate() {
                        let mut at = start(entry.to_bits(), slots.len());
                        while slots[at] != FREE {
                            at = (at + 1) & (slots.len() - 1);
                        }
                        slots[at] = place as u32;
                    }
                    last = None;
                    of_values.push(entries.len() as u32 - 1);
                    continue;
                }
            }
            let place = slots[at];
            last = Some((bits, place));
            of_values.push(place);
        }
        (!entries.is_empty()).then_some(Self { entries, of_values })
    }
}
