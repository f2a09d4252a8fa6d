//! Small changes to bytes: flipped bits, boundary numbers (binary and in text), removed, repeated and exchanged parts.

/// A seeded generator (xorshift64*; Vigna 2016): equal seeds give equal inputs.
pub(crate) struct Random(u64);

/// Numbers at which parsers break.
const NUMBERS: [i64; 12] =
    [0, 1, -1, 127, 255, 256, 32_767, 65_535, i32::MAX as i64, u32::MAX as i64, i64::MAX, i64::MIN];
const TEXTS: [&str; 14] = [
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "NaN",
    "inf",
    "",
    "18446744073709551616",
    "9223372036854775807",
    "1e9",
    "\u{0}",
    "\"",
    "]]]]]]",
];

impl Random {
    /// One of its own for each execution of a run (SplitMix64's finalizer; Steele, Lea and Flood 2014).
    pub fn of_execution(seed: u64, number: u64) -> Self {
        let mut z =
            seed.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self((z ^ (z >> 31)) | 1)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// Evenly below `n`; 0 when `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % (n as u64).max(1)) as usize
    }

    fn range(&mut self, length: usize, most: usize) -> std::ops::Range<usize> {
        let start = self.below(length);
        let end = start + 1 + self.below(most.min(length - start));
        start..end.min(length)
    }
}

/// One to four changes to `input`; parts of `other` may be mixed in.
pub(crate) fn mutate(random: &mut Random, input: &mut Vec<u8>, other: &[u8]) {
    let is_text = input.iter().take(64).all(|b| *b >= b'\t');
    for _ in 0..=random.below(4) {
        if input.is_empty() {
            input.extend_from_slice(other);
            continue;
        }
        if is_text && random.below(2) == 0 {
            one_of_text(random, input, other);
        } else {
            one(random, input, other);
        }
    }
}

/// Characters between which a text has its parts.
const DELIMITERS: &[u8] = b"<>{}[](),;:/=\"' \n";

/// A change that leaves the form of a text mostly as it is: a part between delimiters is removed, repeated elsewhere or
/// put in place of another.
fn one_of_text(random: &mut Random, input: &mut Vec<u8>, other: &[u8]) {
    let part = part_of_text(random, input);
    match random.below(4) {
        0 => drop(input.drain(part)),
        1 => {
            let copy = input[part].to_vec();
            let at = part_of_text(random, input).start;
            input.splice(at..at, copy);
        }
        2 => {
            let from = if other.is_empty() { &*input } else { other };
            let copy = from[part_of_text(random, from)].to_vec();
            input.splice(part, copy);
        }
        _ => {
            input.splice(part, TEXTS[random.below(TEXTS.len())].bytes());
        }
    }
}

/// A few parts between delimiters that follow each other; `text` is not empty.
fn part_of_text(random: &mut Random, text: &[u8]) -> std::ops::Range<usize> {
    let is_delimiter = |b: &u8| DELIMITERS.contains(b);
    let at = random.below(text.len());
    let start = text[..at].iter().rposition(is_delimiter).map_or(0, |p| p + 1);
    let mut end = start;
    for _ in 0..=[0, 0, 2, 8][random.below(4)] {
        let rest = &text[end..];
        let skipped = usize::from(end > start && end < text.len());
        end += rest.iter().skip(skipped).position(is_delimiter).map_or(rest.len(), |p| p + skipped);
    }
    start..end
}

fn one(random: &mut Random, input: &mut Vec<u8>, other: &[u8]) {
    let at = random.below(input.len());
    match random.below(12) {
        10 | 11 => near(random, input, at),
        0 => input[at] ^= 1 << random.below(8),
        1 => input[at] = random.next() as u8,
        2 | 3 => {
            let number = NUMBERS[random.below(NUMBERS.len())];
            let size = [1, 2, 4, 8][random.below(4)];
            let mut bytes = number.to_le_bytes()[..size].to_vec();
            if random.below(2) == 0 {
                bytes.reverse();
            }
            let end = (at + size).min(input.len());
            input[at..end].copy_from_slice(&bytes[..end - at]);
        }
        4 => drop(input.drain(random.range(input.len(), 64))),
        5 => {
            let part = input[random.range(input.len(), 256)].to_vec();
            input.splice(at..at, part);
        }
        6 => input.truncate(at),
        7 if !other.is_empty() => {
            let part = other[random.range(other.len(), 256)].to_vec();
            let end = (at + part.len()).min(input.len());
            input.splice(at..end, part);
        }
        _ => number_in_text(random, input, at),
    }
}

/// Adds a little to a number of one, two or four bytes: lengths and counts that are off by a few.
fn near(random: &mut Random, input: &mut [u8], at: usize) {
    let size = [1, 2, 4][random.below(3)].min(input.len() - at);
    let little = random.below(2) == 0;
    let bytes = &mut input[at..at + size];
    let place = |k: usize| if little { k } else { size - 1 - k };
    let number = (0..size).fold(0_u32, |n, k| n | u32::from(bytes[place(k)]) << (8 * k));
    let changed = number.wrapping_add(random.below(17) as u32).wrapping_sub(8);
    (0..size).for_each(|k| bytes[place(k)] = (changed >> (8 * k)) as u8);
}

/// Puts another number (or no number) in place of the run of digits at or behind `at`.
fn number_in_text(random: &mut Random, input: &mut Vec<u8>, at: usize) {
    let Some(start) = input[at..].iter().position(u8::is_ascii_digit).map(|p| p + at) else { return };
    let end = input[start..].iter().position(|b| !b.is_ascii_digit()).map_or(input.len(), |p| p + start);
    input.splice(start..end, TEXTS[random.below(TEXTS.len())].bytes());
}
