//! Required records (last column in TAXONOMY.md): each is present, and its value fits its type.

use crate::check::view::View;
use whyroad_framework::RecordTypes;
use whyroad_framework::check::class_index::Prescribed;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::record_types::{RecordType, RecordVerdict};
use whyroad_model::label_fields::pointer;

/// Records that the class requires; a document of 2.0 has no place for them.
pub(in crate::check) fn missing(label: &View<'_>, class: &Prescribed, sink: &mut dyn Sink) {
    let filled: &[_] = match &label.records {
        Slot::Is(filled) => filled,
        Slot::Absent if label.states_2_0() => return,
        Slot::Absent => &[],
        Slot::Broken => return,
    };
    let owed = class.records.iter().filter(|(id, ..)| !filled.iter().any(|(k, _)| k == id));
    for (id, title, unit) in owed {
        sink.report(Finding::error("label.record.missing", pointer::records_of(id)), &|| {
            let unit =
                unit.as_ref().map(|u| (format!("（单位 {u}）"), format!(" in {u}"))).unwrap_or_default();
            let name = &class.title;
            Words::new(
                format!("“{}”要求记录“{}”", name.zh, title.zh),
                format!("'{}' requires a record of the {}", name.en, title.en),
            )
            .hint(
                format!("填写该记录{}；看不出时写明（“看不出”或“未知”）", unit.0),
                format!("fill in the record{}, or say that it cannot be seen ('unknown')", unit.1),
            )
        });
    }
}

/// The value of a record is of its type and plausible.
pub(in crate::check) fn types(
    label: &View<'_>,
    class: Option<&Prescribed>,
    types: &RecordTypes,
    sink: &mut dyn Sink,
) {
    let Slot::Is(records) = &label.records else { return };
    for (id, value) in records {
        let Some(verdict) = types.judge(id, *value) else { continue };
        let spec = class.and_then(|c| c.records.iter().find(|(k, ..)| k == id));
        let title = || {
            let title = spec.map(|(_, title, _)| title.clone());
            title.map_or_else(|| ((*id).to_owned(), (*id).to_owned()), |t| (t.zh, t.en))
        };
        let unit = || spec.and_then(|(_, _, unit)| unit.clone()).unwrap_or_default();
        let report = |sink: &mut dyn Sink, words: &dyn Fn() -> Words| {
            sink.report(Finding::error("label.record.value", pointer::records_of(id)), words);
        };
        match verdict {
            RecordVerdict::Stored(_) => {}
            RecordVerdict::WrongType => report(sink, &|| {
                let (zh, en) = title();
                let words = Words::new(
                    format!("“{zh}”的取值类型不对"),
                    format!("the {en} has a value of the wrong type"),
                );
                match types.records.get(*id) {
                    Some(RecordType::Number { .. }) => match unit() {
                        u if u.is_empty() => words.hint("写一个数，或“未知”", "write a number, or 'unknown'"),
                        u => words.hint(
                            format!("写以 {u} 为单位的数，或“未知”"),
                            format!("write a number in {u}, or 'unknown'"),
                        ),
                    },
                    Some(RecordType::Flag { .. }) => {
                        words.hint("写 true 或 false，或“未知”", "write true or false, or 'unknown'")
                    }
                    Some(RecordType::Choice { values, or_text: false, .. }) => {
                        let ids: Vec<&str> = values.iter().map(|v| v.id.as_str()).collect();
                        words.one_of(&ids.join("、"), &ids.join(", "))
                    }
                    Some(RecordType::Choice { .. } | RecordType::Text) | None => {
                        words.hint("写文字，或“未知”", "write text, or 'unknown'")
                    }
                }
            }),
            RecordVerdict::OutOfRange { min, max } => report(sink, &|| {
                let ((zh, en), u) = (title(), unit());
                Words::new(
                    format!("“{zh}”超出合理范围（{min} 至 {max} {u}）"),
                    format!("the {en} is implausible: expected {min} to {max} {u}"),
                )
                .hint("检查数值和单位", "check the number and its unit")
            }),
            RecordVerdict::NotAChoice(choices) => report(sink, &|| {
                let (zh, en) = title();
                Words::new(
                    format!("“{zh}”的取值不在可选范围内"),
                    format!("the {en} has a value that is not one of its choices"),
                )
                .one_of(&choices.join("、"), &choices.join(", "))
            }),
        }
    }
}
