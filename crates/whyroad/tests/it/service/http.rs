//! A small HTTP/1.1 client for tests and benches: one kept connection, JSON in and out. It speaks only what our own
//! server speaks, and panics at what it does not understand: in a test that is the report.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

/// An answer.
#[derive(Clone, Debug)]
pub struct Answer {
    pub status: u16,
    pub headers: Vec<(String, String)>,
    pub body: Vec<u8>,
}

impl Answer {
    /// The body as JSON; null without one.
    pub fn json(&self) -> Value {
        if self.body.is_empty() { Value::Null } else { serde_json::from_slice(&self.body).unwrap() }
    }

    /// The first header of this name.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, v)| v.as_str())
    }

    /// The JSON body of a successful answer.
    #[track_caller]
    pub fn good(self) -> Value {
        assert!(
            (200..300).contains(&self.status),
            "{}: {}",
            self.status,
            String::from_utf8_lossy(&self.body)
        );
        self.json()
    }
}

/// Somebody who calls the service.
pub struct Client {
    at: SocketAddr,
    connection: Option<BufReader<TcpStream>>,
    token: Option<String>,
    cookie: Option<String>,
    csrf: String,
}

impl Client {
    /// Nobody yet.
    pub fn new(at: SocketAddr) -> Self {
        Self { at, connection: None, token: None, cookie: None, csrf: String::new() }
    }

    /// With an API token.
    pub fn with_token(at: SocketAddr, token: &str) -> Self {
        Self { token: Some(token.to_owned()), ..Self::new(at) }
    }

    /// Makes the first account and stays signed in.
    pub fn set_up(at: SocketAddr, name: &str) -> Self {
        let mut client = Self::new(at);
        let account = serde_json::json!({"name": name, "display": name, "password": "a long password"});
        client.enter("/setup", &account);
        client
    }

    /// Signs in with the password that all accounts of these tests have.
    pub fn sign_in(at: SocketAddr, name: &str) -> Self {
        Self::sign_in_with(at, name, "a long password")
    }

    /// Signs in.
    pub fn sign_in_with(at: SocketAddr, name: &str, password: &str) -> Self {
        let mut client = Self::new(at);
        client.enter("/session", &serde_json::json!({"name": name, "password": password}));
        client
    }

    /// The service is elsewhere now.
    pub fn move_to(&mut self, at: SocketAddr) {
        (self.at, self.connection) = (at, None);
    }

    /// Tries to sign in; the answer.
    pub fn try_to_sign_in(&mut self, name: &str, password: &str) -> Answer {
        self.try_to_enter("/session", &serde_json::json!({"name": name, "password": password}))
    }

    /// The same for any path that begins a session.
    pub fn try_to_enter(&mut self, path: &str, body: &Value) -> Answer {
        let before = self.get("/session");
        self.take_session(&before);
        let answer = self.send("POST", path, Some(body)).unwrap();
        self.take_session(&answer);
        answer
    }

    fn enter(&mut self, path: &str, body: &Value) {
        self.try_to_enter(path, body).good();
    }

    fn take_session(&mut self, answer: &Answer) {
        for (_, v) in answer.headers.iter().filter(|(n, _)| n.eq_ignore_ascii_case("set-cookie")) {
            self.cookie = v.split(';').next().map(str::to_owned);
        }
        if let Some(csrf) = answer.json()["csrf"].as_str() {
            self.csrf = csrf.to_owned();
        }
    }

    pub fn get(&mut self, path: &str) -> Answer {
        self.send("GET", path, None).unwrap()
    }

    pub fn post(&mut self, path: &str, body: &Value) -> Answer {
        self.send("POST", path, Some(body)).unwrap()
    }

    pub fn patch(&mut self, path: &str, body: &Value) -> Answer {
        self.send("PATCH", path, Some(body)).unwrap()
    }

    /// Sends a request; an error when the connection broke before the whole answer was there.
    pub fn send(&mut self, verb: &str, path: &str, body: Option<&Value>) -> std::io::Result<Answer> {
        let answer = self.attempt(verb, path, body);
        let close = answer.as_ref().map_or(true, |a| a.header("connection").is_some_and(|c| c == "close"));
        if close {
            self.connection = None;
        }
        answer
    }

    fn attempt(&mut self, verb: &str, path: &str, body: Option<&Value>) -> std::io::Result<Answer> {
        let text = body.map(Value::to_string).unwrap_or_default();
        let mut head = format!(
            "{verb} /api/v1{path} HTTP/1.1\r\nhost: {}\r\ncontent-length: {}\r\n",
            self.at,
            text.len()
        );
        if body.is_some() {
            head.push_str("content-type: application/json\r\n");
        }
        if let Some(token) = &self.token {
            head.push_str(&format!("authorization: Bearer {token}\r\n"));
        }
        if let Some(cookie) = &self.cookie {
            head.push_str(&format!("cookie: {cookie}\r\nx-csrf-token: {}\r\n", self.csrf));
        }
        head.push_str("\r\n");
        head.push_str(&text);
        let connection = match &mut self.connection {
            Some(c) => c,
            none => {
                let stream = TcpStream::connect(self.at)?;
                stream.set_read_timeout(Some(Duration::from_secs(60)))?;
                stream.set_nodelay(true)?;
                none.insert(BufReader::new(stream))
            }
        };
        connection.get_mut().write_all(head.as_bytes())?;
        read_answer(connection)
    }
}

fn read_answer(connection: &mut BufReader<TcpStream>) -> std::io::Result<Answer> {
    let broken = || std::io::Error::from(std::io::ErrorKind::UnexpectedEof);
    let mut line = String::new();
    connection.read_line(&mut line)?;
    let status = line.split(' ').nth(1).and_then(|s| s.parse().ok()).ok_or_else(broken)?;
    let mut headers = Vec::new();
    loop {
        line.clear();
        if connection.read_line(&mut line)? == 0 {
            return Err(broken());
        }
        match line.trim_end().split_once(": ") {
            Some((name, value)) => headers.push((name.to_owned(), value.to_owned())),
            None => break,
        }
    }
    let of = |name: &str| headers.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, v)| v.clone());
    let mut body = Vec::new();
    if of("transfer-encoding").is_some_and(|t| t == "chunked") {
        loop {
            line.clear();
            connection.read_line(&mut line)?;
            let n = u64::from_str_radix(line.trim(), 16).map_err(|_| broken())?;
            let mut part = Vec::new();
            connection.take(n).read_to_end(&mut part)?;
            connection.read_line(&mut line)?;
            if n == 0 {
                break;
            }
            body.extend(part);
        }
    } else if let Some(n) = of("content-length").and_then(|n| n.parse::<u64>().ok()) {
        connection.take(n).read_to_end(&mut body)?;
        if body.len() as u64 != n {
            return Err(broken());
        }
    }
    Ok(Answer { status, headers, body })
}
