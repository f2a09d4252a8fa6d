//! The slow path's walk over a document: fields are requested one by one, every error of form is reported with its
//! location, and the walk continues. The rules interpret the fields.

use super::finding::{Finding, Sink, Words};
use super::json::{Entry, JsonKind, Locator, Node};
use super::slot::Slot;
use crate::taxonomy::did_you_mean;
use std::collections::HashSet;
use std::ops::Range;
use whyroad_model::{Bilingual, Diagnostic, Nanos, Severity};

/// Maximum number of keys of an object that are compared pair by pair.
const FEW_KEYS: usize = 24;

/// The codes that a family of documents uses for errors of form.
#[derive(Debug)]
pub struct Family {
    /// A field is missing, null or blank.
    pub required: &'static str,
    /// A value of another JSON type.
    pub kind: &'static str,
    /// A text that is not a time.
    pub time: &'static str,
    /// A field that no message of this family has.
    pub unknown_field: &'static str,
}

/// CoC labels and scenario labels.
pub const LABEL: Family = Family {
    required: "label.required",
    kind: "label.type",
    time: "label.time.format",
    unknown_field: "label.unknown_field",
};

/// All other messages.
pub const MESSAGE: Family = Family {
    required: "message.required",
    kind: "message.type",
    time: "message.time.format",
    unknown_field: "message.unknown_field",
};

/// One document being explained.
pub struct Walk<'d> {
    /// The document.
    pub root: &'d Node<'d>,
    /// From its bytes to lines and columns.
    pub locator: &'d Locator<'d>,
    /// Codes for errors of form.
    pub family: &'static Family,
    /// Receives the findings.
    pub out: &'d mut Vec<Diagnostic>,
}

/// An object being read. Every requested key is a known one; [`Walk::close`] reports the others.
pub struct Object<'d> {
    /// Its value in the document.
    pub node: &'d Node<'d>,
    /// Its JSON pointer.
    pub pointer: String,
    entries: &'d [Entry<'d>],
    asked: Vec<&'static str>,
}

impl<'d> Object<'d> {
    /// The value of a key, null included.
    pub fn raw(&mut self, key: &'static str) -> Option<&'d Node<'d>> {
        self.asked.push(key);
        self.entries.iter().find(|e| e.key == key).map(|e| &e.node)
    }

    /// The value of an optional key; null is absent.
    pub fn get(&mut self, key: &'static str) -> Option<&'d Node<'d>> {
        self.raw(key).filter(|n| !n.is_null())
    }

    /// The JSON pointer of a key.
    pub fn at(&self, key: &str) -> String {
        format!("{}/{}", self.pointer, key.replace('~', "~0").replace('/', "~1"))
    }

    /// All keys with their values.
    pub fn entries(&self) -> &'d [Entry<'d>] {
        self.entries
    }
}

impl<'d> Walk<'d> {
    /// Adds a diagnostic that underlines these bytes.
    pub fn push(&mut self, d: Diagnostic, span: Range<usize>, pointer: &str) {
        self.out.push(d.at(self.locator.place(span, pointer)));
    }

    fn error(&mut self, code: &'static str, node: &Node<'_>, pointer: &str, zh: String, en: String) {
        self.push(Diagnostic::error(code, Bilingual::new(zh, en)), node.mark(), pointer);
    }

    fn wrong_kind<T>(&mut self, node: &Node<'_>, pointer: &str, zh: &str, en: &str) -> Slot<T> {
        let found = describe(node);
        let (zh, en) =
            (format!("此处应为{zh}，实为{}", found.zh), format!("expected {en}, found {}", found.en));
        self.error(self.family.kind, node, pointer, zh, en);
        Slot::Broken
    }

    /// Starts reading an object; a key written twice is reported, the first one counts.
    pub fn object(&mut self, node: &'d Node<'d>, pointer: String) -> Option<Object<'d>> {
        let Some(entries) = node.entries() else {
            self.wrong_kind::<()>(node, &pointer, "对象 {…}", "an object {...}");
            return None;
        };
        self.duplicates(entries, &pointer);
        Some(Object { node, pointer, entries, asked: Vec::new() })
    }

    fn duplicates(&mut self, entries: &[Entry<'_>], pointer: &str) {
        // For few keys, comparing all pairs is faster than a set.
        let mut seen = (entries.len() > FEW_KEYS).then(HashSet::new);
        for (i, e) in entries.iter().enumerate() {
            let twice = match &mut seen {
                Some(seen) => !seen.insert(&*e.key),
                None => entries[..i].iter().any(|o| o.key == e.key),
            };
            if twice {
                let key = &e.key;
                let d = Diagnostic::error(
                    "label.json.duplicate_key",
                    Bilingual::new(format!("键 '{key}' 重复出现"), format!("key '{key}' is written twice")),
                )
                .with_hint(Bilingual::new(
                    "不同的读取程序会取不同的那个值；只留一个",
                    "programs differ in which of the two they read; keep one",
                ));
                self.push(d, e.key_span.clone(), &format!("{pointer}/{key}"));
            }
        }
    }

    /// Looks for keys written twice in values that are not read further.
    pub fn free(&mut self, node: &Node<'_>, pointer: &str) {
        match &node.kind {
            JsonKind::List(items) => {
                for (i, item) in items.iter().enumerate() {
                    self.free(item, &format!("{pointer}/{i}"));
                }
            }
            JsonKind::Map(entries) => {
                self.duplicates(entries, pointer);
                for e in entries {
                    self.free(&e.node, &format!("{pointer}/{}", e.key));
                }
            }
            _ => {}
        }
    }

    /// A key that must be there; null is reported too unless the caller reads it with [`Walk::nullable`].
    pub fn need(&mut self, o: &mut Object<'d>, key: &'static str) -> Option<&'d Node<'d>> {
        let node = self.nullable(o, key)?;
        if node.is_null() {
            let (zh, en) =
                (format!("必填字段 '{key}' 不可为 null"), format!("required field '{key}' must not be null"));
            self.error(self.family.required, node, &o.at(key), zh, en);
            return None;
        }
        Some(node)
    }

    /// A key that must be there, with null as a separate value.
    pub fn nullable(&mut self, o: &mut Object<'d>, key: &'static str) -> Option<&'d Node<'d>> {
        let found = o.raw(key);
        if found.is_none() {
            let words =
                Bilingual::new(format!("缺少必填字段 '{key}'"), format!("required field '{key}' is missing"));
            let mut d = Diagnostic::error(self.family.required, words);
            let near = o.entries.iter().map(|e| &*e.key).filter(|k| !o.asked.contains(k));
            if let Some(near) = did_you_mean(key, near) {
                d = d.with_hint(Bilingual::new(
                    format!("此处有字段 '{near}'，是否写错了名字？"),
                    format!("there is a field '{near}' here; is it a typo for this one?"),
                ));
            }
            self.push(d, o.node.mark(), &o.at(key));
        }
        found
    }

    /// A text that is not blank.
    pub fn text(&mut self, node: Option<&'d Node<'d>>, pointer: &str) -> Slot<&'d str> {
        match self.any_text(node, pointer) {
            Slot::Is(t) if t.trim().is_empty() => {
                if let Some(node) = node {
                    self.error(
                        self.family.required,
                        node,
                        pointer,
                        "文本为空".into(),
                        "the text is empty".into(),
                    );
                }
                Slot::Broken
            }
            t => t,
        }
    }

    /// A text, blank or not.
    pub fn any_text(&mut self, node: Option<&'d Node<'d>>, pointer: &str) -> Slot<&'d str> {
        match node.map(|n| (n, &n.kind)) {
            None => Slot::Absent,
            Some((_, JsonKind::Text(t))) => Slot::Is(t),
            Some((n, _)) => self.wrong_kind(n, pointer, "文本", "text"),
        }
    }

    /// An ISO 8601 time.
    pub fn time(&mut self, node: Option<&'d Node<'d>>, pointer: &str) -> Slot<Nanos> {
        let Slot::Is(text) = self.any_text(node, pointer) else {
            return if node.is_none() { Slot::Absent } else { Slot::Broken };
        };
        let (Ok(time), Some(node)) = (Nanos::parse_iso(text), node) else {
            let d = Diagnostic::error(
                self.family.time,
                Bilingual::new(
                    format!("'{text}' 不是带时区的 ISO 8601 时间"),
                    format!("'{text}' is not an ISO 8601 date-time with its offset from UTC"),
                ),
            )
            .with_hint(Bilingual::new(
                "写作 2026-01-15T10:30:00.000Z",
                "write it as 2026-01-15T10:30:00.000Z",
            ));
            if let Some(node) = node {
                self.push(d, node.mark(), pointer);
            }
            return Slot::Broken;
        };
        let _ = node;
        Slot::Is(time)
    }

    /// A whole number from 0.
    pub fn count(&mut self, node: Option<&'d Node<'d>>, pointer: &str) -> Slot<u64> {
        match node.map(|n| (n, &n.kind)) {
            None => Slot::Absent,
            Some((n, JsonKind::Number(raw))) => match raw.parse::<u64>() {
                Ok(v) => Slot::Is(v),
                Err(_) => self.wrong_kind(n, pointer, "不小于 0 的整数", "a whole number from 0"),
            },
            Some((n, _)) => self.wrong_kind(n, pointer, "不小于 0 的整数", "a whole number from 0"),
        }
    }

    /// A frame index or count of frames.
    pub fn frame(&mut self, node: Option<&'d Node<'d>>, pointer: &str) -> Slot<u32> {
        match (self.count(node, pointer), node) {
            (Slot::Is(v), Some(n)) => match u32::try_from(v) {
                Ok(v) => Slot::Is(v),
                Err(_) => self.wrong_kind(n, pointer, "帧号", "a frame number"),
            },
            (Slot::Absent, _) => Slot::Absent,
            _ => Slot::Broken,
        }
    }

    /// Any number.
    pub fn number(&mut self, node: Option<&'d Node<'d>>, pointer: &str) -> Slot<f64> {
        match node.map(|n| (n, &n.kind)) {
            None => Slot::Absent,
            Some((n, JsonKind::Number(raw))) => match raw.parse() {
                Ok(v) => Slot::Is(v),
                Err(_) => self.wrong_kind(n, pointer, "数字", "a number"),
            },
            Some((n, _)) => self.wrong_kind(n, pointer, "数字", "a number"),
        }
    }

    /// true or false.
    pub fn flag(&mut self, node: Option<&'d Node<'d>>, pointer: &str) -> Slot<bool> {
        match node.map(|n| (n, &n.kind)) {
            None => Slot::Absent,
            Some((_, JsonKind::Flag(b))) => Slot::Is(*b),
            Some((n, _)) => self.wrong_kind(n, pointer, " true 或 false", "true or false"),
        }
    }

    /// The items of a list.
    pub fn list(&mut self, node: Option<&'d Node<'d>>, pointer: &str) -> Slot<&'d [Node<'d>]> {
        match node.map(|n| (n, &n.kind)) {
            None => Slot::Absent,
            Some((_, JsonKind::List(items))) => Slot::Is(items),
            Some((n, _)) => self.wrong_kind(n, pointer, "列表 […]", "a list [...]"),
        }
    }

    /// A list of texts.
    pub fn texts(&mut self, node: Option<&'d Node<'d>>, pointer: &str) {
        if let Slot::Is(items) = self.list(node, pointer) {
            for (i, item) in items.iter().enumerate() {
                self.any_text(Some(item), &format!("{pointer}/{i}"));
            }
        }
    }

    /// Reports the keys that were not requested.
    pub fn close(&mut self, o: Object<'d>, severity: Severity) {
        for (i, e) in o.entries.iter().enumerate() {
            if o.asked.contains(&&*e.key) || o.entries[..i].iter().any(|p| p.key == e.key) {
                continue;
            }
            let key = &e.key;
            let mut d = Diagnostic::error(
                self.family.unknown_field,
                Bilingual::new(format!("未知字段 '{key}'"), format!("unknown field '{key}'")),
            );
            d.severity = severity;
            if let Some(near) = did_you_mean(key, o.asked.iter().copied()) {
                d = d.with_hint(Bilingual::new(
                    format!("是否想写 '{near}'？"),
                    format!("did you mean '{near}'?"),
                ));
            }
            let pointer = o.at(key);
            self.push(d, e.key_span.clone(), &pointer);
            self.free(&e.node, &pointer);
        }
    }

    /// Bytes to underline for `pointer`: its value, or the nearest thing above it that exists.
    fn span_of(&self, pointer: &str, part: Option<(usize, usize)>) -> Range<usize> {
        let mut node = self.root;
        let mut key_span: Option<Range<usize>> = None;
        let mut whole = true;
        for step in pointer.split('/').skip(1) {
            let step = step.replace("~1", "/").replace("~0", "~");
            let next = match &node.kind {
                JsonKind::Map(entries) => {
                    entries.iter().find(|e| e.key == step).map(|e| (&e.node, Some(e.key_span.clone())))
                }
                JsonKind::List(items) => {
                    step.parse::<usize>().ok().and_then(|i| items.get(i)).map(|n| (n, None))
                }
                _ => None,
            };
            match next {
                Some((n, key)) => {
                    node = n;
                    key_span = key.or(key_span);
                }
                None => {
                    whole = false;
                    break;
                }
            }
        }
        match (part, &node.kind) {
            (Some((start, end)), JsonKind::Text(t)) if whole && t.len() + 2 == node.span.len() => {
                node.span.start + 1 + start..node.span.start + 1 + end
            }
            // A long text is named by its key; underlining all of it would not help.
            (_, JsonKind::Text(t)) if whole && t.len() > 60 => key_span.unwrap_or_else(|| node.mark()),
            (_, JsonKind::Map(_) | JsonKind::List(_)) => key_span.unwrap_or_else(|| node.mark()),
            _ => node.mark(),
        }
    }
}

impl Sink for Walk<'_> {
    fn report(&mut self, finding: Finding, words: &dyn Fn() -> Words) {
        let Words { message, hint } = words();
        let span = self.span_of(&finding.pointer, finding.part);
        let d = Diagnostic {
            code: finding.code,
            severity: finding.severity,
            message,
            location: Default::default(),
            hint,
        };
        self.push(d, span, &finding.pointer);
    }
}

/// A value, for "expected ..., found ...".
fn describe(node: &Node<'_>) -> Bilingual {
    match &node.kind {
        JsonKind::Null => Bilingual::same("null"),
        JsonKind::Flag(b) => Bilingual::same(b.to_string()),
        JsonKind::Number(raw) => Bilingual::new(format!("数字 {raw}"), format!("the number {raw}")),
        JsonKind::Text(t) => {
            let short: String = t.chars().take(20).collect();
            let more = if short.len() < t.len() { "…" } else { "" };
            Bilingual::new(format!("文本 \"{short}{more}\""), format!("the text \"{short}{more}\""))
        }
        JsonKind::List(_) => Bilingual::new("列表", "a list"),
        JsonKind::Map(_) => Bilingual::new("对象", "an object"),
    }
}
