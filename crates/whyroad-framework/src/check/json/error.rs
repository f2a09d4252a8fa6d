//! Syntax errors, described so that an annotator can fix them. The location is a byte range of the document;
//! [`super::Locator`] converts it to line and column.

use std::ops::Range;
use whyroad_model::Bilingual;

/// Why a text is not JSON.
#[derive(Clone, Debug, PartialEq)]
pub struct SyntaxError {
    /// Bytes of the document to underline.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: Bilingual,
    /// How to fix it.
    pub hint: Option<Bilingual>,
}

impl SyntaxError {
    /// An error without a hint.
    pub fn new(span: Range<usize>, zh: impl Into<String>, en: impl Into<String>) -> Self {
        Self { span, message: Bilingual::new(zh, en), hint: None }
    }

    /// With a hint.
    #[must_use]
    pub fn hint(mut self, zh: impl Into<String>, en: impl Into<String>) -> Self {
        self.hint = Some(Bilingual::new(zh, en));
        self
    }

    /// `wanted` is expected at `at`, but something else is there, or the text ends.
    pub fn expected(text: &str, at: usize, wanted_zh: &str, wanted_en: &str) -> Self {
        let Some(c) = text[at..].chars().next() else {
            return Self::new(
                end_of(text),
                format!("JSON 在此处中断，缺少{wanted_zh}"),
                format!("the JSON ends here, {wanted_en} is missing"),
            );
        };
        let span = at..at + c.len_utf8();
        let e = Self::new(
            span,
            format!("此处应为{wanted_zh}，实为 '{c}'"),
            format!("expected {wanted_en}, found '{c}'"),
        );
        match c {
            '，' | '：' | '“' | '”' | '｛' | '｝' | '［' | '］' | '‘' | '’' => e.hint(
                format!("'{c}' 是中文（全角）标点，JSON 只用英文（半角）标点"),
                format!("'{c}' is full-width or typographic punctuation; JSON uses plain ASCII punctuation"),
            ),
            '\'' => e.hint("JSON 只用双引号 \"", "JSON uses double quotes \" only"),
            '/' | '#' => e.hint("JSON 不允许注释", "JSON has no comments"),
            _ => e,
        }
    }

    /// A word that is not a JSON value, such as Python's `None` or a bare identifier.
    pub fn word(text: &str, at: usize) -> Self {
        let word: String = text[at..]
            .chars()
            .take_while(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '+' | '.'))
            .collect();
        if word.is_empty() {
            return Self::expected(text, at, "一个值", "a value");
        }
        let e = Self::new(
            at..at + word.len(),
            format!("'{word}' 不是 JSON 值"),
            format!("'{word}' is not a JSON value"),
        );
        match word.to_ascii_lowercase().as_str() {
            "none" | "null" | "nil" | "undefined" => e.hint("空值写作 null", "write null"),
            "true" => e.hint("写作 true", "write true"),
            "false" => e.hint("写作 false", "write false"),
            "nan" | "inf" | "-inf" | "infinity" | "-infinity" => e.hint(
                "JSON 没有 NaN 和无穷大；未知的值写 null",
                "JSON has no NaN or infinity; write null for unknown values",
            ),
            w if w.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.')) => {
                e.hint("数字写作 12、-0.5 或 1.5e3", "numbers look like 12, -0.5 or 1.5e3")
            }
            _ => e.hint("文本要加双引号", "text needs double quotes"),
        }
    }
}

/// The last character of `text`, which is where a reader looks for the end.
fn end_of(text: &str) -> Range<usize> {
    let trimmed = text.trim_end();
    let start = trimmed.char_indices().next_back().map_or(0, |(i, _)| i);
    start..trimmed.len()
}
