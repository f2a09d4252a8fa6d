//! A local endpoint for chat completions that answers by a script, and misbehaves where the script says so.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// A request as it arrived.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Header lines.
    #[allow(dead_code, reason = "not every test binary asks for headers")]
    pub head: String,
    /// The body.
    pub body: Value,
}

impl Seen {
    /// All texts of the messages, one after the other.
    #[allow(dead_code, reason = "not every test binary asks for texts")]
    pub fn text(&self) -> String {
        let messages = self.body["messages"].as_array().into_iter().flatten();
        let contents = messages.map(|m| match &m["content"] {
            Value::Array(parts) => {
                parts.iter().filter_map(|p| p["text"].as_str()).collect::<Vec<_>>().join("\n")
            }
            other => other.as_str().unwrap_or_default().to_owned(),
        });
        contents.collect::<Vec<_>>().join("\n")
    }

    /// Name of the form that is asked for.
    #[allow(dead_code, reason = "not every test binary asks for forms")]
    pub fn form(&self) -> String {
        self.body["response_format"]["json_schema"]["name"].as_str().unwrap_or_default().to_owned()
    }
}

/// What the endpoint does with a request.
#[derive(Clone, Debug)]
#[allow(dead_code, reason = "not every test binary uses every misbehavior")]
pub enum Reply {
    /// A completion with this content: 100 tokens of question, 20 of answer.
    Says(String),
    /// A completion in which the model declines.
    Refuses(String),
    /// A status, seconds of `retry-after`, and a body.
    Status(u16, Option<u64>, String),
    /// Status 200 with this body.
    Body(String),
    /// No answer for so long.
    Hangs(Duration),
}

/// The running endpoint; ends when dropped.
pub struct Scripted {
    /// Address of the interface.
    pub url: String,
    address: std::net::SocketAddr,
    seen: Arc<Mutex<Vec<Seen>>>,
    ends: Arc<AtomicBool>,
}

impl Scripted {
    /// `script` is asked with the number of the request, from 0, and the request.
    pub fn new(script: impl FnMut(usize, &Seen) -> Reply + Send + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let (seen, ends) = (Arc::new(Mutex::new(Vec::new())), Arc::new(AtomicBool::new(false)));
        let script = Arc::new(Mutex::new(script));
        let (all, end) = (Arc::clone(&seen), Arc::clone(&ends));
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                if end.load(Ordering::SeqCst) {
                    return;
                }
                let (all, script) = (Arc::clone(&all), Arc::clone(&script));
                std::thread::spawn(move || {
                    let Some(request) = read(&stream) else { return };
                    let reply = {
                        let mut all = all.lock().unwrap();
                        let reply = (script.lock().unwrap())(all.len(), &request);
                        all.push(request);
                        reply
                    };
                    answer(stream, reply);
                });
            }
        });
        Self { url: format!("http://{address}/v1"), address, seen, ends }
    }

    /// The requests so far.
    pub fn seen(&self) -> Vec<Seen> {
        self.seen.lock().unwrap().clone()
    }
}

impl Drop for Scripted {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::SeqCst);
        let _ = TcpStream::connect(self.address);
    }
}

fn read(stream: &TcpStream) -> Option<Seen> {
    let mut reader = BufReader::new(stream);
    let mut head = String::new();
    let mut length = 0;
    loop {
        let mut line = String::new();
        if reader.read_line(&mut line).ok()? == 0 {
            return None;
        }
        if let Some(n) = line.to_ascii_lowercase().strip_prefix("content-length:") {
            length = n.trim().parse().ok()?;
        }
        if line.trim().is_empty() {
            break;
        }
        head.push_str(&line);
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).ok()?;
    Some(Seen { head, body: serde_json::from_slice(&body).ok()? })
}

fn answer(mut stream: TcpStream, reply: Reply) {
    let completion = |message: Value| {
        json!({
            "choices": [{ "index": 0, "message": message, "finish_reason": "stop" }],
            "usage": { "prompt_tokens": 100, "completion_tokens": 20 },
        })
        .to_string()
    };
    let (status, retry, body) = match reply {
        Reply::Says(content) => (200, None, completion(json!({ "role": "assistant", "content": content }))),
        Reply::Refuses(why) => {
            (200, None, completion(json!({ "role": "assistant", "content": null, "refusal": why })))
        }
        Reply::Status(status, retry, body) => (status, retry, body),
        Reply::Body(body) => (200, None, body),
        Reply::Hangs(time) => {
            std::thread::sleep(time);
            return;
        }
    };
    let retry = retry.map(|s| format!("retry-after: {s}\r\n")).unwrap_or_default();
    let head = format!(
        "HTTP/1.1 {status} x\r\ncontent-type: application/json\r\nconnection: close\r\n{retry}content-length: {}\r\n\r\n",
        body.len()
    );
    let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(body.as_bytes()));
}
