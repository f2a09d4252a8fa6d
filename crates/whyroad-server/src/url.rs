//! Texts as parts of a URL.

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};

/// All characters except the unreserved ones of RFC 3986.
const RESERVED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~');

/// `text` as a segment of a path, or as a name or value of a query or a form.
pub fn encoded(text: &str) -> String {
    utf8_percent_encode(text, RESERVED).to_string()
}

#[cfg(test)]
mod tests {
    #[test]
    fn only_unreserved_characters_stay() {
        // RFC 3986 2.3, and 2.1 for the upper-case digits.
        assert_eq!(super::encoded("aZ09-._~"), "aZ09-._~");
        assert_eq!(super::encoded("a b/ü+&=%"), "a%20b%2F%C3%BC%2B%26%3D%25");
    }
}
