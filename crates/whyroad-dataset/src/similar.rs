//! Episodes by the descriptors that near-duplicates are found by: how similar two moments are before anybody has
//! labelled them.

use crate::cut::{Cutter, Media};
use crate::{Spec, descriptor};
use std::collections::BTreeSet;
use whyroad_framework::Framework;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Drive, Lang, Nanos};

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
    let cutter = Cutter::new(&spec, (framework, Lang::default()), (drive, None), "", &media);
    let one = |(keyframe, target): (Nanos, BTreeSet<String>)| cutter.describe(keyframe, &target);
    let of = |e: &EpisodeRecord| {
        let target = e.target_id.iter().map(ToString::to_string).collect();
        one((e.keyframe.timestamp, target)).map(EpisodeDescriptor)
    };
    episodes.into_iter().map(of).collect()
}
