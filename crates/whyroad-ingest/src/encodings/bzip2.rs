//! bzip2, unpacked in memory: Huffman codes, move to front, the Burrows-Wheeler transform and its run lengths, with the
//! checksums of every block. Written here because the maintained crate brings a C library's port and its license for
//! chunks of ROS 1 bags alone.

use crate::file_reader::FileReader;
use std::num::Wrapping;

const BLOCK: u64 = 0x3141_5926_5359;
const END: u64 = 0x1772_4538_5090;
/// Symbols of a group, maximum number of selectors, longest code.
const GROUP: usize = 50;
const MAX_SELECTORS: usize = 18_002;
const MAX_BITS: u32 = 20;
const RUN_A: u16 = 0;
const RUN_B: u16 = 1;

/// The unpacked bytes; `Err` says what is wrong, also when there are more than `limit`.
pub(crate) fn unpack(packed: &[u8], limit: usize) -> Result<Vec<u8>, String> {
    let mut bits = Bits { bytes: packed, at: 0, held: 0, count: 0 };
    let mut out = Vec::new();
    // Streams may follow each other.
    loop {
        stream(&mut bits, limit, &mut out)?;
        bits.align();
        if bits.at >= packed.len() && bits.count == 0 {
            return Ok(out);
        }
    }
}

fn stream(bits: &mut Bits<'_>, limit: usize, out: &mut Vec<u8>) -> Result<(), String> {
    let (magic, level) = (bits.get(24)?, bits.get(8)?);
    let level = level.wrapping_sub(u64::from(b'0'));
    if magic != 0x42_5a68 || !(1..=9).contains(&level) {
        return Err("it does not begin as bzip2".into());
    }
    let mut sum = 0_u32;
    loop {
        match bits.get(48)? {
            BLOCK => {
                let crc = bits.get(32)? as u32;
                let before = out.len();
                block(bits, level as usize * 100_000, limit, out)?;
                if checksum(&out[before..]) != crc {
                    return Err("a block does not fit its checksum".into());
                }
                sum = sum.rotate_left(1) ^ crc;
            }
            END if bits.get(32)? as u32 == sum => return Ok(()),
            END => return Err("it does not fit its checksum".into()),
            _ => return Err("a block has no mark".into()),
        }
    }
}

/// CRC-32 as bzip2 has it: most significant bit first.
fn checksum(bytes: &[u8]) -> u32 {
    const TABLE: [u32; 256] = {
        let mut table = [0; 256];
        let mut i = 0;
        while i < 256 {
            let mut c = (i as u32) << 24;
            let mut k = 0;
            while k < 8 {
                c = if c & 0x8000_0000 != 0 { (c << 1) ^ 0x04c1_1db7 } else { c << 1 };
                k += 1;
            }
            table[i] = c;
            i += 1;
        }
        table
    };
    !bytes.iter().fold(u32::MAX, |c, b| (c << 8) ^ TABLE[((c >> 24) as u8 ^ b) as usize])
}

struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    held: u64,
    count: u32,
}

impl Bits<'_> {
    /// Up to 48 bits, the most significant first.
    fn get(&mut self, n: u32) -> Result<u64, String> {
        while self.count < n {
            let byte = *self.bytes.get(self.at).ok_or("it is cut short")?;
            self.at += 1;
            self.held = self.held << 8 | u64::from(byte);
            self.count += 8;
        }
        self.count -= n;
        let out = self.held >> self.count;
        self.held &= (1 << self.count) - 1;
        Ok(out)
    }

    fn flag(&mut self) -> Result<bool, String> {
        Ok(self.get(1)? == 1)
    }

    fn align(&mut self) {
        (self.held, self.count) = (0, 0);
    }
}

/// A Huffman code by the canonical order of its lengths.
struct Code {
    /// Symbols, by length.
    symbols: Vec<u16>,
    /// By length: first code, and the symbol's index less that code.
    first: [u32; MAX_BITS as usize + 2],
    offset: [Wrapping<u32>; MAX_BITS as usize + 2],
}

impl Code {
    fn new(lengths: &[u8]) -> Self {
        let mut symbols: Vec<u16> = (0..lengths.len() as u16).collect();
        symbols.sort_by_key(|s| lengths[*s as usize]);
        let mut out = Self { symbols, first: [0; 22], offset: [Wrapping(0); 22] };
        let (mut code, mut index) = (0_u32, 0_u32);
        for length in 1..=MAX_BITS as usize {
            out.offset[length] = Wrapping(index) - Wrapping(code);
            let n = lengths.iter().filter(|l| **l as usize == length).count() as u32;
            code = code.wrapping_add(n);
            index += n;
            // One past the last code of this length.
            out.first[length] = code;
            code = code.wrapping_shl(1);
        }
        out
    }

    fn symbol(&self, bits: &mut Bits<'_>) -> Result<u16, String> {
        let mut code = 0_u32;
        for length in 1..=MAX_BITS as usize {
            code = code << 1 | bits.get(1)? as u32;
            if code < self.first[length] {
                let index = (self.offset[length] + Wrapping(code)).0 as usize;
                return self.symbols.get(index).copied().ok_or_else(|| "a code is not in its table".into());
            }
        }
        Err("a code is too long".into())
    }
}

fn block(bits: &mut Bits<'_>, size: usize, limit: usize, out: &mut Vec<u8>) -> Result<(), String> {
    if bits.flag()? {
        return Err("its blocks are randomized, which no program has written since 1999".into());
    }
    let origin = bits.get(24)? as usize;
    let mut front = Vec::with_capacity(256);
    let rows = bits.get(16)?;
    for row in (0..16_u16).filter(|r| rows >> (15 - r) & 1 == 1) {
        let used = bits.get(16)?;
        front.extend((0..16_u16).filter(|c| used >> (15 - c) & 1 == 1).map(|c| (row * 16 + c) as u8));
    }
    let (groups, selectors) = (bits.get(3)? as usize, bits.get(15)? as usize);
    if front.is_empty() || !(2..=6).contains(&groups) || selectors == 0 {
        return Err("a block's tables are broken".into());
    }
    let selectors = selectors_of(bits, groups, selectors)?;
    let end = front.len() as u16 + 1;
    let codes: Vec<Code> = (0..groups)
        .map(|_| lengths(bits, end as usize + 1).map(|l| Code::new(&l)))
        .collect::<Result<_, _>>()?;
    let mut last: Vec<u8> = Vec::new();
    let (mut run, mut weight) = (0_usize, 1_usize);
    'block: for selector in selectors {
        for _ in 0..GROUP {
            let symbol = codes[selector].symbol(bits)?;
            if symbol == RUN_A || symbol == RUN_B {
                run += weight << symbol;
                weight <<= 1;
                if run > size {
                    return Err("a block is larger than it may be".into());
                }
                continue;
            }
            let repeated = last.len() + std::mem::take(&mut run);
            weight = 1;
            if repeated > size {
                return Err("a block is larger than it may be".into());
            }
            last.resize(repeated, front[0]);
            if symbol == end {
                return inverse(&last, origin, limit, out);
            }
            let place = symbol as usize - 1;
            front[..=place].rotate_right(1);
            last.push(front[0]);
            if last.len() > size {
                break 'block;
            }
        }
    }
    Err("a block has no end".into())
}

/// Which code each group of symbols has, moved to front.
fn selectors_of(bits: &mut Bits<'_>, groups: usize, n: usize) -> Result<Vec<usize>, String> {
    let mut order: Vec<usize> = (0..groups).collect();
    let mut out = Vec::with_capacity(n.min(MAX_SELECTORS));
    for _ in 0..n {
        let mut place = 0;
        while bits.flag()? {
            place += 1;
            if place >= groups {
                return Err("a selector is broken".into());
            }
        }
        order[..=place].rotate_right(1);
        // More than the maximum are skipped, as the reference program does.
        if out.len() < MAX_SELECTORS {
            out.push(order[0]);
        }
    }
    Ok(out)
}

/// Lengths of the codes of all symbols.
fn lengths(bits: &mut Bits<'_>, symbols: usize) -> Result<Vec<u8>, String> {
    let mut length = bits.get(5)?;
    (0..symbols)
        .map(|_| {
            loop {
                if !(1..=u64::from(MAX_BITS)).contains(&length) {
                    return Err("a code's length is broken".to_owned());
                }
                if !bits.flag()? {
                    return Ok(length as u8);
                }
                length = if bits.flag()? { length.wrapping_sub(1) } else { length + 1 };
            }
        })
        .collect()
}

/// From the last column of the sorted rotations to the text, and from its runs to its bytes.
fn inverse(last: &[u8], origin: usize, limit: usize, out: &mut Vec<u8>) -> Result<(), String> {
    if origin >= last.len() {
        return Err("a block's origin lies outside of it".into());
    }
    let mut starts = [0_u32; 256];
    last.iter().for_each(|b| starts[*b as usize] += 1);
    let mut sum = 0;
    for start in &mut starts {
        sum += std::mem::replace(start, sum);
    }
    let mut next = vec![0_u32; last.len()];
    for (i, b) in last.iter().enumerate() {
        next[starts[*b as usize] as usize] = i as u32;
        starts[*b as usize] += 1;
    }
    let (mut at, mut run, mut previous) = (next[origin] as usize, 0, None);
    for _ in 0..last.len() {
        let byte = last[at];
        at = next[at] as usize;
        // Four equal bytes are followed by the number of further ones.
        if run == 4 {
            out.extend(std::iter::repeat_n(previous.unwrap_or_default(), byte as usize));
            (run, previous) = (0, None);
        } else {
            run = if previous == Some(byte) { run + 1 } else { 1 };
            previous = Some(byte);
            out.push(byte);
        }
        if out.len() > limit {
            return Err("it unpacks to more than it declares".into());
        }
    }
    Ok(())
}

/// For [`crate::readers`].
pub(crate) const READER: FileReader =
    FileReader { name: "bzip2", read: |bytes| unpack(bytes, 1 << 20).is_ok() };

#[cfg(test)]
mod tests {
    use super::*;

    /// Written by Python's `bz2.compress`.
    fn packed(hex: &str) -> Vec<u8> {
        (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect()
    }

    const TEXT: &[&str] = &[
        "425a68393141592653594c533b2c0000051180400434c090a02000223f550d064201a69a3112d369",
        "8eb8ca614a5a56f8bb9229c284826299d960",
    ];
    const RUNS: &[&str] = &[
        "425a683931415926535904e5815600003e7fffffffffffffffffffffffffffffffffffffffffffff",
        "ffffffffffffffffffffffb000dad249800260002600000000000000000000000000000000000000",
        "00000000000000000019268000132600004d31300000000004c000000034269a6009800026000000",
        "00098000000004c0004c99100000000000000000000000000000000009804c000000000000000000",
        "000260002600013d0181820283038404850586068707880889098a0a8b0b8c0c8d0d8e0e8f0f9010",
        "911192129313941495159616971798189717981899199a1a9b1b9c1c9d1d9e1e9f1fa020a121a222",
        "a323a424a525a626a727a828a929aa2aab2bac2cad2dae2eaf2fb2b333b434b535b636b737b838b9",
        "39ba3abb3bbc3cfa02f7080000040a000080b901837e7ffb407de07f10507090b0d0f0f111315171",
        "91b1d1f21232527292b2d2f31333537393b3d3f41434547494b4d4f51535557595b5d5f616365676",
        "96b6d6f71737577797b7d7f81838587898b8d8f91939597999b9d9fa1a3a5a7a9abadafb1b3b5b7b",
        "9bbbdbfc1c3c5c7c9cad5ccd9cfd1cdcfd1d3d5d7d9dbdddfe1e3e5e7fdf4f802f583ff7b7bffc5d",
        "c914e1424013960558",
    ];
    const EMPTY: &str = "425a683917724538509000000000";

    #[test]
    fn text_runs_and_nothing() {
        let text = unpack(&packed(&TEXT.concat()), 1000).unwrap();
        assert_eq!(text, b"a whyroad bag, a whyroad bag, a whyroad bag");
        let runs = unpack(&packed(&RUNS.concat()), 10_000).unwrap();
        let want: Vec<u8> = [vec![b'x'; 1000], vec![b'y'; 5], (0..=255).collect()].concat();
        assert_eq!(runs, want);
        assert_eq!(unpack(&packed(EMPTY), 0).unwrap(), b"");
        let two = [packed(&TEXT.concat()), packed(&TEXT.concat())].concat();
        assert_eq!(unpack(&two, 1000).unwrap().len(), 2 * text.len());
    }

    #[test]
    fn damage_and_size_are_found() {
        let whole = packed(&TEXT.concat());
        assert!(unpack(&whole[..whole.len() - 5], 1000).is_err());
        assert!(unpack(&packed(&RUNS.concat()), 500).unwrap_err().contains("more than"));
        let text = unpack(&whole, 1000).unwrap();
        let mut found = 0;
        for at in 0..whole.len() {
            let mut bad = whole.clone();
            bad[at] ^= 0x10;
            // A bit of a code that no symbol uses changes nothing.
            match unpack(&bad, 1000) {
                Ok(same) => assert_eq!(same, text, "{at}"),
                Err(_) => found += 1,
            }
        }
        assert!(found > whole.len() * 9 / 10, "{found} of {}", whole.len());
        assert!(unpack(b"", 10).is_err());
    }

    proptest::proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..200)) {
            let framed = [b"BZh91AY&SY".as_slice(), &bytes].concat();
            let _ = unpack(&framed, 1 << 20);
            let _ = unpack(&bytes, 1 << 20);
        }
    }
}
