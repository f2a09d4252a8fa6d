//! Texts as UTF-8. Other encodings are not guessed: the message says what to do.

use std::borrow::Cow;
use std::io;
use std::str::Utf8Error;

/// The remedy, which reasons end in.
const UTF16: &str = "it is UTF-16 text; save it as UTF-8";

/// The bytes as UTF-8; `Err` names the line that is not.
pub(crate) fn utf8(bytes: &[u8]) -> Result<&str, String> {
    not_utf16(bytes)?;
    std::str::from_utf8(bytes).map_err(|e| reason(bytes, e))
}

/// The same as an error of input.
pub(crate) fn utf8_input(bytes: Cow<'_, [u8]>) -> io::Result<Cow<'_, str>> {
    let text = match bytes {
        Cow::Borrowed(bytes) => utf8(bytes).map(Cow::Borrowed),
        Cow::Owned(bytes) => not_utf16(&bytes).and_then(|()| {
            String::from_utf8(bytes).map(Cow::Owned).map_err(|e| reason(e.as_bytes(), e.utf8_error()))
        }),
    };
    text.map_err(|reason| io::Error::new(io::ErrorKind::InvalidData, reason))
}

fn not_utf16(bytes: &[u8]) -> Result<(), String> {
    // Of a character of Latin script one byte is zero; UTF-8 texts have none.
    let begins_as_utf16 = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    let is_utf16 = begins_as_utf16 || bytes.iter().take(64).any(|b| *b == 0);
    if is_utf16 { Err(UTF16.to_owned()) } else { Ok(()) }
}

fn reason(bytes: &[u8], error: Utf8Error) -> String {
    not_utf8(1 + bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count())
}

/// The reason for a line that is not UTF-8.
pub(crate) fn not_utf8(line: usize) -> String {
    format!("line {line} is not UTF-8 text; save the file as UTF-8")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// "car" and the word for it in Chinese, as the encodings' own tables have it.
    #[test]
    fn other_encodings_are_named_with_the_remedy() {
        assert_eq!(utf8("id\n汽车".as_bytes()), Ok("id\n汽车"));
        // GBK: 汽 is C6 FB; Latin-1: é is E9.
        for text in [&b"id\n\xc6\xfb"[..], b"id\n\xe9t\xe9"] {
            assert_eq!(utf8(text).unwrap_err(), "line 2 is not UTF-8 text; save the file as UTF-8");
        }
        let utf16 = |mark: &[u8]| [mark, b"i\0d\0\n\0"].concat();
        for text in [utf16(b"\xff\xfe"), utf16(b"")] {
            assert_eq!(utf8(&text).unwrap_err(), UTF16);
        }
    }
}
