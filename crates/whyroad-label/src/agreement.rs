//! Agreement of raters beyond chance. The coefficients are pure functions over categories and numbers; [`pairing`]
//! finds the labels of one episode by several people, [`measure`] compares them part by part, with intervals.
//!
//! Sources: J. Cohen, "A coefficient of agreement for nominal scales", Educational and Psychological Measurement 20
//! (1960); J. L. Fleiss, "Measuring nominal scale agreement among many raters", Psychological Bulletin 76 (1971).

mod alpha;
mod components;
mod interval;
mod measure;
mod pairing;

pub use alpha::{alpha_interval, alpha_nominal};
pub use components::{ComponentMatch, match_components};
pub use interval::{Estimate, bootstrap};
pub use measure::{Agreement, ComponentAgreement, KeyframeAgreement, NominalAgreement, agreement};
pub use pairing::{Item, Judged, RatedLabel, pair_files, pair_tasks};

use std::collections::BTreeMap;

/// Cohen's kappa of pairs (first rater, second rater). `None` without pairs, and where agreement by chance is certain
/// (both raters used only one and the same category), because agreement beyond chance is not defined then.
pub fn cohen<C: Ord>(pairs: &[(C, C)]) -> Option<f64> {
    let (seen, chance) = agreements(pairs);
    beyond_chance(seen, chance)
}

/// Fleiss' kappa of items that were each put into a category by two or more raters, who may differ from item to item.
/// Items may have different numbers of raters; an item counts by its number of ratings. `None` as for [`cohen`].
pub fn fleiss<C: Ord>(items: &[Vec<C>]) -> Option<f64> {
    let (mut total, mut agreed) = (0.0, 0.0);
    let mut shares: BTreeMap<&C, f64> = BTreeMap::new();
    for item in items.iter().filter(|i| i.len() > 1) {
        let n = item.len() as f64;
        let mut own: BTreeMap<&C, f64> = BTreeMap::new();
        for category in item {
            *own.entry(category).or_default() += 1.0;
            *shares.entry(category).or_default() += 1.0;
        }
        let pairs: f64 = own.values().map(|k| k * (k - 1.0)).sum();
        agreed += n * pairs / (n * (n - 1.0));
        total += n;
    }
    let chance: f64 = shares.values().map(|k| (k / total) * (k / total)).sum();
    beyond_chance(agreed / total, chance)
}

/// Two values, each with who gave it.
pub type RatedPair<R, C> = ((R, C), (R, C));

/// Cohen's kappa over pairs of labels of several people: the observed agreement of all pairs, against the agreement by
/// chance that each pair of people has from their own margins, weighted by their number of labels (H. De Vries et al.,
/// "Using pooled kappa to summarize interrater agreement across many items", Field Methods 20, 2008). For two people it
/// is [`cohen`]. Unlike kappa of one table of all pairs it does not depend on which of a pair comes first.
pub fn cohen_pooled<R: Ord, C: Ord>(pairs: &[RatedPair<R, C>]) -> Option<f64> {
    let mut tables: BTreeMap<(&R, &R), Vec<(&C, &C)>> = BTreeMap::new();
    for ((one, a), (other, b)) in pairs {
        let (people, values) = if one <= other { ((one, other), (a, b)) } else { ((other, one), (b, a)) };
        tables.entry(people).or_default().push(values);
    }
    let (mut seen, mut chance) = (0.0, 0.0);
    for table in tables.values() {
        let of_table = agreements(table);
        seen += of_table.0 * table.len() as f64;
        chance += of_table.1 * table.len() as f64;
    }
    let n = pairs.len() as f64;
    beyond_chance(seen / n, chance / n)
}

/// Observed agreement of pairs, and agreement by chance.
fn agreements<C: Ord>(pairs: &[(C, C)]) -> (f64, f64) {
    let n = pairs.len() as f64;
    let mut margins: BTreeMap<&C, (f64, f64)> = BTreeMap::new();
    for (a, b) in pairs {
        margins.entry(a).or_default().0 += 1.0;
        margins.entry(b).or_default().1 += 1.0;
    }
    let seen = pairs.iter().filter(|(a, b)| a == b).count() as f64 / n;
    (seen, margins.values().map(|(a, b)| a * b / (n * n)).sum())
}

fn beyond_chance(seen: f64, chance: f64) -> Option<f64> {
    let room = 1.0 - chance;
    (seen.is_finite() && room > 1e-12).then(|| (seen - chance) / room)
}

/// The median; the mean of the two middle values of an even number. `None` of an empty list.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        n if n % 2 == 1 => Some(values[middle]),
        _ => Some(f64::midpoint(values[middle - 1], values[middle])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(cells: [((&'static str, &'static str), usize); 4]) -> Vec<(&'static str, &'static str)> {
        cells.iter().flat_map(|(pair, n)| std::iter::repeat_n(*pair, *n)).collect()
    }

    /// docs/reference/service.md, *Workflow*: a label is submitted at the end of Stage II; before, and where the task
    /// was skipped, there is none. Such a task is no broken line.
    #[test]
    fn tasks_without_a_submission_are_counted_apart() {
        let task = |state: &str| serde_json::json!({ "task": { "id": "t", "state": state, "draft": {}, "history": [] } });
        let mut lines: Vec<serde_json::Value> =
            ["open", "stage1", "stage1_locked", "stage2", "skipped", "rejected"].map(task).into();
        let judged = pair_tasks(&lines);
        assert_eq!(
            (judged.waiting, judged.left_out),
            (4, 2),
            "nobody will submit what was skipped or rejected"
        );
        assert_eq!((judged.unreadable, judged.unmatched), (0, 0));
        lines.push(task("submitted"));
        assert_eq!(pair_tasks(&lines).unreadable, 1, "a submitted task without a label");
    }

    #[test]
    fn cohen_is_that_of_the_textbook_tables() {
        // Wikipedia, "Cohen's kappa", simple example (20, 5, 10, 15: 0.4) and the two tables of "same percentage but
        // different numbers" (0.1304 and 0.2593).
        let yes_no = |yy, yn, ny, nn| {
            cohen(&table([(("y", "y"), yy), (("y", "n"), yn), (("n", "y"), ny), (("n", "n"), nn)])).unwrap()
        };
        assert!((yes_no(20, 5, 10, 15) - 0.4).abs() < 1e-12);
        assert!((yes_no(45, 15, 25, 15) - 0.1304).abs() < 5e-5);
        assert!((yes_no(25, 35, 5, 35) - 0.2593).abs() < 5e-5);
    }

    /// By hand from two of the tables above: observed (35 + 60) / 150, by chance (25 + 54) / 150.
    #[test]
    fn pooled_kappa_depends_on_no_order() {
        let of = |people: (&'static str, &'static str), pairs: Vec<(&'static str, &'static str)>| -> Vec<_> {
            pairs.into_iter().map(|(a, b)| ((people.0, a), (people.1, b))).collect()
        };
        let one = table([(("y", "y"), 20), (("y", "n"), 5), (("n", "y"), 10), (("n", "n"), 15)]);
        let other = table([(("y", "y"), 45), (("y", "n"), 15), (("n", "y"), 25), (("n", "n"), 15)]);
        let alone = of(("ann", "bo"), one.clone());
        assert_eq!(cohen_pooled(&alone), cohen(&one));
        let all = [alone, of(("ann", "cai"), other)].concat();
        let expected = (95.0 - 79.0) / (150.0 - 79.0);
        assert!((cohen_pooled(&all).unwrap() - expected).abs() < 1e-12);
        let turned: Vec<_> =
            all.iter().enumerate().map(|(i, (a, b))| if i % 3 == 0 { (*b, *a) } else { (*a, *b) }).collect();
        assert!((cohen_pooled(&turned).unwrap() - expected).abs() < 1e-12);
        assert_eq!(cohen_pooled::<u8, u8>(&[]), None);
    }

    #[test]
    fn fleiss_is_that_of_the_worked_example() {
        // Wikipedia, "Fleiss' kappa", worked example: ten subjects, fourteen raters, five categories: 0.210.
        const COUNTS: [[usize; 5]; 10] = [
            [0, 0, 0, 0, 14],
            [0, 2, 6, 4, 2],
            [0, 0, 3, 5, 6],
            [0, 3, 9, 2, 0],
            [2, 2, 8, 1, 1],
            [7, 7, 0, 0, 0],
            [3, 2, 6, 3, 0],
            [2, 5, 3, 2, 2],
            [6, 5, 2, 1, 0],
            [0, 2, 2, 3, 7],
        ];
        let item = |row: &[usize; 5]| -> Vec<usize> {
            row.iter().enumerate().flat_map(|(category, n)| std::iter::repeat_n(category, *n)).collect()
        };
        let items: Vec<Vec<usize>> = COUNTS.iter().map(item).collect();
        assert!((fleiss(&items).unwrap() - 0.210).abs() < 5e-4);
    }

    #[test]
    fn agreement_that_chance_explains_has_no_kappa() {
        assert_eq!(cohen::<u8>(&[]), None);
        assert_eq!(cohen(&[("a", "a"), ("a", "a")]), None);
        assert_eq!(fleiss(&[vec!["a", "a"], vec!["b"]]), None);
        assert_eq!(cohen(&[("a", "a"), ("b", "b")]), Some(1.0));
        assert_eq!(cohen(&[("a", "b"), ("b", "a")]), Some(-1.0));
    }

    #[test]
    fn the_median_is_the_middle() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }
}
