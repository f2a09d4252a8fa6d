//! Comparing numbers, 64 to a word of truth.

use super::bits::Bits;
use crate::language::syntax::CompareOp;

/// The result of a comparison for all values of a range, where it is the same for all.
pub(super) fn settled(op: CompareOp, (least, greatest): (f64, f64), bound: f64) -> Option<bool> {
    if least > greatest {
        return Some(false);
    }
    match op {
        CompareOp::Less if greatest < bound => Some(true),
        CompareOp::Less if least >= bound => Some(false),
        CompareOp::LessOrEqual if greatest <= bound => Some(true),
        CompareOp::LessOrEqual if least > bound => Some(false),
        CompareOp::Greater if least > bound => Some(true),
        CompareOp::Greater if greatest <= bound => Some(false),
        CompareOp::GreaterOrEqual if least >= bound => Some(true),
        CompareOp::GreaterOrEqual if greatest < bound => Some(false),
        CompareOp::Equal if bound < least || bound > greatest => Some(false),
        CompareOp::NotEqual if bound < least || bound > greatest => Some(true),
        _ => None,
    }
}

/// Least and greatest known value of up to 64 rows. Eight at a time: the comparisons skip NaN, and a
/// compiler turns them into vector instructions.
pub(super) fn range(rows: &[f64]) -> (f64, f64) {
    let (mut least, mut greatest) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8]);
    let (eights, rest) = rows.as_chunks::<8>();
    for eight in eights {
        for k in 0..8 {
            least[k] = if eight[k] < least[k] { eight[k] } else { least[k] };
            greatest[k] = if eight[k] > greatest[k] { eight[k] } else { greatest[k] };
        }
    }
    for (k, x) in rest.iter().enumerate() {
        least[k] = if *x < least[k] { *x } else { least[k] };
        greatest[k] = if *x > greatest[k] { *x } else { greatest[k] };
    }
    let least = least.into_iter().fold(f64::INFINITY, f64::min);
    (least, greatest.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

pub(super) fn holds(op: CompareOp, a: f64, b: f64) -> bool {
    match op {
        CompareOp::Less => a < b,
        CompareOp::LessOrEqual => a <= b,
        CompareOp::Greater => a > b,
        CompareOp::GreaterOrEqual => a >= b,
        CompareOp::Equal => a == b,
        CompareOp::NotEqual => a != b,
    }
}

/// Up to 64 rows to a word.
pub(super) fn compare_word(op: CompareOp, rows: &[f64], b: f64) -> u64 {
    // One loop per operator: so that rows need no check of it.
    match op {
        CompareOp::Less => pack(rows, |a| a < b),
        CompareOp::LessOrEqual => pack(rows, |a| a <= b),
        CompareOp::Greater => pack(rows, |a| a > b),
        CompareOp::GreaterOrEqual => pack(rows, |a| a >= b),
        CompareOp::Equal => pack(rows, |a| a == b),
        CompareOp::NotEqual => pack(rows, |a| a != b),
    }
}

pub(super) fn compare_slice(op: CompareOp, rows: &[f64], b: f64) -> Bits {
    Bits::of_words(rows.chunks(64).map(|w| compare_word(op, w, b)).collect(), rows.len())
}

pub(super) fn compare_columns(op: CompareOp, a: &[f64], b: &[f64]) -> Bits {
    let words = a.chunks(64).zip(b.chunks(64)).map(|(a, b)| match op {
        CompareOp::Less => pack2(a, b, |a, b| a < b),
        CompareOp::LessOrEqual => pack2(a, b, |a, b| a <= b),
        CompareOp::Greater => pack2(a, b, |a, b| a > b),
        CompareOp::GreaterOrEqual => pack2(a, b, |a, b| a >= b),
        CompareOp::Equal => pack2(a, b, |a, b| a == b),
        CompareOp::NotEqual => pack2(a, b, |a, b| a != b),
    });
    Bits::of_words(words.collect(), a.len())
}

/// One bit per item.
pub fn pack_all<T: Copy>(items: &[T], f: impl Fn(T) -> bool + Copy) -> Bits {
    Bits::of_words(items.chunks(64).map(|w| pack(w, f)).collect(), items.len())
}

fn pack<T: Copy>(items: &[T], f: impl Fn(T) -> bool) -> u64 {
    let mut flags = [0u8; 64];
    for (flag, item) in flags.iter_mut().zip(items) {
        *flag = u8::from(f(*item));
    }
    gathered(&flags)
}

fn pack2(a: &[f64], b: &[f64], f: impl Fn(f64, f64) -> bool) -> u64 {
    let mut flags = [0u8; 64];
    for ((flag, a), b) in flags.iter_mut().zip(a).zip(b) {
        *flag = u8::from(f(*a, *b));
    }
    gathered(&flags)
}

/// Rows where the numbers differ by no more than their noise, the standard deviation of the difference; where that is
/// unknown, none (`crate::deviation::stated`).
pub(super) fn within_noise(a: &[f64], b: &[f64], noise: &[f64]) -> Bits {
    let words = a.chunks(64).zip(b.chunks(64)).zip(noise.chunks(64));
    Bits::of_words(words.map(|((a, b), noise)| within_noise_word(a, b, noise)).collect(), a.len())
}

/// [`within_noise`] of up to 64 rows.
pub(super) fn within_noise_word(a: &[f64], b: &[f64], noise: &[f64]) -> u64 {
    let mut flags = [0u8; 64];
    for (((flag, a), b), noise) in flags.iter_mut().zip(a).zip(b).zip(noise) {
        *flag = u8::from(is_within_noise(*a, *b, *noise));
    }
    gathered(&flags)
}

/// Without branches: a compiler turns this into vector instructions.
pub(super) fn is_within_noise(a: f64, b: f64, noise: f64) -> bool {
    let noise = noise.abs();
    (noise > 0.0) & (noise < f64::INFINITY) & ((a - b).abs() <= noise)
}

/// 64 bytes of 0 or 1 to 64 bits. The product moves byte i of eight to bit 56 + i, with no carry between them.
fn gathered(flags: &[u8; 64]) -> u64 {
    let (eights, _) = flags.as_chunks::<8>();
    let byte = |eight: &[u8; 8]| u64::from_le_bytes(*eight).wrapping_mul(0x0102_0408_1020_4080) >> 56;
    eights.iter().enumerate().fold(0, |word, (i, eight)| word | byte(eight) << (8 * i))
}
