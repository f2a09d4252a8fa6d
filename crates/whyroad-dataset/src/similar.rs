//! Episodes by the descriptors used for near-duplicates: how similar two moments are before anybody has labeled them.

use crate::cut::{Cutter, Media};
use crate::{Spec, descriptor};
use std::collections::BTreeSet;
use whyroad_framework::Framework;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Drive, Nanos};

/// A moment as a short vector; [`Self::similarity`] compares two.
#[derive(Clone, Debug, PartialEq)]
pub struct EpisodeDescriptor(Vec<f32>);

impl EpisodeDescriptor {
    /// 1 for the same moment, towards 0 for a different one.
    pub fn similarity(&self, other: &Self) -> f64 {
        descriptor::similarity(descriptor::distance(&self.0, &other.0))
    }
}

/// Describes episodes of one drive: its map is prepared once. An episode whose keyframe has no pose has no descriptor.
pub fn describe<'e>(
    framework: &Framework,
    drive: &Drive,
    episodes: impl IntoIterator<Item = &'e EpisodeRecord>,
) -> Vec<Option<EpisodeDescriptor>> {
    let (spec, media) = (Spec::default(), Media::default());
    let cutter = Cutter::new(&spec, framework, (drive, None), "", &media);
    let one = |(keyframe, target): (Nanos, BTreeSet<String>)| cutter.describe(keyframe, &target);
    let of = |e: &EpisodeRecord| {
        let target = e.target_id.iter().map(ToString::to_string).collect();
        one((e.keyframe.timestamp, target)).map(EpisodeDescriptor)
    };
    episodes.into_iter().map(of).collect()
}

/// A group of moments that resemble one of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SimilarMoments {
    /// The one that most others resemble, by its index.
    pub center: usize,
    /// All of them, the center included, in their order.
    pub members: Vec<usize>,
}

/// Groups moments: the moment with the most remaining moments of at least this similarity is the center of the next
/// group; ties go to the first, so the result depends only on the order. A moment without a descriptor is a group of
/// one.
pub fn groups(moments: &[Option<EpisodeDescriptor>], similarity: f64) -> Vec<SimilarMoments> {
    let alike = |a: usize, b: usize| match (&moments[a], &moments[b]) {
        (Some(x), Some(y)) => x.similarity(y) >= similarity,
        _ => a == b,
    };
    let mut near: Vec<BTreeSet<usize>> =
        (0..moments.len()).map(|a| (0..moments.len()).filter(|&b| a == b || alike(a, b)).collect()).collect();
    let mut left: BTreeSet<usize> = (0..moments.len()).collect();
    let mut out = Vec::new();
    // Of equally many the first: `max_by_key` would give the last.
    while let Some(center) = left.iter().copied().rev().max_by_key(|&a| near[a].len()) {
        let members: Vec<usize> = near[center].iter().copied().collect();
        for member in &members {
            left.remove(member);
        }
        for of_other in &mut near {
            of_other.retain(|m| left.contains(m));
        }
        out.push(SimilarMoments { center, members });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f32) -> Option<EpisodeDescriptor> {
        Some(EpisodeDescriptor(vec![x]))
    }

    #[test]
    fn the_moment_that_most_resemble_is_the_center() {
        // Distances up to 0.5 have a similarity of 1 / 1.5 and more.
        let moments = [at(0.0), at(0.4), at(0.8), at(5.0), None, at(5.1)];
        let found = groups(&moments, 0.66);
        let plain: Vec<(usize, Vec<usize>)> = found.into_iter().map(|g| (g.center, g.members)).collect();
        assert_eq!(plain, [(1, vec![0, 1, 2]), (3, vec![3, 5]), (4, vec![4])]);
        assert_eq!(groups(&[], 0.5), []);
    }
}
