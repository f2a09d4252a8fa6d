//! Public keys of a provider (JWK sets, RFC 7517). Keys of unknown types, or not for signatures, are ignored: a
//! provider may publish them for other purposes.

use super::algorithm::{Algorithm, KeyShape};
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde_json::Value;

/// Maximum number of keys read from one set.
const MOST: usize = 100;

/// A public key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Jwk {
    /// Its id.
    pub kid: Option<String>,
    /// The only algorithm that it is for.
    pub algorithm: Option<Algorithm>,
    shape: KeyShape,
    /// The modulus of RSA, or the point: `04`, x, y; for Ed25519 x alone.
    pub(super) public: Vec<u8>,
    /// The exponent of RSA.
    pub(super) exponent: Vec<u8>,
}

impl Jwk {
    /// The kind of the key.
    pub fn shape(&self) -> KeyShape {
        self.shape
    }
}

/// The keys for signatures in a set.
pub fn read(set: &Value) -> Vec<Jwk> {
    set["keys"].as_array().into_iter().flatten().take(MOST).filter_map(key).collect()
}

fn key(jwk: &Value) -> Option<Jwk> {
    let text = |name: &str| jwk.get(name).and_then(Value::as_str);
    let number = |name: &str, length: Option<usize>| {
        let bytes = URL_SAFE_NO_PAD.decode(text(name)?).ok()?;
        // A coordinate has its full length (RFC 7518 6.2.1.2).
        length.is_none_or(|l| l == bytes.len()).then_some(bytes)
    };
    let point = |length: usize| {
        let (x, y) = (number("x", Some(length))?, number("y", Some(length))?);
        Some([vec![4], x, y].concat())
    };
    if text("use").is_some_and(|u| u != "sig") {
        return None;
    }
    if let Some(operations) = jwk.get("key_ops").and_then(Value::as_array)
        && !operations.iter().any(|o| o == "verify")
    {
        return None;
    }
    // A key for an unknown algorithm is not used for a known one.
    let algorithm = match text("alg") {
        Some(name) => Some(Algorithm::named(name)?),
        None => None,
    };
    let (shape, public, exponent) = match (text("kty")?, text("crv")) {
        ("RSA", _) => {
            let without_zeros = |b: Vec<u8>| b.into_iter().skip_while(|b| *b == 0).collect::<Vec<_>>();
            (KeyShape::Rsa, without_zeros(number("n", None)?), without_zeros(number("e", None)?))
        }
        ("EC", Some("P-256")) => (KeyShape::P256, point(32)?, vec![]),
        ("EC", Some("P-384")) => (KeyShape::P384, point(48)?, vec![]),
        ("OKP", Some("Ed25519")) => (KeyShape::Ed25519, number("x", Some(32))?, vec![]),
        _ => return None,
    };
    Some(Jwk { kid: text("kid").map(str::to_owned), algorithm, shape, public, exponent })
}
