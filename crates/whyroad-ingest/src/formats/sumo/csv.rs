//! FCD as CSV: `sumo --fcd-output fcd.csv` (columns `timestep_time;vehicle_id;...`), `xml2csv.py`, or headers without
//! the tag (`time;id;...`). The separator is the first of `;`, `,` and tab that the header has. SUMO quotes no values.

use crate::encodings::input::Input;
use crate::encodings::text::not_utf8;
use std::collections::HashMap;
use std::io::{BufRead, BufReader};

const KINDS: [&str; 3] = ["vehicle", "person", "container"];

/// One row, values by FCD's own attribute names.
pub(super) struct Row<'a> {
    /// `vehicle`, `person`, `container`, or nothing for a row that is only a time step.
    pub kind: Option<&'static str>,
    columns: &'a HashMap<(&'static str, String), usize>,
    cells: &'a [&'a str],
}

impl Row<'_> {
    /// The attribute; empty cells count as absent.
    pub fn get(&self, name: &str) -> Option<&str> {
        let tag = if name == "time" { "timestep" } else { self.kind? };
        let cell = |tag| self.columns.get(&(tag, name.to_owned())).and_then(|&i| self.cells.get(i));
        cell(tag).or_else(|| cell("")).copied().map(str::trim).filter(|c| !c.is_empty())
    }
}

/// Column places by tag (empty where the header has none) and attribute.
fn columns(header: &str, separator: char) -> HashMap<(&'static str, String), usize> {
    let tags = ["timestep"].into_iter().chain(KINDS);
    header
        .trim_start_matches('\u{feff}')
        .split(separator)
        .enumerate()
        .map(|(i, name)| {
            let name = name.trim();
            let tagged =
                tags.clone().find_map(|t| Some((t, name.strip_prefix(t)?.strip_prefix('_')?.to_owned())));
            (tagged.unwrap_or(("", name.to_owned())), i)
        })
        .collect()
}

fn reason(e: &std::io::Error, line: usize) -> String {
    match e.kind() {
        std::io::ErrorKind::InvalidData => not_utf8(line),
        _ => format!("at line {line}: {e}"),
    }
}

/// Hands every row to `visit`. `Err` says why reading stopped.
pub(super) fn for_each_row(input: Input<'_>, mut visit: impl FnMut(Row)) -> Result<(), String> {
    let mut input = BufReader::with_capacity(
        1 << 16,
        crate::encodings::compressed::open(input).map_err(|e| e.to_string())?,
    );
    let mut line = String::new();
    input.read_line(&mut line).map_err(|e| reason(&e, 1))?;
    let header = line.trim_end().to_owned();
    let separator = [';', ',', '\t'].into_iter().find(|s| header.contains(*s)).unwrap_or(';');
    let columns = columns(&header, separator);
    let has = |tag: &'static str, name: &str| columns.contains_key(&(tag, name.to_owned()));
    if !has("timestep", "time") && !has("", "time") {
        return Err("its header has no time and no 'timestep_time'".to_owned());
    }
    let width = header.split(separator).count();
    let mut number = 1;
    loop {
        line.clear();
        number += 1;
        if input.read_line(&mut line).map_err(|e| reason(&e, number))? == 0 {
            return Ok(());
        }
        let cells: Vec<&str> = line.trim_end_matches(['\r', '\n']).split(separator).collect();
        if cells.len() == 1 && cells[0].is_empty() {
            continue;
        }
        if cells.len() != width && !line.ends_with('\n') {
            return Err(format!("line {number} breaks off"));
        }
        let filled = |tag| {
            columns.get(&(tag, "id".to_owned())).and_then(|&i| cells.get(i)).is_some_and(|c| !c.is_empty())
        };
        // Without tags in the header, everything is a vehicle.
        let kind = KINDS.into_iter().find(|k| filled(k)).or_else(|| filled("").then_some("vehicle"));
        visit(Row { kind, columns: &columns, cells: &cells });
    }
}
