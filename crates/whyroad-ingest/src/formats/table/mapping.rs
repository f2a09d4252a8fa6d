//! The mapping file (`--mapping FILE`): which files and columns of a fleet's own tables are those of the layout, in
//! which units, axes and words. Reading it; `mapped` applies it. Documented in `docs/reference/table-mapping.md`.

mod axes;
mod units;

use super::layout::{EGO_KEYS, KEYS, TABLES, columns_of};
use super::sheet::CsvForm;
use crate::assemble::class_names::class_of;
use crate::mapping_file::{self, class, number, one_of, unknown_word};
pub(super) use axes::{Axes, Headings};
use std::collections::BTreeMap;
pub(super) use units::{Dimension, Unit};
use whyroad_model::suggest::suggestion_or_known;
use whyroad_model::yaml::{Fields, FileReport, FormCodes, Node, Value};
use whyroad_model::{Bilingual, Diagnostic, ObjectClass};

/// Everything that is wrong with a mapping file has one code.
static FORM: FormCodes = FormCodes {
    syntax: "table.mapping",
    missing: "table.mapping",
    unknown: "table.mapping",
    kind: "table.mapping",
    duplicate: "table.mapping",
    empty: "table.mapping",
};

/// The mapping file; the default describes tables in the layout itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Mapping {
    /// What drives without a drive file, or without one of its keys, have in common.
    pub drive: Option<Node>,
    pub csv: CsvForm,
    /// The fleet's class names and ours.
    pub classes: BTreeMap<String, ObjectClass>,
    /// By name of the table; those that the file does not name follow the file's axes alone.
    pub tables: BTreeMap<&'static str, TableMapping>,
}

/// How one table is read.
#[derive(Clone, Debug)]
pub(super) struct TableMapping {
    /// Name of its file; `*` stands for any text.
    pub file: Option<String>,
    pub axes: Axes,
    pub headings: Headings,
    /// By our name.
    pub columns: BTreeMap<&'static str, ColumnMapping>,
    /// Texts that mean unknown in every column.
    pub unknown: Vec<String>,
}

/// Where the cells of one of our columns come from.
#[derive(Clone, Debug)]
pub(super) struct ColumnMapping {
    pub source: ColumnSource,
    /// The source's; ours when there is none.
    pub unit: Option<Unit>,
    /// Applied to the source's number before its unit: `number * scale + offset`.
    pub scale: f64,
    pub offset: f64,
    /// Numbers and texts of the source that mean unknown.
    pub unknown: Vec<String>,
    /// The source's words and ours.
    pub words: BTreeMap<String, String>,
}

#[derive(Clone, Debug)]
pub(super) enum ColumnSource {
    Column(String),
    /// One value for all rows.
    Constant(String),
    /// One value per class of objects; unknown for the others.
    ByClass(BTreeMap<ObjectClass, String>),
}

/// True when a cell is what a mapping names: the same text, or the same number.
pub(super) fn is_same(cell: &str, named: &str) -> bool {
    cell == named || matches!((cell.parse::<f64>(), named.parse::<f64>()), (Ok(a), Ok(b)) if a == b)
}

impl Mapping {
    /// Reads the text of a mapping file; with an error there is no mapping.
    pub fn read(file: &str, text: &str) -> (Option<Self>, Vec<Diagnostic>) {
        mapping_file::read((file, text), &FORM, mapping)
    }

    /// Our class of a fleet's class name.
    pub fn class(&self, name: &str) -> Option<ObjectClass> {
        let own = self.classes.get(name).or_else(|| {
            let number: f64 = name.parse().ok()?;
            self.classes.iter().find(|(k, _)| k.parse() == Ok(number)).map(|(_, class)| class)
        });
        own.copied().or_else(|| class_of(name))
    }
}

fn mapping(root: &Node, report: &mut FileReport) -> Option<Mapping> {
    let mut out = Mapping::default();
    let mut fields = Fields::open(root, report)?;
    if let Some(node) = fields.get("drive") {
        check_drive(node, report);
        out.drive = Some(node.clone());
    }
    let (axes, headings) = orientation(&mut fields, report);
    let unknown = unknown_texts(&mut fields, report);
    if let Some(node) = fields.get("csv") {
        out.csv = csv_form(node, report).unwrap_or_default();
    }
    if let Some(node) = fields.get("classes") {
        for entry in report.entries(node).unwrap_or_default() {
            if let Some(class) = class(&entry.node, report) {
                out.classes.insert(entry.key.clone(), class);
            }
        }
    }
    for table in TABLES {
        let axes = axes.unwrap_or_default();
        let headings = headings.unwrap_or(axes.headings());
        let (columns, unknown) = (BTreeMap::new(), unknown.clone());
        out.tables.insert(table, TableMapping { file: None, axes, headings, columns, unknown });
    }
    if let Some(node) = fields.get("tables") {
        for entry in report.entries(node).unwrap_or_default() {
            let Some(name) = TABLES.iter().find(|t| **t == entry.key) else {
                unknown_key(&entry.key, &entry.node, TABLES, report);
                continue;
            };
            if let Some(table) = out.tables.get_mut(name) {
                read_table(name, &entry.node, table, report);
            }
        }
    }
    fields.close(report);
    Some(out)
}

/// A key that is not one of `known`.
fn unknown_key(key: &str, node: &Node, known: &[&str], report: &mut FileReport) {
    let message = Bilingual::new(format!("未知字段 '{key}'"), format!("unknown field '{key}'"));
    report.error_with_hint(FORM.unknown, node, message, suggestion_or_known(key, known.iter().copied()));
}

/// The keys of a drive file that several drives can share: all but its id.
fn check_drive(node: &Node, report: &mut FileReport) {
    let Some(mut fields) = Fields::open(node, report) else { return };
    for key in KEYS.iter().copied().filter(|k| *k != "drive_id") {
        let Some(node) = fields.get(key) else { continue };
        if key == "ego"
            && let Some(mut ego) = Fields::open(node, report)
        {
            for key in EGO_KEYS {
                if let Some(node) = ego.get(key) {
                    number(node, report);
                }
            }
            ego.close(report);
        }
    }
    fields.close(report);
}

fn orientation(fields: &mut Fields<'_>, report: &mut FileReport) -> (Option<Axes>, Option<Headings>) {
    let axes = fields.get("axes").and_then(|n| one_of(n, report, Axes::from_id, Axes::IDS));
    let headings = fields.get("headings").and_then(|n| one_of(n, report, Headings::from_id, Headings::IDS));
    (axes, headings)
}

/// Texts that mean unknown wherever they are. A number would be a good value in some column.
fn unknown_texts(fields: &mut Fields<'_>, report: &mut FileReport) -> Vec<String> {
    let mut out = Vec::new();
    for node in fields.list("unknown", report) {
        let Some(text) = report.text(node) else { continue };
        if text.parse::<f64>().is_ok_and(f64::is_finite) {
            let message = Bilingual::new(
                format!("数值 '{text}' 不能在所有列中都表示未知"),
                format!("the number '{text}' cannot mean unknown in every column"),
            );
            let hint = Bilingual::new(
                format!("写在有此含义的列中：{{ column: ..., unknown: [{text}] }}"),
                format!("state it at the columns that mean it so: {{ column: ..., unknown: [{text}] }}"),
            );
            report.error_with_hint(FORM.kind, node, message, hint);
        } else {
            out.push(text);
        }
    }
    out
}

fn csv_form(node: &Node, report: &mut FileReport) -> Option<CsvForm> {
    let mut fields = Fields::open(node, report)?;
    let separator = fields.get("separator").and_then(|n| match &n.value {
        // Not `report.text`, which takes a tab for an empty text.
        Value::Scalar(s) if [",", ";", "\t", "|"].contains(&s.text.as_str()) => s.text.bytes().next(),
        other => {
            let text = other.text().map_or_else(|| other.description().en, str::to_owned);
            unknown_word(n, report, &text, &[",", ";", "\\t", "|"]);
            None
        }
    });
    let decimal = fields
        .get("decimal")
        .and_then(|n| one_of(n, report, |t| [".", ","].contains(&t).then_some(t == ","), &[".", ","]));
    fields.close(report);
    Some(CsvForm { separator: separator.unwrap_or(b','), decimal_comma: decimal.unwrap_or(false) })
}

fn read_table(name: &'static str, node: &Node, table: &mut TableMapping, report: &mut FileReport) {
    let Some(mut fields) = Fields::open(node, report) else { return };
    if let Some(node) = fields.get("file")
        && let Some(text) = report.text(node)
    {
        let ending = text.rsplit_once('.').map_or("", |(_, ending)| ending);
        if text.contains(['/', '\\']) || !["csv", "parquet"].contains(&ending) {
            let message = Bilingual::new(
                format!("'{text}' 不是行程文件夹中 CSV 或 Parquet 文件的名称"),
                format!("'{text}' is not the name of a CSV or Parquet file in the folder of a drive"),
            );
            let hint = Bilingual::new(
                "写文件名，含 .csv 或 .parquet；* 代表任意文字",
                "write the name with .csv or .parquet; * stands for any text",
            );
            report.error_with_hint(FORM.kind, node, message, hint);
        } else {
            table.file = Some(text);
        }
    }
    let (axes, headings) = orientation(&mut fields, report);
    if let Some(axes) = axes {
        table.axes = axes;
        table.headings = axes.headings();
    }
    table.headings = headings.unwrap_or(table.headings);
    table.unknown.extend(unknown_texts(&mut fields, report));
    if let Some(node) = fields.get("columns") {
        let known = columns_of(name);
        for entry in report.entries(node).unwrap_or_default() {
            let Some(column) = known.iter().find(|c| **c == entry.key) else {
                unknown_key(&entry.key, &entry.node, known, report);
                continue;
            };
            if let Some(mapped) = read_column(name, column, &entry.node, report) {
                table.columns.insert(column, mapped);
            }
        }
    }
    fields.close(report);
}

/// `name`, or `{ column: name, ... }`, or `{ value: constant, ... }`.
fn read_column(
    table: &str,
    column: &'static str,
    node: &Node,
    report: &mut FileReport,
) -> Option<ColumnMapping> {
    let mut out = ColumnMapping {
        source: ColumnSource::Column(String::new()),
        unit: None,
        scale: 1.0,
        offset: 0.0,
        unknown: Vec::new(),
        words: BTreeMap::new(),
    };
    if matches!(node.value, Value::Scalar(_)) {
        out.source = ColumnSource::Column(report.text(node)?);
        return Some(out);
    }
    let mut fields = Fields::open(node, report)?;
    let of_column = fields.text_opt("column", report);
    let constant = fields.get("value");
    out.source = match (of_column, constant) {
        (Some(name), None) => ColumnSource::Column(name),
        (None, Some(node)) if matches!(node.value, Value::Map(_)) && table == "objects" => {
            ColumnSource::ByClass(by_class(node, report)?)
        }
        (None, Some(node)) => ColumnSource::Constant(report.text(node)?),
        _ => {
            let message = Bilingual::new(
                format!("'{column}' 需要 'column' 或 'value' 之一"),
                format!("'{column}' needs either 'column' or 'value'"),
            );
            let hint = Bilingual::new(
                "column：文件中的列名；value：文件中没有该列时所有行的值",
                "column: the name of the column in the file; value: one for all rows, where the file has no such column",
            );
            report.error_with_hint(FORM.missing, node, message, hint);
            return None;
        }
    };
    out.unit = fields.get("unit").and_then(|n| unit(column, n, report));
    for (key, slot) in [("scale", &mut out.scale), ("offset", &mut out.offset)] {
        if let Some(n) = fields.get(key) {
            if Dimension::of_column(column).is_none() || column == "timestamp_ns" {
                let message = Bilingual::new(
                    format!("列 '{column}' 不能用 '{key}'"),
                    format!("column '{column}' cannot have '{key}'"),
                );
                let hint = Bilingual::new(
                    "只用于有单位的数值列；时间戳用 'unit'",
                    "it is for columns of numbers with a unit; time stamps have 'unit'",
                );
                report.error_with_hint(FORM.kind, n, message, hint);
            }
            *slot = number(n, report).unwrap_or(*slot);
        }
    }
    out.unknown = fields.list("unknown", report).iter().filter_map(|n| report.text(n)).collect();
    if let Some(n) = fields.get("words") {
        for entry in report.entries(n).unwrap_or_default() {
            if let Some(word) = report.text(&entry.node) {
                out.words.insert(entry.key.clone(), word);
            }
        }
    }
    fields.close(report);
    Some(out)
}

fn by_class(node: &Node, report: &mut FileReport) -> Option<BTreeMap<ObjectClass, String>> {
    let ids: Vec<&str> = ObjectClass::ALL.iter().map(|c| c.id()).collect();
    let mut out = BTreeMap::new();
    for entry in report.entries(node)? {
        match ObjectClass::from_id(&entry.key) {
            Some(class) => out.extend(report.text(&entry.node).map(|text| (class, text))),
            None => unknown_key(&entry.key, &entry.node, &ids, report),
        }
    }
    Some(out)
}

fn unit(column: &str, node: &Node, report: &mut FileReport) -> Option<Unit> {
    let text = report.text(node)?;
    let units = Dimension::of_column(column).map_or(Vec::new(), |(d, _)| d.units());
    let unit = Unit::named(&text);
    let fits = |u: &Unit| Dimension::of_column(column).is_some_and(|(d, _)| d.fits(*u));
    if let Some(unit) = unit.filter(fits) {
        return Some(unit);
    }
    if units.is_empty() {
        let message =
            Bilingual::new(format!("列 '{column}' 没有单位"), format!("column '{column}' has no unit"));
        let hint = Bilingual::new("删去 'unit'", "delete 'unit'");
        report.error_with_hint(FORM.kind, node, message, hint);
    } else {
        let list = units.join(", ");
        let message = Bilingual::new(
            format!("'{text}' 不是列 '{column}' 的单位"),
            format!("'{text}' is not a unit of column '{column}'"),
        );
        let hint = Bilingual::new(format!("可用：{list}"), format!("its units are {list}"));
        report.error_with_hint(FORM.kind, node, message, hint);
    }
    None
}
