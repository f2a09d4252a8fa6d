//! Shares of judged episodes: their interval, and monotone estimates by score.

/// Neighboring episodes with one estimate, `sum / weight`.
pub(crate) struct Block {
    /// Least score.
    pub from: f64,
    /// Estimate by weight.
    pub sum: f64,
    /// Weight.
    pub weight: f64,
    /// Right ones.
    pub right: usize,
    /// All.
    pub judged: usize,
}

/// Pools adjacent violators: the estimates never fall.
pub(crate) fn pooled(blocks: impl IntoIterator<Item = Block>) -> Vec<Block> {
    let mut out: Vec<Block> = Vec::new();
    for block in blocks {
        out.push(block);
        while let [.., a, b] = &out[..]
            && a.sum * b.weight >= b.sum * a.weight
        {
            let from = a.from;
            let (sum, weight) = (a.sum + b.sum, a.weight + b.weight);
            let (right, judged) = (a.right + b.right, a.judged + b.judged);
            out.truncate(out.len() - 2);
            out.push(Block { from, sum, weight, right, judged });
        }
    }
    out
}

/// The 95 % interval of a share (Wilson 1927).
pub(crate) fn wilson(right: usize, n: usize) -> [f64; 2] {
    const Z: f64 = 1.959_964;
    let (n, p) = (n as f64, right as f64 / n as f64);
    let middle = p + Z * Z / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    [((middle - half) / scale).max(0.0), ((middle + half) / scale).min(1.0)]
}
