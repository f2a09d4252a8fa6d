//! Counts and pages of the episodes of a mined folder. The Parquet table states which lines of the JSON Lines file
//! match a filter; only these are read. What is held in memory does not grow with the folder.

use super::columns::{
    DRIVE_ID, EPISODE_ID, EPISODES_VERSION, IS_PRIMARY, LINE_BYTES, LINE_START, SCENARIO_ID, SCORE,
    VERSION_KEY,
};
use crate::LakeError;
use crate::file::{check_columns, next_batch};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, RecordBatch};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderMetadata, ParquetRecordBatchReaderBuilder};
use parquet::file::statistics::Statistics;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use whyroad_model::ScenarioId;
use whyroad_model::ids::OTHER;
use whyroad_model::messages::{EpisodeCursor, EpisodeFilter, EpisodePage, EpisodeRecord};

/// Rows that are decoded together.
const ROWS_PER_BATCH: usize = 4096;

/// The opened table of a folder's episodes.
#[derive(Clone, Debug)]
pub struct EpisodeIndex {
    table: PathBuf,
    lines: PathBuf,
    metadata: ArrowReaderMetadata,
}

/// An episode that matches a filter, by its line.
struct Hit {
    row: u64,
    episode_id: String,
    start: u64,
    bytes: usize,
}

impl EpisodeIndex {
    pub(super) fn open(table: &Path, lines: &Path) -> Result<Self, LakeError> {
        let file = File::open(table).map_err(LakeError::io(table))?;
        let metadata =
            ArrowReaderMetadata::load(&file, Default::default()).map_err(|e| LakeError::broken(table, e))?;
        check_columns(metadata.metadata()).map_err(|e| LakeError::broken(table, e))?;
        let stated = metadata.metadata().file_metadata().key_value_metadata();
        let version = stated.and_then(|all| all.iter().find(|kv| kv.key == VERSION_KEY)?.value.clone());
        if version.as_deref() != Some(EPISODES_VERSION.to_string().as_str()) {
            let found = version.as_deref().unwrap_or("none").to_owned();
            return Err(LakeError::MinedVersion { path: table.to_owned(), found });
        }
        Ok(Self { table: table.to_owned(), lines: lines.to_owned(), metadata })
    }

    /// Number of episodes that match `filter`.
    pub fn count(&self, filter: &EpisodeFilter) -> Result<u64, LakeError> {
        if filter.is_all() {
            return Ok(self.rows());
        }
        let mut count = 0;
        self.scan(filter, 0, |_, _| {
            count += 1;
            Ok(true)
        })?;
        Ok(count)
    }

    /// At most `limit` episodes that match `filter`, from `after` on. A cursor behind the last episode gives an empty
    /// page.
    pub fn page(
        &self,
        filter: &EpisodeFilter,
        after: Option<EpisodeCursor>,
        limit: usize,
    ) -> Result<EpisodePage, LakeError> {
        let mut hits: Vec<Hit> = Vec::new();
        let mut next = None;
        self.scan(filter, after.map_or(0, |c| c.0), |row, of| {
            if hits.len() == limit {
                next = Some(EpisodeCursor(row));
                return Ok(false);
            }
            hits.push(of.hit(row)?);
            Ok(true)
        })?;
        let mut file = BufReader::new(File::open(&self.lines).map_err(LakeError::io(&self.lines))?);
        let mut at = 0;
        let episodes = hits.iter().map(|hit| self.read(&mut file, &mut at, hit)).collect::<Result<_, _>>()?;
        Ok(EpisodePage { episodes, next })
    }

    fn rows(&self) -> u64 {
        u64::try_from(self.metadata.metadata().file_metadata().num_rows()).unwrap_or(0)
    }

    /// Calls `each` for every row from `from` on that matches the filter, until it returns false.
    fn scan(
        &self,
        filter: &EpisodeFilter,
        from: u64,
        mut each: impl FnMut(u64, &Row<'_>) -> Result<bool, LakeError>,
    ) -> Result<(), LakeError> {
        let broken = |e: &dyn std::fmt::Display| LakeError::broken(&self.table, e);
        let scenario = filter.scenario.as_ref().map(ScenarioPrefix::new);
        let schema = self.metadata.metadata().file_metadata().schema_descr();
        let names = [EPISODE_ID, SCENARIO_ID, DRIVE_ID, SCORE, IS_PRIMARY, LINE_START, LINE_BYTES];
        let mut base = 0_u64;
        for (group, about) in self.metadata.metadata().row_groups().iter().enumerate() {
            let first = base;
            base += u64::try_from(about.num_rows()).unwrap_or(0);
            let beyond = |drive: &str| {
                let column = about.columns().iter().find(|c| c.column_path().string() == DRIVE_ID);
                excludes(column.and_then(|c| c.statistics()), drive)
            };
            if base <= from || filter.drive.as_ref().is_some_and(|d| beyond(d.as_str())) {
                continue;
            }
            let skip = usize::try_from(from.saturating_sub(first)).unwrap_or(usize::MAX);
            let file = File::open(&self.table).map_err(LakeError::io(&self.table))?;
            let mut reader = ParquetRecordBatchReaderBuilder::new_with_metadata(file, self.metadata.clone())
                .with_row_groups(vec![group])
                .with_projection(ProjectionMask::columns(schema, names))
                .with_offset(skip)
                .with_batch_size(ROWS_PER_BATCH)
                .build()
                .map_err(|e| broken(&e))?;
            let mut row = first + skip as u64;
            while let Some(batch) = next_batch(&mut reader).map_err(|e| broken(&e))? {
                let columns = Columns::of(batch, &self.table)?;
                for index in 0..columns.batch.num_rows() {
                    let of = Row { columns: &columns, index };
                    if of.answers(filter, scenario.as_ref()) && !each(row, &of)? {
                        return Ok(());
                    }
                    row += 1;
                }
            }
        }
        Ok(())
    }

    /// Reads the line of an episode; `at` is the reader's position.
    fn read(&self, file: &mut BufReader<File>, at: &mut u64, hit: &Hit) -> Result<EpisodeRecord, LakeError> {
        let io = |e| LakeError::io(&self.lines)(e);
        // A line a short distance ahead stays in the buffer.
        match hit.start.checked_sub(*at).and_then(|ahead| i64::try_from(ahead).ok()) {
            Some(ahead) => file.seek_relative(ahead).map_err(io)?,
            None => file.seek(SeekFrom::Start(hit.start)).map(drop).map_err(io)?,
        }
        // The stated length is not allocated: a damaged table could request all memory.
        let mut line = Vec::new();
        file.by_ref().take(hit.bytes as u64).read_to_end(&mut line).map_err(io)?;
        *at = hit.start + line.len() as u64;
        let changed = || {
            LakeError::broken(
                &self.lines,
                format!("row {} of {} does not lead to its episode; the folder was changed", hit.row, {
                    super::MinedFile::EpisodeTable.name()
                }),
            )
        };
        let record: EpisodeRecord = serde_json::from_slice(&line).map_err(|_| changed())?;
        if record.episode_id == hit.episode_id { Ok(record) } else { Err(changed()) }
    }
}

/// True when no row of a group can be of `drive`, by the bounds that the file states.
fn excludes(statistics: Option<&Statistics>, drive: &str) -> bool {
    let Some(Statistics::ByteArray(s)) = statistics else { return false };
    // Bounds may be cut short: the lower one is then smaller, the upper one larger, than any value.
    s.min_opt().is_some_and(|min| drive.as_bytes() < min.data())
        || s.max_opt().is_some_and(|max| drive.as_bytes() > max.data())
}

/// A class and all below it, as texts.
struct ScenarioPrefix {
    whole: String,
    below: String,
}

impl ScenarioPrefix {
    fn new(id: &ScenarioId) -> Self {
        Self { whole: id.to_string(), below: format!("{id}.") }
    }
}

/// The columns of a batch, checked once.
struct Columns {
    batch: RecordBatch,
    at: [usize; 7],
    table: PathBuf,
}

impl Columns {
    fn of(batch: RecordBatch, table: &Path) -> Result<Self, LakeError> {
        let find = |name: &str, fits: &dyn Fn(&dyn Array) -> bool| {
            let found = batch.schema_ref().index_of(name).ok();
            found
                .filter(|i| fits(batch.column(*i)) && batch.column(*i).null_count() == 0)
                .ok_or_else(|| LakeError::broken(table, format!("column '{name}' is not as expected")))
        };
        let text = |a: &dyn Array| a.as_string_opt::<i32>().is_some();
        let integer = |a: &dyn Array| a.as_primitive_opt::<Int64Type>().is_some();
        let at = [
            find(EPISODE_ID, &text)?,
            find(SCENARIO_ID, &text)?,
            find(DRIVE_ID, &text)?,
            find(SCORE, &|a| a.as_primitive_opt::<Float64Type>().is_some())?,
            find(IS_PRIMARY, &|a| a.as_boolean_opt().is_some())?,
            find(LINE_START, &integer)?,
            find(LINE_BYTES, &integer)?,
        ];
        Ok(Self { batch, at, table: table.to_owned() })
    }
}

struct Row<'a> {
    columns: &'a Columns,
    index: usize,
}

impl Row<'_> {
    fn text(&self, column: usize) -> &str {
        self.columns.batch.column(self.columns.at[column]).as_string::<i32>().value(self.index)
    }

    fn integer(&self, column: usize) -> i64 {
        self.columns.batch.column(self.columns.at[column]).as_primitive::<Int64Type>().value(self.index)
    }

    fn answers(&self, filter: &EpisodeFilter, scenario: Option<&ScenarioPrefix>) -> bool {
        let column = |i: usize| self.columns.batch.column(self.columns.at[i]);
        filter.drive.as_ref().is_none_or(|d| self.text(2) == d.as_str())
            && scenario.is_none_or(|p| self.text(1) == p.whole || self.text(1).starts_with(&p.below))
            && filter.classes.as_ref().is_none_or(|ids| ids.contains(self.text(1)))
            && (!filter.explained_only || self.text(1) != OTHER)
            && filter.min_score.is_none_or(|m| column(3).as_primitive::<Float64Type>().value(self.index) >= m)
            && (!filter.primary_only || column(4).as_boolean().value(self.index))
    }

    fn hit(&self, row: u64) -> Result<Hit, LakeError> {
        let broken = || LakeError::broken(&self.columns.table, format!("row {row} names no line"));
        Ok(Hit {
            row,
            episode_id: self.text(0).to_owned(),
            start: u64::try_from(self.integer(5)).map_err(|_| broken())?,
            bytes: usize::try_from(self.integer(6)).map_err(|_| broken())?,
        })
    }
}
