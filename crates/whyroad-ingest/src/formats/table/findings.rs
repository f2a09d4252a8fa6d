//! What the adapter of the table layout reports, one function per code. Texts only.

use super::group::Group;
use crate::phrases::zh;
use crate::report::reason_text;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of this adapter.
pub(crate) const CODES: &[&str] = &[
    "table.ego.missing",
    "table.file.empty",
    "table.file.unread",
    "table.time.epoch",
    "table.file.unreadable",
    "table.column.unknown",
    "table.column.missing",
    "table.cell.invalid",
    "table.row.dropped",
    "table.meta.invalid",
    "table.meta.unknown",
    "table.class.unknown",
    "table.word.unknown",
    "table.mapping",
    "table.mapping.absent",
    "table.mapping.ambiguous",
    "table.column.unread",
];

fn mapping_guide() -> Bilingual {
    Bilingual::new(
        "docs/reference/table-mapping.zh.md 说明映射文件",
        "docs/reference/table-mapping.md describes the mapping file",
    )
}

/// A problem of the mapping file, with the page that describes the file.
pub(super) fn with_guide(d: Diagnostic) -> Diagnostic {
    if d.hint.is_some() { d } else { d.with_hint(mapping_guide()) }
}

pub(super) fn mapping_unreadable(file: &str, reason: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("映射文件无法读取：{reason_zh}", reason_zh = zh(reason)),
        format!("the mapping file cannot be read: {reason}"),
    );
    Diagnostic::error("table.mapping", message).with_hint(mapping_guide()).in_file(file)
}

/// A file of the mapping that a drive does not have.
pub(super) fn no_file(dir: &str, table: &str, pattern: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("没有映射文件为表 '{table}' 指定的文件 '{pattern}'，其内容为未知"),
        format!(
            "there is no '{pattern}', which the mapping names for the table '{table}': what it is about is unknown"
        ),
    );
    let hint = Bilingual::new("改正映射文件中的文件名", "correct the name in the mapping file");
    Diagnostic::warning("table.mapping.absent", message).with_hint(hint).in_file(dir)
}

/// A column of the mapping that a file does not have; `others`: columns that nothing reads.
pub(super) fn mapped_column_absent(file: &str, column: &str, others: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("没有映射文件所写的列 '{column}'，其内容为未知"),
        format!("there is no column '{column}', which the mapping names: what it would say is unknown"),
    );
    let hint = if others.is_empty() {
        Bilingual::new("改正映射文件中的列名", "correct the name in the mapping file")
    } else {
        Bilingual::new(
            format!("改正映射文件中的列名；未读取的列：{others}"),
            format!("correct the name in the mapping file; columns that nothing reads: {others}"),
        )
    };
    Diagnostic::warning("table.mapping.absent", message).with_hint(hint).in_file(file)
}

/// Several files fit the name that the mapping gives for one table.
pub(super) fn several_files(dir: &str, table: &str, names: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("映射文件为表 '{table}' 指定的文件名有多个文件符合：{names}"),
        format!("the name that the mapping gives for the table '{table}' fits several files: {names}"),
    );
    let hint = Bilingual::new(
        "一个文件夹是一个行程：分开各行程的文件，或写得更具体",
        "one folder is one drive: put the files of each drive into a folder of their own, or name the file more closely",
    );
    Diagnostic::error("table.mapping.ambiguous", message).with_hint(hint).in_file(dir)
}

/// Columns that neither the mapping nor the layout names.
pub(super) fn columns_unread(file: &str, names: &str) -> Diagnostic {
    let message =
        Bilingual::new(format!("未读取的列：{names}"), format!("columns that nothing reads: {names}"));
    Diagnostic::note("table.column.unread", message).with_hint(mapping_guide()).in_file(file)
}

pub(super) fn ego_missing(dir: &str) -> Diagnostic {
    let message = Bilingual::new("没有 ego.parquet 或 ego.csv", "there is neither ego.parquet nor ego.csv");
    let hint = Bilingual::new(
        "docs/reference/table-format.zh.md 说明该表",
        "docs/reference/table-format.md describes it",
    );
    Diagnostic::error("table.ego.missing", message).in_file(dir).with_hint(hint)
}

/// A table without a row that can be used says nothing, and not that there is nothing.
pub(super) fn no_row(file: &str) -> Diagnostic {
    let message = Bilingual::new(
        "表中没有可用的行：其内容为未知",
        "the table has no row that can be used: what it is about is unknown",
    );
    let hint = Bilingual::new(
        "补上数据；没有数据时删去该文件",
        "add the rows, or take the file away where there are none",
    );
    Diagnostic::error("table.file.empty", message).in_file(file).with_hint(hint)
}

/// A name of a table at which there is no file: a link whose target does not exist, a folder.
pub(super) fn not_a_file(file: &str) -> Diagnostic {
    let message = Bilingual::new(
        "该表无法读取：它不是文件，或是目标不存在的链接",
        "this table cannot be read: it is not a file, or a link whose target does not exist",
    );
    Diagnostic::error("table.file.unread", message).in_file(file)
}

/// A file beside the tables that looks like one of them.
pub(super) fn unread(file: &str, meant: &str) -> Diagnostic {
    let message = Bilingual::new("该文件未读取", "this file is not read");
    let hint = Bilingual::new(
        format!("是否指 '{meant}.csv' 或 '{meant}.parquet'？表的文件名区分大小写，不可压缩"),
        format!(
            "is '{meant}.csv' or '{meant}.parquet' meant? Names of tables are in lower case, and tables are not \
             compressed"
        ),
    );
    Diagnostic::error("table.file.unread", message).in_file(file).with_hint(hint)
}

/// Seconds since 1970 where seconds since the start of the drive belong.
pub(super) fn since_1970(file: &str, seconds: f64) -> Diagnostic {
    let message = Bilingual::new(
        format!("time_s 从 {seconds:.1} 开始：像是 1970 年以来的秒数，而该列是行程开始以来的秒数"),
        format!(
            "time_s begins at {seconds:.1}: these seem to be seconds since 1970; the column is for seconds since the start \
             of the drive"
        ),
    );
    let hint = Bilingual::new(
        "改用列 'timestamp_ns'（1970 年以来的纳秒）或 'time'（ISO 8601）",
        "use the column 'timestamp_ns' (nanoseconds since 1970) or 'time' (ISO 8601)",
    );
    Diagnostic::error("table.time.epoch", message).in_file(file).with_hint(hint)
}

pub(super) fn unreadable(file: &str, reason: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("文件无法读取：{reason_zh}", reason_zh = zh(reason)),
        format!("the file cannot be read: {reason}"),
    );
    Diagnostic::error("table.file.unreadable", message).in_file(file)
}

/// The known name nearest to `name`, if it is near.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let score = |k: &str| strsim::normalized_damerau_levenshtein(&name.to_lowercase(), k);
    let best = known.iter().copied().max_by(|a, b| score(a).total_cmp(&score(b)))?;
    (score(best) >= 0.6).then_some(best)
}

fn did_you_mean(d: Diagnostic, name: &str, known: &[&str]) -> Diagnostic {
    let hint = match nearest(name, known) {
        Some(n) => Bilingual::new(format!("是否指 '{n}'？"), format!("did you mean '{n}'?")),
        None => {
            let all = known.join(", ");
            Bilingual::new(format!("可用：{all}"), format!("known: {all}"))
        }
    };
    d.with_hint(hint)
}

pub(super) fn unknown_column(file: &str, name: &str, known: &[&str]) -> Diagnostic {
    let message = Bilingual::new(
        format!("未知的列 '{name}'，已忽略"),
        format!("unknown column '{name}'; it is not read"),
    );
    did_you_mean(Diagnostic::warning("table.column.unknown", message).in_file(file), name, known)
}

pub(super) fn missing_column(file: &str, any: &[&str]) -> Diagnostic {
    let names = any.iter().map(|n| format!("'{n}'")).collect::<Vec<_>>();
    let (zh, en) = (names.join(" 或 "), names.join(" or "));
    let message =
        Bilingual::new(format!("缺少必需的列 {zh}"), format!("the required column {en} is missing"));
    Diagnostic::error("table.column.missing", message).in_file(file)
}

pub(super) fn bad_cells(file: &str, column: &str, g: &Group) -> Diagnostic {
    let (n, rows, example, expected) = (g.count, g.rows_text(), &g.example, g.expected);
    let message = Bilingual::new(
        format!(
            "列 '{column}' 有 {n} 个单元格不是所需的值（应为 {expected_zh}），记为未知：第 {rows} 行；例如 '{example}'",
            expected_zh = zh(expected)
        ),
        format!(
            "{n} cells of column '{column}' are not {expected} and count as unknown: rows {rows}; for example '{example}'"
        ),
    );
    // An unknown value where the file had one is lost input.
    Diagnostic::error("table.cell.invalid", message).in_file(file)
}

pub(super) fn dropped_rows(file: &str, reason: &str, g: &Group) -> Diagnostic {
    let (n, rows, why) = (g.count, g.rows_text(), reason_text(reason));
    let message = Bilingual::new(
        format!("丢弃 {n} 行（{}）：第 {rows} 行", why.zh),
        format!("{n} rows dropped ({}): rows {rows}", why.en),
    );
    Diagnostic::warning("table.row.dropped", message).in_file(file)
}

pub(super) fn bad_meta(file: &str, zh: String, en: String) -> Diagnostic {
    Diagnostic::error("table.meta.invalid", Bilingual::new(zh, en)).in_file(file)
}

pub(super) fn unknown_key(file: &str, name: &str, known: &[&str]) -> Diagnostic {
    let message =
        Bilingual::new(format!("未知的键 '{name}'，已忽略"), format!("unknown key '{name}'; it is not read"));
    did_you_mean(Diagnostic::warning("table.meta.unknown", message).in_file(file), name, known)
}

pub(super) fn unknown_class(file: &str, name: &str, rows: usize, known: &[&str]) -> Diagnostic {
    let message = Bilingual::new(
        format!("{rows} 行的类别 '{name}' 未知；轨迹保留，类别记为 unknown"),
        format!("{rows} rows have the unknown class '{name}'; the tracks are kept with class unknown"),
    );
    did_you_mean(Diagnostic::warning("table.class.unknown", message).in_file(file), name, known)
}

pub(super) fn unknown_word(file: &str, column: &str, word: &str, rows: usize, known: &[&str]) -> Diagnostic {
    let message = Bilingual::new(
        format!("列 '{column}' 有 {rows} 行的词 '{word}' 不在词表中，未采用"),
        format!("{rows} rows of column '{column}' have the unknown word '{word}'; it is not used"),
    );
    // What the file states is lost.
    did_you_mean(Diagnostic::error("table.word.unknown", message).in_file(file), word, known)
}
