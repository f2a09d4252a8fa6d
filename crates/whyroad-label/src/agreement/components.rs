//! Matches the critical components of two labels: those that link the same object, else those of one category whose
//! descriptions are similar.

use std::collections::BTreeSet;
use whyroad_model::messages::CriticalComponent;

/// Minimum similarity of matching descriptions (share of common character pairs, Dice).
const ALIKE: f64 = 0.5;

/// Number of matching components of two labels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ComponentMatch {
    /// In both.
    pub common: usize,
    /// In the first.
    pub first: usize,
    /// In the second.
    pub second: usize,
}

impl ComponentMatch {
    /// F1 over all items: the harmonic mean of precision and recall, which does not depend on which label is taken as
    /// ground truth. `None` where neither has a component.
    pub fn f1(matches: &[Self]) -> Option<f64> {
        let sum = |of: fn(&Self) -> usize| matches.iter().map(of).sum::<usize>() as f64;
        let all = sum(|m| m.first) + sum(|m| m.second);
        (all > 0.0).then(|| 2.0 * sum(|m| m.common) / all)
    }
}

/// Pairs components one to one, the most similar first.
pub fn match_components(first: &[CriticalComponent], second: &[CriticalComponent]) -> ComponentMatch {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (i, a) in first.iter().enumerate() {
        for (j, b) in second.iter().enumerate() {
            let score = likeness(a, b);
            if score >= ALIKE {
                pairs.push((score, i, j));
            }
        }
    }
    pairs.sort_by(|x, y| y.0.total_cmp(&x.0).then_with(|| (x.1, x.2).cmp(&(y.1, y.2))));
    let (mut left, mut right, mut common) = (BTreeSet::new(), BTreeSet::new(), 0);
    for (_, i, j) in pairs {
        if !left.contains(&i) && !right.contains(&j) {
            left.insert(i);
            right.insert(j);
            common += 1;
        }
    }
    ComponentMatch { common, first: first.len(), second: second.len() }
}

/// 2 where both link one object; 0 where they link different objects or are of different categories; else the
/// similarity of their descriptions, 0 to 1.
fn likeness(a: &CriticalComponent, b: &CriticalComponent) -> f64 {
    if !a.linked_objects.is_empty() && !b.linked_objects.is_empty() {
        return if a.linked_objects.iter().any(|o| b.linked_objects.contains(o)) { 2.0 } else { 0.0 };
    }
    let differ = a.category.as_ref().zip(b.category.as_ref()).is_some_and(|(a, b)| a != b);
    if differ { 0.0 } else { dice(&a.description, &b.description) }
}

/// Share of common pairs of adjacent characters, without punctuation and case.
fn dice(a: &str, b: &str) -> f64 {
    let pairs = |text: &str| -> BTreeSet<(char, char)> {
        let chars: Vec<char> =
            text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect();
        chars.windows(2).map(|w| (w[0], w[1])).collect()
    };
    let (a, b) = (pairs(a), pairs(b));
    let all = a.len() + b.len();
    if all == 0 { 0.0 } else { 2.0 * a.intersection(&b).count() as f64 / all as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn component(description: &str, category: Option<&str>, objects: &[&str]) -> CriticalComponent {
        CriticalComponent {
            category: category.map(str::to_owned),
            description: description.to_owned(),
            uncertainty: None,
            id: None,
            evidence_times: Vec::new(),
            linked_objects: objects.iter().map(|o| (*o).to_owned()).collect(),
        }
    }

    #[test]
    fn objects_decide_and_words_where_there_are_none() {
        let a = [component("左前方的轿车正在并入", None, &["t1"]), component("前方路口为红灯", None, &[])];
        let b = [component("前方路口是红灯", None, &[]), component("银色小车压线", None, &["t1"])];
        let m = match_components(&a, &b);
        assert_eq!(m, ComponentMatch { common: 2, first: 2, second: 2 });
        assert_eq!(ComponentMatch::f1(&[m]), Some(1.0));
        // Another object with the same description is another component; so is another category.
        let other = [component("左前方的轿车正在并入", None, &["t2"])];
        assert_eq!(match_components(&a[..1], &other).common, 0);
        let (x, y) = (
            component("wet road", Some("road_events"), &[]),
            component("wet road", Some("odd_constraints"), &[]),
        );
        assert_eq!(match_components(&[x], &[y]).common, 0);
    }

    #[test]
    fn f1_is_twice_the_common_over_all() {
        // 2 + 1 common of 3 + 2 and 2 + 1: 2 x 3 / 8.
        let m = [
            ComponentMatch { common: 2, first: 3, second: 2 },
            ComponentMatch { common: 1, first: 2, second: 1 },
        ];
        assert_eq!(ComponentMatch::f1(&m), Some(0.75));
        assert_eq!(ComponentMatch::f1(&[ComponentMatch::default()]), None);
    }
}
