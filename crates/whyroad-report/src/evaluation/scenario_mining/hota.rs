//! HOTA: Luiten et al., "HOTA: A Higher Order Metric for Evaluating Multi-Object Tracking", IJCV 2020 (arXiv
//! 2009.07736). Over sequences, counts are added and the association accuracy is weighted by true positives.

use super::assignment::best_assignment;
use super::sequence::{Frame, Sequence};
use super::similarity;
use super::thresholds::thresholds;
use std::collections::BTreeMap;

/// Localization thresholds: 0.05, 0.10, ... 0.95.
const ALPHAS: usize = 19;
/// Rounding must not decide whether a similarity reaches its threshold.
const EPSILON: f64 = f64::EPSILON;

/// The best HOTA over the score thresholds, and the first threshold that gives it.
pub fn best(pairs: &[(Sequence, Sequence)]) -> (f64, f64) {
    let mut best = (f64::NEG_INFINITY, 0.0);
    for threshold in thresholds(pairs) {
        let value = hota(pairs, threshold);
        if value > best.0 {
            best = (value, threshold);
        }
    }
    (best.0.max(0.0), best.1)
}

/// Mean HOTA over the localization thresholds, of predictions with at least this score.
pub fn hota(pairs: &[(Sequence, Sequence)], least_score: f64) -> f64 {
    let mut sum = Counts::default();
    for (t, p) in pairs {
        sum.add(&counts(t, p, least_score));
    }
    let at = |a: usize| {
        let [hit, missed, spurious] = [sum.hit[a], sum.missed[a], sum.spurious[a]];
        let detection = hit / (hit + missed + spurious).max(1.0);
        let association = sum.association[a] / hit.max(1e-10);
        (detection * association).sqrt()
    };
    (0..ALPHAS).map(at).sum::<f64>() / ALPHAS as f64
}

#[derive(Clone, Debug, Default)]
struct Counts {
    hit: [f64; ALPHAS],
    missed: [f64; ALPHAS],
    spurious: [f64; ALPHAS],
    /// Sum over hits of how well their two tracks belong together.
    association: [f64; ALPHAS],
}

impl Counts {
    fn add(&mut self, other: &Self) {
        let all = [
            (&mut self.hit, &other.hit),
            (&mut self.missed, &other.missed),
            (&mut self.spurious, &other.spurious),
            (&mut self.association, &other.association),
        ];
        for (sum, more) in all {
            sum.iter_mut().zip(more).for_each(|(s, m)| *s += m);
        }
    }
}

/// Objects of a frame as numbered tracks.
struct Seen {
    truth: Vec<usize>,
    found: Vec<usize>,
    similar: Vec<Vec<f64>>,
}

fn numbered<'a>(ids: &mut BTreeMap<&'a str, usize>, id: &'a str) -> usize {
    let next = ids.len();
    *ids.entry(id).or_insert(next)
}

fn counts(truth: &Sequence, predicted: &Sequence, least_score: f64) -> Counts {
    let (mut truth_ids, mut found_ids) = (BTreeMap::new(), BTreeMap::new());
    let mut frames = Vec::new();
    for (t, p) in truth.frames.iter().zip(&predicted.frames) {
        let kept: Vec<_> = p.objects.iter().filter(|o| o.score >= least_score).collect();
        frames.push(Seen {
            truth: numbers(t, &mut truth_ids),
            found: kept.iter().map(|o| numbered(&mut found_ids, &o.track_id)).collect(),
            similar: t.objects.iter().map(|a| kept.iter().map(|b| similarity(a, b)).collect()).collect(),
        });
    }
    // How well any two tracks belong together over the whole sequence.
    let (n, m) = (truth_ids.len(), found_ids.len());
    let (mut truth_count, mut found_count) = (vec![0.0; n], vec![0.0; m]);
    let mut together = vec![vec![0.0; m]; n];
    for f in &frames {
        f.truth.iter().for_each(|&i| truth_count[i] += 1.0);
        f.found.iter().for_each(|&j| found_count[j] += 1.0);
        let row: Vec<f64> = f.similar.iter().map(|r| r.iter().sum()).collect();
        for (j, &b) in f.found.iter().enumerate() {
            let column: f64 = f.similar.iter().map(|r| r[j]).sum();
            for (i, &a) in f.truth.iter().enumerate() {
                let s = f.similar[i][j];
                let either = row[i] + column - s;
                if either > EPSILON {
                    together[a][b] += s / either;
                }
            }
        }
    }
    let aligned = |a: usize, b: usize| together[a][b] / (truth_count[a] + found_count[b] - together[a][b]);
    let mut out = Counts::default();
    let mut matched: Vec<BTreeMap<(usize, usize), f64>> = vec![BTreeMap::new(); ALPHAS];
    for f in &frames {
        let weight: Vec<Vec<f64>> = f
            .truth
            .iter()
            .zip(&f.similar)
            .map(|(&a, row)| f.found.iter().zip(row).map(|(&b, s)| aligned(a, b) * s).collect())
            .collect();
        let assigned = best_assignment(&weight);
        for (a, matched) in matched.iter_mut().enumerate() {
            let alpha = 0.05 * (a + 1) as f64;
            let hits: Vec<_> =
                assigned.iter().filter(|&&(i, j)| f.similar[i][j] >= alpha - EPSILON).collect();
            out.hit[a] += hits.len() as f64;
            out.missed[a] += (f.truth.len() - hits.len()) as f64;
            out.spurious[a] += (f.found.len() - hits.len()) as f64;
            for &&(i, j) in &hits {
                *matched.entry((f.truth[i], f.found[j])).or_default() += 1.0;
            }
        }
    }
    for (a, pairs) in matched.iter().enumerate() {
        out.association[a] =
            pairs.iter().map(|(&(i, j), &n)| n * n / (truth_count[i] + found_count[j] - n).max(1.0)).sum();
    }
    out
}

fn numbers<'a>(frame: &'a Frame, ids: &mut BTreeMap<&'a str, usize>) -> Vec<usize> {
    frame.objects.iter().map(|o| numbered(ids, &o.track_id)).collect()
}
