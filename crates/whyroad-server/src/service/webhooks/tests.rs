//! A receiver of the test on the loopback interface; the signature is checked as a receiver would, with RFC 2104's
//! HMAC.

use super::*;
use crate::domain::workflow::State;
use crate::service::fixtures::{self, task};
use crate::service::people;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer};
use rustls::{ServerConfig, ServerConnection, StreamOwned};
use std::io::{Read, Write};
use std::net::TcpListener;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::mpsc::{Receiver as Inbox, channel};

struct Scene {
    app: App,
    clock: Arc<AtomicI64>,
    _dir: tempfile::TempDir,
}

fn scene() -> Scene {
    let (mut app, dir) = fixtures::app();
    let clock = Arc::new(AtomicI64::new(1_000_000));
    let hand = Arc::clone(&clock);
    app.clock = Arc::new(move || hand.load(Ordering::SeqCst));
    Scene { app, clock, _dir: dir }
}

/// Answers each request with the next status and passes on the received text.
fn receiver(statuses: &'static [u16]) -> (String, Inbox<String>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/hook", listener.local_addr().unwrap());
    let (tell, told) = channel();
    std::thread::spawn(move || {
        for status in statuses {
            let (mut stream, _) = listener.accept().unwrap();
            let (mut text, mut part) = (String::new(), [0; 4096]);
            // Bodies here are JSON objects: the last brace ends the request.
            while !text.ends_with('}') {
                let n = stream.read(&mut part).unwrap();
                text.push_str(std::str::from_utf8(&part[..n]).unwrap());
            }
            write!(stream, "HTTP/1.1 {status} x\r\ncontent-length: 0\r\n\r\n").unwrap();
            tell.send(text).unwrap();
        }
    });
    (url, told)
}

fn tell(app: &App, action: &'static str) {
    let now = app.now();
    let job = move |tx: &mut dyn Tx| {
        announce(tx, &task(), &Entry { action, from: Some(State::Stage2), ..Entry::default() }, now)
    };
    app.store.write(job).unwrap();
}

fn hook(app: &App, url: &str, events: &[&str]) -> Webhook {
    add(app, url, events, &Reach::OwnMachine).unwrap()
}

/// A webhook of Lea, whose account is created with her first one.
fn add(app: &App, url: &str, events: &[&str], reach: &Reach) -> Answer<Webhook> {
    let (url, events) = (url.to_owned(), events.iter().map(|e| (*e).to_owned()).collect::<Vec<_>>());
    let (vault, reach) = (Arc::clone(&app.store.vault), reach.clone());
    app.store.write(move |tx| {
        let lea = lea();
        if people::find(tx, &lea.id)?.is_none() {
            people::create(tx, &lea, people::NO_PASSWORD, 0)?;
            let (name, display) = ("root".to_owned(), "Root".to_owned());
            let root = User { id: "r".into(), name, display, admin: true, ..lea.clone() };
            people::create(tx, &root, people::NO_PASSWORD, 0)?;
        }
        create(tx, Wanted { project: "p", owner: &lea, url: &url, events: &events }, &reach, &vault, 0)
    })
}

fn lea() -> User {
    User {
        id: "l".into(),
        name: "lea".into(),
        display: "Lea".into(),
        admin: false,
        lang: "zh".into(),
        disabled: false,
        email: None,
    }
}

fn disable(app: &App, disabled: bool) {
    app.store.write(move |tx| people::update(tx, &User { disabled, ..lea() })).unwrap();
}

fn pending(app: &App) -> (i64, Option<String>) {
    let hooks = app.store.read(|tx| list(tx, "p")).unwrap();
    (hooks[0].pending, hooks[0].last_error.clone().map(|e| e.en))
}

#[test]
fn a_message_is_signed_and_says_what_happened_but_no_label() {
    let s = scene();
    let (url, told) = receiver(&[204]);
    let made = hook(&s.app, &url, &[]);
    tell(&s.app, "submit");
    tell(&s.app, "edit");
    assert_eq!(deliver_due(&s.app).unwrap(), 1);
    let request = told.recv().unwrap();
    let (head, body) = request.split_once("\r\n\r\n").unwrap();
    assert!(head.starts_with("POST /hook HTTP/1.1\r\n"));
    let signature = head.lines().find_map(|l| l.strip_prefix("x-whyroad-signature: ")).unwrap();
    let (at, mac) = signature.strip_prefix("t=").unwrap().split_once(",v1=").unwrap();
    let expected = secret::sign(&made.secret.unwrap(), format!("{at}.{body}").as_bytes());
    assert_eq!((at, mac), ("1000000", expected.as_str()));
    let message: serde_json::Value = serde_json::from_str(body).unwrap();
    assert_eq!(message["event"], "submit");
    assert_eq!((&message["from_state"], &message["to_state"]), (&json!("stage2"), &json!("submitted")));
    assert!(!body.contains("nobody else"));
    assert_eq!(pending(&s.app), (0, None));
}

#[test]
fn what_was_not_taken_is_sent_again_later_and_later() {
    let s = scene();
    let (url, told) = receiver(&[500, 302, 200]);
    hook(&s.app, &url, &["submit"]);
    tell(&s.app, "accept");
    tell(&s.app, "submit");
    let delivered = || s.app.store.read(|tx| list(tx, "p")).unwrap()[0].last_delivery;
    let turn = |ms: i64| s.clock.fetch_add(ms, Ordering::SeqCst);
    assert_eq!(deliver_due(&s.app).unwrap(), 0);
    assert_eq!(pending(&s.app), (1, Some("the receiver answered with status 500".into())));
    let told_of = s.app.store.read(|tx| list(tx, "p")).unwrap().remove(0);
    assert_eq!(delivered(), None, "nothing was delivered yet");
    assert_eq!((told_of.failures, told_of.next_try), (1, Some(s.app.now() + 5_000)));
    turn(4_999);
    assert_eq!((deliver_due(&s.app).unwrap(), told.try_iter().count()), (0, 1));
    turn(1);
    assert_eq!(deliver_due(&s.app).unwrap(), 0);
    turn(9_999);
    assert_eq!((deliver_due(&s.app).unwrap(), told.try_iter().count()), (0, 1));
    turn(1);
    assert_eq!(deliver_due(&s.app).unwrap(), 1);
    assert_eq!(pending(&s.app), (0, None));
    assert_eq!(delivered(), Some(s.app.now()));
}

#[test]
fn webhooks_of_a_disabled_person_are_paused() {
    let s = scene();
    let (url, told) = receiver(&[204, 204]);
    let made = hook(&s.app, &url, &[]);
    assert_eq!((made.owner.as_deref(), made.paused), (Some("Lea"), false));
    tell(&s.app, "submit");
    disable(&s.app, true);
    assert_eq!(deliver_due(&s.app).unwrap(), 0);
    // What happens meanwhile is not kept: nobody may ever come back.
    tell(&s.app, "accept");
    assert_eq!((pending(&s.app), told.try_iter().count()), ((1, None), 0));
    let listed = s.app.store.read(paused).unwrap();
    assert_eq!(
        listed.iter().map(|w| (w.id.as_str(), w.paused)).collect::<Vec<_>>(),
        [(made.id.as_str(), true)]
    );
    assert_eq!(s.app.store.read(waiting).unwrap(), (0, None), "nobody is alarmed");
    // A sender that has read the message before does not send it either.
    let row = s.app.store.read(|tx| tx.row("SELECT id, due FROM outbox", &[])).unwrap().unwrap();
    assert!(!claim(&s.app, &row.text("id").unwrap(), row.int("due").unwrap()).unwrap());
    disable(&s.app, false);
    s.clock.fetch_add(1, Ordering::SeqCst);
    tell(&s.app, "reopen");
    assert_eq!(deliver_due(&s.app).unwrap(), 2);
    let events: Vec<String> = told.try_iter().collect();
    assert!(
        events[0].contains(r#""event":"submit""#) && events[1].contains(r#""event":"reopen""#),
        "{events:?}"
    );
    assert!(s.app.store.read(paused).unwrap().is_empty());
    // One from before owners were recorded goes on.
    let forget = |tx: &mut dyn Tx| tx.run("UPDATE webhooks SET owner = NULL", &[]);
    s.app.store.write(forget).unwrap();
    disable(&s.app, true);
    tell(&s.app, "submit");
    assert_eq!((pending(&s.app).0, s.app.store.read(waiting).unwrap().0), (1, 1));
}

#[test]
fn waits_double_up_to_an_hour() {
    assert_eq!([1, 2, 3, 40].map(wait_ms), [5_000, 10_000, 20_000, 3_600_000]);
}

#[test]
fn a_receiver_that_is_away_keeps_its_messages_and_a_removed_one_loses_them() {
    let s = scene();
    let made = hook(&s.app, "http://127.0.0.1:1/", &[]);
    for _ in 0..3 {
        tell(&s.app, "submit");
    }
    assert_eq!(deliver_due(&s.app).unwrap(), 0);
    let (left, error) = pending(&s.app);
    assert_eq!(left, 3);
    assert!(error.unwrap().starts_with("no connection"));
    s.app.store.write(move |tx| remove(tx, &made.id)).unwrap();
    let rest = s.app.store.read(|tx| tx.row("SELECT count(*) AS n FROM outbox", &[])).unwrap();
    assert_eq!(rest.unwrap().int("n").unwrap(), 0);
}

#[test]
fn two_senders_do_not_send_one_message_twice() {
    let s = scene();
    hook(&s.app, "http://127.0.0.1:1/", &[]);
    tell(&s.app, "submit");
    let row = s.app.store.read(|tx| tx.row("SELECT id, due FROM outbox", &[])).unwrap().unwrap();
    let (id, due) = (row.text("id").unwrap(), row.int("due").unwrap());
    assert!(claim(&s.app, &id, due).unwrap());
    assert!(!claim(&s.app, &id, due).unwrap());
}

#[test]
fn a_service_that_others_reach_calls_nothing_on_its_own_machine() {
    let mut s = scene();
    s.app.reach = Reach::Network;
    let make = |url: &str, event: &str| {
        add(&s.app, url, &[event], &Reach::Network).map_or_else(|p| p.code, |_| "made")
    };
    for (url, event, outcome) in [
        ("http://127.0.0.1/", "submit", "webhook.address"),
        ("http://[::1]/", "submit", "webhook.address"),
        ("http://169.254.169.254/latest", "submit", "webhook.address"),
        ("http://ci/", "submitted", "webhook.event"),
        ("http://ci/", "edit", "webhook.event"),
    ] {
        assert_eq!(make(url, event), outcome, "{url} {event}");
    }
    // A host name is checked by its resolved address, when it is called.
    let (url, inbox) = receiver(&[200]);
    assert_eq!(make(&url.replace("127.0.0.1", "localhost"), "submit"), "made");
    tell(&s.app, "submit");
    assert_eq!(deliver_due(&s.app).unwrap(), 0);
    assert!(inbox.try_recv().is_err(), "nothing was sent");
    let (left, error) = pending(&s.app);
    assert!(left == 1 && error.as_ref().unwrap().contains("sends nothing to localhost"), "{error:?}");
}

#[test]
fn only_plain_addresses_are_taken() {
    let s = scene();
    for bad in ["ftp://a/", "file:///etc/passwd", "http://a\r\nx"] {
        let refused = add(&s.app, bad, &[], &Reach::OwnMachine).unwrap_err();
        assert_eq!(refused.code, "webhook.url", "{bad}");
    }
}

/// Accepts one message over TLS with a certificate for `localhost`; other certificates fail in the handshake.
fn receiver_with_tls() -> (String, CertificateDer<'static>, Inbox<String>) {
    let made = rcgen::generate_simple_self_signed(vec!["localhost".to_owned()]).unwrap();
    let certificate = made.cert.der().clone();
    let key = PrivateKeyDer::Pkcs8(PrivatePkcs8KeyDer::from(made.signing_key.serialize_der()));
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ServerConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
    let config = config.with_no_client_auth().with_single_cert(vec![certificate.clone()], key).unwrap();
    let config = Arc::new(config);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("https://localhost:{}/hook", listener.local_addr().unwrap().port());
    let (tell, told) = channel();
    std::thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            let connection = ServerConnection::new(Arc::clone(&config)).unwrap();
            let mut stream = StreamOwned::new(connection, stream);
            let (mut text, mut part) = (String::new(), [0; 4096]);
            while !text.ends_with('}') {
                match stream.read(&mut part) {
                    Ok(n) if n > 0 => text.push_str(std::str::from_utf8(&part[..n]).unwrap()),
                    _ => break,
                }
            }
            let _ = stream.write_all(b"HTTP/1.1 204 x\r\n\r\n");
            let _ = tell.send(text);
        }
    });
    (url, certificate, told)
}

#[test]
fn only_a_receiver_whose_certificate_is_believed_is_told() {
    let mut s = scene();
    let (url, certificate, told) = receiver_with_tls();
    hook(&s.app, &url, &[]);
    tell(&s.app, "submit");
    assert_eq!(deliver_due(&s.app).unwrap(), 0);
    let (left, error) = pending(&s.app);
    assert!(left == 1 && error.as_ref().unwrap().contains("certificate"), "{error:?}");
    assert_eq!(told.recv().unwrap(), "", "it was told nothing");

    s.app.trust = Trust::with(vec![certificate]);
    s.clock.fetch_add(5_000, Ordering::SeqCst);
    assert_eq!(deliver_due(&s.app).unwrap(), 1);
    let request = told.recv().unwrap();
    assert!(
        request.starts_with("POST /hook HTTP/1.1\r\nhost: localhost:") && request.ends_with('}'),
        "{request}"
    );
    assert_eq!(pending(&s.app), (0, None));
}

fixtures::on_postgresql! {
    a_message_is_signed_and_says_what_happened_but_no_label,
    what_was_not_taken_is_sent_again_later_and_later,
    webhooks_of_a_disabled_person_are_paused,
    waits_double_up_to_an_hour,
    a_receiver_that_is_away_keeps_its_messages_and_a_removed_one_loses_them,
    two_senders_do_not_send_one_message_twice,
    a_service_that_others_reach_calls_nothing_on_its_own_machine,
    only_plain_addresses_are_taken,
    only_a_receiver_whose_certificate_is_believed_is_told,
}
