//! What the MCAP adapter reports, one function per code. Texts only.

use super::fields::FieldCount;
use super::mapping::Role;
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
    "mcap.field.absent",
    "mcap.field.unreadable",
    "mcap.time.log",
    "mcap.bus.unused",
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

pub(super) fn ego_missing(file: &str, count: &RowCount, topics: &str) -> Diagnostic {
    let (read, lost) = (count.read, |lang| counts_text(&count.dropped, lang));
    let of_rows = if count.dropped_total() == 0 {
        Bilingual::new("", "")
    } else {
        Bilingual::new(
            format!("；读到 {read} 个位姿，丢弃：{}", lost(Lang::Zh)),
            format!("; {} read, dropped: {}", counted(read, "pose"), lost(Lang::En)),
        )
    };
    Diagnostic::error(
        "mcap.ego.missing",
        Bilingual::new(
            format!("没有可用的自车位姿{}；主题：{topics}", of_rows.zh),
            format!("no topic gives two usable poses of the ego{}; topics: {topics}", of_rows.en),
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
        "不读取变换（tf）：请在记录前把目标变换到自车位姿的坐标系或自车坐标系；仅当该坐标系与二者之一重合时，才在映射文件中写 \
         `frame: world` 或 `frame: ego`",
        "transforms (tf) are not read: transform the objects to the frame of the ego's poses or of its car before \
         recording; set `frame: world` or `frame: ego` in a mapping file only if this frame is one of the two by another \
         name",
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

/// What the elements are that a topic's fields are counted in.
fn elements(role: Role) -> Bilingual {
    match role {
        Role::Objects => Bilingual::new("个目标", "objects"),
        _ => Bilingual::new("条消息", "messages"),
    }
}

/// What becomes of rows without the field.
fn without(field: &str) -> Bilingual {
    match field {
        "time" | "id" | "position" | "heading" | "orientation" => {
            Bilingual::new("这些行被丢弃", "these rows are dropped")
        }
        _ => Bilingual::new("其值为未知", "its value is unknown there"),
    }
}

/// A field of the mapping that no message has.
pub(super) fn field_absent(
    file: &str,
    topic: &str,
    role: Role,
    (field, count): (&str, &FieldCount),
) -> Diagnostic {
    let (path, read, beside) = (&count.path, count.read, &count.beside);
    let (of, then) = (elements(role), without(field));
    let message = Bilingual::new(
        format!("{topic}：{read} {}中都没有映射文件所写的 `{field}: {path}`；{}", of.zh, then.zh),
        format!("{topic}: none of {read} {} has the `{field}: {path}` of the mapping; {}", of.en, then.en),
    );
    let hint = Bilingual::new(
        format!("改正映射文件中的路径；该处有：{beside}"),
        format!("correct the path in the mapping file; what is there: {beside}"),
    );
    Diagnostic::warning("mcap.field.absent", message).with_hint(hint).in_file(file)
}

/// A field in a form that is not understood.
pub(super) fn field_unreadable(
    file: &str,
    topic: &str,
    role: Role,
    (field, count): (&str, &FieldCount),
) -> Option<Diagnostic> {
    let (example, form) = count.example.as_ref()?;
    let (path, read, n) = (&count.path, count.read, count.foreign);
    let (of, then, form) = (elements(role), without(field), form.text());
    let message = Bilingual::new(
        format!(
            "{topic}：{read} {}中有 {n} 个的 `{field}: {path}` 无法理解，例如 {example}；{}",
            of.zh, then.zh
        ),
        format!(
            "{topic}: `{field}: {path}` is not understood in {n} of {read} {}, for example {example}; {}",
            of.en, then.en
        ),
    );
    let hint = Bilingual::new(
        format!("可用的形式：{}；其他形式须在记录前换算", form.zh),
        format!("expected: {}; convert other forms before recording", form.en),
    );
    Some(Diagnostic::warning("mcap.field.unreadable", message).with_hint(hint).in_file(file))
}

/// The log's times are taken because no message of the topic has a stamp.
pub(super) fn time_of_log(file: &str, topic: &str, rows: usize) -> Diagnostic {
    let message = Bilingual::new(
        format!("{topic}：所有 {rows} 个时间戳均为 0（未设置）；采用日志时刻"),
        format!("{topic}: all {rows} stamps are 0 (not set); the times of the log are used"),
    );
    let hint = Bilingual::new(
        "日志时刻是记录消息的时刻，晚于测量时刻；请在发布时设置时间戳",
        "the log's time is that of recording, later than that of measuring: set the stamps where the messages are made",
    );
    Diagnostic::warning("mcap.time.log", message).with_hint(hint).in_file(file)
}

/// Bus signals of which none falls into the drive; the first is `first_s` after the first frame.
pub(super) fn bus_unused(file: &str, rows: usize, first_s: f64) -> Diagnostic {
    let message = Bilingual::new(
        format!("{rows} 个总线信号值无一落在行程时间内（第一个位于首帧后 {first_s:.1} s）：车辆总线为未知"),
        format!(
            "none of {rows} values of the bus falls into the drive (the first is at {first_s:.1} s from its first frame): \
             the vehicle bus is unknown"
        ),
    );
    let hint = Bilingual::new(
        "检查总线与自车位姿的时间是否用同一时钟、同一单位",
        "check that the times of the bus and of the ego's poses are of one clock and in one unit",
    );
    Diagnostic::error("mcap.bus.unused", message).with_hint(hint).in_file(file)
}
