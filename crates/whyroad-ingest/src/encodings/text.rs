//! Texts as UTF-8. Other encodings are not guessed: the message says what to do.

use std::io;

/// The remedy, which reasons end in.
const UTF16: &str = "it is UTF-16 text; save it as UTF-8";

/// The bytes as UTF-8; `Err` names the line that is not.
pub(crate) fn utf8(bytes: &[u8]) -> Result<&str, String> {
    // Of a character of Latin script one byte is zero; UTF-8 texts have none.
    let begins_as_utf16 = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    if begins_as_utf16 || bytes.iter().take(64).any(|b| *b == 0) {
        return Err(UTF16.to_owned());
    }
    std::str::from_utf8(bytes).map_err(|e| not_utf8(1 + lines(&bytes[..e.valid_up_to()])))
}

/// The reason for a line that is not UTF-8.
pub(crate) fn not_utf8(line: usize) -> String {
    format!("line {line} is not UTF-8 text; save the file as UTF-8")
}

/// The same as an error of input.
pub(crate) fn utf8_or_error(bytes: &[u8]) -> io::Result<&str> {
    utf8(bytes).map_err(|reason| io::Error::new(io::ErrorKind::InvalidData, reason))
}

fn lines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|b| **b == b'\n').count()
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
