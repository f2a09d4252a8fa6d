//! What a check reports: a code, a location by JSON pointer, and texts that are made only when they are read.

use std::borrow::Cow;
use whyroad_model::{Bilingual, Severity};

/// Texts of a finding.
#[derive(Clone, Debug)]
pub struct Words {
    /// What is wrong.
    pub message: Bilingual,
    /// How to fix it.
    pub hint: Option<Bilingual>,
}

impl Words {
    /// A message without a hint.
    pub fn new(zh: impl Into<String>, en: impl Into<String>) -> Self {
        Self { message: Bilingual::new(zh, en), hint: None }
    }

    /// With a hint.
    #[must_use]
    pub fn hint(mut self, zh: impl Into<String>, en: impl Into<String>) -> Self {
        self.hint = Some(Bilingual::new(zh, en));
        self
    }

    /// With a suggested word.
    #[must_use]
    pub fn meant(self, word: &str) -> Self {
        self.hint(format!("是否想写 '{word}'？"), format!("did you mean '{word}'?"))
    }

    /// With the accepted words, as each language lists them.
    #[must_use]
    pub fn one_of(self, zh: &str, en: &str) -> Self {
        self.hint(format!("可选：{zh}"), format!("choose one of: {en}"))
    }
}

/// What was found, and where.
#[derive(Clone, Debug)]
pub struct Finding {
    /// Stable code.
    pub code: &'static str,
    /// How serious.
    pub severity: Severity,
    /// JSON pointer; need not exist in the document.
    pub pointer: Cow<'static, str>,
    /// Bytes of the text there, for a finding about a part of it.
    pub part: Option<(usize, usize)>,
}

impl Finding {
    /// An error at a pointer.
    pub fn error(code: &'static str, pointer: impl Into<Cow<'static, str>>) -> Self {
        Self { code, severity: Severity::Error, pointer: pointer.into(), part: None }
    }

    /// A warning at a pointer.
    pub fn warning(code: &'static str, pointer: impl Into<Cow<'static, str>>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, pointer) }
    }

    /// A hint at a pointer: likely, not certain.
    pub fn note(code: &'static str, pointer: impl Into<Cow<'static, str>>) -> Self {
        Self { severity: Severity::Note, ..Self::error(code, pointer) }
    }

    /// Only these bytes of the text there.
    #[must_use]
    pub fn part(mut self, start: usize, end: usize) -> Self {
        self.part = Some((start, end));
        self
    }
}

/// Takes findings. The fast path only notes that there was one.
pub trait Sink {
    /// Takes one finding; `words` makes its text when it is shown.
    fn report(&mut self, finding: Finding, words: &dyn Fn() -> Words);
}
