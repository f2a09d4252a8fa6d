//! Thresholds of numbers that have standard deviations. A comparison by `<`, `<=`, `>` or `>=` changes its answer only
//! where the two sides differ by more than the deviation of their difference; within it the answer of the previous row
//! is kept, unless [`ROWS_ACROSS`] rows in succession contradict it. A new answer holds from the first of the rows in
//! succession that contradict the old one: there the threshold was crossed, and noise only delays the proof. Without
//! deviations each row is compared by itself.
//!
//! Here are the rules by which deviations combine, and the plain definition of such a comparison; both evaluators use
//! the first, the reference also the second.

use crate::comparison::compare;
use crate::language::syntax::CompareOp;
use whyroad_model::Tri;

/// Rows in succession on the other side of a threshold, however near, that change the answer: 2 s at 10 Hz. Errors that
/// are correlated over 1 s rarely keep their sign for longer; without this, one sample decides for the rest of a drive
/// on a slow deceleration or on a speed just below a limit.
pub(crate) const ROWS_ACROSS: usize = 20;

/// Of a sum or difference of independent numbers.
pub(crate) fn of_sum(a: f64, b: f64) -> f64 {
    let (a, b) = (stated(a), stated(b));
    // Many numbers are exact, and a root is slow; the hypotenuse of one side is that side.
    if a == 0.0 {
        b
    } else if b == 0.0 {
        a
    } else {
        a.hypot(b)
    }
}

/// Of a product of independent numbers, each with its deviation.
pub(crate) fn of_product((a, of_a): (f64, f64), (b, of_b): (f64, f64)) -> f64 {
    of_sum(a * stated(of_b), b * stated(of_a))
}

/// An unknown deviation counts as zero.
pub(crate) fn stated(deviation: f64) -> f64 {
    if deviation.is_finite() { deviation.abs() } else { 0.0 }
}

/// True for the operators that have a threshold.
pub(crate) fn has_threshold(op: CompareOp) -> bool {
    !matches!(op, CompareOp::Equal | CompareOp::NotEqual)
}

/// Truth of a comparison row by row. The first known row, and the first after an unknown one, is compared by itself.
pub(crate) fn crossed(op: CompareOp, a: &[f64], b: &[f64], deviation: &[f64]) -> Vec<Tri> {
    let mut before = Tri::Unknown;
    let mut across = 0;
    let mut out = Vec::with_capacity(a.len());
    for ((a, b), deviation) in a.iter().zip(b).zip(deviation) {
        let plain = compare(op, *a, *b, 1.0).0;
        let noise = stated(*deviation);
        let within = noise > 0.0 && (a - b).abs() <= noise;
        if plain == Tri::Unknown || before == Tri::Unknown || plain == before {
            before = plain;
            across = 0;
        } else if within && across + 1 < ROWS_ACROSS {
            across += 1;
        } else {
            let first = out.len() - across;
            out[first..].fill(plain);
            before = plain;
            across = 0;
        }
        out.push(before);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use Tri::{False, True, Unknown};

    #[test]
    fn a_threshold_is_crossed_by_more_than_the_noise() {
        let a = [1.0, 2.05, 2.2, 2.05, 1.95, 1.85, 1.95];
        let above = |sd: f64| crossed(CompareOp::Greater, &a, &[2.0; 7], &[sd; 7]);
        // By hand: with 0.1, 2.05 and 1.95 prove nothing, 2.2 and 1.85 do, back to the row before them.
        assert_eq!(above(0.1), [False, True, True, True, False, False, False]);
        let swings = [1.0, 2.05, 1.95, 2.05, 2.2, 1.95, 2.05, 2.2];
        let found = crossed(CompareOp::Greater, &swings, &[2.0; 8], &[0.1; 8]);
        assert_eq!(found, [False, False, False, True, True, True, True, True], "from the last crossing");
        assert_eq!(above(0.0), [False, True, True, True, False, False, False], "without noise as ever");
        assert_eq!(above(f64::NAN), above(0.0), "a deviation that is not known counts as none");
        let below = crossed(CompareOp::LessOrEqual, &a, &[2.0; 7], &[0.1; 7]);
        assert!(below.iter().zip(above(0.1)).all(|(b, a)| *b == !a), "the negation is the other operator");
    }

    #[test]
    fn two_seconds_on_the_other_side_change_the_answer() {
        // By hand: 1.9 is below, 2.05 within the noise of 2.0. 19 rows of it are not enough, the twentieth is.
        let at = |k: usize, rows: usize| std::iter::repeat_n([1.9, 2.05, 1.95][k], rows);
        let found = |values: Vec<f64>| {
            let n = values.len();
            crossed(CompareOp::Greater, &values, &vec![2.0; n], &vec![0.1; n])
        };
        let stays = found(at(0, 1).chain(at(1, 19)).chain(at(2, 1)).chain(at(1, 19)).collect());
        assert!(stays.iter().all(|t| *t == False), "one row on the old side begins the count again");
        let changes = found(at(0, 1).chain(at(1, 20)).chain(at(2, 1)).collect());
        assert_eq!(changes[..2], [False, True], "from the first row of the twenty");
        assert!(changes[1..].iter().all(|t| *t == True), "the new answer is kept like any other");
    }

    #[test]
    fn what_is_not_known_ends_the_memory() {
        let a = [3.0, 1.95, f64::NAN, 1.95, 3.0];
        let found = crossed(CompareOp::Greater, &a, &[2.0; 5], &[0.1; 5]);
        assert_eq!(found, [True, True, Unknown, False, True]);
    }

    #[test]
    fn deviations_combine_as_of_independent_numbers() {
        assert!((of_sum(3.0, 4.0) - 5.0).abs() < 1e-12);
        assert!((of_product((2.0, 0.3), (5.0, 0.4)) - (0.8f64).hypot(1.5)).abs() < 1e-12);
        assert_eq!(of_product((f64::INFINITY, 0.0), (5.0, 0.0)), 0.0);
    }
}
