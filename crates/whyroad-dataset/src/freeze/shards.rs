//! The samples' files: shuffled once by the seed, so that any part of a file is a random sample of its split; the files
//! of a split differ by at most one sample.

use super::tables::properties;
use crate::DatasetError;
use crate::sample::Sample;
use crate::sample::schema::{schema, to_batch};
use parquet::arrow::ArrowWriter;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// Rows per row group: the minimum that a reader holds, and the maximum for a writer. Fewer with images.
pub(crate) const ROWS: usize = 256;
/// Rows of a row group of samples with images.
pub(crate) const ROWS_WITH_IMAGES: usize = 32;

/// A file and the positions of its samples in the shuffled order of their split.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shard {
    pub name: String,
    pub range: std::ops::Range<usize>,
}

/// Equal parts of `n` samples, at most `per_shard` each.
pub(crate) fn shards(split: &str, n: usize, per_shard: usize) -> Vec<Shard> {
    let count = n.div_ceil(per_shard.max(1));
    (0..count)
        .map(|i| Shard {
            name: format!("{split}-{i:05}-of-{count:05}.parquet"),
            range: n * i / count..n * (i + 1) / count,
        })
        .collect()
}

/// Writes one file, reading each sample when it is needed.
pub(crate) fn write(
    path: &Path,
    rows_per_group: usize,
    samples: impl Iterator<Item = Result<Sample, DatasetError>>,
) -> Result<(), DatasetError> {
    let broken = |e: &dyn std::fmt::Display| DatasetError::broken(path, e);
    let aside = path.with_extension("writing");
    let file = File::create(&aside).map_err(DatasetError::io(&aside))?;
    let mut writer = ArrowWriter::try_new(file, Arc::new(schema()), Some(properties(rows_per_group)))
        .map_err(|e| broken(&e))?;
    let mut waiting = Vec::with_capacity(rows_per_group);
    let flush = |waiting: &mut Vec<Sample>, writer: &mut ArrowWriter<File>| -> Result<(), DatasetError> {
        let batch = to_batch(waiting).map_err(|e| broken(&e))?;
        waiting.clear();
        writer.write(&batch).and_then(|()| writer.flush()).map_err(|e| broken(&e))
    };
    for sample in samples {
        waiting.push(sample?);
        if waiting.len() >= rows_per_group {
            flush(&mut waiting, &mut writer)?;
        }
    }
    if !waiting.is_empty() {
        flush(&mut waiting, &mut writer)?;
    }
    writer.close().map_err(|e| broken(&e))?;
    std::fs::rename(&aside, path).map_err(DatasetError::io(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_differ_by_one_sample_at_most_and_none_is_lost() {
        for (n, per) in [(0, 10), (1, 10), (10, 10), (11, 10), (2_345, 100), (7, 1)] {
            let all = shards("train", n, per);
            let sizes: Vec<usize> = all.iter().map(|s| s.range.len()).collect();
            assert_eq!(sizes.iter().sum::<usize>(), n);
            assert!(sizes.iter().all(|s| *s <= per));
            let (low, high) = (sizes.iter().min(), sizes.iter().max());
            assert!(high.unwrap_or(&0) - low.unwrap_or(&0) <= 1, "{sizes:?}");
        }
        assert_eq!(shards("val", 11, 10)[1].name, "val-00001-of-00002.parquet");
    }
}
