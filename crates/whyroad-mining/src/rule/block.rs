//! A `mining:` block as it is written, read field by field: what is missing, unknown or of the wrong kind is reported
//! where it stands, and the rest is read. What the texts in it say is for [`super::source`].

use super::origin::Origin;
use crate::language::check::nearest;
use crate::language::{Fault, Span};
use serde_yaml_ng::{Mapping, Value};
use whyroad_model::Diagnostic;

/// The fields of a block, in the order of `docs/reference/rules.md`.
const FIELDS: &[&str] = &[
    "target",
    "roles",
    "parameters",
    "define",
    "when",
    "require",
    "min_duration",
    "max_duration",
    "merge_gap",
];

/// The fields of a parameter.
const OF_PARAMETER: &[&str] = &["value", "reason"];

/// The block: texts as written.
#[derive(Debug, Default)]
pub(super) struct Block {
    pub target: Option<String>,
    pub roles: Mapping,
    /// Name and value.
    pub parameters: Vec<(String, String)>,
    /// Name and text.
    pub define: Vec<(String, String)>,
    pub when: Vec<String>,
    pub require: Vec<String>,
    pub min_duration: Option<String>,
    pub max_duration: Option<String>,
    pub merge_gap: Option<String>,
    /// Parameters and definitions that could not be read.
    pub broken: Vec<String>,
}

/// Reads a block. Without a `when` (there, or null) nothing can match; that too is a fault.
pub(super) fn read(block: &Value, origin: &Origin<'_>, found: &mut Vec<Diagnostic>) -> Block {
    let mut reader = Reader { origin, found };
    let Value::Mapping(fields) = block else {
        reader.fault("/mining", "", &format!("mining 块应为映射，实为{}", kind(block).0), &{
            format!("a mining block is a mapping, not {}", kind(block).1)
        });
        return Block::default();
    };
    let mut out = Block::default();
    reader.unknown("/mining", fields, FIELDS);
    let of = |key: &str| fields.get(key).filter(|v| !v.is_null());
    let mut text = |key: &str| of(key).and_then(|v| reader.text(&format!("/mining/{key}"), v));
    out.target = text("target");
    out.min_duration = text("min_duration");
    out.max_duration = text("max_duration");
    out.merge_gap = text("merge_gap");
    let mut texts = |key: &str| match of(key) {
        Some(Value::Sequence(items)) => {
            items.iter().filter_map(|v| reader.text(&format!("/mining/{key}"), v)).collect()
        }
        Some(one) => reader.text(&format!("/mining/{key}"), one).into_iter().collect(),
        None => Vec::new(),
    };
    out.when = texts("when");
    out.require = texts("require");
    if of("when").is_none_or(|v| v.as_sequence().is_some_and(Vec::is_empty)) {
        reader.fault(
            "/mining",
            "",
            "缺少 when：何时匹配",
            "there is no `when`: the condition that makes a match",
        );
    }
    let mut mapping = |key: &str| of(key).and_then(|v| reader.mapping(&format!("/mining/{key}"), v));
    out.roles = mapping("roles").cloned().unwrap_or_default();
    let (parameters, define) = (mapping("parameters"), mapping("define"));
    for (name, value) in parameters.into_iter().flatten() {
        let name = scalar(name).unwrap_or_default();
        match reader.parameter(&name, value) {
            Some(value) => out.parameters.push((name, value)),
            None => out.broken.push(name),
        }
    }
    for (name, value) in define.into_iter().flatten() {
        let name = scalar(name).unwrap_or_default();
        match reader.text(&format!("/mining/define/{name}"), value) {
            Some(text) => out.define.push((name, text)),
            None => out.broken.push(name),
        }
    }
    out
}

struct Reader<'a> {
    origin: &'a Origin<'a>,
    found: &'a mut Vec<Diagnostic>,
}

impl Reader<'_> {
    /// Reports something about the key at the end of `pointer`; with no `name`, about the block.
    fn fault(&mut self, pointer: &str, name: &str, zh: &str, en: &str) {
        let fault = Fault::new("rule.block", Span { start: 0, end: name.len() }, zh, en);
        self.found.push(self.origin.diagnose(pointer, name, fault));
    }

    fn unknown(&mut self, pointer: &str, fields: &Mapping, known: &[&str]) {
        for name in fields.keys().map(|k| scalar(k).unwrap_or_default()) {
            if known.contains(&name.as_str()) {
                continue;
            }
            let fault = Fault::new(
                "rule.block",
                Span { start: 0, end: name.len() },
                format!("未知字段 '{name}'"),
                format!("unknown field '{name}'"),
            );
            let fault = match nearest(&name, known.iter().copied()) {
                Some(near) => fault.hint(format!("是否想写 '{near}'？"), format!("did you mean '{near}'?")),
                None => {
                    let all = known.join(", ");
                    fault.hint(format!("可用字段：{all}"), format!("there are: {all}"))
                }
            };
            self.found.push(self.origin.diagnose(&format!("{pointer}/{name}"), &name, fault));
        }
    }

    /// The text of a scalar. A number is one too: YAML makes numbers of `3` and `0.1`.
    fn text(&mut self, pointer: &str, value: &Value) -> Option<String> {
        let text = scalar(value);
        if text.is_none() {
            self.wrong_kind(pointer, value, "文本", "text");
        }
        text
    }

    fn mapping<'v>(&mut self, pointer: &str, value: &'v Value) -> Option<&'v Mapping> {
        let mapping = value.as_mapping();
        if mapping.is_none() {
            self.wrong_kind(pointer, value, "映射（名称: 内容）", "a mapping (name: content)");
        }
        mapping
    }

    fn wrong_kind(&mut self, pointer: &str, value: &Value, zh: &str, en: &str) {
        let (found_zh, found_en) = kind(value);
        let name = pointer.rsplit('/').next().unwrap_or_default();
        let message = (format!("{name} 应为{zh}，实为{found_zh}"), format!("{name} is {en}, not {found_en}"));
        self.fault(pointer, name, &message.0, &message.1);
    }

    /// The value of a parameter; one without a reason is reported, and used to find what else is wrong.
    fn parameter(&mut self, name: &str, value: &Value) -> Option<String> {
        let pointer = format!("/mining/parameters/{name}");
        let Value::Mapping(fields) = value else {
            self.fault(
                &pointer,
                name,
                "参数须写明 value 与 reason，例如 { value: 3 m, reason: \"…\" }",
                "a parameter has a value and a reason, as in { value: 3 m, reason: \"...\" }",
            );
            return None;
        };
        self.unknown(&pointer, fields, OF_PARAMETER);
        let mut field = |key: &str| {
            let text = fields.get(key).and_then(scalar).filter(|t| !t.trim().is_empty());
            if text.is_none() {
                let (zh, en) = match key {
                    "reason" => ("参数缺少理由（reason）", "the parameter has no reason"),
                    _ => ("参数缺少数值（value）", "the parameter has no value"),
                };
                self.fault(&pointer, name, zh, en);
            }
            text
        };
        let (value, _) = (field("value"), field("reason"));
        value
    }
}

/// The text of a value; a number is written as one.
pub(super) fn scalar(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        Value::Bool(flag) => Some(flag.to_string()),
        _ => None,
    }
}

/// What a value is, in Chinese and English.
fn kind(value: &Value) -> (&'static str, &'static str) {
    match value {
        Value::Null => ("空值", "nothing"),
        Value::Sequence(_) => ("列表", "a list"),
        Value::Mapping(_) => ("映射", "a mapping"),
        _ => ("单个值", "a single value"),
    }
}
