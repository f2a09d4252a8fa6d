//! Random names, keyed hashes, passwords.

use crate::problem::{Answer, Problem};
use argon2::Argon2;
use argon2::password_hash::{PasswordHasher, PasswordVerifier, phc::PasswordHash};
use hmac::{Hmac, KeyInit, Mac};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;

/// Minimum length of a password, characters.
pub const PASSWORD_LENGTH: usize = 10;

/// Bytes as hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut out, b| {
        let _ = write!(out, "{b:02x}");
        out
    })
}

/// `bytes` random bytes in hexadecimal.
pub fn random(bytes: usize) -> Answer<String> {
    let mut out = vec![0; bytes];
    getrandom::fill(&mut out).map_err(Problem::store)?;
    Ok(hex(&out))
}

/// An id: 80 random bits, which cannot be guessed and do not reveal a count.
pub fn id() -> Answer<String> {
    random(10)
}

/// SHA-256 in hexadecimal.
pub fn hash(text: &str) -> String {
    hash_bytes(text.as_bytes())
}

/// SHA-256 of bytes in hexadecimal.
pub fn hash_bytes(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// HMAC-SHA256 in hexadecimal.
pub fn sign(key: &str, message: &[u8]) -> String {
    // HMAC takes keys of any length.
    Hmac::<Sha256>::new_from_slice(key.as_bytes()).map_or_else(
        |_| String::new(),
        |mut mac| {
            mac.update(message);
            hex(&mac.finalize().into_bytes())
        },
    )
}

/// Compares in a time that does not depend on the position of the difference.
pub fn same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |d, (x, y)| d | (x ^ y)) == 0
}

/// The hash of a new password (argon2id).
pub fn hash_password(password: &str) -> Answer<String> {
    if password.chars().count() < PASSWORD_LENGTH || password.len() > 1024 {
        return Err(Problem::new(
            422,
            "password.length",
            format!("密码至少 {PASSWORD_LENGTH} 个字符"),
            format!("a password needs at least {PASSWORD_LENGTH} characters"),
        ));
    }
    if is_weak(password) {
        return Err(Problem::new(
            422,
            "password.weak",
            "密码过于简单：请避免重复、连续的字符和常见密码",
            "the password is too simple: avoid repeated or consecutive characters and common passwords",
        ));
    }
    let hash: PasswordHash = Argon2::default().hash_password(password.as_bytes()).map_err(Problem::store)?;
    Ok(hash.to_string())
}

/// Words in most guessed passwords, with digits around them.
const COMMON: &[&str] = &[
    "password",
    "passw0rd",
    "p@ssword",
    "p@ssw0rd",
    "passwort",
    "qwerty",
    "qwertyuiop",
    "qwertz",
    "qazwsx",
    "qazwsxedc",
    "1q2w3e4r5t",
    "1qaz2wsx3edc",
    "q1w2e3r4t5",
    "asdfgh",
    "asdfghjkl",
    "zxcvbnm",
    "admin",
    "administrator",
    "root",
    "user",
    "test",
    "testtest",
    "guest",
    "login",
    "welcome",
    "letmein",
    "changeme",
    "secret",
    "default",
    "iloveyou",
    "woaini",
    "dragon",
    "monkey",
    "football",
    "sunshine",
    "princess",
    "master",
    "superman",
    "whyroad",
];

/// True for a password that is easily guessed: few different characters, one repeated part, a sequence of letters or
/// digits, digits only, or a common word with digits around it.
fn is_weak(password: &str) -> bool {
    let lower = password.to_lowercase();
    let letters: Vec<char> = lower.chars().collect();
    let n = letters.len();
    let distinct: std::collections::BTreeSet<char> = letters.iter().copied().collect();
    let repeated = (1..=n / 2).any(|period| (period..n).all(|i| letters[i] == letters[i - period]));
    let step = |w: &[char]| i64::from(u32::from(w[1])) - i64::from(u32::from(w[0]));
    let run = letters.windows(2).filter(|w| step(w).abs() <= 1).count() * 4 >= (n - 1) * 3;
    let word = lower.trim_matches(|c: char| c.is_ascii_digit() || c.is_ascii_punctuation() || c == ' ');
    distinct.len() < 5
        || repeated
        || run
        || word.is_empty()
        || COMMON.contains(&word)
        || COMMON.contains(&lower.as_str())
}

/// True when `password` belongs to `hash`.
pub fn is_password(password: &str, hash: &str) -> bool {
    PasswordHash::new(hash).is_ok_and(|h| Argon2::default().verify_password(password.as_bytes(), &h).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hmac_is_that_of_rfc_4231() {
        // RFC 4231, test case 2.
        assert_eq!(
            sign("Jefe", b"what do ya want for nothing?"),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843"
        );
    }

    #[test]
    fn passwords_are_verified_and_short_ones_refused() {
        let hash = hash_password("correct horse").unwrap();
        assert!(hash.starts_with("$argon2id$"));
        assert!(is_password("correct horse", &hash));
        assert!(!is_password("correct horsf", &hash));
        assert_eq!(hash_password("short").unwrap_err().code, "password.length");
        for weak in [
            "aaaaaaaaaa",
            "abababababab",
            "1234567890",
            "0987654321",
            "8461937205",
            "abcdefghij",
            "password123",
            "Passw0rd!!",
            "admin12345",
            "qwertyuiop",
            "1q2w3e4r5t",
            "hunterhunter",
            "天天天天天天天天天天",
        ] {
            assert_eq!(hash_password(weak).map(drop).unwrap_err().code, "password.weak", "{weak}");
        }
        for fine in ["correct horse", "tr0ub4dor&3x", "x7Kq-29mdp", "一二三四五六七八九十大海"] {
            assert!(!is_weak(fine), "{fine}");
        }
    }
}
