//! Problems of one kind in one table: how many, in which rows, and an example.

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
    pub fn add(&mut self, row: usize) {
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
