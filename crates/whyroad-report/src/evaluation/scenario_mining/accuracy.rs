//! Balanced accuracy: is anything there at all, in this frame, in this log?

use super::sequence::{Frame, Sequence};

#[derive(Default)]
struct Table {
    right_yes: usize,
    wrong_no: usize,
    right_no: usize,
    wrong_yes: usize,
}

impl Table {
    fn count(&mut self, truth: bool, found: bool) {
        let cell = match (truth, found) {
            (true, true) => &mut self.right_yes,
            (true, false) => &mut self.wrong_no,
            (false, false) => &mut self.right_no,
            (false, true) => &mut self.wrong_yes,
        };
        *cell += 1;
    }

    fn balanced(&self) -> f64 {
        let rate = |part: usize, other: usize| {
            if part + other == 0 { 1.0 } else { part as f64 / (part + other) as f64 }
        };
        (rate(self.right_yes, self.wrong_no) + rate(self.right_no, self.wrong_yes)) / 2.0
    }
}

/// By timestamp and by log, of predictions with at least this score. `pairs` hold referred objects only.
pub fn balanced(pairs: &[(Sequence, Sequence)], least_score: f64) -> (f64, f64) {
    let (mut timestamps, mut logs) = (Table::default(), Table::default());
    for (t, p) in pairs {
        let frames: Vec<(Option<bool>, bool)> =
            t.frames.iter().zip(&p.frames).map(|(t, p)| (truth_of(t), is_found(p, least_score))).collect();
        if !frames.is_empty() && frames.iter().all(|(truth, _)| truth.is_none()) {
            continue;
        }
        for (truth, found) in &frames {
            if let Some(truth) = truth {
                timestamps.count(*truth, *found);
            }
        }
        logs.count(frames.iter().any(|f| f.0 == Some(true)), frames.iter().any(|f| f.1));
    }
    (timestamps.balanced(), logs.balanced())
}

/// `None` where it is undecided.
fn truth_of(frame: &Frame) -> Option<bool> {
    frame.is_positive.unwrap_or(Some(!frame.objects.is_empty()))
}

fn is_found(frame: &Frame, least_score: f64) -> bool {
    frame.is_positive == Some(Some(true)) || frame.objects.iter().any(|o| o.score >= least_score)
}
