//! From observed rows of tracks to the dense rows of target columns: frames in which a target was not observed stay
//! unknown.

use crate::table::{TableBuilder, TargetRows};
use crate::target::placement::{Placement, Target};
use whyroad_model::Tri;
use whyroad_model::catalog::CategoryValue;
use whyroad_model::scene::{Drive, Track};

/// The row layout of one table.
pub struct Rows<'a> {
    tracks: Vec<&'a Track>,
    first_rows: Vec<usize>,
    count: usize,
}

impl<'a> Rows<'a> {
    /// The layout of `table`, which was created for `drive`.
    pub fn new(drive: &'a Drive, table: &TableBuilder<'_>) -> Self {
        Self {
            tracks: observed_tracks(drive).collect(),
            first_rows: table.targets().iter().map(|t| t.first_row).collect(),
            count: table.rows(),
        }
    }

    fn fill<T: Clone>(&self, unknown: T, value: impl Fn(usize, &Track, usize) -> T) -> TargetRows<T> {
        let mut column = vec![unknown; self.count];
        for (k, (track, first)) in self.tracks.iter().zip(&self.first_rows).enumerate() {
            let (rows, start) = (&mut column[*first..], track.frames[0]);
            for (row, frame) in track.frames.iter().enumerate() {
                rows[(frame - start) as usize] = value(k, track, row);
            }
        }
        TargetRows(column)
    }

    /// A value in all observed rows of each track.
    pub fn per_track<T: Clone>(&self, unknown: T, value: impl Fn(&Track) -> T) -> TargetRows<T> {
        let values: Vec<T> = self.tracks.iter().map(|track| value(track)).collect();
        self.fill(unknown, |k, _, _| values[k].clone())
    }

    /// A number per row of each track.
    pub fn numbers(&self, value: impl Fn(&Track, usize) -> f64) -> TargetRows<f64> {
        self.fill(f64::NAN, |_, t, r| value(t, r))
    }

    /// Several columns of numbers in one pass, from `(target index, row, track)`.
    pub fn columns<const N: usize>(
        &self,
        value: impl Fn(usize, usize, &Track) -> [f64; N],
    ) -> [TargetRows<f64>; N] {
        let mut columns = [(); N].map(|()| vec![f64::NAN; self.count]);
        for (k, (track, first)) in self.tracks.iter().zip(&self.first_rows).enumerate() {
            let start = track.frames[0];
            for (row, frame) in track.frames.iter().enumerate() {
                let at = first + (frame - start) as usize;
                for (column, value) in columns.iter_mut().zip(value(k, row, track)) {
                    column[at] = value;
                }
            }
        }
        columns.map(TargetRows)
    }

    /// Several columns of numbers in one pass, from `(target index, row, placement)`; unknown where there is no
    /// placement.
    pub fn placed_columns<const N: usize>(
        &self,
        targets: &[Target<'_>],
        value: impl Fn(usize, usize, &Placement) -> [f64; N],
    ) -> [TargetRows<f64>; N] {
        self.columns(|k, r, _| targets[k].places[r].as_ref().map_or([f64::NAN; N], |p| value(k, r, p)))
    }

    /// A flag per row, unknown where not observed.
    pub fn flags(&self, value: impl Fn(&Track, usize) -> Tri) -> TargetRows<Tri> {
        self.flags_or(Tri::Unknown, value)
    }

    /// A flag per row, `unseen` where not observed.
    pub fn flags_or(&self, unseen: Tri, value: impl Fn(&Track, usize) -> Tri) -> TargetRows<Tri> {
        self.fill(unseen, |_, t, r| value(t, r))
    }

    /// A category value per row.
    pub fn values<C: CategoryValue>(
        &self,
        value: impl Fn(&Track, usize) -> Option<C>,
    ) -> TargetRows<Option<C>> {
        self.fill(None, |_, t, r| value(t, r))
    }

    /// A value per row from `(target index, row, placement)`; rows are those of `targets[k].track`.
    pub fn spread<T: Clone>(
        &self,
        targets: &[Target<'_>],
        unknown: T,
        value: impl Fn(usize, usize, Option<&Placement>) -> T,
    ) -> TargetRows<T> {
        let mut column = vec![unknown; self.count];
        for (k, ((track, first), target)) in self.tracks.iter().zip(&self.first_rows).zip(targets).enumerate()
        {
            let (rows, start) = (&mut column[*first..], track.frames[0]);
            for (row, (frame, place)) in track.frames.iter().zip(&target.places).enumerate() {
                rows[(frame - start) as usize] = value(k, row, place.as_ref());
            }
        }
        TargetRows(column)
    }

    /// A column in which every row is unknown, for [`Rows::each_placed`].
    pub fn column<T: Clone>(&self, unknown: T) -> TargetRows<T> {
        TargetRows(vec![unknown; self.count])
    }

    /// Visits all placed rows once, for several columns of different types: placements are large, and reading them all
    /// takes longer than what is computed from one. The arguments are the row of the table, the target's index with the
    /// row of its track, and the placement.
    pub fn each_placed(
        &self,
        targets: &[Target<'_>],
        mut visit: impl FnMut(usize, (usize, usize), &Placement),
    ) {
        for (k, (target, first)) in targets.iter().zip(&self.first_rows).enumerate() {
            let start = target.track.frames[0];
            for (row, (frame, place)) in target.track.frames.iter().zip(&target.places).enumerate() {
                if let Some(place) = place {
                    visit(first + (frame - start) as usize, (k, row), place);
                }
            }
        }
    }

    /// A value per placed row; unknown where there is no placement.
    pub fn placed<T: Clone>(
        &self,
        targets: &[Target<'_>],
        unknown: T,
        value: impl Fn(&Placement) -> T,
    ) -> TargetRows<T> {
        self.spread(targets, unknown.clone(), |_, _, p| p.map_or(unknown.clone(), &value))
    }
}

/// Tracks that have rows; the order of the targets.
pub fn observed_tracks(drive: &Drive) -> impl Iterator<Item = &Track> {
    drive.tracks.iter().filter(|t| !t.frames.is_empty())
}
