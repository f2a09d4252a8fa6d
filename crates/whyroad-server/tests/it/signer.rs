//! Keys made by the test, RSA and elliptic, and tokens signed with them. RSA is done here with whole numbers, as RFC
//! 8017 writes it, so that the service's verification is not compared with the library that does it.

#![allow(clippy::unwrap_used)] // in a test a panic is the report

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use num_bigint::BigUint;
use ring::rand::SystemRandom;
use ring::signature::{ECDSA_P256_SHA256_FIXED_SIGNING, EcdsaKeyPair, KeyPair as _};
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};
use std::sync::{Arc, OnceLock};

/// The algorithm identifier in front of a SHA-256 hash (RFC 8017 section 9.2, note 1).
const SHA256_INFO: [u8; 19] = [
    0x30, 0x31, 0x30, 0x0d, 0x06, 0x09, 0x60, 0x86, 0x48, 0x01, 0x65, 0x03, 0x04, 0x02, 0x01, 0x05, 0x00,
    0x04, 0x20,
];

/// Base64url without padding.
pub fn base64url(bytes: impl AsRef<[u8]>) -> String {
    URL_SAFE_NO_PAD.encode(bytes)
}

/// An RSA key of 2048 bits.
pub struct Rsa {
    n: BigUint,
    d: BigUint,
}

impl Rsa {
    /// The first (0) or second (1) key of this run. They share a prime, which saves the making of one.
    pub fn of_this_run(which: usize) -> Arc<Self> {
        static KEYS: OnceLock<[Arc<Rsa>; 2]> = OnceLock::new();
        let keys = KEYS.get_or_init(|| {
            let made: Vec<BigUint> =
                std::thread::scope(|s| [0; 3].map(|_| s.spawn(prime)).map(|t| t.join().unwrap()).into());
            [&made[1], &made[2]].map(|q| Arc::new(Self::from_primes(&made[0], q)))
        });
        Arc::clone(&keys[which])
    }

    fn from_primes(p: &BigUint, q: &BigUint) -> Self {
        let one = BigUint::from(1u8);
        let phi = (p - &one) * (q - &one);
        Self { n: p * q, d: BigUint::from(65537u32).modinv(&phi).unwrap() }
    }

    /// RSASSA-PKCS1-v1_5 with SHA-256.
    fn sign(&self, message: &[u8]) -> Vec<u8> {
        let hash = Sha256::digest(message);
        let mut block = vec![0xff; 256];
        (block[0], block[1]) = (0, 1);
        block[256 - 52] = 0;
        block[256 - 51..256 - 32].copy_from_slice(&SHA256_INFO);
        block[256 - 32..].copy_from_slice(&hash);
        let signature = BigUint::from_bytes_be(&block).modpow(&self.d, &self.n).to_bytes_be();
        [vec![0; 256 - signature.len()], signature].concat()
    }

    /// The modulus in bytes.
    pub fn modulus(&self) -> Vec<u8> {
        self.n.to_bytes_be()
    }
}

/// A prime of 1024 bits whose top two bits are set, by Miller and Rabin's test.
fn prime() -> BigUint {
    let small: Vec<u64> =
        (3..4000).filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0)).collect();
    loop {
        let mut bytes = [0; 128];
        getrandom::fill(&mut bytes).unwrap();
        bytes[0] |= 0xc0;
        bytes[127] |= 1;
        let mut candidate = BigUint::from_bytes_be(&bytes);
        // A walk of odd numbers from there: sieving is cheap, the test is not.
        for _ in 0..200 {
            candidate += 2u8;
            let e = BigUint::from(65537u32);
            if small.iter().all(|s| &candidate % *s != BigUint::ZERO)
                && &candidate % &e != BigUint::from(1u8)
                && [2u32, 3, 5, 7].iter().all(|base| is_witnessed(&candidate, *base))
            {
                return candidate;
            }
        }
    }
}

fn is_witnessed(n: &BigUint, base: u32) -> bool {
    let one = BigUint::from(1u8);
    let less = n - &one;
    let twos = less.trailing_zeros().unwrap();
    let mut x = BigUint::from(base).modpow(&(&less >> twos), n);
    if x == one || x == less {
        return true;
    }
    for _ in 1..twos {
        x = &x * &x % n;
        if x == less {
            return true;
        }
    }
    false
}

/// A key with a name.
#[derive(Clone)]
pub struct Key {
    pub kid: String,
    pub kind: Kind,
}

#[derive(Clone)]
pub enum Kind {
    Rsa(Arc<Rsa>),
    Ec(Arc<EcdsaKeyPair>),
}

impl Key {
    pub fn rsa(kid: &str, which: usize) -> Self {
        Self { kid: kid.to_owned(), kind: Kind::Rsa(Rsa::of_this_run(which)) }
    }

    pub fn ec(kid: &str) -> Self {
        let how = &ECDSA_P256_SHA256_FIXED_SIGNING;
        let random = SystemRandom::new();
        let made = EcdsaKeyPair::generate_pkcs8(how, &random).unwrap();
        let pair = EcdsaKeyPair::from_pkcs8(how, made.as_ref(), &random).unwrap();
        Self { kid: kid.to_owned(), kind: Kind::Ec(Arc::new(pair)) }
    }

    pub fn algorithm(&self) -> &'static str {
        match self.kind {
            Kind::Rsa(_) => "RS256",
            Kind::Ec(_) => "ES256",
        }
    }

    /// As it stands in a key set.
    pub fn jwk(&self) -> Value {
        match &self.kind {
            Kind::Rsa(key) => json!({
                "kty": "RSA", "kid": self.kid, "use": "sig", "alg": "RS256",
                "n": base64url(key.n.to_bytes_be()), "e": "AQAB",
            }),
            Kind::Ec(pair) => {
                let point = pair.public_key().as_ref();
                json!({
                    "kty": "EC", "kid": self.kid, "use": "sig", "crv": "P-256",
                    "x": base64url(&point[1..33]), "y": base64url(&point[33..]),
                })
            }
        }
    }

    /// A signed token of these claims.
    pub fn token(&self, claims: &Value) -> String {
        self.token_with(&json!({ "alg": self.algorithm(), "kid": self.kid, "typ": "JWT" }), claims)
    }

    /// The same with a given header.
    pub fn token_with(&self, header: &Value, claims: &Value) -> String {
        let signed = format!("{}.{}", base64url(header.to_string()), base64url(claims.to_string()));
        let signature = match &self.kind {
            Kind::Rsa(key) => key.sign(signed.as_bytes()),
            Kind::Ec(pair) => pair.sign(&SystemRandom::new(), signed.as_bytes()).unwrap().as_ref().to_vec(),
        };
        format!("{signed}.{}", base64url(signature))
    }
}
