//! Near-identical traces: found by sketches (MinHash over groups of three characters), confirmed on the texts, and
//! reported. No sample is dropped because of its text alone.

use crate::item::SKETCH;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};

/// Values of a sketch that must agree for two texts to be compared.
const BAND: usize = 2;
/// Maximum number of texts of one bucket that are compared with the first.
const COMPARED: usize = 2000;

/// The sketch of a text; all zero for an empty one.
pub(crate) fn sketch(text: &str) -> [u32; SKETCH] {
    let mut out = [u32::MAX; SKETCH];
    let shingles = shingles(text);
    if shingles.is_empty() {
        return [0; SKETCH];
    }
    for shingle in shingles {
        for (k, least) in out.iter_mut().enumerate() {
            *least = (*least).min(mix(shingle ^ (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        }
    }
    out
}

fn mix(mut x: u64) -> u32 {
    x ^= x >> 33;
    x = x.wrapping_mul(0xff51_afd7_ed55_8ccd);
    x ^= x >> 33;
    x = x.wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    (x >> 32) as u32
}

/// Hashes of all groups of three letters, digits and characters, without case, spaces and punctuation.
fn shingles(text: &str) -> BTreeSet<u64> {
    let letters: Vec<char> =
        text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect();
    letters.windows(3.min(letters.len().max(1))).filter(|w| !w.is_empty()).map(hash).collect()
}

fn hash(letters: &[char]) -> u64 {
    letters.iter().fold(0xcbf2_9ce4_8422_2325, |h, c| (h ^ u64::from(*c)).wrapping_mul(0x0100_0000_01b3))
}

/// Share of common groups of three, 0 to 1.
pub(crate) fn similarity(a: &str, b: &str) -> f64 {
    let (a, b) = (shingles(a), shingles(b));
    let all = a.union(&b).count();
    if all == 0 { 1.0 } else { a.intersection(&b).count() as f64 / all as f64 }
}

/// Groups of texts whose sketches suggest similarity and whose texts are at least `least` similar to the
/// first of their group. `text` reads one.
pub(crate) fn groups<E: Send>(
    sketches: &[[u32; SKETCH]],
    least: f64,
    text: impl Fn(usize) -> Result<String, E> + Sync,
) -> Result<Vec<Vec<(usize, f64)>>, E> {
    let mut buckets: HashMap<(usize, [u32; BAND]), Vec<usize>> = HashMap::new();
    for (i, sketch) in sketches.iter().enumerate().filter(|(_, s)| **s != [0; SKETCH]) {
        for (band, values) in sketch.chunks_exact(BAND).enumerate() {
            buckets.entry((band, [values[0], values[1]])).or_default().push(i);
        }
    }
    let mut candidates: HashMap<usize, BTreeSet<usize>> = HashMap::new();
    for list in buckets.values().filter(|l| l.len() > 1) {
        let first = list[0];
        candidates.entry(first).or_default().extend(list.iter().skip(1).take(COMPARED));
    }
    let mut firsts: Vec<(usize, BTreeSet<usize>)> = candidates.into_iter().collect();
    firsts.sort();
    let compared: Vec<Result<Vec<(usize, f64)>, E>> = firsts
        .par_iter()
        .map(|(first, others)| {
            let reference = text(*first)?;
            let mut group = vec![(*first, 1.0)];
            for other in others {
                let s = similarity(&reference, &text(*other)?);
                if s >= least {
                    group.push((*other, s));
                }
            }
            Ok(group)
        })
        .collect();
    let mut taken = BTreeSet::new();
    let mut out = Vec::new();
    for group in compared {
        let group: Vec<(usize, f64)> = group?.into_iter().filter(|(i, _)| !taken.contains(i)).collect();
        if group.len() > 1 {
            taken.extend(group.iter().map(|g| g.0));
            out.push(group);
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_the_same_words_are_found_and_others_are_not() {
        let texts = [
            "The lead car brakes hard ahead, so the ego slows down to keep a safe gap.",
            "A pedestrian steps onto the crosswalk from the right; the ego stops and waits.",
            "The lead car brakes hard ahead, so the ego slows down to keep a safe gap!",
            "前车突然急刹，自车减速以保持安全车距。",
            "前车突然急刹，自车减速，以保持安全的车距。",
            "",
        ];
        let sketches: Vec<_> = texts.iter().map(|t| sketch(t)).collect();
        let found = groups(&sketches, 0.7, |i| Ok::<_, ()>(texts[i].to_owned())).unwrap();
        let members: Vec<Vec<usize>> = found.iter().map(|g| g.iter().map(|m| m.0).collect()).collect();
        assert_eq!(members, [vec![0, 2], vec![3, 4]]);
        assert_eq!(similarity(texts[0], texts[2]), 1.0, "punctuation does not count");
        assert!(similarity(texts[0], texts[1]) < 0.3);
    }
}
