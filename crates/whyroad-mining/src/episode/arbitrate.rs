//! One primary class per decision (LABELING.md 1, MECE), by the order of `schema/precedence.yaml`.
//!
//! Episodes are taken from the most to the least preferred; each becomes primary unless one that is primary already
//! has its keyframe in the neighborhood. Only three kinds are dropped: an L2's episode that a leaf of the same L2
//! describes more precisely, a second match of one event, and a decision moment (`other`) that some class explains.

use super::{Episode, Rank};
use crate::interpret::CLOCK_TOLERANCE;
use crate::rule::Precedence;
use crate::rule::other::is_decision_moment;
use std::collections::BTreeMap;
use whyroad_model::messages::EgoResponse;
use whyroad_model::{FrameRange, Nanos, ScenarioId};

/// Drops episodes that a leaf describes better, joins those of one event, orders the rest by keyframe, and ranks it.
pub fn arbitrate(episodes: Vec<Episode>, times: &[Nanos], precedence: &Precedence) -> Vec<Episode> {
    let mut episodes = without_explained(without_resolved(episodes), times, precedence);
    episodes.sort_by(|a, b| {
        (a.keyframe, &a.scenario, &a.target, a.matched).cmp(&(b.keyframe, &b.scenario, &b.target, b.matched))
    });
    let mut episodes = joined(episodes);
    // The order of classes is a long list of names: each class is looked up once.
    let mut ranks: BTreeMap<&ScenarioId, usize> = BTreeMap::new();
    let rank = |e| *ranks.entry(e).or_insert_with(|| precedence.rank(e));
    let ranks: Vec<usize> = episodes.iter().map(|e| &e.scenario).map(rank).collect();
    let mut order: Vec<usize> = (0..episodes.len()).collect();
    order.sort_by(|&i, &j| {
        let (a, b) = (&episodes[i], &episodes[j]);
        ranks[i].cmp(&ranks[j]).then(b.score.total_cmp(&a.score)).then(i.cmp(&j))
    });
    // Ten frames of a jittering clock count as 1 s, whether slightly shorter or longer.
    let near = precedence.neighbourhood.0 - CLOCK_TOLERANCE.0;
    let mut primary: Vec<usize> = Vec::new();
    for i in order {
        let time = times[episodes[i].keyframe];
        let distance = |p: &usize| (times[episodes[*p].keyframe].0 - time.0).abs();
        let rival = primary.iter().copied().find(|p| distance(p) < near);
        match rival {
            Some(p) => episodes[i].rank = Rank::SecondaryTo(p),
            None => {
                episodes[i].rank = Rank::Primary;
                primary.push(i);
            }
        }
    }
    episodes
}

/// Matches of a rule with one target and one time range are one event that was interrupted: the first, in order of
/// keyframes, stands for it.
fn joined(episodes: Vec<Episode>) -> Vec<Episode> {
    let mut out: Vec<Episode> = Vec::with_capacity(episodes.len());
    for e in episodes {
        let same = |of: &&mut Episode| {
            (&of.scenario, &of.target, &of.roles, of.range) == (&e.scenario, &e.target, &e.roles, e.range)
        };
        match out.iter_mut().filter(|_| e.target.is_some()).find(same) {
            Some(first) => {
                first.matched = FrameRange::new(
                    first.matched.start.min(e.matched.start),
                    first.matched.end.max(e.matched.end),
                );
                if e.response == EgoResponse::Observed {
                    first.response = EgoResponse::Observed;
                }
            }
            None => out.push(e),
        }
    }
    out
}

/// The decision moments that no episode explains; an episode explains a moment near its keyframe or within its time
/// range. The first of several near moments represents all.
fn without_explained(episodes: Vec<Episode>, times: &[Nanos], precedence: &Precedence) -> Vec<Episode> {
    let (mut moments, mut out): (Vec<Episode>, Vec<Episode>) =
        episodes.into_iter().partition(is_decision_moment);
    moments.sort_by_key(|e| e.keyframe);
    let explained = |m: &Episode, e: &Episode| {
        let apart = (times[e.keyframe].0 - times[m.keyframe].0).abs();
        apart < precedence.neighbourhood.0 || (e.range.contains(m.keyframe) && !is_decision_moment(e))
    };
    for moment in moments {
        if !out.iter().any(|e| explained(&moment, e)) {
            out.push(moment);
        }
    }
    out
}

/// An L2's own rule means "this L2, variant unknown": where a leaf of it matched the same target at the
/// same time, the variant is known. An L2 about the ego alone (a lane change) may have a leaf about a target (the
/// vehicle overtaken): for any target, the variant is known.
fn without_resolved(episodes: Vec<Episode>) -> Vec<Episode> {
    let resolved = |e: &Episode| episodes.iter().any(|o| resolves(o, e));
    let keep: Vec<bool> = episodes.iter().map(|e| !resolved(e)).collect();
    episodes.into_iter().zip(keep).filter(|(_, k)| *k).map(|(e, _)| e).collect()
}

/// `leaf` is the variant of the L2's episode `e`.
pub(crate) fn resolves(leaf: &Episode, e: &Episode) -> bool {
    e.scenario.l3.is_none()
        && !leaf.matched.intersect(e.matched).is_empty()
        && leaf.scenario.is_leaf()
        && leaf.scenario.is_within(&e.scenario)
        && (e.target.is_none() || leaf.target == e.target)
}
