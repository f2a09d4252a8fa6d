//! The label checker (DATA_FORMAT.md 4.3): documents in, findings out, each with a code, a place and a hint.
//!
//! A label takes the fast path first: one typed pass over its bytes ([`lean`]) and the rules ([`rules`]) with
//! nobody listening but a flag. Only when that leaves any doubt is the document parsed again with places
//! ([`json`]), walked tolerantly ([`label`], [`message`]) and the same rules run with an audience. Nothing here
//! opens a file: [`Splitter`] takes bytes and gives documents.

mod class_index;
mod clips;
mod codes;
mod json;
mod label;
mod lean;
mod message;
mod rules;
mod trace;
mod view;
mod walk;

pub use clips::{ClipFacts, ClipIndex};
pub use codes::CODES;
pub use json::{Document, Layout, MAX_DOCUMENT_BYTES, Origin, Piece, Problem, Splitter};
pub use message::Kind;

use class_index::ClassIndex;
use json::{Locator, SyntaxError};
use rules::{Finding, Rulebook, Sink, Words};
use walk::{LABEL, Walk};
use whyroad_framework::Framework;
use whyroad_model::{Bilingual, Diagnostic, Location, Severity};

/// Checks documents against one framework and, where given, one list of clips.
#[derive(Debug)]
pub struct Checker<'f> {
    framework: &'f Framework,
    classes: ClassIndex,
    clips: Option<ClipIndex>,
}

/// What a document turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Its kind; `None` when it is no known document.
    pub kind: Option<Kind>,
    /// It has no error; there may be warnings.
    pub valid: bool,
    /// It is JSON and resembles none of our documents: perhaps another program's.
    pub foreign: bool,
}

/// Listens only for whether anything was said.
struct Silence {
    broken: bool,
}

impl Sink for Silence {
    fn report(&mut self, _: Finding, _: &dyn Fn() -> Words) {
        self.broken = true;
    }
}

impl<'f> Checker<'f> {
    /// A checker that knows no clips.
    pub fn new(framework: &'f Framework) -> Self {
        Self { framework, classes: ClassIndex::new(framework), clips: None }
    }

    /// The same, holding labels against these clips.
    #[must_use]
    pub fn with_clips(mut self, clips: ClipIndex) -> Self {
        self.clips = Some(clips);
        self
    }

    fn rulebook(&self) -> Rulebook<'_> {
        Rulebook { classes: &self.classes, lexicon: &self.framework.lexicon, clips: self.clips.as_ref() }
    }

    /// Checks one document and adds what was found, sorted by place, to `out`. Places have no file name.
    pub fn check(&self, document: &Document<'_>, out: &mut Vec<Diagnostic>) -> Verdict {
        match std::str::from_utf8(document.bytes) {
            Ok(text) if self.is_clean_label(text) => {
                Verdict { kind: Some(Kind::CocLabel), valid: true, foreign: false }
            }
            Ok(text) => self.explain(text, &document.origin, out),
            Err(e) => {
                out.push(not_utf8(document, e.valid_up_to()));
                Verdict { kind: None, valid: false, foreign: false }
            }
        }
    }

    /// Checks a document that stands alone.
    pub fn check_text(&self, text: &str) -> Vec<Diagnostic> {
        let mut out = Vec::new();
        self.check(&Document { origin: Origin::start(), bytes: text.as_bytes() }, &mut out);
        out
    }

    /// The fast path: true when `text` is a label without any finding. False says nothing yet.
    pub fn is_clean_label(&self, text: &str) -> bool {
        lean::Lean::read(text).is_some_and(|label| {
            let mut sink = Silence { broken: false };
            self.rulebook().check(&label.view(), &mut sink);
            !sink.broken
        })
    }

    /// The slow path: everything that is wrong with `text`, whatever the fast path thinks.
    fn explain(&self, text: &str, origin: &Origin, out: &mut Vec<Diagnostic>) -> Verdict {
        let from = out.len();
        let locator = Locator::new(text, origin);
        let mut foreign = false;
        let kind = match json::parse(text) {
            Ok(root) => {
                let kind = message::kind_of(&root);
                let mut walk = Walk { root: &root, locator: &locator, family: &LABEL, out };
                match kind {
                    None => foreign = message::unknown(&mut walk),
                    Some(Kind::CocLabel) => {
                        let view = label::read(&mut walk, &root, &self.framework.decisions);
                        self.rulebook().check(&view, &mut walk);
                    }
                    Some(kind) => message::check(&mut walk, kind, &self.classes),
                }
                kind
            }
            Err(SyntaxError { span, message, hint }) => {
                let d = Diagnostic::error("label.json.syntax", message).at(locator.place(span, ""));
                out.push(Diagnostic { hint, ..d });
                None
            }
        };
        out[from..].sort_by_key(|a| (a.location.line, a.location.column));
        let valid = out[from..].iter().all(|d| d.severity != Severity::Error);
        Verdict { kind, valid, foreign }
    }
}

/// The finding for something wrong between documents. The place has no file name.
pub fn problem(problem: Problem, origin: &Origin) -> Diagnostic {
    let place = Location {
        line: Some(origin.line),
        column: Some(origin.column),
        pointer: Some(origin.element.map(|i| format!("/{i}")).unwrap_or_default()),
        ..Location::default()
    };
    let b = |zh: &str, en: &str| Bilingual::new(zh, en);
    let syntax = |message| Diagnostic::error("label.json.syntax", message);
    let d = match problem {
        Problem::ByteOrderMark => Diagnostic::warning(
            "label.json.bom",
            b(
                "文件以 BOM（字节顺序标记）开头，许多程序读不了",
                "the file starts with a byte order mark, which many programs refuse",
            ),
        )
        .with_hint(b("另存为“UTF-8”（不带 BOM）", "save it as UTF-8 without BOM")),
        Problem::Utf16 => Diagnostic::error(
            "label.json.encoding",
            b("文件是 UTF-16 编码，未读取", "the file is UTF-16 and was not read"),
        )
        .with_hint(b("另存为 UTF-8", "save it as UTF-8")),
        Problem::CommaMissing => {
            syntax(b("数组的两个元素之间缺少逗号", "a comma is missing between two elements of the array"))
        }
        Problem::CommaTooMany => syntax(b("数组中多了一个逗号", "there is a comma too many in the array"))
            .with_hint(b("删除这个逗号", "delete this comma")),
        Problem::ArrayOpen => {
            syntax(b("文件在数组中间中断，缺少 ']'", "the file ends inside its array: ']' is missing"))
        }
        Problem::TooLarge => {
            let megabytes = MAX_DOCUMENT_BYTES >> 20;
            Diagnostic::error(
                "label.json.too_large",
                Bilingual::new(
                    format!("文档超过 {megabytes} MB，未检查"),
                    format!("the document is larger than {megabytes} MB and was not checked"),
                ),
            )
        }
        Problem::NotJson => syntax(b(
            "此后的内容看来不是 JSON，文件余下部分未检查",
            "this does not look like JSON; the rest of the file was not checked",
        )),
    };
    d.at(place)
}

fn not_utf8(document: &Document<'_>, valid: usize) -> Diagnostic {
    let good = std::str::from_utf8(&document.bytes[..valid]).unwrap_or_default();
    let place = Locator::new(good, &document.origin).place(good.len()..good.len(), "");
    Diagnostic::error("label.json.encoding", Bilingual::new("文本不是 UTF-8 编码", "the text is not UTF-8"))
        .with_hint(Bilingual::new(
            "多半是 GBK（ANSI）；另存为 UTF-8",
            "probably another encoding such as GBK; save it as UTF-8",
        ))
        .at(place)
}

#[cfg(test)]
mod tests;
