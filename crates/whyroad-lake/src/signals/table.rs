//! One of the two files of a store: its footer, and columns of a drive, which is one row group.

use super::pages::{Dense, Values, read};
use super::{FRAME, KEY, ROW_ORDER, StoredDrive};
use crate::file::{ROW_ORDER_KEY, check_columns};
use crate::{LAKE_VERSION, LakeError};
use parquet::basic::Type;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader, RowGroupMetaData};
use parquet::file::reader::ChunkReader;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

#[derive(Clone, Debug)]
pub(super) struct Table {
    pub path: PathBuf,
    pub metadata: Arc<ParquetMetaData>,
    /// Columns by name.
    pub columns: Arc<BTreeMap<String, usize>>,
    /// Row group of each drive; `None` for a drive without rows.
    groups: Arc<[Option<usize>]>,
    /// Of each row group, whether the order of its rows has been checked: once is enough while the store is open.
    in_order: Arc<[AtomicBool]>,
}

impl Table {
    /// The table, and its description of the contents of the store, as text.
    pub fn open(path: &Path) -> Result<Option<(Self, String)>, LakeError> {
        let file = match File::open(path) {
            Ok(f) => f,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(LakeError::io(path)(e)),
        };
        Self::of(path, &file).map(Some)
    }

    /// The same from any source; `path` is its name.
    pub fn of(path: &Path, source: &impl ChunkReader) -> Result<(Self, String), LakeError> {
        let metadata =
            ParquetMetaDataReader::new().parse_and_finish(source).map_err(|e| LakeError::broken(path, e))?;
        check_columns(&metadata).map_err(|e| LakeError::broken(path, e))?;
        let stated = metadata.file_metadata().key_value_metadata();
        let value = |key: &str| stated?.iter().find(|kv| kv.key == key)?.value.clone();
        match value("whyroad.lake_version").and_then(|v| v.parse::<u32>().ok()) {
            Some(LAKE_VERSION) => {}
            Some(found) => return Err(LakeError::version(path, found, Vec::new())),
            None => return Err(LakeError::broken(path, "the file does not state its lake version")),
        }
        if value(ROW_ORDER_KEY).as_deref() != Some(ROW_ORDER) {
            return Err(LakeError::broken(path, format!("the order of its rows is not '{ROW_ORDER}'")));
        }
        let contents = value(KEY).unwrap_or_default();
        // Names may contain dots, but are a single part of a path.
        let leaves = metadata.file_metadata().schema_descr().columns().iter().enumerate();
        let named = leaves.filter_map(|(i, c)| match c.path().parts() {
            [name] => Some((name.clone(), i)),
            _ => None,
        });
        let columns = Arc::new(named.collect());
        let in_order = metadata.row_groups().iter().map(|_| AtomicBool::new(false)).collect();
        let (path, metadata, groups) = (path.to_owned(), Arc::new(metadata), Arc::new([]));
        Ok((Self { path, metadata, columns, groups, in_order }, contents))
    }

    /// Gives each drive its row group: those with rows have one each, in their order. False where the row groups do
    /// not have these numbers of rows.
    pub fn divide(&mut self, rows_of_drives: &[usize]) -> bool {
        let rows = self.metadata.row_groups().iter().map(|g| usize::try_from(g.num_rows()).unwrap_or(0));
        // Some writers write an empty row group for a file without rows.
        let with_rows: Vec<(usize, usize)> = rows.enumerate().filter(|(_, n)| *n > 0).collect();
        let mut left = with_rows.iter();
        let mut fits = true;
        let groups = rows_of_drives.iter().map(|n| {
            let group = if *n == 0 { None } else { left.next() };
            fits &= *n == 0 || group.is_some_and(|(_, rows)| rows == n);
            group.map(|(at, _)| *at)
        });
        self.groups = groups.collect();
        fits && left.next().is_none()
    }

    /// The same table for one of its drives alone.
    pub fn of_drive(&self, drive: usize) -> Self {
        let group = self.group_index(drive);
        Self { groups: Arc::new([group]), ..self.clone() }
    }

    /// Metadata of a drive's row group; `None` where the drive has no rows.
    pub fn group(&self, drive: usize) -> Option<&RowGroupMetaData> {
        self.metadata.row_groups().get(self.group_index(drive)?)
    }

    /// Number of a drive's row group; `None` where the drive has no rows.
    pub fn group_index(&self, drive: usize) -> Option<usize> {
        self.groups.get(drive).copied().flatten()
    }

    pub fn wrong_type(&self, name: &str) -> LakeError {
        LakeError::broken(&self.path, format!("column '{name}' is not of the expected type"))
    }

    /// How the values of a column are stored.
    pub fn physical(&self, name: &str) -> Option<Type> {
        let column = *self.columns.get(name)?;
        Some(self.metadata.file_metadata().schema_descr().column(column).physical_type())
    }

    /// These columns of a drive; `None` where it has no rows.
    pub fn read(&self, drive: usize, names: &[&str]) -> Result<Option<Vec<Dense>>, LakeError> {
        let Some(group) = self.group(drive) else { return Ok(None) };
        let rows = usize::try_from(group.num_rows()).unwrap_or(0);
        // Every thread reads through a file of its own: a position is shared by all clones of a handle.
        let mut file = File::open(&self.path).map_err(LakeError::io(&self.path))?;
        let one = |name: &&str| {
            let missing = || LakeError::broken(&self.path, format!("column '{name}' is missing"));
            let column = *self.columns.get(*name).ok_or_else(missing)?;
            read(&mut file, group.column(column), rows).map_err(|e| LakeError::broken(&self.path, e))
        };
        names.iter().map(one).collect::<Result<_, _>>().map(Some)
    }

    /// Every column of every row group, from any source: those that can be read.
    pub fn read_all(&self, source: &mut (impl Read + Seek)) -> Vec<Dense> {
        let groups = self.metadata.row_groups().iter();
        let columns = groups.flat_map(|group| {
            let rows = usize::try_from(group.num_rows()).unwrap_or(0);
            group.columns().iter().map(move |column| (column, rows))
        });
        columns.filter_map(|(column, rows)| read(source, column, rows).ok()).collect()
    }

    /// Checks that the rows of a drive are those that the store states, in the stated order; only the first time.
    pub fn check_order(
        &self,
        drive: usize,
        expected: impl Iterator<Item = std::ops::Range<usize>>,
    ) -> Result<(), LakeError> {
        let group = self.group_index(drive);
        let checked = group.and_then(|g| self.in_order.get(g));
        if checked.is_some_and(|c| c.load(Ordering::Relaxed)) {
            return Ok(());
        }
        let Some(columns) = self.read(drive, &[FRAME])? else { return Ok(()) };
        let [Dense { values: Values::Integers(frames), known: None }] = columns.as_slice() else {
            return Err(self.wrong_type(FRAME));
        };
        let expected = expected.map(|frames| frames.start as i64..frames.end as i64);
        if let Some(row) = frames.differ(expected) {
            return Err(LakeError::RowOrder { path: self.path.clone(), row });
        }
        if let Some(of_drive) = checked {
            of_drive.store(true, Ordering::Relaxed);
        }
        Ok(())
    }
}

/// The frames of each object of a drive, in the order of their rows.
pub(super) fn frames_of_targets(of: &StoredDrive) -> impl Iterator<Item = std::ops::Range<usize>> {
    of.targets.iter().map(|t| t.frames.start..t.frames.end)
}
