//! Cells that cannot be read and rows that cannot be kept, gathered by reason with the rows' numbers.

use super::findings;
use crate::report::RowCount;
use std::collections::BTreeMap;
use whyroad_model::Diagnostic;

/// Rows that are named one by one; of the rest there is the number.
const NAMED_ROWS: usize = 5;

/// What is wrong with one column's cells or one kind of rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Group {
    pub count: usize,
    /// The first few, as the file numbers them.
    pub rows: Vec<usize>,
    /// The first bad cell.
    pub example: String,
    pub expected: &'static str,
}

impl Group {
    fn add(&mut self, row: usize) {
        self.count += 1;
        if self.rows.len() < NAMED_ROWS {
            self.rows.push(row);
        }
    }

    /// `2, 5, 9, ...`
    pub fn rows_text(&self) -> String {
        let mut text = self.rows.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        if self.count > self.rows.len() {
            text += ", ...";
        }
        text
    }
}

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

    /// Takes note of a row that is dropped.
    pub fn row(&mut self, reason: &'static str, row: usize, count: &mut RowCount) {
        count.drop_rows(reason, 1);
        self.rows.entry(reason).or_default().add(row);
    }

    pub fn diagnostics(&self, file: &str) -> Vec<Diagnostic> {
        let cells = self.cells.iter().map(|(column, g)| findings::bad_cells(file, column, g));
        cells.chain(self.rows.iter().map(|(reason, g)| findings::dropped_rows(file, reason, g))).collect()
    }
}
