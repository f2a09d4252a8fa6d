//! Agreement of the labels of the same episodes: class, decisions, keyframe, components, each with an interval.

use super::pairing::{Item, moment, seconds_in_clip};
use super::{
    ComponentMatch, Estimate, alpha_interval, alpha_nominal, bootstrap, cohen_pooled, match_components,
    median,
};
use serde::Serialize;
use std::collections::BTreeSet;
use whyroad_model::messages::CocLabel;

/// Maximum distance of keyframes that count as the same moment, s.
const SAME_MOMENT_S: f64 = 0.5;

/// Agreement on one categorical part of a label.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NominalAgreement {
    /// Which part.
    pub part: &'static str,
    /// Number of episodes.
    pub episodes: usize,
    /// Share of pairs of raters with the same value.
    pub same: Estimate,
    /// Cohen's kappa over pairs of raters ([`cohen_pooled`]).
    pub kappa: Estimate,
    /// Krippendorff's alpha.
    pub alpha: Estimate,
}

/// Agreement on the keyframe.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeyframeAgreement {
    /// Median distance of pairs, s.
    pub median_s: Estimate,
    /// Share of pairs at most 0.5 s apart.
    pub within_half_second: Estimate,
    /// Krippendorff's alpha of the moment within the clip.
    pub alpha: Estimate,
}

/// Agreement on critical components.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComponentAgreement {
    /// Over all pairs of labels: components of the first, of the second, and of both. Of an episode with three labels a
    /// component is in two pairs.
    pub counts: [usize; 3],
    /// F1 over all pairs of labels of all episodes.
    pub f1: Estimate,
}

/// Agreement on all parts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Episodes with two or more labels.
    pub episodes: usize,
    /// Raters, sorted.
    pub raters: Vec<String>,
    /// Class, L2, decisions.
    pub parts: Vec<NominalAgreement>,
    /// Keyframe.
    pub keyframe: KeyframeAgreement,
    /// Components.
    pub components: ComponentAgreement,
}

/// A part of a label as a category.
type Part = fn(&CocLabel) -> String;

const PARTS: [(&str, Part); 5] = [
    ("class", |l| format!("{}.{}.{}", l.scenario.l1, l.scenario.l2, l.scenario.l3.as_deref().unwrap_or("-"))),
    ("l2", |l| format!("{}.{}", l.scenario.l1, l.scenario.l2)),
    ("longitudinal", |l| l.driving_decision.longitudinal.map_or("null", |d| d.id()).to_owned()),
    ("lateral", |l| l.driving_decision.lateral.map_or("null", |d| d.id()).to_owned()),
    ("lateral_direction", |l| l.driving_decision.lateral_direction.map_or("null", |d| d.id()).to_owned()),
];

/// Compares the labels of each item. `seed` is the seed of the intervals.
pub fn agreement(items: &[Item], seed: u64) -> Agreement {
    let raters: BTreeSet<&str> = items.iter().flat_map(|i| &i.labels).map(|l| l.rater.as_str()).collect();
    let parts = PARTS.iter().map(|(name, part)| nominal(name, *part, items, seed)).collect();
    let gaps: Vec<Vec<f64>> =
        items.iter().map(|i| pairs(i, moment, |a, b| a.seconds_since(*b).abs())).collect();
    let moments: Vec<Vec<f64>> =
        items.iter().map(|i| i.labels.iter().map(|l| seconds_in_clip(&l.label)).collect()).collect();
    let components = |l: &CocLabel| l.critical_components.clone();
    let matches: Vec<Vec<ComponentMatch>> =
        items.iter().map(|i| pairs(i, components, |a, b| match_components(a, b))).collect();
    let sum = |of: fn(&ComponentMatch) -> usize| matches.iter().flatten().map(of).sum();
    Agreement {
        episodes: items.len(),
        raters: raters.into_iter().map(str::to_owned).collect(),
        parts,
        keyframe: KeyframeAgreement {
            median_s: bootstrap(&gaps, seed, |g| median(g.concat())),
            within_half_second: bootstrap(&gaps, seed, |g| {
                share(&g.concat(), |s| *s <= SAME_MOMENT_S + 1e-9)
            }),
            alpha: bootstrap(&moments, seed, alpha_interval),
        },
        components: ComponentAgreement {
            counts: [sum(|m| m.first), sum(|m| m.second), sum(|m| m.common)],
            f1: bootstrap(&matches, seed, |m| ComponentMatch::f1(&m.concat())),
        },
    }
}

fn nominal(part: &'static str, of: Part, items: &[Item], seed: u64) -> NominalAgreement {
    let units: Vec<Vec<(String, String)>> =
        items.iter().map(|i| i.labels.iter().map(|l| (l.rater.clone(), of(&l.label))).collect()).collect();
    NominalAgreement { part, episodes: units.len(), ..nominal_agreement(part, &units, seed) }
}

/// Raters and values of a unit, two by two.
fn two_by_two(units: &[Vec<(String, String)>]) -> Vec<(Rating<'_>, Rating<'_>)> {
    let mut out = Vec::new();
    for unit in units {
        for (i, a) in unit.iter().enumerate() {
            out.extend(unit[i + 1..].iter().map(|b| (rating(a), rating(b))));
        }
    }
    out
}

/// A rater and a value.
type Rating<'u> = (&'u str, &'u str);

fn rating((rater, value): &(String, String)) -> Rating<'_> {
    (rater, value)
}

/// Agreement on categories; each unit has its raters with their values.
pub(crate) fn nominal_agreement(
    part: &'static str,
    units: &[Vec<(String, String)>],
    seed: u64,
) -> NominalAgreement {
    let values: Vec<Vec<&str>> = units.iter().map(|u| u.iter().map(|(_, v)| v.as_str()).collect()).collect();
    NominalAgreement {
        part,
        episodes: units.len(),
        same: bootstrap(units, seed, |u| share(&two_by_two(u), |(a, b)| a.1 == b.1)),
        kappa: bootstrap(units, seed, |u| cohen_pooled(&two_by_two(u))),
        alpha: bootstrap(&values, seed, alpha_nominal),
    }
}

fn share<T>(all: &[T], which: impl Fn(&T) -> bool) -> Option<f64> {
    (!all.is_empty()).then(|| all.iter().filter(|t| which(t)).count() as f64 / all.len() as f64)
}

/// One value per pair of raters of an item.
fn pairs<V, R>(item: &Item, of: impl Fn(&CocLabel) -> V, value: impl Fn(&V, &V) -> R) -> Vec<R> {
    let all: Vec<V> = item.labels.iter().map(|l| of(&l.label)).collect();
    let mut out = Vec::new();
    for (i, a) in all.iter().enumerate() {
        out.extend(all[i + 1..].iter().map(|b| value(a, b)));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agreement::RatedLabel;

    #[test]
    fn kappa_and_alpha_are_those_of_the_libraries() {
        // scikit-learn 1.9.1, cohen_kappa_score(A, B); krippendorff 0.9.0, level_of_measurement="nominal".
        const A: &str = "y y f n s s f y n n r f s y n f y r s n";
        const B: &str = "y f f n s n f y n y r f s y n n y f s n";
        let rated = |rater: &str, value: &str| (rater.to_owned(), value.to_owned());
        let units: Vec<Vec<(String, String)>> =
            A.split(' ').zip(B.split(' ')).map(|(a, b)| vec![rated("a", a), rated("b", b)]).collect();
        let of = nominal_agreement("x", &units, 7);
        assert!((of.kappa.value.unwrap() - 0.678_456_591_639_871_4).abs() < 1e-12, "{of:?}");
        assert!((of.alpha.value.unwrap() - 0.685_483_870_967_742).abs() < 1e-12, "{of:?}");
        assert!((of.same.value.unwrap() - 0.75).abs() < 1e-12);
        for e in [of.same, of.kappa, of.alpha] {
            assert!(e.low.unwrap() < e.value.unwrap() && e.value.unwrap() < e.high.unwrap(), "{e:?}");
        }
    }

    /// Three labels of one episode, of which one names other objects than the two that agree: of three pairs one
    /// agrees. By hand: 2 components in each label, 6 and 6 over the pairs, 2 in common; F1 = 2 x 2 / 12.
    #[test]
    fn components_are_compared_over_all_pairs_whoever_differs() {
        let text = include_str!("../../../../examples/cutin_urgent_example.json");
        let example: CocLabel = serde_json::from_str(text).unwrap();
        let label = |objects: [&str; 2]| {
            let mut label = example.clone();
            let one = label.critical_components[0].clone();
            label.critical_components = objects
                .iter()
                .map(|o| {
                    let mut c = one.clone();
                    c.linked_objects = vec![(*o).to_owned()];
                    c
                })
                .collect();
            label
        };
        for odd in 0..3 {
            let labels = ["ann", "bo", "cai"].iter().enumerate().map(|(i, rater)| RatedLabel {
                rater: (*rater).to_owned(),
                label: label(if i == odd { ["x", "y"] } else { ["t1", "t2"] }),
            });
            let items = [Item { id: "e1".to_owned(), labels: labels.collect() }];
            let of = agreement(&items, 1).components;
            assert_eq!(of.counts, [6, 6, 2], "{odd}");
            assert!((of.f1.value.unwrap() - 1.0 / 3.0).abs() < 1e-12, "{odd}: {of:?}");
        }
    }
}
