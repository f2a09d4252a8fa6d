//! A `mining:` block as it is written, read field by field: fields that are missing, unknown, written twice or of the
//! wrong type are reported at their position, and the rest is read. [`super::source`] interprets the texts.

use super::origin::{Origin, SourceFile};
use crate::language::check::nearest;
use crate::language::{Fault, Span};
use whyroad_model::yaml::{Entry, Mark, Node, Value};
use whyroad_model::{Bilingual, Diagnostic};

/// The fields of a block, in the order of `docs/reference/rules.md`.
const FIELDS: &[&str] = &[
    "target",
    "roles",
    "parameters",
    "define",
    "names",
    "when",
    "require",
    "response",
    "min_duration",
    "max_duration",
    "merge_gap",
];

/// The fields of a parameter.
const OF_PARAMETER: &[&str] = &["value", "reason"];

/// The block: scalars as written.
#[derive(Debug, Default)]
pub(super) struct Block<'n> {
    pub target: Option<&'n Node>,
    pub roles: Vec<&'n Entry>,
    /// Entry and value.
    pub parameters: Vec<(&'n Entry, &'n Node)>,
    pub define: Vec<&'n Entry>,
    /// Displayed names of definitions.
    pub names: Vec<(&'n Entry, Bilingual)>,
    pub when: Vec<&'n Node>,
    pub require: Vec<&'n Node>,
    pub response: Vec<&'n Node>,
    pub min_duration: Option<&'n Node>,
    pub max_duration: Option<&'n Node>,
    pub merge_gap: Option<&'n Node>,
    /// Parameters and definitions that could not be read.
    pub broken: Vec<String>,
}

/// Reads a block. Without a `when` (present, and not null) nothing can match; that is an error too.
pub(super) fn read<'n>(block: &'n Node, origin: &Origin<'_>, found: &mut Vec<Diagnostic>) -> Block<'n> {
    let mut reader = Reader { file: origin.file, found };
    let mut out = Block::default();
    let Value::Map(_) = block.value else {
        let (zh, en) = description(block);
        reader.fault(
            origin.mark,
            &block.pointer,
            &format!("mining 块应为映射，实为{zh}"),
            &format!("a mining block is a mapping, not {en}"),
        );
        return out;
    };
    reader.unknown(block.entries(), FIELDS);
    let of = |key: &str| block.entries().iter().find(|e| e.key == key && !is_null(&e.node));
    let mut text = |key: &str| of(key).and_then(|e| reader.text(e));
    out.target = text("target");
    out.min_duration = text("min_duration");
    out.max_duration = text("max_duration");
    out.merge_gap = text("merge_gap");
    out.when = of("when").map(|e| reader.texts(e)).unwrap_or_default();
    out.require = of("require").map(|e| reader.texts(e)).unwrap_or_default();
    out.response = of("response").map(|e| reader.texts(e)).unwrap_or_default();
    if of("when").is_none_or(|e| matches!(&e.node.value, Value::List(items) if items.is_empty())) {
        reader.fault(
            origin.mark,
            &block.pointer,
            "缺少 when：何时匹配",
            "`when`, the condition that makes a match, is missing",
        );
    }
    out.roles = of("roles").map(|e| reader.mapping(e)).unwrap_or_default();
    for entry in of("parameters").map(|e| reader.mapping(e)).unwrap_or_default() {
        match reader.parameter(entry) {
            Some(value) => out.parameters.push((entry, value)),
            None => out.broken.push(entry.key.clone()),
        }
    }
    for entry in of("define").map(|e| reader.mapping(e)).unwrap_or_default() {
        match reader.text(entry) {
            Some(_) => out.define.push(entry),
            None => out.broken.push(entry.key.clone()),
        }
    }
    for entry in of("names").map(|e| reader.mapping(e)).unwrap_or_default() {
        out.names.extend(reader.bilingual(entry).map(|words| (entry, words)));
    }
    out
}

/// Reports every key of a mapping that is written twice; readers of the mapping use the first.
pub(super) fn duplicates(entries: &[Entry], file: SourceFile<'_>, found: &mut Vec<Diagnostic>) {
    for (i, e) in entries.iter().enumerate() {
        if let Some(first) = entries[..i].iter().find(|o| o.key == e.key) {
            let (key, line) = (&e.key, first.mark.line);
            let fault = Fault::new(
                "rule.block",
                Span::default(),
                format!("键 '{key}' 重复，首次出现在第 {line} 行"),
                format!("key '{key}' is written twice, first on line {line}"),
            );
            found.push(file.at(e.mark, &e.node.pointer, fault));
        }
    }
}

struct Reader<'a> {
    file: SourceFile<'a>,
    found: &'a mut Vec<Diagnostic>,
}

impl Reader<'_> {
    fn fault(&mut self, mark: Mark, pointer: &str, zh: &str, en: &str) {
        self.found.push(self.file.at(mark, pointer, Fault::new("rule.block", Span::default(), zh, en)));
    }

    fn unknown(&mut self, entries: &[Entry], known: &[&str]) {
        for e in entries.iter().filter(|e| !known.contains(&e.key.as_str())) {
            let name = &e.key;
            let fault = Fault::new(
                "rule.block",
                Span::default(),
                format!("未知字段 '{name}'"),
                format!("unknown field '{name}'"),
            );
            let fault = match nearest(name, known.iter().copied()) {
                Some(near) => fault.hint(format!("是否想写 '{near}'？"), format!("did you mean '{near}'?")),
                None => {
                    let all = known.join(", ");
                    fault.hint(format!("可用字段：{all}"), format!("known fields: {all}"))
                }
            };
            self.found.push(self.file.at(e.mark, &e.node.pointer, fault));
        }
    }

    /// The value, where it is a scalar.
    fn text<'n>(&mut self, entry: &'n Entry) -> Option<&'n Node> {
        if entry.node.text().is_none() {
            self.wrong_type(entry, "文本", "text");
            return None;
        }
        Some(&entry.node)
    }

    /// A list of scalars, or a single one as a list of one.
    fn texts<'n>(&mut self, entry: &'n Entry) -> Vec<&'n Node> {
        let Value::List(items) = &entry.node.value else { return self.text(entry).into_iter().collect() };
        let (good, bad): (Vec<&Node>, Vec<&Node>) = items.iter().partition(|n| n.text().is_some());
        for node in bad {
            let (zh, en) = description(node);
            self.fault(
                node.mark,
                &node.pointer,
                &format!("{} 的每一项应为文本，实为{zh}", entry.key),
                &format!("each item of {} is text, not {en}", entry.key),
            );
        }
        good
    }

    /// The entries of a mapping, each key once.
    fn mapping<'n>(&mut self, entry: &'n Entry) -> Vec<&'n Entry> {
        let Value::Map(entries) = &entry.node.value else {
            self.wrong_type(entry, "映射（名称: 内容）", "a mapping (name: content)");
            return Vec::new();
        };
        duplicates(entries, self.file, self.found);
        let first = |i: usize, e: &Entry| entries[..i].iter().all(|o| o.key != e.key);
        entries.iter().enumerate().filter(|(i, e)| first(*i, e)).map(|(_, e)| e).collect()
    }

    fn wrong_type(&mut self, entry: &Entry, zh: &str, en: &str) {
        let (found_zh, found_en) = description(&entry.node);
        let name = &entry.key;
        let (zh, en) =
            (format!("{name} 应为{zh}，实为{found_zh}"), format!("{name} is {en}, not {found_en}"));
        self.fault(entry.mark, &entry.node.pointer, &zh, &en);
    }

    /// A text in both languages.
    fn bilingual(&mut self, entry: &Entry) -> Option<Bilingual> {
        self.unknown(entry.node.entries(), &["zh", "en"]);
        let text = |key: &str| entry.node.get(key).and_then(Node::text).filter(|t| !t.trim().is_empty());
        let words = text("zh").zip(text("en")).map(|(zh, en)| Bilingual::new(zh, en));
        if words.is_none() {
            self.fault(
                entry.mark,
                &entry.node.pointer,
                "名称须写明 zh 与 en，例如 { zh: 目标已转向, en: the target has turned }",
                "a name has both languages, as in { zh: 目标已转向, en: the target has turned }",
            );
        }
        words
    }

    /// The value of a parameter; one without a reason is reported, but still used to find other errors.
    fn parameter<'n>(&mut self, entry: &'n Entry) -> Option<&'n Node> {
        let pointer = &entry.node.pointer;
        let Value::Map(fields) = &entry.node.value else {
            self.fault(
                entry.mark,
                pointer,
                "参数须写明 value 与 reason，例如 { value: 3 m, reason: \"…\" }",
                "a parameter has a value and a reason, as in { value: 3 m, reason: \"...\" }",
            );
            return None;
        };
        self.unknown(fields, OF_PARAMETER);
        duplicates(fields, self.file, self.found);
        let mut field = |key: &str| {
            let text = entry.node.get(key).filter(|n| n.text().is_some_and(|t| !t.trim().is_empty()));
            if text.is_none() {
                let (zh, en) = match key {
                    "reason" => ("参数缺少理由（reason）", "the parameter has no reason"),
                    _ => ("参数缺少数值（value）", "the parameter has no value"),
                };
                self.fault(entry.mark, pointer, zh, en);
            }
            text
        };
        let (value, _) = (field("value"), field("reason"));
        value
    }
}

fn is_null(node: &Node) -> bool {
    matches!(node.value, Value::Null)
}

/// Type of a value, in Chinese and English.
fn description(node: &Node) -> (&'static str, &'static str) {
    match node.value {
        Value::Null => ("空值", "nothing"),
        Value::List(_) => ("列表", "a list"),
        Value::Map(_) => ("映射", "a mapping"),
        Value::Scalar(_) => ("单个值", "a single value"),
    }
}
