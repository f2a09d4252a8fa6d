//! The splits of an earlier release, which samples keep: by their id, and by every group key and place that they share
//! with a sample of it. A sample that shares them with two splits can be in neither, and is left out.

use crate::item::{Dropped, Item, Position, SplitName, Stage, id_text};
use crate::place::{self, Grid};
use crate::spec::{GroupKey, Split};
use crate::split::{Facts, value_of_sample};
use crate::{DatasetError, Release, Sample};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashMap};
use std::path::Path;
use whyroad_model::Bilingual;

/// Columns of the earlier release that are read.
const COLUMNS: &[&str] = &["sample_id", "split", "lineage", "groups"];

/// The earlier release; part of the manifest.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptSplits {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// SHA-256 of its manifest.
    pub manifest_sha256: String,
    /// Samples of this release that are in the split of the earlier one because they, their drive or their place were
    /// in it.
    pub samples: usize,
    /// Samples left out because they would join two splits of it.
    pub between: usize,
}

/// The splits of an earlier release.
#[derive(Clone, Debug)]
pub(crate) struct Keep {
    pub about: KeptSplits,
    by_id: HashMap<String, SplitName>,
    by_key: HashMap<(GroupKey, String), BTreeSet<SplitName>>,
    positions: Vec<(Position, SplitName)>,
    min_distance_m: Option<f64>,
}

impl Keep {
    /// Reads the release in `dir`, as the keys of `spec` group samples.
    pub fn read(dir: &Path, spec: &Split) -> Result<Self, DatasetError> {
        let release = Release::open(dir)?;
        let (_, sha256) = crate::freeze::checksums::sum(&dir.join(crate::freeze::MANIFEST))?;
        let mut out = Self {
            about: KeptSplits {
                name: release.manifest.name.clone(),
                version: release.manifest.version.clone(),
                manifest_sha256: sha256,
                ..KeptSplits::default()
            },
            by_id: HashMap::new(),
            by_key: HashMap::new(),
            positions: Vec::new(),
            min_distance_m: spec.by.contains(&GroupKey::Place).then_some(spec.min_distance_m),
        };
        for batch in release.batches(None, Some(COLUMNS)) {
            let samples = crate::sample::schema::from_batch(&batch?);
            for sample in samples.map_err(|e| DatasetError::broken(dir, e))? {
                let Some(split) = SplitName::of_name(&sample.split) else { continue };
                out.put(sample, split, spec);
            }
        }
        Ok(out)
    }

    fn put(&mut self, sample: Sample, split: SplitName, spec: &Split) {
        let position = place::of_sample(&sample);
        for key in spec.by.iter().chain([&GroupKey::Drive]) {
            // Cells are named after the grid: those of this spec count, not those that the earlier one had.
            let value = match key {
                GroupKey::Place => position.as_ref().map(|p| place::cell(p, spec)),
                _ => value_of_sample(&sample, *key),
            };
            if let Some(value) = value {
                self.by_key.entry((*key, value)).or_default().insert(split);
            }
        }
        self.positions.extend(position.map(|p| (p, split)));
        self.by_id.insert(sample.sample_id, split);
    }

    /// For each of `kept` the splits that it is tied to: one for a sample of the earlier release, none for one that
    /// shares nothing with it.
    pub fn ties(
        &self,
        items: &[Item],
        kept: &[usize],
        by: &[GroupKey],
        facts: Facts<'_>,
    ) -> Vec<BTreeSet<SplitName>> {
        let points: Vec<Option<&Position>> = self.positions.iter().map(|(p, _)| Some(p)).collect();
        let grid = self.min_distance_m.map(|edge| Grid::new(points, edge));
        kept.iter()
            .map(|&i| {
                let item = &items[i];
                if let Some(split) = self.by_id.get(&id_text(item.id)) {
                    return BTreeSet::from([*split]);
                }
                let mut out = BTreeSet::new();
                for key in by.iter().chain([&GroupKey::Drive]) {
                    if let Some(value) = facts.value(item, *key) {
                        out.extend(self.by_key.get(&(*key, value)).into_iter().flatten());
                    }
                }
                if let (Some(grid), Some(at)) = (&grid, item.cut.as_ref().and_then(|c| c.position.as_ref())) {
                    grid.near(at, |o| {
                        out.insert(self.positions[o as usize].1);
                        true
                    });
                }
                out
            })
            .collect()
    }

    /// Whether the earlier release has the sample.
    pub fn has(&self, item: &Item) -> bool {
        self.by_id.contains_key(&id_text(item.id))
    }
}

/// Leaves out a sample that would join two splits of the earlier release.
pub(crate) fn leave_out(item: &mut Item) {
    item.dropped = Some(Dropped::with(
        Stage::Split,
        "between_kept",
        "it shares a group or a place with two splits of the earlier release",
    ));
}

/// Groups of this spec that the earlier release has in two splits.
pub(crate) fn torn(dir: &Path, n: usize, first: &str) -> DatasetError {
    let message = Bilingual::new(
        format!(
            "split.keep：{} 的划分不符合 split.by：{n} 个分组的样本分属两个划分，例如样本 {first}",
            dir.display()
        ),
        format!(
            "split.keep: the splits of {} do not hold for split.by: {n} groups have samples in two of them, for example \
             sample {first}",
            dir.display()
        ),
    );
    let hint = Bilingual::new(
        "用该数据集的 split.by、place_cell_m 与 min_distance_m，或去掉 split.keep",
        "use split.by, place_cell_m and min_distance_m of that release, or unset split.keep",
    );
    DatasetError::Refused(vec![
        whyroad_model::Diagnostic::error("dataset.split.keep", message).with_hint(hint),
    ])
}
