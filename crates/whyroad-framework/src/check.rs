//! Checks of every message but the label (DATA_FORMAT.md 2.2, 3 and 5), and the parts shared with the checks of labels
//! in whyroad-label: JSON with spans ([`json`]), the tolerant walk over it ([`walk`]), and findings ([`finding`]).
//!
//! Nothing here opens a file, and nothing here knows what a label means.

pub mod class_index;
pub mod closed_set;
pub mod codes;
pub mod finding;
pub mod json;
pub mod message;
pub mod scenario;
pub mod slot;
pub mod walk;

pub use class_index::ClassIndex;
pub use codes::CODES;
pub use finding::{Finding, Sink, Words};
pub use json::{Document, Layout, MAX_DOCUMENT_BYTES, Origin, Piece, Problem, Splitter, problem};
pub use message::MessageKind;
pub use slot::Slot;

use json::{Locator, Node, SyntaxError};
use walk::{LABEL, Walk};
use whyroad_model::{Bilingual, Diagnostic, Severity};

/// The result of checking one document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Its kind; `None` when it is not a known document.
    pub kind: Option<MessageKind>,
    /// It has no error; there may be warnings.
    pub valid: bool,
    /// It is JSON and resembles none of our documents: perhaps another program's.
    pub foreign: bool,
}

/// Parses `text`, checks it as the message it is, and adds the findings, sorted by location, to `out`. Locations have
/// no file name. The caller handles labels.
pub fn check_document<'t>(
    text: &'t str,
    origin: &'t Origin,
    classes: &ClassIndex,
    out: &mut Vec<Diagnostic>,
    label: impl FnOnce(&mut Walk<'_>),
) -> Verdict {
    let from = out.len();
    let locator = Locator::new(text, origin);
    let mut foreign = false;
    let kind = match json::parse(text) {
        Ok(root) => {
            let kind = message::kind_of(&root);
            let mut walk = Walk { root: &root, locator: &locator, family: &LABEL, out };
            match kind {
                None => foreign = message::unknown(&mut walk),
                Some(MessageKind::CocLabel) => label(&mut walk),
                Some(kind) => message::check(&mut walk, kind, classes),
            }
            kind
        }
        Err(error) => {
            out.push(not_json(error, &locator));
            None
        }
    };
    out[from..].sort_by_key(|a| (a.location.line, a.location.column));
    let valid = out[from..].iter().all(|d| d.severity != Severity::Error);
    Verdict { kind, valid, foreign }
}

/// All errors of a text that should be a message of this kind; [`MessageKind::CocLabel`] is not one of them.
pub fn check_message(text: &str, kind: MessageKind, classes: &ClassIndex) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    let origin = Origin::start();
    let locator = Locator::new(text, &origin);
    match json::parse(text) {
        Ok(root) => {
            let mut walk = Walk { root: &root, locator: &locator, family: &LABEL, out: &mut out };
            check_as(&mut walk, &root, kind, classes);
        }
        Err(error) => out.push(not_json(error, &locator)),
    }
    out.sort_by_key(|a| (a.location.line, a.location.column));
    out
}

fn check_as(walk: &mut Walk<'_>, root: &Node<'_>, kind: MessageKind, classes: &ClassIndex) {
    match message::kind_of(root) {
        Some(found) if found == kind => message::check(walk, kind, classes),
        None => {
            message::unknown(walk);
        }
        Some(found) => walk.report(Finding::error("message.kind", ""), &|| {
            Words::new(
                format!("此处应为 {}，实为 {}", kind.id(), found.id()),
                format!("expected a {}, found a {}", kind.id(), found.id()),
            )
        }),
    }
}

fn not_json(SyntaxError { span, message, hint }: SyntaxError, locator: &Locator<'_>) -> Diagnostic {
    let d = Diagnostic::error("label.json.syntax", message).at(locator.place(span, ""));
    Diagnostic { hint, ..d }
}

/// The finding for a document that is not UTF-8; its first `valid` bytes are.
pub fn not_utf8(document: &Document<'_>, valid: usize) -> Diagnostic {
    let good = std::str::from_utf8(&document.bytes[..valid]).unwrap_or_default();
    let place = Locator::new(good, &document.origin).place(good.len()..good.len(), "");
    Diagnostic::error("label.json.encoding", Bilingual::new("文本不是 UTF-8 编码", "the text is not UTF-8"))
        .with_hint(Bilingual::new(
            "可能是 GBK（ANSI）；另存为 UTF-8",
            "probably another encoding such as GBK; save it as UTF-8",
        ))
        .at(place)
}
