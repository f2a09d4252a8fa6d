//! Confident learning: the same steps, tolerances and rounding as cleanlab 2.9's `find_label_issues(labels,
//! pred_probs)` with its default filter `prune_by_noise_rate`. Equal numbers keep the order of the input; cleanlab
//! leaves that order to numpy's unstable sort, which differs between processors.

/// Maximum difference of two numbers that count as equal (cleanlab's `FLOATING_POINT_COMPARISON`).
const TOLERANCE: f64 = 1e-6;
/// Fewest samples of a class that are left (cleanlab's `min_examples_per_class`).
const KEPT_PER_CLASS: usize = 1;

/// The result.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelIssues {
    /// Per sample: probably wrong.
    pub mask: Vec<bool>,
    /// Indices of those, smallest probability of the given label first.
    pub ranked: Vec<usize>,
    /// Estimated counts, by given class and true class; sums to the number of samples.
    pub joint: Vec<Vec<usize>>,
}

/// Finds wrong labels. `labels` are class indices, `probabilities` one row per sample with one column per class.
pub fn find_label_issues(labels: &[usize], probabilities: &[Vec<f64>]) -> LabelIssues {
    let classes = probabilities.first().map_or(0, Vec::len);
    let joint = confident_joint(labels, probabilities, classes);
    let prune = prune_counts(&joint);
    let mut mask = vec![false; labels.len()];
    for given in 0..classes {
        let members: Vec<usize> = (0..labels.len()).filter(|i| labels[*i] == given).collect();
        if members.len() <= KEPT_PER_CLASS {
            continue;
        }
        for other in (0..classes).filter(|j| *j != given) {
            let margin = |i: usize| probabilities[i][other] - probabilities[i][given];
            let mut order = members.clone();
            order.sort_by(|a, b| margin(*b).total_cmp(&margin(*a)));
            order.iter().take(prune[other][given]).for_each(|i| mask[*i] = true);
        }
    }
    for (i, row) in probabilities.iter().enumerate() {
        let mut row = row.clone();
        row[labels[i]] += TOLERANCE;
        if greatest(&row) == labels[i] {
            mask[i] = false;
        }
    }
    let mut ranked: Vec<usize> = (0..labels.len()).filter(|i| mask[*i]).collect();
    ranked.sort_by(|a, b| probabilities[*a][labels[*a]].total_cmp(&probabilities[*b][labels[*b]]));
    LabelIssues { mask, ranked, joint }
}

/// Index of the greatest number, the first of equal ones.
pub fn greatest(row: &[f64]) -> usize {
    (0..row.len()).fold(0, |best, i| if row[i] > row[best] { i } else { best })
}

/// Counts of samples by given class and confidently predicted class, scaled to the number of samples per given class.
fn confident_joint(labels: &[usize], probabilities: &[Vec<f64>], classes: usize) -> Vec<Vec<usize>> {
    let mut counts = vec![0usize; classes];
    let mut own = vec![0.0; classes];
    for (label, row) in labels.iter().zip(probabilities) {
        counts[*label] += 1;
        own[*label] += row[*label];
    }
    // Mean probability of a class over the samples labeled as it; above any probability for a class without samples.
    let threshold =
        |k: usize| if counts[k] > 0 { (own[k] / counts[k] as f64).max(2.0 * TOLERANCE) } else { 2.0 };
    let thresholds: Vec<f64> = (0..classes).map(threshold).collect();
    let mut joint = vec![vec![0usize; classes]; classes];
    for (label, row) in labels.iter().zip(probabilities) {
        let confident: Vec<usize> = (0..classes).filter(|k| row[*k] >= thresholds[*k] - TOLERANCE).collect();
        match confident.as_slice() {
            [] => {}
            [one] => joint[*label][*one] += 1,
            _ => joint[*label][greatest(row)] += 1,
        }
    }
    for (k, row) in joint.iter_mut().enumerate() {
        row[k] = row[k].max(1);
    }
    let scaled: Vec<Vec<f64>> = joint
        .iter()
        .zip(&counts)
        .map(|(row, n)| {
            let sum: usize = row.iter().sum();
            row.iter().map(|v| *v as f64 / sum as f64 * *n as f64).collect()
        })
        .collect();
    // By true class, then given class: the order in which numpy adds them up.
    let by_column: Vec<f64> = (0..classes).flat_map(|k| scaled.iter().map(move |row| row[k])).collect();
    let total = pairwise_sum(&by_column);
    let total = if total > 0.0 { total } else { 1.0 };
    scaled
        .iter()
        .map(|row| {
            round_keeping_sum(&row.iter().map(|v| v / total * labels.len() as f64).collect::<Vec<_>>())
        })
        .collect()
}

/// How many samples to flag, by true class and given class; each class keeps [`KEPT_PER_CLASS`] samples.
fn prune_counts(joint: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let n = joint.len();
    let mut out = vec![vec![0; n]; n];
    for given in 0..n {
        let right = joint[given][given];
        let kept = right.max(KEPT_PER_CLASS);
        let rates = joint[given].iter().filter(|v| **v > 0).count().saturating_sub(1).max(1);
        let less = (kept - right) as f64 / rates as f64;
        for truth in 0..n {
            // Cut off, not rounded, as cleanlab converts to integers here.
            let pruned = (joint[given][truth] as f64 - less).max(0.0) as usize;
            out[truth][given] = if truth == given { kept } else { pruned };
        }
    }
    out
}

/// Rounds so that the sum is the rounded sum: the difference is applied to the numbers with the largest rounding.
fn round_keeping_sum(values: &[f64]) -> Vec<usize> {
    let mut whole: Vec<f64> = values.iter().map(|v| v.round_ties_even()).collect();
    let wanted = values.iter().sum::<f64>().round_ties_even();
    loop {
        let difference = (wanted - whole.iter().sum::<f64>()).round_ties_even();
        if difference.abs() < 0.5 {
            break;
        }
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|a, b| (values[*a] - whole[*a]).total_cmp(&(values[*b] - whole[*b])));
        let step = if difference < 0.0 { -1.0 } else { 1.0 };
        if step > 0.0 {
            order.reverse();
        }
        let changes = (difference.abs() as usize).min(values.len());
        order.iter().take(changes).for_each(|i| whole[*i] += step);
    }
    whole.into_iter().map(|v| v.max(0.0) as usize).collect()
}

/// The sum as numpy adds it: in eight lanes up to 128 numbers, else in halves. The last bit decides which number of a
/// row takes a rounding difference.
fn pairwise_sum(values: &[f64]) -> f64 {
    match values.len() {
        0..8 => values.iter().sum(),
        n @ 8..=128 => {
            let (lanes, rest) = values.split_at(n - n % 8);
            let mut r = [0.0; 8];
            lanes.chunks_exact(8).for_each(|c| r.iter_mut().zip(c).for_each(|(r, v)| *r += v));
            let sum = ((r[0] + r[1]) + (r[2] + r[3])) + ((r[4] + r[5]) + (r[6] + r[7]));
            rest.iter().fold(sum, |s, v| s + v)
        }
        n => {
            let half = n / 2 - n / 2 % 8;
            pairwise_sum(&values[..half]) + pairwise_sum(&values[half..])
        }
    }
}
