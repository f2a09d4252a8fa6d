//! Row sets: the rows of a value: those of the drive, of all objects one after another, of one object, of a pair.
//! A *segment* is an unbroken stretch of the drive's rows; operators over time never look beyond it.

use crate::interpret::{Row, Timeline};
use crate::language::program::PairSide;
use std::borrow::Cow;
use std::ops::Range;
use whyroad_model::pair::PairTable;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{FrameRange, Nanos};

/// Rows of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RowSet {
    /// All rows of the drive.
    Drive,
    /// The rows of all objects, one object after another, as one long column.
    Objects,
    /// The rows of the object with this index.
    Object(usize),
    /// The rows in which both the target and the other object exist; where the drive has a table of pairs, from the
    /// first to the last frame in which they are near.
    Pair(usize, usize),
    /// The rows of all pairs of the drive's table of pairs, one after another, as one long column.
    Pairs,
}

/// A pair of objects and its rows as a stretch of the long column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PairRows {
    /// The target.
    pub first: usize,
    /// The other one.
    pub second: usize,
    /// Its rows.
    pub segment: Segment,
    /// Index of the pair with the two exchanged.
    pub reversed: usize,
}

/// A stretch of the drive's rows in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Where it begins in the column.
    pub start: usize,
    /// Row of the drive with which it begins.
    pub row: usize,
    /// Number of rows.
    pub len: usize,
}

impl Segment {
    /// Its rows in the column.
    pub fn range(&self) -> Range<usize> {
        self.start..self.start + self.len
    }
}

/// The rows of a drive, its gaps included, and where its objects are in them.
#[derive(Clone, Debug)]
pub struct RowLayout {
    /// Rows of the drive.
    pub rows: Vec<Row>,
    /// Row of each frame.
    pub row_of_frame: Vec<usize>,
    /// Of each object, as a stretch of the long column.
    pub objects: Vec<Segment>,
    /// Rows of the long column.
    pub object_rows: usize,
    frames: Vec<FrameRange>,
    first_rows: Vec<usize>,
    drive: Segment,
    gaps: bool,
    /// True when the long column is the table's own: no gap rows in it, objects in the order of their rows.
    dense: bool,
    /// Objects in the order in which they are first observed.
    by_start: Vec<usize>,
    longest: usize,
    /// The pairs of the drive's table, in its order; `None` where it has none.
    pub pairs: Option<Vec<PairRows>>,
    pair_rows: usize,
    pair_segments: Vec<Segment>,
}

impl RowLayout {
    /// Of a drive with these frame times and objects.
    pub fn new(times: &[Nanos], targets: &[TargetSpan]) -> Self {
        let timeline = Timeline::new(times);
        let row_of_frame: Vec<usize> =
            (0..timeline.rows.len()).filter(|&i| timeline.rows[i].frame.is_some()).collect();
        let gaps = timeline.rows.len() != times.len();
        let mut object_rows = 0;
        let mut objects = Vec::with_capacity(targets.len());
        let mut dense = !gaps;
        for target in targets {
            let (row, len) = match target.frames.is_empty() {
                true => (0, 0),
                false => {
                    let first = row_of_frame[target.frames.start];
                    (first, row_of_frame[target.frames.end - 1] + 1 - first)
                }
            };
            dense &= target.first_row == object_rows;
            objects.push(Segment { start: object_rows, row, len });
            object_rows += len;
        }
        let drive = Segment { start: 0, row: 0, len: timeline.rows.len() };
        let frames = targets.iter().map(|t| t.frames).collect();
        let first_rows = targets.iter().map(|t| t.first_row).collect();
        let rows = timeline.rows;
        let mut by_start: Vec<usize> = (0..objects.len()).collect();
        by_start.sort_by_key(|i| objects[*i].row);
        let longest = objects.iter().map(|o| o.len).max().unwrap_or(0);
        Self {
            by_start,
            longest,
            pairs: None,
            pair_rows: 0,
            pair_segments: Vec::new(),
            rows,
            row_of_frame,
            objects,
            object_rows,
            frames,
            first_rows,
            drive,
            gaps,
            dense,
        }
    }

    /// With the pairs of this table.
    #[must_use]
    pub fn with_pairs(mut self, table: &PairTable) -> Self {
        let mut start = 0;
        let rows = table.spans.iter().enumerate().map(|(i, span)| {
            let (row, len) = match span.frames.is_empty() {
                true => (0, 0),
                false => {
                    let first = self.row_of_frame[span.frames.start];
                    (first, self.row_of_frame[span.frames.end - 1] + 1 - first)
                }
            };
            let segment = Segment { start, row, len };
            start += len;
            let reversed = table.reversed(i).unwrap_or(i);
            PairRows { first: span.first, second: span.second, segment, reversed }
        });
        let rows: Vec<PairRows> = rows.collect();
        self.pair_segments = rows.iter().map(|p| p.segment).collect();
        self.pairs = Some(rows);
        self.pair_rows = start;
        self
    }

    /// Index of a pair in the table of pairs.
    pub fn pair(&self, first: usize, second: usize) -> Option<usize> {
        self.pairs.as_ref()?.binary_search_by_key(&(first, second), |p| (p.first, p.second)).ok()
    }

    /// The stretches that form a column there.
    pub fn segments(&self, row_set: RowSet) -> Cow<'_, [Segment]> {
        match row_set {
            RowSet::Drive => Cow::Borrowed(std::slice::from_ref(&self.drive)),
            RowSet::Objects => Cow::Borrowed(&self.objects),
            RowSet::Pairs => Cow::Borrowed(&self.pair_segments),
            _ => Cow::Owned(vec![self.segment(row_set)]),
        }
    }

    /// The stretch of a row set that has one.
    pub fn segment(&self, row_set: RowSet) -> Segment {
        match row_set {
            RowSet::Drive | RowSet::Objects | RowSet::Pairs => self.drive,
            RowSet::Object(i) => Segment { start: 0, ..self.objects[i] },
            RowSet::Pair(a, b) if self.pairs.is_some() => {
                let nobody = Segment { start: 0, row: 0, len: 0 };
                self.pair(a, b).map_or(nobody, |i| Segment { start: 0, ..self.pair_segments[i] })
            }
            RowSet::Pair(a, b) => {
                let (a, b) = (self.objects[a], self.objects[b]);
                let row = a.row.max(b.row);
                let end = (a.row + a.len).min(b.row + b.len);
                Segment { start: 0, row, len: end.saturating_sub(row) }
            }
        }
    }

    /// Rows of a column there.
    pub fn len(&self, row_set: RowSet) -> usize {
        match row_set {
            RowSet::Objects => self.object_rows,
            RowSet::Pairs => self.pair_rows,
            _ => self.segment(row_set).len,
        }
    }

    /// Objects that are observed while this one is, itself included, in the order of the targets.
    ///
    /// Where the drive has a table of pairs: those that come near it.
    pub fn seen_with(&self, object: usize) -> Vec<usize> {
        if let Some(pairs) = &self.pairs {
            let from = pairs.partition_point(|p| p.first < object);
            return pairs[from..].iter().take_while(|p| p.first == object).map(|p| p.second).collect();
        }
        let of = self.objects[object];
        let start = |i: &usize| self.objects[*i].row;
        let from = self.by_start.partition_point(|i| start(i) + self.longest <= of.row);
        let to = self.by_start.partition_point(|i| start(i) < of.row + of.len);
        let near = self.by_start[from.min(to)..to].iter().copied();
        let mut seen: Vec<usize> = near.filter(|i| start(i) + self.objects[*i].len > of.row).collect();
        seen.sort_unstable();
        seen
    }

    /// The row of a frame in a row set with one segment.
    pub fn position(&self, row_set: RowSet, frame: usize) -> Option<usize> {
        let segment = self.segment(row_set);
        let row = self.row_of_frame.get(frame)?.checked_sub(segment.row)?;
        (row < segment.len).then_some(row)
    }

    /// The values of a signal of the drive there: unchanged, or with `hole` in each gap.
    pub fn of_frames<'v, T: Copy>(&self, values: &'v [T], hole: T) -> Cow<'v, [T]> {
        if !self.gaps {
            return Cow::Borrowed(values);
        }
        Cow::Owned(
            self.rows.iter().map(|r| r.frame.and_then(|f| values.get(f).copied()).unwrap_or(hole)).collect(),
        )
    }

    /// The values of a signal of the objects there: unchanged, or with `hole` in each gap.
    pub fn of_objects<'v, T: Copy>(&self, values: &'v [T], row_set: RowSet, hole: T) -> Cow<'v, [T]> {
        match row_set {
            RowSet::Objects if self.dense && values.len() == self.object_rows => Cow::Borrowed(values),
            RowSet::Objects => {
                let mut all = Vec::with_capacity(self.object_rows);
                for i in 0..self.objects.len() {
                    all.extend_from_slice(&self.of_object(values, i, hole));
                }
                Cow::Owned(all)
            }
            RowSet::Object(i) => self.of_object(values, i, hole),
            RowSet::Drive | RowSet::Pair(..) | RowSet::Pairs => Cow::Owned(vec![hole; self.len(row_set)]),
        }
    }

    /// The values of a signal of pairs, as all rows of [`RowSet::Pairs`], with `hole` in each gap.
    pub fn of_pairs<T: Copy>(&self, values: &[T], side: PairSide, hole: T) -> Vec<T> {
        let pairs = self.pairs.as_deref().unwrap_or_default();
        // Stored rows hold frames only.
        let mut firsts = Vec::with_capacity(pairs.len());
        let mut at = 0;
        for p in pairs {
            firsts.push(at);
            at += self.frames_in(p.segment);
        }
        let mut out = Vec::with_capacity(self.pair_rows);
        for (i, p) in pairs.iter().enumerate() {
            let mut next = firsts[if side == PairSide::First { i } else { p.reversed }];
            for row in &self.rows[p.segment.row..p.segment.row + p.segment.len] {
                let value = row.frame.map(|_| {
                    next += 1;
                    values.get(next - 1).copied().unwrap_or(hole)
                });
                out.push(value.unwrap_or(hole));
            }
        }
        out
    }

    fn frames_in(&self, segment: Segment) -> usize {
        self.rows[segment.row..segment.row + segment.len].iter().filter(|r| r.frame.is_some()).count()
    }

    /// The rows of a stored column of `len` values that are the rows of a row set, where they are a subset without
    /// changes.
    pub fn stored_rows(&self, row_set: RowSet, of_target: bool, len: usize) -> Option<Range<usize>> {
        let rows = match row_set {
            _ if self.gaps => return None,
            RowSet::Drive if !of_target => 0..self.rows.len(),
            RowSet::Objects if of_target && self.dense => 0..self.object_rows,
            RowSet::Object(i) if of_target => self.first_rows[i]..self.first_rows[i] + self.objects[i].len,
            _ => return None,
        };
        (rows.end <= len).then_some(rows)
    }

    fn of_object<'v, T: Copy>(&self, values: &'v [T], object: usize, hole: T) -> Cow<'v, [T]> {
        let (segment, first_row, frames) =
            (self.objects[object], self.first_rows[object], self.frames[object]);
        if let (false, Some(rows)) = (self.gaps, values.get(first_row..first_row + segment.len)) {
            return Cow::Borrowed(rows);
        }
        let rows = &self.rows[segment.row..segment.row + segment.len];
        let value = |row: &Row| row.frame.and_then(|f| values.get(first_row + f - frames.start).copied());
        Cow::Owned(rows.iter().map(|r| value(r).unwrap_or(hole)).collect())
    }
}
