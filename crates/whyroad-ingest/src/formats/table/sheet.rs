//! One table, Parquet or CSV, as columns of texts. An empty cell is an unknown value.

use super::problems::Problems;
use crate::encodings::columns::{Columns, read_parquet_bytes};
use crate::encodings::input::Folder;
use crate::encodings::text::utf8;
use whyroad_model::Nanos;

/// `ego.parquet` or `ego.csv` in the folder; the former when both are there.
pub(super) fn sheet_file(dir: Folder<'_>, stem: &str) -> Option<String> {
    ["parquet", "csv"].iter().map(|ext| format!("{stem}.{ext}")).find(|name| dir.has(name))
}

/// The three ways to give a row's time; one of them is enough.
pub(super) const TIME: &[&str] = &["timestamp_ns", "time", "time_s"];

/// How a CSV is written.
#[derive(Clone, Copy, Debug)]
pub(super) struct CsvForm {
    pub separator: u8,
    pub decimal_comma: bool,
}

impl Default for CsvForm {
    fn default() -> Self {
        Self { separator: b',', decimal_comma: false }
    }
}

/// One column as texts.
#[derive(Clone)]
pub(super) struct Column {
    pub name: String,
    /// Its name in the file.
    pub shown: String,
    pub cells: Vec<Option<String>>,
    /// True for times that were brought to nanoseconds since 1970 because the file states their unit.
    pub is_nanoseconds: bool,
}

impl Column {
    pub fn new(name: &str, cells: Vec<Option<String>>) -> Self {
        Self { name: name.to_owned(), shown: name.to_owned(), cells, is_nanoseconds: false }
    }
}

/// A table in memory.
pub(super) struct Sheet {
    /// Path as the user knows it.
    pub label: String,
    /// In the file's order.
    pub columns: Vec<Column>,
    pub rows: usize,
    /// Number of the first row of data: in a CSV the header is row 1, as a spreadsheet shows it.
    pub first_row: usize,
}

impl Sheet {
    /// From the content of the file of this name; times in the column `nanoseconds` are read as such.
    pub fn read(
        name: &str,
        label: &str,
        content: Vec<u8>,
        csv: CsvForm,
        nanoseconds: &str,
    ) -> Result<Self, String> {
        let is_csv = name.ends_with(".csv");
        let columns = if is_csv {
            read_csv(&content, csv)?
        } else {
            texts_of(&read_parquet_bytes(content)?, nanoseconds)?
        };
        let rows = columns.first().map_or(0, |c| c.cells.len());
        Ok(Self { label: label.to_owned(), columns, rows, first_row: if is_csv { 2 } else { 1 } })
    }

    pub fn names(&self) -> Vec<String> {
        self.columns.iter().map(|c| c.name.clone()).collect()
    }

    fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|c| c.name == name)
    }

    pub fn has(&self, name: &str) -> bool {
        self.column(name).is_some()
    }

    /// A column's cells; all unknown when it is not there.
    pub fn texts(&self, name: &str) -> Vec<Option<String>> {
        self.column(name).map_or_else(|| vec![None; self.rows], |c| c.cells.clone())
    }

    /// A column brought to a type; a cell that cannot be is unknown and goes to the problems.
    pub fn parsed<T>(
        &self,
        name: &str,
        expected: &'static str,
        problems: &mut Problems,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Vec<Option<T>> {
        let Some(column) = self.column(name) else {
            return (0..self.rows).map(|_| None).collect();
        };
        let cells = column.cells.iter();
        cells
            .enumerate()
            .map(|(i, cell)| {
                let text = cell.as_deref()?;
                let value = parse(text);
                if value.is_none() {
                    problems.cell(&column.shown, expected, self.first_row + i, text);
                }
                value
            })
            .collect()
    }

    /// A column of numbers; NaN is unknown.
    pub fn numbers(&self, name: &str, problems: &mut Problems) -> Vec<f64> {
        let number = |text: &str| text.parse::<f64>().ok().filter(|v| !v.is_infinite());
        self.parsed(name, "a number", problems, number).into_iter().map(|v| v.unwrap_or(f64::NAN)).collect()
    }

    /// A column of sizes; what is not above zero is unknown.
    pub fn sizes(&self, name: &str, problems: &mut Problems) -> Vec<f64> {
        let size =
            |text: &str| text.parse::<f64>().ok().filter(|v| v.is_nan() || (*v > 0.0 && v.is_finite()));
        self.parsed(name, "a number above 0", problems, size)
            .into_iter()
            .map(|v| v.unwrap_or(f64::NAN))
            .collect()
    }

    /// A column of truth values.
    pub fn flags(&self, name: &str, problems: &mut Problems) -> Vec<Option<bool>> {
        self.parsed(name, "true or false", problems, |text| match text.to_ascii_lowercase().as_str() {
            "true" | "1" | "1.0" => Some(true),
            "false" | "0" | "0.0" => Some(false),
            _ => None,
        })
    }

    /// A column of words of a closed set, spelled as in the lake.
    pub fn words<T: serde::de::DeserializeOwned>(
        &self,
        name: &str,
        expected: &'static str,
        problems: &mut Problems,
    ) -> Vec<Option<T>> {
        self.parsed(name, expected, problems, |text| {
            serde_json::from_value(serde_json::Value::String(text.to_ascii_lowercase())).ok()
        })
    }

    /// The heading in radians, from whichever of the two columns is there.
    pub fn headings(&self, problems: &mut Problems) -> Vec<f64> {
        if self.has("heading_rad") {
            return self.numbers("heading_rad", problems);
        }
        self.numbers("heading_deg", problems).into_iter().map(f64::to_radians).collect()
    }

    /// True where its times are dates and not seconds after a start.
    pub fn states_dates(&self) -> bool {
        self.has("timestamp_ns") || self.has("time")
    }

    /// Times in ns since 1970, from whichever of the three columns is there.
    pub fn times(&self, start: Nanos, problems: &mut Problems) -> Vec<Option<i64>> {
        if self.has("timestamp_ns") {
            self.parsed("timestamp_ns", "a whole number of nanoseconds", problems, |t| t.parse().ok())
        } else if self.has("time") {
            self.parsed("time", "an ISO 8601 time with an offset from UTC", problems, |t| {
                Nanos::parse_iso(t).ok().map(|t| t.0)
            })
        } else {
            let seconds = |t: &str| t.parse::<f64>().ok().filter(|v| v.is_finite());
            self.parsed("time_s", "a number of seconds", problems, |t| Some(start.plus_secs(seconds(t)?).0))
        }
    }
}

fn read_csv(content: &[u8], form: CsvForm) -> Result<Vec<Column>, String> {
    if content.is_empty() {
        return Err("it is empty".to_owned());
    }
    if content.starts_with(b"PAR1") {
        return Err("it is a Parquet file; give it the ending .parquet".to_owned());
    }
    let text = utf8(content)?;
    let first = text.lines().next().unwrap_or_default();
    if let Some(sign) =
        [(';', "semicolons"), ('\t', "tabs"), ('|', "bars")].into_iter().find_map(|(c, sign)| {
            let separator = char::from(form.separator);
            (c != separator && !first.contains(separator) && first.contains(c)).then_some(sign)
        })
    {
        return Err(format!("its columns are separated by {sign}; save it with commas and decimal points"));
    }
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(form.separator)
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(content);
    let header = reader.headers().map_err(|e| e.to_string())?.clone();
    // Spreadsheets begin UTF-8 files with a byte order mark.
    let name = |n: &str| n.trim_start_matches('\u{feff}').to_owned();
    let mut columns: Vec<_> = header.iter().map(|n| Column::new(&name(n), Vec::new())).collect();
    for record in reader.records() {
        let record = record.map_err(|e| e.to_string())?;
        // A row that breaks off or has too much, as in a file that was cut off, says nothing.
        let is_whole = record.len() == header.len();
        for (i, column) in columns.iter_mut().enumerate() {
            let text = record.get(i).filter(|text| is_whole && !text.is_empty());
            column
                .cells
                .push(text.map(|text| if form.decimal_comma { with_point(text) } else { text.to_owned() }));
        }
    }
    Ok(columns)
}

/// A number with its decimal comma replaced; any other text as it is.
fn with_point(text: &str) -> String {
    let number = text.replacen(',', ".", 1);
    if number.parse::<f64>().is_ok() { number } else { text.to_owned() }
}

fn texts_of(table: &Columns, nanoseconds: &str) -> Result<Vec<Column>, String> {
    let texts = |name: String| {
        // Programs write times into a column of times.
        let is_nanoseconds = name == nanoseconds && table.has_times(&name);
        let cells = if is_nanoseconds { table.nanosecond_texts(&name) } else { table.texts(&name) };
        cells.map(|cells| Column { is_nanoseconds, ..Column::new(&name, cells) })
    };
    table.names().into_iter().map(texts).collect()
}

/// A list of ids or words.
pub(super) fn list(cell: &Option<String>) -> Vec<String> {
    let ids = cell.as_deref().unwrap_or_default().split(';').map(str::trim).filter(|id| !id.is_empty());
    ids.map(str::to_owned).collect()
}
