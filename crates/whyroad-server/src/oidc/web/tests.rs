//! TLS against a server of the test, with certificates that it generates.

use super::*;
use rustls::pki_types::{PrivateKeyDer, PrivatePkcs8KeyDer};
use rustls::{ServerConfig, ServerConnection, StreamOwned};
use serde_json::json;
use std::io::{Read, Write};
use std::net::TcpListener;

/// Answers each call with `answer`, over TLS with a certificate for `name`; returns the port, and the certificate as
/// PEM.
fn server(name: &str, answer: &'static str) -> (u16, String) {
    let made = rcgen::generate_simple_self_signed(vec![name.to_owned()]).unwrap();
    let der = made.cert.der().clone();
    let pem = format!("-----BEGIN CERTIFICATE-----\n{}\n-----END CERTIFICATE-----\n", STANDARD.encode(&der));
    let key = PrivateKeyDer::Pkcs8(PrivatePkcs8KeyDer::from(made.signing_key.serialize_der()));
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ServerConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
    let config = Arc::new(config.with_no_client_auth().with_single_cert(vec![der], key).unwrap());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            let connection = ServerConnection::new(Arc::clone(&config)).unwrap();
            let mut stream = StreamOwned::new(connection, stream);
            // A caller who does not trust the certificate disconnects during the handshake.
            let _ = stream.read(&mut [0; 4096]);
            let _ = stream.write_all(answer.as_bytes());
            stream.conn.send_close_notify();
            let _ = stream.flush();
        }
    });
    (port, pem)
}

const FINE: &str = "HTTP/1.1 200 OK\r\ncontent-length: 8\r\nconnection: close\r\n\r\n{\"a\": 1}";

#[test]
fn only_a_certificate_that_is_trusted_and_for_that_name_will_do() {
    let (port, pem) = server("localhost", FINE);
    let url = format!("https://localhost:{port}/x");
    let trusting = Web::new(Some(pem.as_bytes())).unwrap();
    assert_eq!(trusting.get(&url, None).unwrap(), json!({ "a": 1 }));
    assert_eq!(Web::new(None).unwrap().get(&url, None).unwrap_err().code, "oidc.provider");
    let (port, pem) = server("id.example.com", FINE);
    let trusting = Web::new(Some(pem.as_bytes())).unwrap();
    assert!(
        trusting.get(&format!("https://localhost:{port}/x"), None).is_err(),
        "a name that is not its own"
    );
    assert_eq!(
        Web::new(Some(b"-----BEGIN CERTIFICATE-----\n!\n-----END CERTIFICATE-----\n")).err().map(|p| p.code),
        Some("oidc.settings")
    );
}

/// Answers one call over plain HTTP with `answer`.
fn plain(answer: Vec<u8>) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/x", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let _ = stream.read(&mut [0; 4096]);
        let _ = stream.write_all(&answer);
    });
    url
}

#[test]
fn no_redirect_is_followed_and_nothing_endless_read() {
    let web = Web::new(None).unwrap();
    let target = plain(FINE.into());
    let away = format!("HTTP/1.1 302 Found\r\nlocation: {target}\r\ncontent-length: 0\r\n\r\n");
    let told = web.get(&plain(away.into_bytes()), Some("token")).unwrap_err();
    assert!(told.text.en.contains("302"), "{}", told.text.en);
    let mut long = b"HTTP/1.1 200 OK\r\n\r\n\"".to_vec();
    long.extend(vec![b'a'; LARGEST as usize + 1]);
    assert_eq!(web.get(&plain(long), None).unwrap_err().code, "oidc.provider");
    let page = b"HTTP/1.1 200 OK\r\ncontent-length: 6\r\n\r\n<html>".to_vec();
    assert_eq!(web.get(&plain(page), None).unwrap_err().code, "oidc.provider");
    // Sent in chunks, as most servers do.
    let pieces =
        b"HTTP/1.1 200 OK\r\ntransfer-encoding: chunked\r\n\r\n3\r\n{\"a\r\n5\r\n\": 1}\r\n0\r\n\r\n"
            .to_vec();
    assert_eq!(web.get(&plain(pieces), None).unwrap(), json!({ "a": 1 }));
}

#[test]
fn texts_are_written_as_in_a_form() {
    assert_eq!(encoded("a b:+/&é-._~"), "a%20b%3A%2B%2F%26%C3%A9-._~");
}
