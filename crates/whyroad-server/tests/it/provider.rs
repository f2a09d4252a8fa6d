//! An OpenID provider for tests: it strictly follows OpenID Connect Core, PKCE and RFC 9207, and violates them in one
//! point on request.

use crate::signer::{Key, Kind, base64url};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use hmac::{Hmac, KeyInit, Mac};
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};
use std::collections::{BTreeMap, HashMap};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex};

pub const CLIENT: &str = "whyroad client";
/// Characters that must be encoded in a form, and so in the header, too (RFC 6749 2.3.1).
pub const SECRET: &str = "s3cr:et/+ &%";

/// The violation of the provider.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Fault {
    #[default]
    None,
    /// This claim of the token has this value; null removes it.
    Claim(&'static str, Value),
    /// This field of the discovery document has this value.
    Discovery(&'static str, Value),
    /// This field of the token's header has this value.
    Header(&'static str, Value),
    /// Signed with a key that it does not publish, under the id of one that it does.
    WrongKey,
    /// No signature, with the algorithm `none`.
    AlgNone,
    /// Signed with HMAC under its public key.
    Hmac,
    /// The claims were changed after signing.
    Tampered,
    /// The signature is missing.
    Unsigned,
    /// The answer at the redirect names this issuer; null for none.
    Names(Value),
    /// The userinfo endpoint returns another person.
    OtherPerson,
    /// The token endpoint answers with this status.
    Away(u16),
}

#[derive(Default)]
struct State {
    keys: Vec<Key>,
    fault: Fault,
    person: Value,
    /// Claims that only the userinfo endpoint returns.
    aside: Vec<&'static str>,
    codes: HashMap<String, BTreeMap<String, String>>,
    /// Calls by path.
    calls: BTreeMap<String, usize>,
    redirect: String,
    /// Key set that is published instead of the signing keys.
    published: Option<Key>,
}

/// A running provider.
#[derive(Clone)]
pub struct Provider {
    pub address: SocketAddr,
    state: Arc<Mutex<State>>,
    clock: Arc<AtomicI64>,
}

impl Provider {
    /// A provider that signs with `key` and uses the service's clock (ms).
    pub fn start(key: Key, clock: Arc<AtomicI64>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let state = State { keys: vec![key], person: ann(), ..State::default() };
        let provider = Self { address, state: Arc::new(Mutex::new(state)), clock };
        let server = provider.clone();
        std::thread::spawn(move || {
            for stream in listener.incoming().map_while(Result::ok) {
                let server = server.clone();
                std::thread::spawn(move || server.serve(stream));
            }
        });
        provider
    }

    pub fn issuer(&self) -> String {
        format!("http://{}", self.address)
    }
    pub fn goes_wrong(&self, fault: Fault) {
        self.state.lock().unwrap().fault = fault;
    }
    /// From now on the person with `claims` is signed in there.
    pub fn is(&self, claims: Value) {
        self.state.lock().unwrap().person = claims;
    }
    pub fn tells_aside(&self, claims: &[&'static str]) {
        self.state.lock().unwrap().aside = claims.to_vec();
    }
    pub fn redirects_to(&self, address: &str) {
        self.state.lock().unwrap().redirect = address.to_owned();
    }
    /// Replaces all keys.
    pub fn rotates(&self, key: Key) {
        self.state.lock().unwrap().keys = vec![key];
    }
    /// From now on only this key is in the set, whichever signs.
    pub fn publishes_only(&self, key: Key) {
        self.state.lock().unwrap().published = Some(key);
    }
    pub fn publishes_all(&self) {
        self.state.lock().unwrap().published = None;
    }
    pub fn calls(&self, path: &str) -> usize {
        self.state.lock().unwrap().calls.get(path).copied().unwrap_or(0)
    }

    fn serve(&self, mut stream: TcpStream) -> Option<()> {
        let mut reader = BufReader::new(stream.try_clone().ok()?);
        let mut line = String::new();
        reader.read_line(&mut line).ok()?;
        let target = line.split(' ').nth(1)?.to_owned();
        let mut headers = BTreeMap::new();
        loop {
            let mut line = String::new();
            reader.read_line(&mut line).ok()?;
            let Some((name, value)) = line.trim().split_once(':') else { break };
            headers.insert(name.to_ascii_lowercase(), value.trim().to_owned());
        }
        let length = headers.get("content-length").and_then(|l| l.parse().ok()).unwrap_or(0);
        let mut body = vec![0; length];
        reader.read_exact(&mut body).ok()?;
        let (path, query) = target.split_once('?').unwrap_or((&target, ""));
        *self.state.lock().unwrap().calls.entry(path.to_owned()).or_default() += 1;
        let answer = match path {
            "/.well-known/openid-configuration" => (200, self.discovery()),
            "/jwks" => (200, json!({ "keys": self.jwks() })),
            "/authorize" => match self.authorize(&form(query)) {
                Ok(location) => {
                    let head = format!(
                        "HTTP/1.1 303 See Other\r\nlocation: {location}\r\ncontent-length: 0\r\nconnection: close\r\n\r\n"
                    );
                    return stream.write_all(head.as_bytes()).ok();
                }
                Err(why) => (400, json!({ "error": why })),
            },
            "/token" => self.token(headers.get("authorization"), &form(&String::from_utf8_lossy(&body))),
            "/userinfo" => self.userinfo(headers.get("authorization")),
            _ => (404, json!({})),
        };
        let text = answer.1.to_string();
        let head = format!(
            "HTTP/1.1 {} X\r\ncontent-type: application/json\r\ncontent-length: {}\r\nconnection: close\r\n\r\n{text}",
            answer.0,
            text.len()
        );
        stream.write_all(head.as_bytes()).ok()
    }

    fn jwks(&self) -> Vec<Value> {
        // In addition to its own a key that is not for signatures, and one of an unknown type.
        let mut keys = vec![
            json!({ "kty": "RSA", "use": "enc", "kid": "e", "n": "AQAB", "e": "AQAB" }),
            json!({ "kty": "XYZ", "kid": "x" }),
        ];
        let state = self.state.lock().unwrap();
        keys.extend(
            state
                .published
                .iter()
                .chain(state.keys.iter().filter(|_| state.published.is_none()))
                .map(Key::jwk),
        );
        keys
    }

    fn discovery(&self) -> Value {
        let at = self.issuer();
        let mut document = json!({
            "issuer": at, "authorization_endpoint": format!("{at}/authorize"), "token_endpoint": format!("{at}/token"),
            "jwks_uri": format!("{at}/jwks"), "userinfo_endpoint": format!("{at}/userinfo"),
            "end_session_endpoint": format!("{at}/end"), "response_types_supported": ["code"],
            "subject_types_supported": ["public"], "id_token_signing_alg_values_supported": ["RS256", "ES256"],
            "code_challenge_methods_supported": ["S256"], "authorization_response_iss_parameter_supported": true,
        });
        if let Fault::Discovery(field, value) = &self.state.lock().unwrap().fault {
            document[*field] = value.clone();
        }
        document
    }

    /// OpenID Connect Core 3.1.2; the person signed in here consents at once.
    fn authorize(&self, asked: &BTreeMap<String, String>) -> Result<String, &'static str> {
        let mut state = self.state.lock().unwrap();
        let is = |name: &str, wanted: &str| asked.get(name).is_some_and(|v| v == wanted);
        if !is("response_type", "code") || !is("client_id", CLIENT) || !is("redirect_uri", &state.redirect) {
            return Err("invalid_request");
        }
        if !asked.get("scope").is_some_and(|s| s.split(' ').any(|w| w == "openid")) {
            return Err("invalid_scope");
        }
        // 43 characters: a SHA-256 in base64url.
        let challenged = asked.get("code_challenge").is_some_and(|c| c.len() == 43);
        if !challenged || !is("code_challenge_method", "S256") || !asked.contains_key("nonce") {
            return Err("missing_pkce_or_nonce");
        }
        let code = format!("code{}", state.codes.len());
        state.codes.insert(code.clone(), asked.clone());
        let issuer = match &state.fault {
            Fault::Names(name) => name.as_str().map(str::to_owned),
            _ => Some(format!("http://{}", self.address)),
        };
        let issuer = issuer.map(|i| format!("&iss={}", i.replace(':', "%3A").replace('/', "%2F")));
        Ok(format!("{}?code={code}&state={}{}", state.redirect, asked["state"], issuer.unwrap_or_default()))
    }

    /// RFC 6749 4.1.3, RFC 7636 4.6.
    fn token(&self, authorization: Option<&String>, sent: &BTreeMap<String, String>) -> (u16, Value) {
        let mut state = self.state.lock().unwrap();
        if let Fault::Away(status) = state.fault {
            return (status, json!({}));
        }
        if !is_client(&state.fault, authorization, sent) {
            return (401, json!({ "error": "invalid_client" }));
        }
        // A code is valid once.
        let asked = sent
            .get("code")
            .and_then(|code| state.codes.get_mut(code))
            .map(std::mem::take)
            .unwrap_or_default();
        let verifier = sent.get("code_verifier").cloned().unwrap_or_default();
        let fits = (43..=128).contains(&verifier.len())
            && asked.get("code_challenge") == Some(&base64url(Sha256::digest(verifier)))
            && asked.get("redirect_uri") == sent.get("redirect_uri")
            && sent.get("grant_type").is_some_and(|g| g == "authorization_code");
        if !fits {
            return (400, json!({ "error": "invalid_grant" }));
        }
        let token = self.id_token(&state, &asked["nonce"]);
        (
            200,
            json!({ "access_token": "access", "token_type": "Bearer", "expires_in": 60, "id_token": token }),
        )
    }

    fn id_token(&self, state: &State, nonce: &str) -> String {
        let now = self.clock.load(Ordering::SeqCst) / 1000;
        let half = base64url(&Sha256::digest("access")[..16]);
        let mut claims = json!({
            "iss": self.issuer(), "aud": CLIENT, "exp": now + 300, "iat": now, "nonce": nonce, "at_hash": half,
        });
        for (name, value) in state.person.as_object().unwrap() {
            if !state.aside.contains(&name.as_str()) {
                claims[name] = value.clone();
            }
        }
        if let Fault::Claim(name, value) = &state.fault {
            claims[*name] = value.clone();
            if value.is_null() {
                claims.as_object_mut().unwrap().remove(*name);
            }
        }
        let key = &state.keys[0];
        let mut header = json!({ "alg": key.algorithm(), "kid": key.kid, "typ": "JWT" });
        if let Fault::Header(name, value) = &state.fault {
            header[*name] = value.clone();
        }
        let signed = key.token_with(&header, &claims);
        let parts: Vec<&str> = signed.split('.').collect();
        match state.fault {
            Fault::WrongKey => match key.kind {
                Kind::Rsa(_) => Key::rsa(&key.kid, 1),
                Kind::Ec(_) => Key::ec(&key.kid),
            }
            .token(&claims),
            Fault::AlgNone => format!("{}.{}.", base64url(r#"{"alg":"none"}"#), parts[1]),
            Fault::Hmac => {
                let header = json!({ "alg": "HS256", "kid": key.kid, "typ": "JWT" }).to_string();
                let secret = match &key.kind {
                    Kind::Rsa(rsa) => rsa.modulus(),
                    Kind::Ec(_) => key.jwk().to_string().into_bytes(),
                };
                let message = format!("{}.{}", base64url(header), parts[1]);
                let mut mac = Hmac::<Sha256>::new_from_slice(&secret).unwrap();
                mac.update(message.as_bytes());
                format!("{message}.{}", base64url(mac.finalize().into_bytes()))
            }
            Fault::Tampered => {
                claims["sub"] = "somebody else".into();
                format!("{}.{}.{}", parts[0], base64url(claims.to_string()), parts[2])
            }
            Fault::Unsigned => format!("{}.{}.", parts[0], parts[1]),
            _ => signed,
        }
    }

    fn userinfo(&self, authorization: Option<&String>) -> (u16, Value) {
        if authorization.is_none_or(|a| a != "Bearer access") {
            return (401, json!({}));
        }
        let state = self.state.lock().unwrap();
        let mut person = state.person.clone();
        if state.fault == Fault::OtherPerson {
            person["sub"] = "somebody else".into();
        }
        (200, person)
    }
}

/// RFC 6749 2.3.1: in the header, unless the discovery document states another method; never by two methods at once.
fn is_client(fault: &Fault, authorization: Option<&String>, sent: &BTreeMap<String, String>) -> bool {
    let in_header = authorization.and_then(|a| a.strip_prefix("Basic "));
    let in_header = in_header.and_then(|b| String::from_utf8(STANDARD.decode(b).ok()?).ok());
    let in_header =
        in_header.and_then(|g| g.split_once(':').map(|(id, secret)| (decoded(id), decoded(secret))));
    let in_form = (sent.get("client_id").map(String::as_str), sent.get("client_secret").map(String::as_str));
    let methods = match fault {
        Fault::Discovery("token_endpoint_auth_methods_supported", methods) => methods[0].as_str(),
        _ => None,
    };
    match methods {
        Some("client_secret_post") => in_form == (Some(CLIENT), Some(SECRET)) && authorization.is_none(),
        Some("none") => in_form == (Some(CLIENT), None) && authorization.is_none(),
        _ => in_header == Some((CLIENT.to_owned(), SECRET.to_owned())) && in_form == (None, None),
    }
}

/// A person with a verified address.
pub fn ann() -> Value {
    json!({
        "sub": "248289761001", "email": "Ann@Example.com", "email_verified": true, "name": "Ann", "preferred_username": "ann",
    })
}

/// The values of a form or a query.
pub fn form(text: &str) -> BTreeMap<String, String> {
    text.split('&').filter_map(|p| p.split_once('=')).map(|(k, v)| (k.to_owned(), decoded(v))).collect()
}

fn decoded(text: &str) -> String {
    let text = text.replace('+', " ");
    let mut out = Vec::new();
    let mut bytes = text.bytes();
    while let Some(b) = bytes.next() {
        let hex = |b: Option<u8>| (b.unwrap() as char).to_digit(16).unwrap() as u8;
        out.push(if b == b'%' { hex(bytes.next()) * 16 + hex(bytes.next()) } else { b });
    }
    String::from_utf8(out).unwrap()
}
