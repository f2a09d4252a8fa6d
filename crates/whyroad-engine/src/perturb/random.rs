//! Seeded random numbers, a stream for each object, and noise over time.

use whyroad_model::random::SplitMix64;

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub(super) struct Random(SplitMix64);

impl Random {
    /// The stream of this seed and these names: the numbers for one object do not depend on the others.
    pub fn new(seed: u64, names: &[&str]) -> Self {
        // FNV-1a over the names, each ended by a byte that is in no UTF-8 text.
        let mut hash = 0xCBF2_9CE4_8422_2325_u64 ^ seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        for byte in names.iter().flat_map(|n| n.bytes().chain([0xFF])) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3);
        }
        Self(SplitMix64::new(hash))
    }

    /// In [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0.unit()
    }

    /// Mean 0, standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        self.0.normal()
    }
}

/// Correlation of noise over time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    /// Over a second (first-order Gauss-Markov), else independent.
    pub correlated: bool,
}

impl Noise {
    /// A value for each of these frames at 10 Hz.
    pub fn series(self, frames: &[u32], sd: f64, random: &mut Random) -> Vec<f64> {
        let mut out = Vec::with_capacity(frames.len());
        let mut value = random.normal();
        for (i, frame) in frames.iter().enumerate() {
            if i > 0 {
                let kept =
                    if self.correlated { (-0.1 * f64::from(frame - frames[i - 1])).exp() } else { 0.0 };
                value = kept * value + (1.0 - kept * kept).sqrt() * random.normal();
            }
            out.push(sd * value);
        }
        out
    }
}
