//! Collects columns into a [`SignalTable`]. What a column is, and whether the log can support it, the catalogue
//! says; a family only computes.

use crate::catalogue::{Catalogue, SignalKind, SignalScope};
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Column, Drive, Need, SignalTable, Tri};

/// A signal table in the making.
pub struct TableBuilder<'a> {
    catalogue: &'a Catalogue,
    table: SignalTable,
    rows: usize,
}

impl<'a> TableBuilder<'a> {
    /// An empty table for `drive`: one target a track, dense from its first to its last frame.
    pub fn new(catalogue: &'a Catalogue, drive: &Drive) -> Self {
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
            ..SignalTable::default()
        };
        Self { catalogue, table, rows }
    }

    /// Number of target rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The targets, in row order.
    pub fn targets(&self) -> &[TargetSpan] {
        &self.table.targets
    }

    /// A number of target `k` already in the table, in `frame`; NaN where there is none.
    pub fn target_number(&self, name: &str, k: usize, frame: usize) -> f64 {
        let row = self.table.targets[k].row(frame);
        let column = self.table.target_columns.get(name);
        row.zip(column).and_then(|(row, c)| c.number(row)).unwrap_or(f64::NAN)
    }

    /// A column already in the table.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.table.frame_columns.get(name).or_else(|| self.table.target_columns.get(name))
    }

    /// Adds a number signal; one value a frame or target row.
    pub fn number(&mut self, name: &str, values: Vec<f64>) {
        self.add(name, Column::Number(values));
    }

    /// Adds a flag signal.
    pub fn flag(&mut self, name: &str, values: Vec<Tri>) {
        self.add(name, Column::Flag(values));
    }

    /// Adds a category signal from indices into the catalogue's values; `None` is unknown.
    pub fn category(&mut self, name: &str, codes: impl IntoIterator<Item = Option<u16>>) {
        let names = match self.catalogue.get(name).map(|d| &d.kind) {
            Some(SignalKind::Category(names)) => names.clone(),
            _ => std::sync::Arc::from([]),
        };
        let codes = codes.into_iter().map(|c| c.unwrap_or(UNKNOWN_CODE)).collect();
        self.add(name, Column::Category { codes, names });
    }

    fn add(&mut self, name: &str, column: Column) {
        let Some(def) = self.catalogue.get(name) else { return };
        let (columns, rows) = match def.scope {
            SignalScope::Frame => (&mut self.table.frame_columns, self.table.times.len()),
            SignalScope::Target => (&mut self.table.target_columns, self.rows),
        };
        debug_assert_eq!(column.len(), rows, "{name}");
        columns.insert(def.name.clone(), column);
    }

    /// The finished table: what the log cannot support is named instead of given. A signal that nothing computed is
    /// named with what it lacks, or with all that it needs when each part is there but not enough of it.
    pub fn finish(mut self, missing: &BTreeSet<Need>) -> SignalTable {
        let mut unavailable = BTreeMap::new();
        for def in self.catalogue.iter() {
            // A bus that never reports a channel lacks it: "AEB never seen active" must not read as "never active".
            let silent = |need: &Need| {
                *need == Need::VehicleBus
                    && self.table.frame_columns.get(&def.name).is_none_or(|c| c.known_count() == 0)
            };
            let mut lacking: Vec<Need> =
                def.needs.iter().filter(|n| missing.contains(n) || silent(n)).copied().collect();
            let computed = self.table.frame_columns.contains_key(&def.name)
                || self.table.target_columns.contains_key(&def.name);
            if lacking.is_empty() && !computed {
                lacking.clone_from(&def.needs);
            }
            if !lacking.is_empty() || !computed {
                self.table.frame_columns.remove(&def.name);
                self.table.target_columns.remove(&def.name);
                unavailable.insert(def.name.clone(), lacking);
            }
        }
        self.table.unavailable = unavailable;
        self.table
    }
}
