//! HTML text under construction. Markup must be a literal of this program; all text from data goes through an escaping
//! method, so that no name in a log can become markup.

use std::fmt::Write;
use whyroad_model::Bilingual;
use whyroad_model::display::number;

/// A fragment of the page.
#[derive(Clone, Debug, Default)]
pub struct Markup(String);

impl Markup {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Markup that this program wrote.
    pub fn raw(&mut self, literal: &'static str) -> &mut Self {
        self.0.push_str(literal);
        self
    }

    /// Text or the inside of a quoted attribute, escaped.
    pub fn text(&mut self, text: &str) -> &mut Self {
        for c in text.chars() {
            match c {
                '&' => self.0.push_str("&amp;"),
                '<' => self.0.push_str("&lt;"),
                '>' => self.0.push_str("&gt;"),
                '"' => self.0.push_str("&quot;"),
                '\'' => self.0.push_str("&#39;"),
                c => self.0.push(c),
            }
        }
        self
    }

    /// Both languages; the page shows one.
    pub fn both(&mut self, text: &Bilingual) -> &mut Self {
        if text.zh == text.en {
            return self.text(&text.zh);
        }
        self.raw("<span lang=\"zh\">").text(&text.zh).raw("</span>");
        self.raw("<span lang=\"en\">").text(&text.en).raw("</span>")
    }

    /// Both languages of a text of this program.
    pub fn say(&mut self, zh: &'static str, en: &'static str) -> &mut Self {
        self.raw("<span lang=\"zh\">").raw(zh).raw("</span><span lang=\"en\">").raw(en).raw("</span>")
    }

    /// A number with at most `digits` decimals, without trailing zeros.
    pub fn num(&mut self, value: f64, digits: usize) -> &mut Self {
        self.0.push_str(&number(value, digits));
        self
    }

    /// A count.
    pub fn int(&mut self, value: impl TryInto<u64>) -> &mut Self {
        // Counts are never negative; a number that does not fit is shown as such.
        match value.try_into() {
            Ok(n) => {
                let _ = write!(self.0, "{n}");
            }
            Err(_) => self.0.push('?'),
        }
        self
    }

    /// Another piece.
    pub fn piece(&mut self, other: &Markup) -> &mut Self {
        self.0.push_str(&other.0);
        self
    }

    /// The text.
    pub fn into_string(self) -> String {
        self.0
    }
}
