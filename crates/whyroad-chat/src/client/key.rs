//! The key of an endpoint: read from the environment, sent, and shown nowhere.

use crate::ChatError;
use std::fmt;
use whyroad_model::Bilingual;

/// A secret text. Neither `Debug` nor an error shows it.
#[derive(Clone, PartialEq, Eq)]
pub struct Key(String);

impl Key {
    /// `secret` without blanks around it; `None` where nothing is left, or where it could not be in a header.
    pub fn new(secret: &str) -> Option<Self> {
        let secret = secret.trim();
        (!secret.is_empty() && secret.chars().all(|c| c.is_ascii_graphic())).then(|| Self(secret.to_owned()))
    }

    /// The value of an environment variable.
    pub fn from_environment(variable: &str) -> Result<Self, ChatError> {
        let value = std::env::var(variable).unwrap_or_default();
        Self::new(&value).ok_or_else(|| {
            ChatError::Settings(Bilingual::new(
                format!("环境变量 {variable} 未设置，或不是可用的密钥"),
                format!("the environment variable {variable} is unset or holds no usable key"),
            ))
        })
    }

    /// The `authorization` header.
    pub(super) fn header(&self) -> String {
        format!("Bearer {}", self.0)
    }

    /// `text` with the key replaced: endpoints repeat what they were sent.
    pub(super) fn hidden(&self, text: &str) -> String {
        text.replace(&self.0, "***")
    }

    /// True when `text` has the key in it.
    pub(super) fn is_in(&self, text: &str) -> bool {
        text.contains(&self.0)
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(***)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_never_shown() {
        let key = Key::new(" sk-12345 \n").unwrap();
        assert_eq!(format!("{key:?}"), "Key(***)");
        assert_eq!(key.hidden("bad key sk-12345!"), "bad key ***!");
        assert_eq!(key.header(), "Bearer sk-12345");
        for bad in ["", "  ", "a b", "a\nb", "密"] {
            assert_eq!(Key::new(bad), None, "{bad:?}");
        }
        let unset = Key::from_environment("WHYROAD_TEST_NO_SUCH_KEY").unwrap_err();
        assert!(unset.to_string().contains("WHYROAD_TEST_NO_SUCH_KEY"));
    }
}
