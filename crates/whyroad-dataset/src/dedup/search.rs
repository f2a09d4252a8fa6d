//! Vectors within a radius, exactly: buckets over the three directions in which the vectors differ most. A projection
//! never makes a distance larger, so every vector within the radius is in the same or an adjacent bucket, and no
//! neighbor is missed. An approximate graph (HNSW) would miss some, and its result would depend on the order of
//! threads.

use std::collections::HashMap;

/// Directions of the buckets.
const AXES: usize = 3;
/// Maximum number of vectors from which the directions are computed.
const SAMPLED: usize = 20_000;
/// Rounds of the power iteration.
const ROUNDS: usize = 60;

/// Orthonormal directions of the greatest variance.
#[derive(Clone, Debug)]
pub struct Projection {
    axes: [Vec<f32>; AXES],
}

impl Projection {
    /// The first principal directions, by power iteration from fixed starts.
    pub fn of(vectors: &[&[f32]]) -> Self {
        let n = vectors.first().map_or(0, |v| v.len());
        let step = (vectors.len() / SAMPLED).max(1);
        let sampled: Vec<&[f32]> = vectors.iter().step_by(step).copied().collect();
        let count = sampled.len().max(1) as f64;
        let mut mean = vec![0.0_f64; n];
        for v in &sampled {
            for (m, x) in mean.iter_mut().zip(*v) {
                *m += f64::from(*x) / count;
            }
        }
        let mut covariance = vec![0.0_f64; n * n];
        for v in &sampled {
            let centered: Vec<f64> = v.iter().zip(&mean).map(|(x, m)| f64::from(*x) - m).collect();
            for (i, a) in centered.iter().enumerate() {
                for (j, b) in centered.iter().enumerate() {
                    covariance[i * n + j] += a * b / count;
                }
            }
        }
        let mut axes: Vec<Vec<f64>> = Vec::new();
        for k in 0..AXES {
            // A start that is not orthogonal to any direction by symmetry.
            let mut axis: Vec<f64> = (0..n).map(|i| 1.0 + ((i * 7 + k * 3) % 11) as f64 / 10.0).collect();
            orthonormal(&mut axis, &axes);
            for _ in 0..ROUNDS {
                let mut next = vec![0.0; n];
                for (i, out) in next.iter_mut().enumerate() {
                    *out = covariance[i * n..(i + 1) * n].iter().zip(&axis).map(|(c, a)| c * a).sum();
                }
                if next.iter().map(|x| x * x).sum::<f64>() < 1e-18 {
                    break;
                }
                orthonormal(&mut next, &axes);
                axis = next;
            }
            axes.push(axis);
        }
        let mut axes = axes.into_iter().map(|a| a.into_iter().map(|x| x as f32).collect());
        Self { axes: std::array::from_fn(|_| axes.next().unwrap_or_default()) }
    }

    fn project(&self, v: &[f32]) -> [f32; AXES] {
        std::array::from_fn(|k| self.axes[k].iter().zip(v).map(|(a, x)| a * x).sum())
    }
}

/// Makes `v` orthogonal to `others` and of length 1.
fn orthonormal(v: &mut [f64], others: &[Vec<f64>]) {
    for other in others {
        let along: f64 = v.iter().zip(other).map(|(a, b)| a * b).sum();
        v.iter_mut().zip(other).for_each(|(a, b)| *a -= along * b);
    }
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 {
        v.iter_mut().for_each(|x| *x /= length);
    }
}

/// Vectors that can be searched within one radius.
pub struct Neighbors<'a> {
    vectors: &'a [&'a [f32]],
    projection: &'a Projection,
    /// Square of the Euclidean radius.
    square: f32,
    edge: f32,
    buckets: HashMap<[i32; AXES], Vec<u32>>,
}

impl<'a> Neighbors<'a> {
    /// None inserted yet. `radius` is a root mean square difference.
    pub fn new(vectors: &'a [&'a [f32]], projection: &'a Projection, radius: f64) -> Self {
        let n = vectors.first().map_or(1, |v| v.len().max(1)) as f64;
        let euclidean = (radius * n.sqrt()) as f32;
        // Rounding of the projection must not put a neighbor two buckets away.
        let edge = (euclidean * 1.001).max(1e-4);
        Self { vectors, projection, square: euclidean * euclidean, edge, buckets: HashMap::new() }
    }

    fn bucket(&self, v: &[f32]) -> [i32; AXES] {
        self.projection.project(v).map(|x| (x / self.edge).floor() as i32)
    }

    /// Adds a vector by its index.
    pub fn insert(&mut self, i: u32) {
        let bucket = self.bucket(self.vectors[i as usize]);
        self.buckets.entry(bucket).or_default().push(i);
    }

    /// A vector within the radius that `accept` accepts; always the same one.
    pub fn find(&self, v: &[f32], accept: impl Fn(u32) -> bool) -> Option<u32> {
        let mut found = None;
        self.each_near(v, |i| {
            if accept(i) {
                found = Some(i);
            }
            found.is_none()
        });
        found
    }

    /// All vectors within the radius, ascending.
    pub fn all(&self, v: &[f32]) -> Vec<u32> {
        let mut out = Vec::new();
        self.each_near(v, |i| {
            out.push(i);
            true
        });
        out.sort_unstable();
        out
    }

    fn each_near(&self, v: &[f32], mut each: impl FnMut(u32) -> bool) {
        let [a, b, c] = self.bucket(v);
        for i in -1..=1 {
            for j in -1..=1 {
                for k in -1..=1 {
                    let bucket = [a.saturating_add(i), b.saturating_add(j), c.saturating_add(k)];
                    for &other in self.buckets.get(&bucket).into_iter().flatten() {
                        if is_within(v, self.vectors[other as usize], self.square) && !each(other) {
                            return;
                        }
                    }
                }
            }
        }
    }
}

/// Stops adding as soon as the sum is too large.
fn is_within(a: &[f32], b: &[f32], square: f32) -> bool {
    let mut sum = 0.0;
    for (p, q) in a.chunks(8).zip(b.chunks(8)) {
        sum += p.iter().zip(q).map(|(x, y)| (x - y) * (x - y)).sum::<f32>();
        if sum > square {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pseudo-random numbers, the same in every run.
    fn vectors(n: usize, dimensions: usize) -> Vec<Vec<f32>> {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        (0..n)
            .map(|_| (0..dimensions).map(|k| next() * if k % 5 == 0 { 10.0 } else { 1.0 }).collect())
            .collect()
    }

    #[test]
    fn every_neighbor_is_found_and_nothing_else() {
        let all = vectors(2000, 12);
        let views: Vec<&[f32]> = all.iter().map(Vec::as_slice).collect();
        let projection = Projection::of(&views);
        for radius in [0.2, 0.7, 2.0] {
            let mut index = Neighbors::new(&views, &projection, radius);
            (0..views.len()).for_each(|i| index.insert(i as u32));
            let mut pairs = 0;
            for q in views.iter().step_by(17) {
                // By hand: root mean square difference.
                let near = |v: &[f32]| {
                    let sum: f32 = v.iter().zip(*q).map(|(a, b)| (a - b) * (a - b)).sum();
                    (f64::from(sum) / 12.0).sqrt() <= radius
                };
                let expected: Vec<u32> =
                    (0..views.len()).filter(|i| near(views[*i])).map(|i| i as u32).collect();
                assert_eq!(index.all(q), expected);
                pairs += expected.len();
            }
            assert!(pairs >= views.len() / 17, "each finds at least itself");
        }
    }

    #[test]
    fn equal_vectors_and_no_vectors_are_no_trouble() {
        let same = vec![vec![1.0_f32; 5]; 10];
        let views: Vec<&[f32]> = same.iter().map(Vec::as_slice).collect();
        let projection = Projection::of(&views);
        let mut index = Neighbors::new(&views, &projection, 0.0);
        index.insert(3);
        assert_eq!(index.find(views[0], |_| true), Some(3));
        assert_eq!(index.find(views[0], |i| i != 3), None);
        assert!(Projection::of(&[]).axes.iter().all(Vec::is_empty));
    }
}
