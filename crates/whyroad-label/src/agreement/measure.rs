//! Agreement of the labels of the same episodes: class, decisions, keyframe, components, each with an interval.

use super::pairing::{Item, moment, seconds_in_clip};
use super::{ComponentMatch, Estimate, alpha_interval, alpha_nominal, bootstrap, cohen, median};
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
    /// Cohen's kappa over pairs of raters.
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
    /// Components of the first and of the second rater, and of both.
    pub counts: [usize; 3],
    /// F1 over all components.
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
    let matches: Vec<ComponentMatch> = items.iter().filter_map(Item::components).collect();
    let sum = |of: fn(&ComponentMatch) -> usize| matches.iter().map(of).sum();
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
            f1: bootstrap(&matches, seed, ComponentMatch::f1),
        },
    }
}

fn nominal(part: &'static str, of: Part, items: &[Item], seed: u64) -> NominalAgreement {
    let units: Vec<Vec<String>> =
        items.iter().map(|i| i.labels.iter().map(|l| of(&l.label)).collect()).collect();
    NominalAgreement { part, episodes: units.len(), ..nominal_agreement(part, &units, seed) }
}

/// Agreement on categories; each unit has the values of its raters, who are in the same order in every unit.
pub(crate) fn nominal_agreement(part: &'static str, units: &[Vec<String>], seed: u64) -> NominalAgreement {
    let both = |units: &[Vec<String>]| -> Vec<(String, String)> {
        let all = units.iter().flat_map(|u| {
            (0..u.len()).flat_map(move |i| (i + 1..u.len()).map(move |j| (u[i].clone(), u[j].clone())))
        });
        all.collect()
    };
    NominalAgreement {
        part,
        episodes: units.len(),
        same: bootstrap(units, seed, |u| share(&both(u), |(a, b)| a == b)),
        kappa: bootstrap(units, seed, |u| cohen(&both(u))),
        alpha: bootstrap(units, seed, alpha_nominal),
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

    #[test]
    fn kappa_and_alpha_are_those_of_the_libraries() {
        // scikit-learn 1.9.1, cohen_kappa_score(A, B); krippendorff 0.9.0, level_of_measurement="nominal".
        const A: &str = "y y f n s s f y n n r f s y n f y r s n";
        const B: &str = "y f f n s n f y n y r f s y n n y f s n";
        let units: Vec<Vec<String>> =
            A.split(' ').zip(B.split(' ')).map(|(a, b)| vec![a.to_owned(), b.to_owned()]).collect();
        let of = nominal_agreement("x", &units, 7);
        assert!((of.kappa.value.unwrap() - 0.678_456_591_639_871_4).abs() < 1e-12, "{of:?}");
        assert!((of.alpha.value.unwrap() - 0.685_483_870_967_742).abs() < 1e-12, "{of:?}");
        assert!((of.same.value.unwrap() - 0.75).abs() < 1e-12);
        for e in [of.same, of.kappa, of.alpha] {
            assert!(e.low.unwrap() < e.value.unwrap() && e.value.unwrap() < e.high.unwrap(), "{e:?}");
        }
    }
}
