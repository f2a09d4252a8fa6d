//! Reading a release: its manifest, and its samples one row group at a time.

use crate::DatasetError;
use crate::freeze::manifest::{FORMAT, FORMAT_VERSION, Manifest};
use crate::freeze::{DATA, MANIFEST};
use crate::item::SplitName;
use crate::sample::Sample;
use crate::sample::schema::{from_batch, schema};
use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use rayon::prelude::*;
use std::fs::File;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

/// Rows that a core decodes at once.
const DECODED_AT_ONCE: usize = 16;

/// An opened release. Data other than the manifest is read on request.
#[derive(Clone, Debug)]
pub struct Release {
    dir: PathBuf,
    /// The manifest.
    pub manifest: Manifest,
}

impl Release {
    /// Opens the folder.
    ///
    /// # Errors
    /// When there is no manifest, or one of a format that this build does not read.
    pub fn open(dir: impl AsRef<Path>) -> Result<Self, DatasetError> {
        let dir = dir.as_ref().to_owned();
        let path = dir.join(MANIFEST);
        let text = read_text(&path).map_err(|e| match e {
            DatasetError::Io { source, .. }
                if matches!(source.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) =>
            {
                DatasetError::NoRelease(dir.clone())
            }
            e => e,
        })?;
        let manifest: Manifest = serde_json::from_str(&text).map_err(|e| DatasetError::broken(&path, e))?;
        let major = |v: &str| v.split('.').next().map(str::to_owned);
        if manifest.format != FORMAT || major(&manifest.format_version) != major(FORMAT_VERSION) {
            let found = format!("{} {}", manifest.format, manifest.format_version);
            return Err(DatasetError::broken(&path, format!("'{found}' is not {FORMAT} {FORMAT_VERSION}")));
        }
        // A release may come from others: its paths are names of files in its folder.
        if let Some(outside) = manifest.files.iter().find(|f| !is_inside(&f.path)) {
            return Err(DatasetError::broken(&path, format!("'{}' is not in the release", outside.path)));
        }
        Ok(Self { dir, manifest })
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Data files of a split in order; of all splits where none is named.
    pub fn data_files(&self, split: Option<SplitName>) -> Vec<PathBuf> {
        let prefix = split.map_or_else(|| format!("{DATA}/"), |s| format!("{DATA}/{}-", s.name()));
        let paths = self.manifest.files.iter().map(|f| &f.path).filter(|p| p.starts_with(&prefix));
        paths.map(|p| self.dir.join(p)).collect()
    }

    /// Record batches of a split as they are on disk, one per row group. `columns` limits the top-level columns.
    pub fn batches<'a>(
        &'a self,
        split: Option<SplitName>,
        columns: Option<&'a [&'a str]>,
    ) -> impl Iterator<Item = Result<RecordBatch, DatasetError>> + 'a {
        self.data_files(split).into_iter().flat_map(move |path| match open(&path, columns) {
            Ok(batches) => Box::new(batches) as Box<dyn Iterator<Item = Result<RecordBatch, DatasetError>>>,
            Err(e) => Box::new(std::iter::once(Err(e))),
        })
    }

    /// Samples of a split in the order of the files, images included.
    pub fn samples(
        &self,
        split: Option<SplitName>,
    ) -> impl Iterator<Item = Result<Sample, DatasetError>> + '_ {
        self.groups(split).flat_map(|samples| match samples {
            Ok(samples) => samples.into_iter().map(Ok).collect::<Vec<_>>(),
            Err(e) => vec![Err(e)],
        })
    }

    /// The samples of a split, one row group at a time, decoded on all cores.
    pub(crate) fn groups(
        &self,
        split: Option<SplitName>,
    ) -> impl Iterator<Item = Result<Vec<Sample>, DatasetError>> + '_ {
        self.batches(split, None).map(|batch| {
            let batch = batch?;
            let rows = batch.num_rows();
            let starts: Vec<usize> = (0..rows).step_by(DECODED_AT_ONCE).collect();
            let parts: Result<Vec<Vec<Sample>>, String> = starts
                .into_par_iter()
                .map(|start| from_batch(&batch.slice(start, DECODED_AT_ONCE.min(rows - start))))
                .collect();
            Ok(parts.map_err(|e| DatasetError::broken(&self.dir, e))?.into_iter().flatten().collect())
        })
    }

    /// The sample whose id is `id`, or the first of those whose ids begin with it, and the number of matches.
    ///
    /// # Errors
    /// When a file of the release cannot be read.
    pub fn find(&self, id: &str) -> Result<Option<(Sample, usize)>, DatasetError> {
        let mut found: Option<(Sample, usize)> = None;
        for sample in self.samples(None) {
            let sample = sample?;
            if sample.sample_id == id {
                return Ok(Some((sample, 1)));
            }
            if sample.sample_id.starts_with(id) {
                match &mut found {
                    Some((_, n)) => *n += 1,
                    None => found = Some((sample, 1)),
                }
            }
        }
        Ok(found)
    }
}

/// Opens a regular file of a release: reading a pipe or a device may never end.
pub(crate) fn open_file(path: &Path) -> Result<File, DatasetError> {
    if !std::fs::metadata(path).map_err(DatasetError::io(path))?.is_file() {
        return Err(DatasetError::broken(path, "not a file"));
    }
    File::open(path).map_err(DatasetError::io(path))
}

/// Text of a file of a release.
pub(crate) fn read_text(path: &Path) -> Result<String, DatasetError> {
    std::io::read_to_string(open_file(path)?).map_err(DatasetError::io(path))
}

/// True for a relative path that does not lead out of its folder.
pub(crate) fn is_inside(path: &str) -> bool {
    let parts = Path::new(path).components();
    !path.is_empty() && parts.into_iter().all(|part| matches!(part, Component::Normal(_)))
}

/// Drives of the samples of a batch that has the column `lineage`.
///
/// # Errors
/// Where the batch has no such column.
pub fn drive_ids(batch: &RecordBatch) -> Result<impl Iterator<Item = &str>, DatasetError> {
    let lineage = batch.column_by_name("lineage").and_then(|c| c.as_struct_opt());
    let column = lineage.and_then(|l| l.column_by_name("drive_id")).and_then(|c| c.as_string_opt::<i32>());
    let column = column.ok_or_else(|| DatasetError::broken(Path::new("lineage"), "the column is missing"))?;
    Ok(column.iter().flatten())
}

/// The row groups of one data file, until the first that cannot be read: a Parquet reader that failed would fail again
/// without end.
pub(crate) fn open<'a>(
    path: &Path,
    columns: Option<&[&str]>,
) -> Result<impl Iterator<Item = Result<RecordBatch, DatasetError>> + use<'a>, DatasetError> {
    let broken = |e: &dyn std::fmt::Display| DatasetError::broken(path, e);
    let file = open_file(path)?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| broken(&e))?;
    whyroad_lake::check_columns(builder.metadata()).map_err(|e| broken(&e))?;
    let expected = schema();
    let found = builder.schema();
    for field in expected.fields() {
        if found.field_with_name(field.name()).is_err() {
            return Err(broken(&format!("column '{}' is missing", field.name())));
        }
    }
    let largest = (0..builder.metadata().num_row_groups())
        .filter_map(|g| usize::try_from(builder.metadata().row_group(g).num_rows()).ok())
        .max();
    let mask = columns.map(|names| {
        let roots = expected.fields().iter().enumerate().filter(|(_, f)| names.contains(&f.name().as_str()));
        ProjectionMask::roots(builder.parquet_schema(), roots.map(|(i, _)| i))
    });
    let builder = builder.with_batch_size(largest.unwrap_or(1).max(1));
    let builder = match mask {
        Some(mask) => builder.with_projection(mask),
        None => builder,
    };
    let mut reader = Some(builder.build().map_err(|e| broken(&e))?);
    let path = path.to_owned();
    Ok(std::iter::from_fn(move || {
        let batch = whyroad_lake::next_batch(reader.as_mut()?);
        if batch.is_err() {
            reader = None;
        }
        batch.map_err(|e| DatasetError::broken(&path, e)).transpose()
    }))
}
