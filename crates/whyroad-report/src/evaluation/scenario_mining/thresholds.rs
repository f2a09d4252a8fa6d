//! The score thresholds that are tried: those at which recalls of 1.0, 0.9, ... 0.1 are reached, as if every pair of
//! the best assignment were a hit.

use super::assignment::best_assignment;
use super::sequence::Sequence;
use super::similarity;

/// Thresholds tried per prompt.
const COUNT: usize = 10;

/// From the highest recall to the lowest; 0 where a recall is not reached. `pairs`: truth and prediction, referred
/// objects only.
pub fn thresholds(pairs: &[(Sequence, Sequence)]) -> [f64; COUNT] {
    let mut scores = Vec::new();
    let mut truths = 0;
    for (t, p) in pairs {
        for (t, p) in t.frames.iter().zip(&p.frames) {
            let similar: Vec<Vec<f64>> =
                t.objects.iter().map(|a| p.objects.iter().map(|b| similarity(a, b)).collect()).collect();
            scores.extend(best_assignment(&similar).into_iter().map(|(_, c)| p.objects[c].score));
            truths += t.objects.len();
        }
    }
    scores.sort_by(|a, b| b.total_cmp(a));
    let mut out = [0.0; COUNT];
    for (i, slot) in out.iter_mut().enumerate() {
        *slot = score_at((COUNT - i) as f64 / COUNT as f64, &scores, truths);
    }
    out
}

/// Linear between the recalls that the sorted scores reach one after another.
fn score_at(recall: f64, scores: &[f64], truths: usize) -> f64 {
    let reached = |i: usize| (i + 1) as f64 / truths as f64;
    let Some(next) = (0..scores.len()).find(|&i| reached(i) >= recall) else { return 0.0 };
    if next == 0 {
        return scores[0];
    }
    let share = (recall - reached(next - 1)) / (reached(next) - reached(next - 1));
    scores[next - 1] + share * (scores[next] - scores[next - 1])
}
