//! Collects columns into a [`SignalTable`]. The compiler checks scope and type of a column, which are in each signal's
//! constant in [`whyroad_model::catalog::id`]. A family only computes values.

use crate::catalog::{Catalog, SignalKind};
use crate::needs::without_boxes;
use crate::wanted::Wanted;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use whyroad_model::catalog::{
    Category, CategoryValue, Flag, Number, PerFrame, PerTarget, Signal, SignalScope,
};
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Column, Drive, Need, ObjectClass, SignalId, SignalTable, Tri};

/// A column of a target signal: one value per row of the table.
#[derive(Clone, Debug)]
pub struct TargetRows<T>(pub Vec<T>);

impl<T> TargetRows<T> {
    /// Each value mapped by `f`.
    pub fn map<U>(&self, f: impl Fn(&T) -> U) -> TargetRows<U> {
        TargetRows(self.0.iter().map(f).collect())
    }
}

/// Container for the values of a signal of this scope.
pub trait Scoped {
    /// One value per frame, or one per target row.
    type Values<T>: Into<Vec<T>>;
}

impl Scoped for PerFrame {
    type Values<T> = Vec<T>;
}

impl Scoped for PerTarget {
    type Values<T> = TargetRows<T>;
}

impl<T> From<TargetRows<T>> for Vec<T> {
    fn from(rows: TargetRows<T>) -> Self {
        rows.0
    }
}

/// Values of a category signal of scope `S`: anything that yields one per frame, or [`TargetRows`].
pub trait CategoryValues<S, C> {
    /// Codes, unknown where there is no value.
    fn codes(self) -> Vec<u16>;
}

fn codes<C: CategoryValue>(values: impl IntoIterator<Item = Option<C>>) -> Vec<u16> {
    values.into_iter().map(|v| v.map_or(UNKNOWN_CODE, C::code)).collect()
}

impl<C: CategoryValue, I: IntoIterator<Item = Option<C>>> CategoryValues<PerFrame, C> for I {
    fn codes(self) -> Vec<u16> {
        codes(self)
    }
}

impl<C: CategoryValue> CategoryValues<PerTarget, C> for TargetRows<Option<C>> {
    fn codes(self) -> Vec<u16> {
        codes(self.0)
    }
}

/// A signal table under construction.
pub struct TableBuilder<'a> {
    catalog: &'a Catalog,
    table: SignalTable,
    rows: usize,
    wanted: &'a Wanted,
    partial: BTreeSet<SignalId>,
    /// Frames in which nothing observed the objects.
    unobserved: Vec<usize>,
}

impl<'a> TableBuilder<'a> {
    /// An empty table for `drive`: one target per track, dense from its first to its last frame. It is for the `wanted`
    /// signals; others may be missing.
    pub fn new(catalog: &'a Catalog, drive: &Drive, wanted: &'a Wanted) -> Self {
        let mut rows = 0;
        let mut targets = Vec::with_capacity(drive.tracks.len());
        for track in drive.tracks.iter().filter(|t| !t.frames.is_empty()) {
            let frames = track.span();
            targets.push(TargetSpan { id: track.id.clone(), class: track.class, first_row: rows, frames });
            rows += frames.len();
        }
        let table = SignalTable {
            drive_id: drive.meta.drive_id.clone(),
            times: drive.times.clone(),
            targets,
            without_boxes: without_boxes(drive),
            ..SignalTable::default()
        };
        let unobserved = |&frame: &usize| drive.meta.are_objects_unknown(drive.times[frame]);
        let unobserved = (0..drive.times.len()).filter(unobserved).collect();
        Self { catalog, table, rows, wanted, partial: BTreeSet::new(), unobserved }
    }

    /// True if some signal of the family is requested.
    pub fn asks(&self, family: &[SignalId]) -> bool {
        self.wanted.any(family)
    }

    /// Classes of objects of which no box is known.
    pub fn without_boxes(&self) -> &BTreeSet<ObjectClass> {
        &self.table.without_boxes
    }

    /// Number of target rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The targets, in row order.
    pub fn targets(&self) -> &[TargetSpan] {
        &self.table.targets
    }

    fn column(&self, id: SignalId) -> Option<&Column> {
        match id.scope() {
            SignalScope::Frame => self.table.frame_columns.get(id.name()),
            SignalScope::Target | SignalScope::Object => self.table.target_columns.get(id.name()),
            SignalScope::Pair => self.table.pairs.as_ref()?.columns.get(id.name()),
        }
    }

    /// True if the signal is in the table already.
    pub fn has<S, K>(&self, id: Signal<S, K>) -> bool {
        self.column(id.id()).is_some()
    }

    /// A number of target `k` already in the table, in `frame`; NaN if there is none.
    pub fn target_number(&self, id: Signal<PerTarget, Number>, k: usize, frame: usize) -> f64 {
        let row = self.table.targets[k].row(frame);
        row.zip(self.column(id.id())).and_then(|(row, c)| c.number(row)).unwrap_or(f64::NAN)
    }

    /// A category of target `k` already in the table, in `frame`.
    pub fn target_category<C: CategoryValue>(
        &self,
        id: Signal<PerTarget, Category<C>>,
        k: usize,
        frame: usize,
    ) -> Option<C> {
        let row = self.table.targets[k].row(frame)?;
        match self.column(id.id())? {
            Column::Category { codes, .. } => C::from_code(codes[row]),
            _ => None,
        }
    }

    /// The numbers of a frame signal already in the table.
    pub fn numbers(&self, id: Signal<PerFrame, Number>) -> Option<&[f64]> {
        match self.column(id.id())? {
            Column::Number(values) => Some(values),
            _ => None,
        }
    }

    /// The flags of a frame signal already in the table.
    pub fn flags(&self, id: Signal<PerFrame, Flag>) -> Option<&[Tri]> {
        match self.column(id.id())? {
            Column::Flag(values) => Some(values),
            _ => None,
        }
    }

    /// Adds a number signal.
    pub fn number<S: Scoped>(&mut self, id: Signal<S, Number>, values: S::Values<f64>) {
        self.add(id.id(), Column::Number(values.into()));
    }

    /// Adds a flag signal.
    pub fn flag<S: Scoped>(&mut self, id: Signal<S, Flag>, values: S::Values<Tri>) {
        self.add(id.id(), Column::Flag(values.into()));
    }

    /// Adds a category signal; `None` is unknown.
    pub fn category<S, C: CategoryValue>(
        &mut self,
        id: Signal<S, Category<C>>,
        values: impl CategoryValues<S, C>,
    ) {
        let names: Arc<[String]> = match self.catalog.get(id.id().name()).map(|d| &d.kind) {
            Some(SignalKind::Category(names)) => names.clone(),
            _ => C::NAMES.iter().map(|n| (*n).to_owned()).collect(),
        };
        self.add(id.id(), Column::Category { codes: values.codes(), names });
    }

    /// Declares that the values of a signal follow from less than it needs: they are right where they are known, and
    /// that they are unknown elsewhere says nothing.
    pub fn is_partial(&mut self, id: SignalId) {
        self.partial.insert(id);
    }

    fn add(&mut self, id: SignalId, column: Column) {
        let (columns, rows) = match id.scope() {
            SignalScope::Frame => (&mut self.table.frame_columns, self.table.times.len()),
            SignalScope::Target | SignalScope::Object => (&mut self.table.target_columns, self.rows),
            SignalScope::Pair => return,
        };
        debug_assert_eq!(column.len(), rows, "{id}");
        columns.insert(id.name().to_owned(), column);
    }

    /// The finished table: a signal that the log cannot support is listed with the missing data instead. A signal of a
    /// frame that needs objects is unknown in the frames in which nothing observed them. A signal without computed
    /// values is listed with its missing needs, or with all its needs if each of them is present but insufficient. A
    /// partial signal stays in the table, with its missing needs, as does one that needs what is missing `in_part`.
    pub fn finish(mut self, missing: &BTreeSet<Need>, in_part: Option<Need>) -> SignalTable {
        let (mut unavailable, mut partial) = (BTreeMap::new(), BTreeMap::new());
        for def in self.catalog.iter().filter(|d| !d.scope.is_on_demand() && self.wanted.has(&d.name)) {
            // A bus that never reports a channel lacks it: "AEB never seen active" must not be read as "never active".
            let silent = |need: &Need| {
                *need == Need::VehicleBus
                    && self.table.frame_columns.get(&def.name).is_none_or(|c| c.known_count() == 0)
            };
            let mut lacking: Vec<Need> =
                def.needs.iter().filter(|n| missing.contains(n) || silent(n)).copied().collect();
            let computed = self.table.frame_columns.contains_key(&def.name)
                || self.table.target_columns.contains_key(&def.name);
            if computed && self.partial.iter().any(|id| id.name() == def.name) {
                partial.insert(def.name.clone(), lacking);
                continue;
            }
            if lacking.is_empty() && !computed {
                lacking.clone_from(&def.needs);
            }
            if let Some(column) = self.table.frame_columns.get_mut(&def.name)
                && def.needs.contains(&Need::Objects)
            {
                self.unobserved.iter().for_each(|&frame| column.forget(frame));
            }
            if !lacking.is_empty() || !computed {
                self.table.frame_columns.remove(&def.name);
                self.table.target_columns.remove(&def.name);
                unavailable.insert(def.name.clone(), lacking);
            } else if let Some(need) = in_part.filter(|need| def.needs.contains(need)) {
                partial.insert(def.name.clone(), vec![need]);
            }
        }
        (self.table.unavailable, self.table.partial) = (unavailable, partial);
        self.table
    }
}
