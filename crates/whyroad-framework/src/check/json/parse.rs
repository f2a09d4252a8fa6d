//! A strict RFC 8259 parser into [`Node`]s. It accepts exactly what serde_json accepts (checked by a property test),
//! and also keeps positions, duplicate keys, and a description of the error.

use super::error::SyntaxError;
use super::node::{Entry, JsonKind, Node};
use std::borrow::Cow;

/// serde_json's limit.
const DEPTH: usize = 128;

/// Parses one value, white space around it allowed, nothing else.
pub fn parse(text: &str) -> Result<Node<'_>, SyntaxError> {
    let mut p = Parser { text, at: 0, depth: 0 };
    let node = p.value()?;
    p.space();
    if p.at < text.len() {
        let e = SyntaxError::expected(text, p.at, "文档结束", "the end of the document");
        return Err(match text.as_bytes()[p.at] {
            b'{' | b'[' => {
                e.hint("一行（一个文档）只能有一个 JSON 值", "one line (one document) holds one JSON value")
            }
            _ => e,
        });
    }
    Ok(node)
}

struct Parser<'t> {
    text: &'t str,
    at: usize,
    depth: usize,
}

impl<'t> Parser<'t> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn space(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    fn value(&mut self) -> Result<Node<'t>, SyntaxError> {
        self.space();
        let start = self.at;
        let kind = match self.peek() {
            Some(b'{') => self.nested(Self::map)?,
            Some(b'[') => self.nested(Self::list)?,
            Some(b'"') => JsonKind::Text(self.string()?),
            Some(b'-' | b'0'..=b'9') => JsonKind::Number(self.number()?),
            _ => self.word()?,
        };
        Ok(Node { kind, span: start..self.at })
    }

    fn word(&mut self) -> Result<JsonKind<'t>, SyntaxError> {
        let rest = &self.text[self.at..];
        for (word, kind) in
            [("null", JsonKind::Null), ("true", JsonKind::Flag(true)), ("false", JsonKind::Flag(false))]
        {
            let goes_on = |c: char| c.is_alphanumeric() || c == '_';
            if rest.strip_prefix(word).is_some_and(|r| !r.starts_with(goes_on)) {
                self.at += word.len();
                return Ok(kind);
            }
        }
        Err(SyntaxError::word(self.text, self.at))
    }

    fn nested(
        &mut self,
        read: fn(&mut Self) -> Result<JsonKind<'t>, SyntaxError>,
    ) -> Result<JsonKind<'t>, SyntaxError> {
        self.depth += 1;
        if self.depth >= DEPTH {
            let span = self.at..self.at + 1;
            return Err(SyntaxError::new(span, "嵌套超过 127 层", "nested more than 127 levels deep"));
        }
        let kind = read(self)?;
        self.depth -= 1;
        Ok(kind)
    }

    fn list(&mut self) -> Result<JsonKind<'t>, SyntaxError> {
        self.at += 1;
        let mut items = Vec::new();
        self.space();
        if self.peek() == Some(b']') {
            self.at += 1;
            return Ok(JsonKind::List(items));
        }
        loop {
            items.push(self.value()?);
            self.space();
            match self.peek() {
                Some(b',') => self.comma(b']')?,
                Some(b']') => {
                    self.at += 1;
                    return Ok(JsonKind::List(items));
                }
                _ => return Err(SyntaxError::expected(self.text, self.at, " ',' 或 ']'", "',' or ']'")),
            }
        }
    }

    fn map(&mut self) -> Result<JsonKind<'t>, SyntaxError> {
        self.at += 1;
        let mut entries = Vec::new();
        self.space();
        if self.peek() == Some(b'}') {
            self.at += 1;
            return Ok(JsonKind::Map(entries));
        }
        loop {
            self.space();
            let start = self.at;
            if self.peek() != Some(b'"') {
                return Err(SyntaxError::expected(
                    self.text,
                    self.at,
                    "带双引号的键",
                    "a key in double quotes",
                ));
            }
            let key = self.string()?;
            let key_span = start..self.at;
            self.space();
            if self.peek() != Some(b':') {
                return Err(SyntaxError::expected(self.text, self.at, " ':'", "':'"));
            }
            self.at += 1;
            let node = self.value()?;
            entries.push(Entry { key, key_span, node });
            self.space();
            match self.peek() {
                Some(b',') => self.comma(b'}')?,
                Some(b'}') => {
                    self.at += 1;
                    return Ok(JsonKind::Map(entries));
                }
                _ => return Err(SyntaxError::expected(self.text, self.at, " ',' 或 '}'", "',' or '}'")),
            }
        }
    }

    /// Steps over a comma; a closing bracket right after it is the commonest mistake of all.
    fn comma(&mut self, close: u8) -> Result<(), SyntaxError> {
        let comma = self.at;
        self.at += 1;
        self.space();
        if self.peek() == Some(close) {
            let close = char::from(close);
            return Err(SyntaxError::new(
                comma..comma + 1,
                format!("'{close}' 前多了一个逗号"),
                format!("there is an extra comma before '{close}'"),
            )
            .hint("删除这个逗号", "delete this comma"));
        }
        Ok(())
    }

    fn number(&mut self) -> Result<&'t str, SyntaxError> {
        let start = self.at;
        let bytes = self.text.as_bytes();
        let digits = |mut at: usize| {
            while bytes.get(at).is_some_and(u8::is_ascii_digit) {
                at += 1;
            }
            at
        };
        let mut at = start + usize::from(bytes[start] == b'-');
        let whole = digits(at);
        let mut good = whole > at && (whole == at + 1 || bytes[at] != b'0');
        at = whole;
        if bytes.get(at) == Some(&b'.') {
            let end = digits(at + 1);
            good &= end > at + 1;
            at = end;
        }
        if matches!(bytes.get(at), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(at + 1), Some(b'+' | b'-')));
            let end = digits(at + 1 + sign);
            good &= end > at + 1 + sign;
            at = end;
        }
        let raw = &self.text[start..at];
        if !good || self.text[at..].starts_with(|c: char| c.is_alphanumeric() || c == '.' || c == '_') {
            return Err(SyntaxError::word(self.text, start));
        }
        if !raw.parse::<f64>().is_ok_and(f64::is_finite) {
            return Err(SyntaxError::new(
                start..at,
                format!("数字 {raw} 超出范围"),
                format!("the number {raw} is out of range"),
            ));
        }
        self.at = at;
        Ok(raw)
    }

    fn string(&mut self) -> Result<Cow<'t, str>, SyntaxError> {
        let open = self.at;
        self.at += 1;
        let start = self.at;
        let bytes = self.text.as_bytes();
        let mut owned: Option<String> = None;
        let mut from = start;
        loop {
            match bytes.get(self.at) {
                Some(b'"') => {
                    let tail = &self.text[from..self.at];
                    self.at += 1;
                    return Ok(match owned {
                        Some(mut s) => {
                            s.push_str(tail);
                            Cow::Owned(s)
                        }
                        None => Cow::Borrowed(tail),
                    });
                }
                Some(b'\\') => {
                    let s = owned.get_or_insert_with(String::new);
                    s.push_str(&self.text[from..self.at]);
                    let c = self.escape()?;
                    s.push(c);
                    from = self.at;
                }
                Some(c) if *c < 0x20 => {
                    let span = self.at..self.at + 1;
                    return Err(match *c {
                        b'\n' | b'\r' => SyntaxError::new(
                            open..self.at,
                            "文本没有在本行结束，缺少结尾的双引号",
                            "the text does not end on its line: the closing double quote is missing",
                        )
                        .hint("文本中的换行写作 \\n", "write \\n for a line break inside a text"),
                        _ => SyntaxError::new(
                            span,
                            "文本中有未转义的控制字符",
                            "there is a control character in the text that is not escaped",
                        )
                        .hint("制表符写作 \\t", "write \\t for a tab"),
                    });
                }
                Some(_) => self.at += 1,
                None => {
                    return Err(SyntaxError::new(
                        open..self.text.trim_end().len().max(open + 1),
                        "JSON 在文本中间中断，缺少结尾的双引号",
                        "the JSON ends inside a text: the closing double quote is missing",
                    ));
                }
            }
        }
    }

    /// One escape; `at` is on the backslash before and behind the escape after.
    fn escape(&mut self) -> Result<char, SyntaxError> {
        let start = self.at;
        let c = match self.text.as_bytes().get(start + 1) {
            Some(b'"') => '"',
            Some(b'\\') => '\\',
            Some(b'/') => '/',
            Some(b'b') => '\u{8}',
            Some(b'f') => '\u{c}',
            Some(b'n') => '\n',
            Some(b'r') => '\r',
            Some(b't') => '\t',
            Some(b'u') => return self.unicode(start),
            _ => {
                let end = (start + 2..=self.text.len())
                    .find(|&i| self.text.is_char_boundary(i))
                    .unwrap_or(start + 1);
                return Err(SyntaxError::new(
                    start..end,
                    format!("'{}' 不是 JSON 转义", &self.text[start..end]),
                    format!("'{}' is not a JSON escape", &self.text[start..end]),
                )
                .hint("反斜杠本身写作 \\\\", "write \\\\ for a backslash"));
            }
        };
        self.at = start + 2;
        Ok(c)
    }

    fn unicode(&mut self, start: usize) -> Result<char, SyntaxError> {
        let unit = |at: usize| {
            let hex = self.text.get(at..at + 6)?.strip_prefix("\\u")?;
            hex.bytes().all(|b| b.is_ascii_hexdigit()).then(|| u32::from_str_radix(hex, 16).ok())?
        };
        let bad = || {
            SyntaxError::new(
                start..start + 2,
                "'\\u' 后应为四位十六进制数，且代理对要成对",
                "'\\u' needs four hexadecimal digits, and surrogates come in pairs",
            )
        };
        let first = unit(start).ok_or_else(bad)?;
        let (code, used) = match first {
            0xD800..=0xDBFF => match unit(start + 6) {
                Some(second @ 0xDC00..=0xDFFF) => {
                    (0x10000 + ((first - 0xD800) << 10) + (second - 0xDC00), 12)
                }
                _ => return Err(bad()),
            },
            code => (code, 6),
        };
        self.at = start + used;
        char::from_u32(code).ok_or_else(bad)
    }
}

#[cfg(test)]
mod tests;
