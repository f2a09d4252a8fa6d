//! Signal tables from Parquet: one drive, and of it only the columns that are asked for.

use super::{Contents, FRAME, KEY, ROW_ORDER, StoredDrive, TIME};
use crate::file::ROW_ORDER_KEY;
use crate::{LAKE_VERSION, LakeError};
use arrow_array::cast::AsArray;
use arrow_array::types::{Int64Type, UInt16Type, UInt32Type};
use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch};
use arrow_buffer::{BooleanBuffer, NullBuffer};
use arrow_schema::DataType;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder,
};
use parquet::file::statistics::Statistics;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::{Column, Nanos, SignalTable, Tri};

/// Which of the two tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// A row a frame.
    Frames,
    /// A row an object and frame.
    Targets,
}

impl Scope {
    /// Where a signal of this name is.
    pub fn of(signal: &str) -> Self {
        if signal.starts_with("target.") { Self::Targets } else { Self::Frames }
    }
}

/// A column as it was decoded. Bits are 64 rows a word, the first row in the lowest bit.
#[derive(Clone, Debug, PartialEq)]
pub enum StoredColumn {
    /// Numbers, NaN where unknown; which are known, unless all are.
    Numbers(Vec<f64>, Option<Vec<u64>>),
    /// Which are true, which are known.
    Flags(Vec<u64>, Vec<u64>),
    /// Codes into words.
    Words(Vec<u16>, Arc<[String]>),
}

/// What the file's statistics tell of a signal of one drive, without reading its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least and greatest value of a number that is known anywhere; a flag counts as 0 and 1.
    pub bounds: Option<(f64, f64)>,
    /// Rows in which it is known.
    pub known: usize,
    /// Rows.
    pub rows: usize,
}

#[derive(Clone, Debug)]
struct Table {
    path: PathBuf,
    metadata: ArrowReaderMetadata,
    columns: BTreeMap<String, usize>,
    /// Of each drive, whether the order of its rows has been checked: once is enough while the store is open.
    in_order: Arc<[AtomicBool]>,
}

/// An opened store of signals.
#[derive(Clone, Debug)]
pub struct SignalFile {
    frames: Table,
    targets: Table,
    contents: Contents,
}

impl SignalFile {
    /// Opens the store in a folder. `None` where there is none; an error where there is one that cannot be what it says.
    pub fn open(dir: &Path) -> Result<Option<Self>, LakeError> {
        let Some((frames, contents)) = Table::open(&dir.join("frames.parquet"))? else { return Ok(None) };
        let path = dir.join("targets.parquet");
        let Some((targets, same)) = Table::open(&path)? else { return Ok(None) };
        // Both are written with the same text: it is compared as it stands, and parsed once.
        if contents != same {
            return Err(LakeError::broken(&path, "it is not of the same drives as frames.parquet"));
        }
        let contents: Contents =
            serde_json::from_str(&contents).map_err(|e| LakeError::broken(&frames.path, e))?;
        for (table, rows) in [
            (&frames, contents.drives.iter().map(|d| d.frames).collect::<Vec<_>>()),
            (&targets, contents.drives.iter().map(StoredDrive::target_rows).collect()),
        ] {
            let groups = table.metadata.metadata().row_groups();
            let found: Vec<usize> =
                groups.iter().map(|g| usize::try_from(g.num_rows()).unwrap_or(0)).collect();
            // A drive without objects has no row group of targets where it is alone.
            let none = rows.iter().all(|n| *n == 0) && found.iter().all(|n| *n == 0);
            if found != rows && !none {
                let reason = "its row groups are not whole drives";
                return Err(LakeError::broken(&table.path, reason));
            }
        }
        Ok(Some(Self { frames, targets, contents }))
    }

    /// What the files say about themselves.
    pub fn contents(&self) -> &Contents {
        &self.contents
    }

    fn table(&self, scope: Scope) -> &Table {
        match scope {
            Scope::Frames => &self.frames,
            Scope::Targets => &self.targets,
        }
    }

    /// Signals of one drive: those of which the drive's log supports any.
    pub fn signals(&self, drive: usize) -> Vec<&str> {
        let of = &self.contents.drives[drive];
        let names = self.frames.columns.keys().chain(self.targets.columns.keys());
        let names = names.filter(|n| n.contains('.') && !of.unavailable.contains_key(*n));
        names.map(String::as_str).collect()
    }

    /// What the statistics tell of a signal; `None` where there is no such column.
    pub fn range(&self, drive: usize, signal: &str) -> Option<Range> {
        let table = self.table(Scope::of(signal));
        let column = *table.columns.get(signal)?;
        let Some(group) = table.metadata.metadata().row_groups().get(drive) else {
            return Some(Range { bounds: None, known: 0, rows: 0 });
        };
        let rows = usize::try_from(group.num_rows()).ok()?;
        let statistics = group.column(column).statistics()?;
        let nulls = usize::try_from(statistics.null_count_opt()?).ok()?;
        let bounds = match statistics {
            Statistics::Double(s) => s.min_opt().copied().zip(s.max_opt().copied()),
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
        let table = &self.frames;
        let Some(batch) = table.read(drive, &[TIME])? else { return Ok(Vec::new()) };
        let times = batch.column(0).as_primitive_opt::<Int64Type>().ok_or_else(|| table.wrong_type(TIME))?;
        Ok(times.values().iter().map(|t| Nanos(*t)).collect())
    }

    /// Reads these signals of a drive, all of one scope, in their order. Checks the order of the targets' rows.
    pub fn read(&self, drive: usize, scope: Scope, signals: &[&str]) -> Result<Vec<StoredColumn>, LakeError> {
        let table = self.table(scope);
        let of = &self.contents.drives[drive];
        let checked = table.in_order.get(drive).is_some_and(|c| c.load(Ordering::Relaxed));
        let names: Vec<&str> = signals.iter().copied().chain((!checked).then_some(FRAME)).collect();
        let Some(batch) = table.read(drive, &names)? else {
            return signals.iter().map(|name| table.empty(name, of)).collect();
        };
        if !checked {
            table.check_order(&batch, of, scope)?;
            if let Some(of_drive) = table.in_order.get(drive) {
                of_drive.store(true, Ordering::Relaxed);
            }
        }
        let (schema, arrays, _) = batch.into_parts();
        let mut arrays: Vec<Option<ArrayRef>> = arrays.into_iter().map(Some).collect();
        let column = |name: &&str| {
            let array = schema.index_of(name).ok().and_then(|i| arrays[i].take());
            table.column(array.ok_or_else(|| table.wrong_type(name))?, name, of)
        };
        signals.iter().map(column).collect()
    }

    /// The whole table of a drive.
    pub fn read_table(&self, drive: usize) -> Result<SignalTable, LakeError> {
        let of = &self.contents.drives[drive];
        let mut out = SignalTable {
            drive_id: of.drive_id.clone(),
            times: self.times(drive)?,
            targets: of.targets(),
            unavailable: of.unavailable.clone(),
            ..SignalTable::default()
        };
        let all = self.signals(drive);
        for scope in [Scope::Frames, Scope::Targets] {
            let names: Vec<&str> = all.iter().copied().filter(|n| Scope::of(n) == scope).collect();
            let rows = if scope == Scope::Frames { of.frames } else { of.target_rows() };
            let columns =
                if scope == Scope::Frames { &mut out.frame_columns } else { &mut out.target_columns };
            for (name, stored) in names.iter().zip(self.read(drive, scope, &names)?) {
                columns.insert((*name).to_owned(), stored.into_column(rows));
            }
        }
        Ok(out)
    }
}

impl Table {
    /// The table, and what it says of the contents of the store, as text.
    fn open(path: &Path) -> Result<Option<(Self, String)>, LakeError> {
        let file = match File::open(path) {
            Ok(f) => f,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(LakeError::io(path)(e)),
        };
        let metadata = ArrowReaderMetadata::load(&file, ArrowReaderOptions::default())
            .map_err(|e| LakeError::broken(path, e))?;
        let stated = metadata.metadata().file_metadata().key_value_metadata();
        let value = |key: &str| stated?.iter().find(|kv| kv.key == key)?.value.clone();
        match value("whyroad.lake_version").and_then(|v| v.parse::<u32>().ok()) {
            Some(LAKE_VERSION) => {}
            Some(found) => return Err(LakeError::Version { path: path.to_owned(), found }),
            None => return Err(LakeError::broken(path, "the file does not state its lake version")),
        }
        if value(ROW_ORDER_KEY).as_deref() != Some(ROW_ORDER) {
            return Err(LakeError::broken(path, format!("the order of its rows is not '{ROW_ORDER}'")));
        }
        let contents = value(KEY).unwrap_or_default();
        let fields = metadata.schema().fields().iter().enumerate();
        let columns = fields.map(|(i, f)| (f.name().clone(), i)).collect();
        let in_order = metadata.metadata().row_groups().iter().map(|_| AtomicBool::new(false)).collect();
        Ok(Some((Self { path: path.to_owned(), metadata, columns, in_order }, contents)))
    }

    fn wrong_type(&self, name: &str) -> LakeError {
        LakeError::broken(&self.path, format!("column '{name}' is not of the expected type"))
    }

    /// These columns of one row group; `None` where it has no rows.
    fn read(&self, group: usize, names: &[&str]) -> Result<Option<RecordBatch>, LakeError> {
        let groups = self.metadata.metadata().row_groups();
        let Some(rows) = groups.get(group).map(|g| usize::try_from(g.num_rows()).unwrap_or(0)) else {
            return Ok(None);
        };
        let mut wanted = Vec::with_capacity(names.len());
        for name in names {
            let missing = || LakeError::broken(&self.path, format!("column '{name}' is missing"));
            wanted.push(*self.columns.get(*name).ok_or_else(missing)?);
        }
        // Every thread reads through a file of its own: a position is shared by all clones of a handle.
        let file = File::open(&self.path).map_err(LakeError::io(&self.path))?;
        let builder = ParquetRecordBatchReaderBuilder::new_with_metadata(file, self.metadata.clone());
        let mask = ProjectionMask::roots(builder.parquet_schema(), wanted);
        let broken = |e: &dyn std::fmt::Display| LakeError::broken(&self.path, e);
        let reader = builder.with_row_groups(vec![group]).with_projection(mask).with_batch_size(rows.max(1));
        match reader.build().map_err(|e| broken(&e))?.next() {
            Some(batch) => {
                let batch = batch.map_err(|e| broken(&e))?;
                if batch.num_rows() != rows {
                    return Err(broken(&format!("{} of {rows} rows can be read", batch.num_rows())));
                }
                Ok(Some(batch))
            }
            None => Ok(None),
        }
    }

    fn check_order(&self, batch: &RecordBatch, of: &StoredDrive, scope: Scope) -> Result<(), LakeError> {
        let frames = batch.column_by_name(FRAME).and_then(|c| c.as_primitive_opt::<UInt32Type>());
        let frames = frames.ok_or_else(|| self.wrong_type(FRAME))?.values();
        let check = |mut expected: std::ops::Range<usize>, rows: &[u32], from: usize| {
            let wrong = rows.iter().position(|f| expected.next() != Some(*f as usize));
            match wrong {
                Some(row) => Err(LakeError::RowOrder { path: self.path.clone(), row: from + row }),
                None => Ok(()),
            }
        };
        if scope == Scope::Frames {
            return check(0..of.frames, frames, 0);
        }
        let mut first_row = 0;
        for target in &of.targets {
            let expected = target.first..target.end;
            let rows = first_row..first_row + expected.len();
            check(expected, &frames[rows.clone()], first_row)?;
            first_row = rows.end;
        }
        Ok(())
    }

    fn empty(&self, name: &str, of: &StoredDrive) -> Result<StoredColumn, LakeError> {
        let column = self.columns.get(name).ok_or_else(|| self.wrong_type(name))?;
        Ok(match self.metadata.schema().field(*column).data_type() {
            DataType::Float64 => StoredColumn::Numbers(vec![], None),
            DataType::Boolean => StoredColumn::Flags(vec![], vec![]),
            _ => StoredColumn::Words(vec![], words(of, name)),
        })
    }

    fn column(&self, column: ArrayRef, name: &str, of: &StoredDrive) -> Result<StoredColumn, LakeError> {
        if *column.data_type() == DataType::Float64 {
            let data = column.to_data();
            // With the only other owner gone, the values are taken over instead of copied.
            drop(column);
            let (_, values, nulls) = Float64Array::from(data).into_parts();
            let mut values = Vec::from(values);
            let Some(nulls) = nulls.filter(|n| n.null_count() > 0) else {
                return Ok(StoredColumn::Numbers(values, None));
            };
            let known = bits(nulls.inner());
            for (rows, known) in values.chunks_mut(64).zip(&known) {
                unknown_rows(rows.len(), *known).for_each(|i| rows[i] = f64::NAN);
            }
            return Ok(StoredColumn::Numbers(values, Some(known)));
        }
        if let Some(flags) = column.as_boolean_opt() {
            let mut yes = bits(flags.values());
            let known = known(flags.nulls(), flags.len());
            yes.iter_mut().zip(&known).for_each(|(y, k)| *y &= k);
            return Ok(StoredColumn::Flags(yes, known));
        }
        let keys = column.as_dictionary_opt::<UInt16Type>().ok_or_else(|| self.wrong_type(name))?;
        let values = keys.values().as_string_opt::<i32>().ok_or_else(|| self.wrong_type(name))?;
        let words = words(of, name);
        // The file's own dictionary is in the order in which words came up.
        let code = |w: Option<&str>| {
            let at = words.iter().position(|x| Some(x.as_str()) == w);
            at.and_then(|i| u16::try_from(i).ok()).unwrap_or(UNKNOWN_CODE)
        };
        let codes: Vec<u16> = values.iter().map(code).collect();
        let of_key = |k: u16| codes.get(usize::from(k)).copied().unwrap_or(UNKNOWN_CODE);
        let keys = keys.keys();
        let mut of_rows: Vec<u16> = keys.values().iter().map(|k| of_key(*k)).collect();
        if let Some(nulls) = keys.nulls().filter(|n| n.null_count() > 0) {
            for (rows, known) in of_rows.chunks_mut(64).zip(bits(nulls.inner())) {
                unknown_rows(rows.len(), known).for_each(|i| rows[i] = UNKNOWN_CODE);
            }
        }
        Ok(StoredColumn::Words(of_rows, words))
    }
}

fn words(of: &StoredDrive, name: &str) -> Arc<[String]> {
    of.words.get(name).map(|w| w.as_slice().into()).unwrap_or_default()
}

/// The bits of a buffer as words; those beyond its end are 0.
fn bits(buffer: &BooleanBuffer) -> Vec<u64> {
    buffer.bit_chunks().iter_padded().take(buffer.len().div_ceil(64)).collect()
}

/// Which of up to 64 rows are not known; mostly none.
fn unknown_rows(rows: usize, known: u64) -> impl Iterator<Item = usize> {
    let mut left = if rows >= 64 { !known } else { !known & ((1 << rows) - 1) };
    std::iter::from_fn(move || {
        let next = left.trailing_zeros() as usize;
        left &= left.wrapping_sub(1);
        (next < 64).then_some(next)
    })
}

fn known(nulls: Option<&NullBuffer>, n: usize) -> Vec<u64> {
    nulls.map_or_else(|| bits(&BooleanBuffer::new_set(n)), |v| bits(v.inner()))
}

impl StoredColumn {
    /// As a column of a signal table with so many rows.
    pub fn into_column(self, rows: usize) -> Column {
        match self {
            Self::Numbers(v, _) => Column::Number(v),
            Self::Flags(yes, known) => {
                let bit = |plane: &[u64], i: usize| plane[i / 64] >> (i % 64) & 1 == 1;
                let flag = |i: usize| Tri::from(bit(&known, i).then(|| bit(&yes, i)));
                Column::Flag((0..rows).map(flag).collect())
            }
            Self::Words(codes, names) => Column::Category { codes, names },
        }
    }
}
