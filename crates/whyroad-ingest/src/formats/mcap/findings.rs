//! What the MCAP adapter reports, one function per code. Texts only.

use crate::phrases::zh;
use crate::report::{RowCount, counts_text};
use whyroad_model::{Bilingual, Diagnostic, Lang, counted};

/// Codes of the MCAP adapter; each has a page in `docs/diagnostics/`.
pub(crate) const CODES: &[&str] = &[
    "mcap.file.broken",
    "mcap.mapping",
    "mcap.ego.missing",
    "mcap.ego.ambiguous",
    "mcap.topic.undecodable",
    "mcap.topic.absent",
    "mcap.topic.unread",
    "mcap.frame",
    "mcap.rows.dropped",
    "mcap.class",
];

fn look() -> Bilingual {
    Bilingual::new("docs/formats/mcap.md 说明映射文件", "docs/formats/mcap.md describes the mapping file")
}

pub(super) fn broken(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "mcap.file.broken",
        Bilingual::new(
            format!("部分内容丢失：{reason_zh}", reason_zh = zh(reason)),
            format!("a part is lost: {reason}"),
        ),
    )
    .with_hint(Bilingual::new(
        "用 `mcap recover` 修复该文件，或重新复制",
        "repair the file with `mcap recover`, or copy it again",
    ))
    .in_file(file)
}

pub(super) fn mapping(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "mcap.mapping",
        Bilingual::new(
            format!("映射文件无法使用：{reason_zh}", reason_zh = zh(reason)),
            format!("the mapping file cannot be used: {reason}"),
        ),
    )
    .with_hint(look())
    .in_file(file)
}

/// A problem of the mapping file, with the page that describes the file.
pub(super) fn with_guide(d: Diagnostic) -> Diagnostic {
    if d.hint.is_some() { d } else { d.with_hint(look()) }
}

pub(super) fn ego_missing(file: &str, topics: &str) -> Diagnostic {
    Diagnostic::error(
        "mcap.ego.missing",
        Bilingual::new(
            format!("没有可用的自车位姿；主题：{topics}"),
            format!("no topic gives two usable poses of the ego; topics: {topics}"),
        ),
    )
    .with_hint(look())
    .in_file(file)
}

pub(super) fn ego_ambiguous(file: &str, topics: &str, taken: &str) -> Diagnostic {
    Diagnostic::warning(
        "mcap.ego.ambiguous",
        Bilingual::new(
            format!("多个主题给出位姿（{topics}）；采用 {taken}"),
            format!("several topics give poses ({topics}); {taken} is taken"),
        ),
    )
    .with_hint(look())
    .in_file(file)
}

pub(super) fn undecodable(file: &str, topic: &str, what: &str, messages: usize) -> Diagnostic {
    Diagnostic::warning(
        "mcap.topic.undecodable",
        Bilingual::new(
            format!("{topic}：{messages} 条消息无法解码（{what_zh}）", what_zh = zh(what)),
            format!("{topic}: {messages} messages cannot be decoded ({what})"),
        ),
    )
    .in_file(file)
}

/// A topic of the mapping that no message is on; `others`: topics that nothing reads.
pub(super) fn topic_absent(file: &str, topic: &str, others: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("文件中没有映射文件所写的主题 {topic}，其内容视为未记录"),
        format!("the mapping names {topic}, which is not in the file; what it would tell is unknown"),
    );
    let hint = if others.is_empty() {
        Bilingual::new("改正映射文件中的主题名", "correct the name in the mapping file")
    } else {
        Bilingual::new(
            format!("改正映射文件中的主题名；文件中未读取的主题：{others}"),
            format!("correct the name in the mapping file; topics of the file that nothing reads: {others}"),
        )
    };
    Diagnostic::warning("mcap.topic.absent", message).with_hint(hint).in_file(file)
}

/// Topics that no rule reads.
pub(super) fn topics_unread(file: &str, topics: &str, messages: usize) -> Diagnostic {
    let message = Bilingual::new(
        format!("未读取的主题（共 {messages} 条消息）：{topics}"),
        format!("topics that nothing reads ({}): {topics}", counted(messages, "message")),
    );
    Diagnostic::note("mcap.topic.unread", message).with_hint(look()).in_file(file)
}

pub(super) fn frame(file: &str, frame_id: &str, rows: usize) -> Diagnostic {
    Diagnostic::warning(
        "mcap.frame",
        Bilingual::new(
            format!("坐标系 '{frame_id}' 既不是世界也不是自车；丢弃 {rows} 行"),
            format!("frame '{frame_id}' is neither the world's nor the ego's; {rows} rows dropped"),
        ),
    )
    .with_hint(Bilingual::new(
        "在映射文件中为该主题写 `frame: world` 或 `frame: ego`",
        "set `frame: world` or `frame: ego` for the topic in a mapping file",
    ))
    .in_file(file)
}

pub(super) fn dropped(file: &str, count: &RowCount) -> Diagnostic {
    let (table, n, list) = (count.table, count.dropped_total(), |lang| counts_text(&count.dropped, lang));
    Diagnostic::warning(
        "mcap.rows.dropped",
        Bilingual::new(
            format!("{table}：丢弃 {n} 行（{}）", list(Lang::Zh)),
            format!("{table}: {n} rows dropped ({})", list(Lang::En)),
        ),
    )
    .in_file(file)
}

pub(super) fn class(file: &str, names: &str) -> Diagnostic {
    Diagnostic::warning(
        "mcap.class",
        Bilingual::new(
            format!("未知类别，记为 unknown：{names}"),
            format!("unknown class names, kept as class unknown: {names}"),
        ),
    )
    .with_hint(Bilingual::new(
        "在映射文件的 `classes` 中对应它们",
        "map them under `classes` in a mapping file",
    ))
    .in_file(file)
}
