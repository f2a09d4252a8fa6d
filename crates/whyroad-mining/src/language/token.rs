//! Text to tokens. A number includes its unit: `5 km/h` is one token, so that `m/s` is never a division.

use super::Fault;
use super::syntax::{CompareOp, Quantity, Span};
use whyroad_model::units::{UNITS, Unit};

/// A token.
#[derive(Clone, Debug, PartialEq)]
pub enum Token {
    /// Number with unit.
    Number(Quantity),
    /// Signal or other name; may have dots.
    Name(String),
    /// One of [`KEYWORDS`].
    Keyword(&'static str),
    /// Comparison.
    Compare(CompareOp),
    /// One of `( ) { } , + - *`.
    Sign(char),
}

/// Words that are not names.
pub const KEYWORDS: &[&str] =
    &["and", "or", "not", "in", "is", "for", "within", "then", "at", "since", "until"];

/// All tokens of `text`, or the first fault.
pub fn tokens(text: &str) -> Result<Vec<(Token, Span)>, Fault> {
    let mut lexer = Lexer { text, at: 0 };
    let mut out = Vec::new();
    while let Some(t) = lexer.next()? {
        out.push(t);
    }
    Ok(out)
}

struct Lexer<'a> {
    text: &'a str,
    at: usize,
}

impl Lexer<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn skip_space(&mut self) {
        self.at += self.rest().len() - self.rest().trim_start().len();
    }

    /// Length of the longest prefix of the rest whose characters all satisfy `f`.
    fn run(&self, f: impl Fn(char) -> bool) -> usize {
        self.rest().find(|c| !f(c)).unwrap_or(self.rest().len())
    }

    fn next(&mut self) -> Result<Option<(Token, Span)>, Fault> {
        self.skip_space();
        let start = self.at;
        let Some(c) = self.rest().chars().next() else { return Ok(None) };
        let token = if c.is_ascii_digit() {
            self.number()?
        } else if c.is_alphabetic() || c == '_' {
            self.at += self.run(|c| c.is_alphanumeric() || c == '_' || c == '.');
            let word = &self.text[start..self.at];
            match KEYWORDS.iter().find(|k| **k == word) {
                Some(k) => Token::Keyword(k),
                None => Token::Name(word.to_owned()),
            }
        } else {
            self.sign(c)?
        };
        Ok(Some((token, Span { start, end: self.at })))
    }

    fn sign(&mut self, c: char) -> Result<Token, Fault> {
        use CompareOp::{Equal, Greater, GreaterOrEqual, Less, LessOrEqual, NotEqual};
        let table = [
            ("<=", LessOrEqual),
            (">=", GreaterOrEqual),
            ("==", Equal),
            ("!=", NotEqual),
            ("≤", LessOrEqual),
            ("≥", GreaterOrEqual),
            ("≠", NotEqual),
            ("<", Less),
            (">", Greater),
        ];
        if let Some((symbol, op)) = table.into_iter().find(|(s, _)| self.rest().starts_with(s)) {
            self.at += symbol.len();
            return Ok(Token::Compare(op));
        }
        let span = Span { start: self.at, end: self.at + c.len_utf8() };
        self.at = span.end;
        if "(){},+-*".contains(c) {
            return Ok(Token::Sign(c));
        }
        let fault = Fault::new(
            "rule.syntax",
            span,
            format!("规则中不能出现字符 '{c}'"),
            format!("'{c}' has no meaning in a rule"),
        );
        Err(match c {
            '=' => fault.hint("相等写作 ==", "equality is written =="),
            '&' => fault.hint("与写作 and", "write `and`"),
            '|' => fault.hint("或写作 or，绝对值写作 abs(x)", "write `or`; an absolute value is abs(x)"),
            '!' => fault.hint("非写作 not", "write `not`"),
            '/' => fault.hint(
                "规则中没有除法；比较 x < 2 * y，或乘以小数",
                "division is not supported: compare x < 2 * y, or multiply by a fraction",
            ),
            '“' | '”' | '‘' | '’' | '"' | '\'' | '「' | '」' => fault
                .hint("规则中不用引号，名称直接写", "a rule has no quotation marks: write names as they are"),
            '、' | '；' | ';' => fault.hint("并列用逗号 ,", "items are separated by a comma ,"),
            '，' => fault.hint(
                "参数之间用半角逗号 ,；条件之间写作 and",
                "arguments are separated by a half-width comma ,; conditions are joined by `and`",
            ),
            c => match half_width(c) {
                Some(plain) => fault
                    .hint(format!("请用半角字符 {plain}"), format!("write the half-width character {plain}")),
                None => fault,
            },
        })
    }

    fn number(&mut self) -> Result<Token, Fault> {
        let start = self.at;
        self.at += self.run(|c| c.is_ascii_digit() || c == '.');
        let exponent = {
            let rest = self.rest().as_bytes();
            let sign = usize::from(matches!(rest.get(1), Some(b'-' | b'+')));
            matches!(rest.first(), Some(b'e' | b'E')) && rest.get(1 + sign).is_some_and(u8::is_ascii_digit)
        };
        if exponent {
            self.at += 2;
            self.at += self.run(|c| c.is_ascii_digit());
        }
        let text = &self.text[start..self.at];
        let value: f64 = text.parse().map_err(|_| {
            Fault::new(
                "rule.syntax",
                Span { start, end: self.at },
                format!("'{text}' 不是数"),
                format!("'{text}' is not a number"),
            )
        })?;
        if !value.is_finite() {
            let span = Span { start, end: self.at };
            let fault = Fault::new(
                "rule.syntax",
                span,
                format!("数 {text} 太大"),
                format!("the number {text} is too large"),
            );
            return Err(fault.hint("最大约为 1.8e308", "the largest is about 1.8e308"));
        }
        Ok(Token::Number(Quantity { value, unit: self.unit()? }))
    }

    /// The unit after a number; the pure number's when what follows is not a word.
    fn unit(&mut self) -> Result<&'static Unit, Fault> {
        let after_number = self.at;
        self.skip_space();
        let start = self.at;
        if self.rest().starts_with("1/m") {
            self.at += 3;
        } else if self.rest().starts_with('%') {
            self.at += 1;
        } else {
            self.at += self.run(char::is_alphabetic);
            if self.at > start && self.rest().starts_with('/') {
                self.at += 1;
                self.at += self.run(|c| c.is_alphanumeric() || "^²³".contains(c));
            }
        }
        let written = &self.text[start..self.at];
        if written.is_empty() || KEYWORDS.contains(&written) {
            self.at = after_number;
            return Ok(&UNITS[0]);
        }
        let plain = written.replace('^', "").replace('²', "2").replace('³', "3");
        Unit::parse(&plain).ok_or_else(|| unknown_unit(written, Span { start, end: self.at }))
    }
}

/// The ASCII character of a full-width one (Unicode, Halfwidth and Fullwidth Forms: U+FF01 to U+FF5E, in the order of
/// ASCII).
fn half_width(c: char) -> Option<char> {
    let offset = u32::from(c).checked_sub(u32::from('！'))?;
    (c <= '～').then(|| char::from_u32(u32::from('!') + offset)).flatten()
}

/// The fault for a unit that is not in the table.
pub fn unknown_unit(written: &str, span: Span) -> Fault {
    let known: Vec<&str> = UNITS.iter().map(|u| u.symbol).filter(|s| !s.is_empty()).collect();
    let fault = Fault::new(
        "rule.unit.unknown",
        span,
        format!("未知单位 '{written}'"),
        format!("'{written}' is not a known unit"),
    );
    let all = known.join(", ");
    match super::check::nearest(written, known.iter().copied()) {
        Some(near) => fault.hint(
            format!("是否想写 '{near}'？可用单位：{all}"),
            format!("did you mean '{near}'? Known units: {all}"),
        ),
        None => fault.hint(format!("可用单位：{all}"), format!("known units: {all}")),
    }
}
