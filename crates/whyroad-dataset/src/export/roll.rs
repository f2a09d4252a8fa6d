//! Samples of a split in files of equal size, give or take one: the release knows how many there are.

use crate::freeze::shards::{Shard, shards};
use crate::item::SplitName;
use crate::{DatasetError, Release};
use std::collections::BTreeMap;

/// Where the next sample of each split goes.
pub(super) struct Roll {
    totals: BTreeMap<String, usize>,
    per_file: usize,
    done: BTreeMap<&'static str, usize>,
}

/// A file that begins.
pub(super) struct Start {
    /// Its number within the split, from 0.
    pub number: usize,
    /// Its name and samples.
    pub shard: Shard,
}

impl Roll {
    /// Files of at most `per_file` samples.
    pub fn new(release: &Release, per_file: usize) -> Self {
        Self { totals: release.manifest.counts.by_split.clone(), per_file, done: BTreeMap::new() }
    }

    /// Counts a sample; gives the file that begins with it.
    pub fn next(&mut self, split: SplitName) -> Result<Option<Start>, DatasetError> {
        let total = self.totals.get(split.name()).copied().unwrap_or(0);
        let done = self.done.entry(split.name()).or_default();
        if *done >= total {
            let fault = "the release has more samples than its manifest says";
            return Err(DatasetError::broken(std::path::Path::new(split.name()), fault));
        }
        let mut plan = shards(split.name(), total, self.per_file).into_iter().enumerate();
        let start = plan.find(|(_, s)| s.range.start == *done).map(|(number, shard)| Start { number, shard });
        *done += 1;
        Ok(start)
    }
}
