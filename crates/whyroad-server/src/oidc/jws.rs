//! Signed tokens (JWS in its compact form, RFC 7515): parsed, and verified with a key of the provider.
//!
//! Only public-key algorithms are supported. So `none` cannot be accepted by mistake, and a public key can never be
//! used as the secret of an HMAC.

use super::Reason;
use super::algorithm::Algorithm;
use super::keys::Jwk;
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use ring::signature;
use serde::Deserialize;
use serde_json::Value;

#[derive(Deserialize)]
struct Header {
    alg: String,
    #[serde(default)]
    kid: Option<String>,
    #[serde(default)]
    typ: Option<String>,
    #[serde(default)]
    crit: Option<Value>,
}

/// A parsed token; its content is untrusted before [`Token::verify`].
pub struct Token<'t> {
    /// Algorithm that its header names.
    pub algorithm: Algorithm,
    /// Key that its header names.
    kid: Option<String>,
    signed: &'t str,
    signature: Vec<u8>,
    payload: Vec<u8>,
}

impl<'t> Token<'t> {
    /// Parses a token.
    pub fn read(text: &'t str) -> Result<Self, Reason> {
        let (signed, signature) = text.rsplit_once('.').ok_or("form")?;
        let (header, payload) = signed.split_once('.').ok_or("form")?;
        let decoded = |part: &str| URL_SAFE_NO_PAD.decode(part).map_err(|_| "form");
        let header: Header = serde_json::from_slice(&decoded(header)?).map_err(|_| "form")?;
        let algorithm = Algorithm::named(&header.alg).ok_or("alg")?;
        // Critical header extensions are not supported. A token of another type is not an ID token.
        let is_jwt = header.typ.is_none_or(|t| t.eq_ignore_ascii_case("jwt"));
        if header.crit.is_some() || !is_jwt {
            return Err("header");
        }
        Ok(Self {
            algorithm,
            kid: header.kid,
            signed,
            signature: decoded(signature)?,
            payload: decoded(payload)?,
        })
    }

    /// The claims, if one of these keys made the signature. The error `key` if none of them could have.
    pub fn verify(&self, keys: &[Jwk]) -> Result<Value, Reason> {
        let fits = |k: &&Jwk| {
            k.shape() == self.algorithm.shape()
                && k.algorithm.is_none_or(|a| a == self.algorithm)
                && (self.kid.is_none() || k.kid == self.kid)
        };
        let fitting: Vec<&Jwk> = keys.iter().filter(fits).collect();
        if fitting.is_empty() {
            return Err("key");
        }
        if !fitting.iter().any(|k| self.is_signed_by(k)) {
            return Err("signature");
        }
        serde_json::from_slice(&self.payload).map_err(|_| "form")
    }

    fn is_signed_by(&self, key: &Jwk) -> bool {
        let message = self.signed.as_bytes();
        let by_point = |how: &'static dyn signature::VerificationAlgorithm| {
            signature::UnparsedPublicKey::new(how, &key.public).verify(message, &self.signature)
        };
        let by_rsa = |how: &'static signature::RsaParameters| {
            let parts = signature::RsaPublicKeyComponents { n: &key.public, e: &key.exponent };
            parts.verify(how, message, &self.signature)
        };
        match self.algorithm {
            Algorithm::Rs256 => by_rsa(&signature::RSA_PKCS1_2048_8192_SHA256),
            Algorithm::Rs384 => by_rsa(&signature::RSA_PKCS1_2048_8192_SHA384),
            Algorithm::Rs512 => by_rsa(&signature::RSA_PKCS1_2048_8192_SHA512),
            Algorithm::Ps256 => by_rsa(&signature::RSA_PSS_2048_8192_SHA256),
            Algorithm::Ps384 => by_rsa(&signature::RSA_PSS_2048_8192_SHA384),
            Algorithm::Ps512 => by_rsa(&signature::RSA_PSS_2048_8192_SHA512),
            Algorithm::Es256 => by_point(&signature::ECDSA_P256_SHA256_FIXED),
            Algorithm::Es384 => by_point(&signature::ECDSA_P384_SHA384_FIXED),
            Algorithm::EdDsa => by_point(&signature::ED25519),
        }
        .is_ok()
    }
}

#[cfg(test)]
mod tests;
