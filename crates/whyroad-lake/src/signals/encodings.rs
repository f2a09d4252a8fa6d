//! How values are encoded in a page: the encodings of Parquet that signal stores use (the format's "Encodings" page),
//! decoded into what rules read. `None` means that a page is invalid.

use super::bitmap::Bitmap;
use super::steps::Steps;

/// A little-endian base-128 number at the beginning of `bytes`, which then begin after it.
fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut out = 0;
    for shift in (0..64).step_by(7) {
        let (byte, rest) = bytes.split_first()?;
        *bytes = rest;
        out |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Some(out);
        }
    }
    None
}

fn zigzag(bytes: &mut &[u8]) -> Option<i64> {
    let coded = varint(bytes)?;
    Some((coded >> 1) as i64 ^ -((coded & 1) as i64))
}

fn taken<'b>(bytes: &mut &'b [u8], n: usize) -> Option<&'b [u8]> {
    let (head, rest) = bytes.split_at_checked(n)?;
    *bytes = rest;
    Some(head)
}

/// A length of four bytes, and that number of bytes.
pub(super) fn with_length<'b>(bytes: &mut &'b [u8]) -> Option<&'b [u8]> {
    let n = u32::from_le_bytes(taken(bytes, 4)?.try_into().ok()?);
    taken(bytes, usize::try_from(n).ok()?)
}

/// A stretch of the "RLE / bit-packing hybrid".
pub(super) enum Stretch<'b> {
    /// The same number, repeated this many times.
    Same(u32, usize),
    /// A given count of numbers, packed.
    Packed(&'b [u8], usize),
}

/// The stretches that make up `n` numbers of `width` bits.
pub(super) fn stretches<'b>(
    mut bytes: &'b [u8],
    width: usize,
    n: usize,
    mut each: impl FnMut(Stretch<'b>) -> Option<()>,
) -> Option<()> {
    let mut left = n;
    while left > 0 {
        let header = usize::try_from(varint(&mut bytes)?).ok()?;
        let long = if header & 1 == 0 {
            let mut value = [0; 4];
            let stored = taken(&mut bytes, width.div_ceil(8))?;
            value.get_mut(..stored.len())?.copy_from_slice(stored);
            let long = left.min(header >> 1);
            each(Stretch::Same(u32::from_le_bytes(value), long))?;
            long
        } else {
            let groups = header >> 1;
            // The last group may be cut off behind its last number.
            let stored = bytes.len().min(groups.checked_mul(width)?);
            let packed = taken(&mut bytes, stored)?;
            let long = left.min(groups.checked_mul(8)?);
            each(Stretch::Packed(packed, long))?;
            long
        };
        if long == 0 {
            return None;
        }
        left -= long;
    }
    Some(())
}

/// Bits of the hybrid, appended.
pub(super) fn bits(bytes: &[u8], n: usize, to: &mut Bitmap) -> Option<()> {
    stretches(bytes, 1, n, |stretch| match stretch {
        Stretch::Same(bit, n) => {
            to.push_run(bit == 1, n);
            Some(())
        }
        Stretch::Packed(bytes, n) => to.push_bytes(bytes, n),
    })
}

/// The entries of a dictionary that these codes name, appended: a byte with their width, then the hybrid.
pub(super) fn looked_up<T: Copy>(bytes: &[u8], n: usize, dictionary: &[T], to: &mut Vec<T>) -> Option<()> {
    if n == 0 {
        return Some(());
    }
    let (width, bytes) = bytes.split_first()?;
    let width = usize::from(*width);
    let mut codes = Vec::new();
    stretches(bytes, width, n, |stretch| match stretch {
        Stretch::Same(code, n) => {
            let entry = *dictionary.get(code as usize)?;
            to.extend(std::iter::repeat_n(entry, n));
            Some(())
        }
        Stretch::Packed(bytes, n) => {
            codes.clear();
            unpack(bytes, width, n, &mut codes)?;
            // Checked once for all, so that the look-up itself can be fast.
            if codes.iter().max().is_some_and(|most| *most as usize >= dictionary.len()) {
                return None;
            }
            to.extend(codes.iter().map(|c| dictionary[*c as usize]));
            Some(())
        }
    })
}

/// `n` numbers of `width` bits (at most 32), packed from the lowest bit on, appended. Eight of them fill `width` bytes.
fn unpack(bytes: &[u8], width: usize, n: usize, to: &mut Vec<u32>) -> Option<()> {
    if width > 32 || (n * width).div_ceil(8) > bytes.len() {
        return None;
    }
    if width == 0 {
        to.extend(std::iter::repeat_n(0, n));
        return Some(());
    }
    let (end, mask) = (to.len() + n, super::bitmap::low(width));
    for group in bytes.chunks(width).take(n.div_ceil(8)) {
        let mut padded = [0; 40];
        padded[..group.len()].copy_from_slice(group);
        to.extend((0..8).map(|i| (bits_at(&padded, i * width) & mask) as u32));
    }
    to.truncate(end);
    Some(())
}

/// The bits from `bit` on, at least 57 of them; `bytes` has at least eight bytes from the first of them.
fn bits_at(bytes: &[u8; 40], bit: usize) -> u64 {
    let eight = bytes[bit / 8..].first_chunk::<8>().copied().unwrap_or_default();
    u64::from_le_bytes(eight) >> (bit % 8)
}

/// PLAIN-encoded numbers.
pub(super) fn plain<const N: usize, T>(
    bytes: &[u8],
    n: usize,
    of: impl Fn([u8; N]) -> T,
    to: &mut Vec<T>,
) -> Option<()> {
    let (values, _) = bytes.get(..n.checked_mul(N)?)?.as_chunks::<N>();
    to.extend(values.iter().map(|v| of(*v)));
    Some(())
}

/// "DELTA_BINARY_PACKED": each number as its difference from the one before.
pub(super) fn deltas(mut bytes: &[u8], n: usize, to: &mut Steps) -> Option<()> {
    let size = |bytes: &mut &[u8]| usize::try_from(varint(bytes)?).ok();
    let (block, minis, total) = (size(&mut bytes)?, size(&mut bytes)?, size(&mut bytes)?);
    let mut value = zigzag(&mut bytes)?;
    let per_mini = block.checked_div(minis)?;
    if total != n || per_mini == 0 || per_mini % 8 != 0 {
        return None;
    }
    let end = to.len() + n;
    if n > 0 {
        to.push(value);
    }
    let mut packed = Vec::new();
    while to.len() < end {
        let least = zigzag(&mut bytes)?;
        let widths = taken(&mut bytes, minis)?;
        for width in widths.iter().map(|w| usize::from(*w)) {
            let take = per_mini.min(end - to.len());
            if take == 0 {
                break;
            }
            let stored = taken(&mut bytes, width.checked_mul(per_mini)? / 8)?;
            if width == 0 {
                // The same step each time: frames of one object, times of a clock that keeps its rate.
                to.push_run(value.wrapping_add(least), least, take);
                value = value.wrapping_add(least.wrapping_mul(take as i64));
                continue;
            }
            packed.clear();
            unpack_long(stored, width, take, &mut packed)?;
            for delta in &packed {
                value = value.wrapping_add(least).wrapping_add(*delta as i64);
                to.push(value);
            }
        }
    }
    Some(())
}

/// As [`unpack`], for up to 64 bits.
fn unpack_long(bytes: &[u8], width: usize, n: usize, to: &mut Vec<u64>) -> Option<()> {
    if width > 64 || (n * width).div_ceil(8) > bytes.len() {
        return None;
    }
    let mask = super::bitmap::low(width);
    for bit in (0..n).map(|i| i * width) {
        let from = &bytes[bit / 8..];
        // Eight bytes hold the whole number, unless it is very wide; at the end there may be fewer.
        let value = match from.first_chunk::<8>() {
            Some(eight) if width <= 57 => u64::from_le_bytes(*eight) >> (bit % 8),
            _ => {
                let mut padded = [0; 16];
                let there = from.len().min(9);
                padded[..there].copy_from_slice(&from[..there]);
                (u128::from_le_bytes(padded) >> (bit % 8)) as u64
            }
        };
        to.push(value & mask);
    }
    Some(())
}
