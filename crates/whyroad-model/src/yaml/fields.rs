//! Reading a mapping field by field, continuing after each mistake: fields that are missing, of the wrong type, written
//! twice or unknown are reported with their location, and the rest is read.

use super::{Entry, Mark, Node, Value};
use crate::suggest::{did_you_mean, suggestion};
use crate::{Bilingual, Diagnostic, Location};

/// The codes that one family of files (`taxonomy.*`, `spec.*`) uses for mistakes of form.
#[derive(Debug)]
pub struct FormCodes {
    /// The text is not YAML.
    pub syntax: &'static str,
    /// A required field is missing.
    pub missing: &'static str,
    /// A field is unknown.
    pub unknown: &'static str,
    /// A value has the wrong type (text, list, mapping).
    pub kind: &'static str,
    /// A key is written twice.
    pub duplicate: &'static str,
    /// A required text is empty.
    pub empty: &'static str,
}

/// Diagnostics of one file.
pub struct FileReport<'t> {
    /// Name of the file, for locations.
    pub file: &'t str,
    /// Codes for mistakes of form.
    pub codes: &'static FormCodes,
    lines: Vec<&'t str>,
    /// What was found, in the order of finding.
    pub diagnostics: Vec<Diagnostic>,
}

impl<'t> FileReport<'t> {
    /// An empty report on `text`, the content of `file`.
    pub fn new(file: &'t str, text: &'t str, codes: &'static FormCodes) -> Self {
        Self { file, codes, lines: text.lines().collect(), diagnostics: Vec::new() }
    }

    /// Adds `d` at `mark`.
    pub fn push(&mut self, d: Diagnostic, mark: Mark, pointer: &str) {
        self.diagnostics.push(d.at(self.location(mark, pointer)));
    }

    /// The location of `mark` in this file.
    pub fn location(&self, mark: Mark, pointer: &str) -> Location {
        Location {
            file: Some(self.file.to_owned()),
            line: Some(mark.line),
            column: Some(mark.column),
            pointer: Some(pointer.to_owned()),
            snippet: self.lines.get(mark.line.saturating_sub(1)).map(|s| (*s).to_owned()),
            span: mark.span,
            ..Location::default()
        }
    }

    /// Adds an error about `node`.
    pub fn error(&mut self, code: &'static str, node: &Node, zh: String, en: String) {
        self.push(Diagnostic::error(code, Bilingual::new(zh, en)), node.mark, &node.pointer);
    }

    /// Adds an error about `node` with its remedy.
    pub fn error_with_hint(&mut self, code: &'static str, node: &Node, message: Bilingual, hint: Bilingual) {
        self.push(Diagnostic::error(code, message).with_hint(hint), node.mark, &node.pointer);
    }

    /// Parses `text`; a syntax error is reported and yields nothing.
    pub fn parse(&mut self, text: &str) -> Option<Node> {
        match super::parse(text) {
            Ok(node) => Some(node),
            Err(e) => {
                let message = Bilingual::new(
                    format!("不是合法的 YAML：{}", e.message().zh),
                    format!("not valid YAML: {}", e.message().en),
                );
                self.push(Diagnostic::error(self.codes.syntax, message), e.mark, "");
                None
            }
        }
    }

    /// `how` states how the wanted kind is written.
    fn wrong_kind(&mut self, node: &Node, wanted: Bilingual, how: Bilingual) {
        let found = node.value.description();
        let message = Bilingual::new(
            format!("此处应为{}，实为{}", wanted.zh, found.zh),
            format!("expected {}, found {}", wanted.en, found.en),
        );
        let is_empty_file = node.pointer.is_empty() && matches!(node.value, Value::Null);
        let how = if is_empty_file {
            Bilingual::new(
                "文件是空的：写入其字段，或删除该文件",
                "the file is empty: write its fields, or delete the file",
            )
        } else {
            how
        };
        self.error_with_hint(self.codes.kind, node, message, how);
    }

    /// The text of a scalar.
    pub fn text(&mut self, node: &Node) -> Option<String> {
        match &node.value {
            Value::Scalar(scalar) if scalar.text.trim().is_empty() => {
                let hint = Bilingual::new("填写文本，或删除该字段", "write the text, or delete the field");
                let message = Bilingual::new("文本为空", "the text is empty");
                self.error_with_hint(self.codes.empty, node, message, hint);
                None
            }
            Value::Scalar(scalar) => Some(scalar.text.trim().to_owned()),
            _ => {
                let how = Bilingual::new(
                    "写成一个值，必要时加引号",
                    "write one value, in quotation marks if need be",
                );
                self.wrong_kind(node, Bilingual::new("文本", "text"), how);
                None
            }
        }
    }

    /// The items of a list.
    pub fn items<'n>(&mut self, node: &'n Node) -> &'n [Node] {
        match &node.value {
            Value::List(items) => items,
            _ => {
                let how = Bilingual::new(
                    "写成 [甲, 乙]，或每项一行，以 '- ' 开头",
                    "write `[a, b]`, or one item a line after '- '",
                );
                self.wrong_kind(node, Bilingual::new("列表", "a list"), how);
                &[]
            }
        }
    }

    /// The entries of a mapping, keys unique: a key's second use is reported and left out.
    pub fn entries<'n>(&mut self, node: &'n Node) -> Option<Vec<&'n Entry>> {
        let Value::Map(entries) = &node.value else {
            let how = Bilingual::new(
                "写成缩进的若干行 '键: 值'，或 { 键: 值 }",
                "write indented lines `key: value`, or `{ key: value }`",
            );
            self.wrong_kind(node, Bilingual::new("映射", "a mapping"), how);
            return None;
        };
        let mut out: Vec<&Entry> = Vec::with_capacity(entries.len());
        for e in entries {
            if let Some(first) = out.iter().find(|o| o.key == e.key) {
                let (key, line) = (&e.key, first.mark.line);
                let message = Bilingual::new(
                    format!("键 '{key}' 重复，首次出现在第 {line} 行"),
                    format!("key '{key}' is written twice, first on line {line}"),
                );
                let hint = Bilingual::new(
                    "删除其中一个，或合并两处的内容",
                    "delete one of the two, or merge what they hold",
                );
                let d = Diagnostic::error(self.codes.duplicate, message).with_hint(hint);
                self.push(d, e.mark, &e.node.pointer);
            } else {
                out.push(e);
            }
        }
        Some(out)
    }
}

/// A mapping that is being read. Every key that is requested is known; [`Fields::close`] reports the others.
pub struct Fields<'n> {
    node: &'n Node,
    entries: Vec<&'n Entry>,
    asked: Vec<&'static str>,
}

impl<'n> Fields<'n> {
    /// Starts reading `node`; reports it if it is not a mapping.
    pub fn open(node: &'n Node, report: &mut FileReport) -> Option<Self> {
        Some(Self { node, entries: report.entries(node)?, asked: Vec::new() })
    }

    /// The entry of a key, null included.
    pub fn entry(&mut self, key: &'static str) -> Option<&'n Entry> {
        self.asked.push(key);
        self.entries.iter().find(|e| e.key == key).copied()
    }

    /// The value of an optional key; null counts as absent.
    pub fn get(&mut self, key: &'static str) -> Option<&'n Node> {
        self.entry(key).map(|e| &e.node).filter(|n| !matches!(n.value, Value::Null))
    }

    /// The value of a required key.
    pub fn need(&mut self, key: &'static str, report: &mut FileReport) -> Option<&'n Node> {
        let found = self.get(key);
        if found.is_none() {
            let message =
                Bilingual::new(format!("缺少必填字段 '{key}'"), format!("required field '{key}' is missing"));
            let is_written = self.entries.iter().any(|e| e.key == key);
            let hint = if is_written {
                Bilingual::new(format!("在 '{key}:' 之后填写值"), format!("write a value after '{key}:'"))
            } else {
                Bilingual::new(
                    format!("在此处同级的字段中补上 '{key}: …'"),
                    format!("add '{key}: ...' beside the fields that are here"),
                )
            };
            report.error_with_hint(report.codes.missing, self.node, message, hint);
        }
        found
    }

    /// A required text.
    pub fn text(&mut self, key: &'static str, report: &mut FileReport) -> Option<String> {
        self.need(key, report).and_then(|n| report.text(n))
    }

    /// An optional text.
    pub fn text_opt(&mut self, key: &'static str, report: &mut FileReport) -> Option<String> {
        self.get(key).and_then(|n| report.text(n))
    }

    /// An optional list; absent is empty.
    pub fn list(&mut self, key: &'static str, report: &mut FileReport) -> &'n [Node] {
        self.get(key).map_or(&[], |n| report.items(n))
    }

    /// Reports the keys that were not requested.
    pub fn close(self, report: &mut FileReport) {
        for e in &self.entries {
            if self.asked.contains(&e.key.as_str()) {
                continue;
            }
            let key = &e.key;
            let mut d = Diagnostic::error(
                report.codes.unknown,
                Bilingual::new(format!("未知字段 '{key}'"), format!("unknown field '{key}'")),
            );
            let hint = match did_you_mean(key, self.asked.iter().copied()) {
                Some(near) => suggestion(near),
                None => {
                    let known = self.asked.join(", ");
                    Bilingual::new(format!("可用字段：{known}"), format!("known fields: {known}"))
                }
            };
            d = d.with_hint(hint);
            report.push(d, e.mark, &e.node.pointer);
        }
    }
}
