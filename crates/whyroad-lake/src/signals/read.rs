//! Signal tables from Parquet: one drive, and only its requested columns.

use super::column::{StoredColumn, words};
use super::pages::{Dense, Values};
use super::table::{Table, frames_of_targets};
use super::{Contents, StoredDrive, TIME, digest};
use crate::LakeError;
use parquet::basic::Type;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::statistics::Statistics;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_model::{Nanos, SignalTable};

/// Which of the two tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableKind {
    /// One row per frame.
    Frames,
    /// One row per object and frame.
    Targets,
}

impl TableKind {
    /// Where a signal of this name is.
    pub fn of(signal: &str) -> Self {
        if signal.starts_with("target.") { Self::Targets } else { Self::Frames }
    }
}

/// What the file's statistics say about a signal of one drive, without reading its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least and greatest value of a number that is known anywhere; a flag counts as 0 and 1.
    pub bounds: Option<(f64, f64)>,
    /// Rows in which it is known.
    pub known: usize,
    /// Rows.
    pub rows: usize,
}

/// An opened store of signals.
#[derive(Clone, Debug)]
pub struct SignalFile {
    frames: Table,
    targets: Table,
    contents: Arc<Contents>,
}

impl SignalFile {
    /// Opens the store in a folder. `None` without one; an error where there is one that cannot be what it
    /// says.
    pub fn open(dir: &Path) -> Result<Option<Self>, LakeError> {
        let Some((mut frames, contents)) = Table::open(&dir.join("frames.parquet"))? else { return Ok(None) };
        let path = dir.join("targets.parquet");
        let Some((mut targets, same)) = Table::open(&path)? else { return Ok(None) };
        // The second names the first one's text by its hash, or, written by an earlier version, repeats it.
        if same != digest(&contents) && same != contents {
            return Err(LakeError::broken(&path, "it is not of the same drives as frames.parquet"));
        }
        let contents: Contents =
            serde_json::from_str(&contents).map_err(|e| LakeError::broken(&frames.path, e))?;
        let rows = |of: fn(&StoredDrive) -> usize| contents.drives.iter().map(of).collect::<Vec<_>>();
        for (table, rows) in
            [(&mut frames, rows(|d| d.frames)), (&mut targets, rows(StoredDrive::target_rows))]
        {
            if !table.divide(&rows) {
                let reason = "its row groups are not whole drives";
                return Err(LakeError::broken(&table.path, reason));
            }
        }
        Ok(Some(Self { frames, targets, contents: Arc::new(contents) }))
    }

    /// The part of the store that belongs to one drive, which has index 0 in it.
    pub(crate) fn of_drive(&self, drive: usize) -> Option<Self> {
        let stored = self.contents.drives.get(drive)?;
        let version = stored.version.clone().unwrap_or_else(|| self.contents.version.clone());
        let contents = Arc::new(Contents { version, drives: vec![stored.clone()] });
        Some(Self { frames: self.frames.of_drive(drive), targets: self.targets.of_drive(drive), contents })
    }

    /// File, footer and row group of the first drive's rows.
    pub(crate) fn part(&self, kind: TableKind) -> (PathBuf, Arc<ParquetMetaData>, Option<usize>) {
        let table = self.table(kind);
        (table.path.clone(), Arc::clone(&table.metadata), table.group_index(0))
    }

    /// What the files say about themselves.
    pub fn contents(&self) -> &Contents {
        &self.contents
    }

    fn table(&self, scope: TableKind) -> &Table {
        match scope {
            TableKind::Frames => &self.frames,
            TableKind::Targets => &self.targets,
        }
    }

    /// Signals of one drive: those of which the drive's log supports any.
    pub fn signals(&self, drive: usize) -> Vec<&str> {
        let of = &self.contents.drives[drive];
        let names = self.frames.columns.keys().chain(self.targets.columns.keys());
        let names = names.filter(|n| n.contains('.') && !of.lacks(n));
        names.map(String::as_str).collect()
    }

    /// True where the drive's log supports a signal of this name.
    pub fn has(&self, drive: usize, signal: &str) -> bool {
        signal.contains('.')
            && self.table(TableKind::of(signal)).columns.contains_key(signal)
            && !self.contents.drives[drive].lacks(signal)
    }

    /// What the statistics say about a signal; `None` where there is no such column.
    pub fn range(&self, drive: usize, signal: &str) -> Option<Range> {
        let table = self.table(TableKind::of(signal));
        let column = *table.columns.get(signal)?;
        if self.contents.drives.get(drive)?.lacks(signal) {
            return None;
        }
        let Some(group) = table.group(drive) else {
            return Some(Range { bounds: None, known: 0, rows: 0 });
        };
        let rows = usize::try_from(group.num_rows()).ok()?;
        let statistics = group.column(column).statistics()?;
        let nulls = usize::try_from(statistics.null_count_opt()?).ok()?;
        let bounds = match statistics {
            // The format gives a least zero a sign, as the column may have -0.0.
            Statistics::Double(s) => s.min_opt().map(|m| m + 0.0).zip(s.max_opt().copied()),
            Statistics::Boolean(s) => {
                let number = |b: &bool| if *b { 1.0 } else { 0.0 };
                s.min_opt().map(number).zip(s.max_opt().map(number))
            }
            _ => None,
        };
        Some(Range { bounds, known: rows - nulls, rows })
    }

    /// Frame times of a drive.
    pub fn times(&self, drive: usize) -> Result<Vec<Nanos>, LakeError> {
        match self.frames.read(drive, &[TIME])?.as_deref() {
            None => Ok(Vec::new()),
            Some([Dense { values: Values::Integers(times), known: None }]) => {
                Ok(times.iter().map(Nanos).collect())
            }
            Some(_) => Err(self.frames.wrong_type(TIME)),
        }
    }

    /// Reads these signals of a drive, all of one scope, in their order. Checks the order of the rows.
    pub fn read(
        &self,
        drive: usize,
        scope: TableKind,
        signals: &[&str],
    ) -> Result<Vec<StoredColumn>, LakeError> {
        let (table, of) = (self.table(scope), &self.contents.drives[drive]);
        let rows = match scope {
            TableKind::Frames => {
                table.check_order(drive, std::iter::once(0..of.frames))?;
                of.frames
            }
            TableKind::Targets => {
                table.check_order(drive, frames_of_targets(of))?;
                of.target_rows()
            }
        };
        let Some(columns) = table.read(drive, signals)? else {
            return signals.iter().map(|name| empty(table, name, of)).collect();
        };
        let named = signals.iter().zip(columns);
        let column = |(name, dense): (&&str, Dense)| {
            StoredColumn::of(dense, name, of, rows).ok_or_else(|| table.wrong_type(name))
        };
        named.map(column).collect()
    }

    /// The whole table of a drive.
    pub fn read_table(&self, drive: usize) -> Result<SignalTable, LakeError> {
        let of = &self.contents.drives[drive];
        let mut out = SignalTable {
            drive_id: of.drive_id.clone(),
            times: self.times(drive)?,
            targets: of.targets.clone(),
            unavailable: of.unavailable.clone(),
            partial: of.partial.clone(),
            without_boxes: of.without_boxes.clone(),
            ..SignalTable::default()
        };
        let all = self.signals(drive);
        for scope in [TableKind::Frames, TableKind::Targets] {
            let names: Vec<&str> = all.iter().copied().filter(|n| TableKind::of(n) == scope).collect();
            let rows = if scope == TableKind::Frames { of.frames } else { of.target_rows() };
            let columns =
                if scope == TableKind::Frames { &mut out.frame_columns } else { &mut out.target_columns };
            for (name, stored) in names.iter().zip(self.read(drive, scope, &names)?) {
                columns.insert((*name).to_owned(), stored.into_column(rows));
            }
        }
        Ok(out)
    }
}

/// A signal of a drive that has no rows.
fn empty(table: &Table, name: &str, of: &StoredDrive) -> Result<StoredColumn, LakeError> {
    Ok(match table.physical(name).ok_or_else(|| table.wrong_type(name))? {
        Type::DOUBLE => StoredColumn::Numbers(vec![], None),
        Type::BOOLEAN => StoredColumn::Flags(vec![], None),
        _ => StoredColumn::Words(vec![], words(of, name)),
    })
}
