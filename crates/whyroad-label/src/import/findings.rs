//! Diagnostics of an import of labels, one function per code. Texts only.

use std::collections::BTreeMap;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of the import; each has a page in `docs/diagnostics/`.
pub const CODES: &[&str] = &[
    "import.file.unreadable",
    "import.entry.invalid",
    "import.text.missing",
    "import.text.conflict",
    "import.drive.unknown",
    "import.time.outside",
    "import.field.left_out",
];

/// A file that cannot be read, or is not in the format.
pub fn unreadable(file: &str, reason: &str) -> Diagnostic {
    let message =
        Bilingual::new(format!("文件无法读取：{reason}"), format!("the file cannot be read: {reason}"));
    Diagnostic::error("import.file.unreadable", message).in_file(file)
}

pub(super) fn invalid(origin: &str, reason_zh: &str, reason_en: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("条目无法使用：{reason_zh}"),
        format!("the entry cannot be used: {reason_en}"),
    );
    Diagnostic::error("import.entry.invalid", message).in_file(origin)
}

pub(super) fn no_time(origin: &str) -> Diagnostic {
    invalid(origin, "没有时刻", "it has no time")
}

pub(super) fn no_clip(origin: &str) -> Diagnostic {
    invalid(origin, "没有片段编号", "it has no clip id")
}

pub(super) fn no_text(origin: &str) -> Diagnostic {
    let message = Bilingual::new("没有因果文本；略去", "it has no causal text; it is skipped");
    Diagnostic::warning("import.text.missing", message).in_file(origin)
}

pub(super) fn conflict(origin: &str) -> Diagnostic {
    let message = Bilingual::new(
        "`coc` 与 `cot` 的文本不同；采用 `coc`",
        "`coc` and `cot` have different texts; `coc` is used",
    );
    Diagnostic::warning("import.text.conflict", message).in_file(origin)
}

/// A clip without a drive in the lake.
pub fn drive_unknown(origin: &str, clip: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("湖中没有片段 '{clip}' 的行程；该文本未导入"),
        format!("the lake has no drive of clip '{clip}'; its text is not imported"),
    );
    let hint = Bilingual::new(
        "先用 `whyroad ingest` 导入行程，或用 --drives 给出片段与行程的对应",
        "ingest the drive first with `whyroad ingest`, or assign drives to clips with --drives",
    );
    Diagnostic::error("import.drive.unknown", message).with_hint(hint).in_file(origin)
}

pub(super) fn outside(origin: &str, at_s: f64, drive: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("时刻 {at_s:.1} s 不在行程 '{drive}' 内；该文本未导入"),
        format!("its time, {at_s:.1} s, is outside drive '{drive}'; its text is not imported"),
    );
    let hint = Bilingual::new(
        "用 --start-time 给出片段时刻 0 的时间",
        "give the time of the clip's time 0 with --start-time",
    );
    Diagnostic::error("import.time.outside", message).with_hint(hint).in_file(origin)
}

/// Data for which a label has no field, one diagnostic per field.
pub fn fields(source: &str, left_out: &BTreeMap<String, usize>) -> Vec<Diagnostic> {
    let one = |(field, n): (&String, &usize)| {
        let message = Bilingual::new(
            format!("字段 `{field}` 的 {n} 个值在标注中没有位置，未导入"),
            format!("a label has no field for {n} values of `{field}`; they are not imported"),
        );
        Diagnostic::warning("import.field.left_out", message).in_file(source)
    };
    left_out.iter().map(one).collect()
}
