//! Cells that cannot be read and rows that cannot be kept, gathered by reason with the rows' numbers.

use super::findings;
use super::group::Group;
use crate::report::RowCount;
use std::collections::BTreeMap;
use whyroad_model::Diagnostic;

/// Everything that is wrong inside one table.
#[derive(Debug, Default)]
pub(super) struct Problems {
    cells: BTreeMap<String, Group>,
    rows: BTreeMap<&'static str, Group>,
}

impl Problems {
    pub fn cell(&mut self, column: &str, expected: &'static str, row: usize, text: &str) {
        let group = self.cells.entry(column.to_owned()).or_default();
        if group.count == 0 {
            (group.example, group.expected) = (text.to_owned(), expected);
        }
        group.add(row);
    }

    /// Records a dropped row.
    pub fn row(&mut self, reason: &'static str, row: usize, count: &mut RowCount) {
        count.drop_rows(reason, 1);
        self.rows.entry(reason).or_default().add(row);
    }

    pub fn diagnostics(&self, file: &str) -> Vec<Diagnostic> {
        let cells = self.cells.iter().map(|(column, g)| findings::bad_cells(file, column, g));
        cells.chain(self.rows.iter().map(|(reason, g)| findings::dropped_rows(file, reason, g))).collect()
    }
}
