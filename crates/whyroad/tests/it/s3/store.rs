//! An S3 store for the tests: moto (a Python package), and a proxy before it that fails on purpose.

use crate::duckdb::python;
use std::io::{BufRead as _, BufReader, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// One request at a time: moto compares a condition and writes in two steps, which two requests at once could come
/// between. S3 does both as one.
const SERVER: &str = "
import logging
from moto.server import DomainDispatcherApplication, create_backend_app
from werkzeug.serving import make_server
logging.getLogger('werkzeug').setLevel(logging.ERROR)
server = make_server('127.0.0.1', 0, DomainDispatcherApplication(create_backend_app), threaded=False)
print(server.server_port, flush=True)
server.serve_forever()
";

/// What nobody may ever see.
pub const SECRET: &str = "hunter2SecretAccessKey";
/// A second secret: of temporary credentials.
pub const TOKEN: &str = "hunter2SessionToken";

/// A store with the bucket `fleet`, until this is dropped.
pub struct Store {
    server: Child,
    pub port: u16,
}

impl Store {
    /// `None` where moto is not installed, which the test says.
    pub fn start() -> Option<Self> {
        let import = Command::new(python()).args(["-c", "import moto.server"]).output();
        if !import.is_ok_and(|o| o.status.success()) {
            crate::require::skipped("python", "no moto");
            return None;
        }
        let mut server = Command::new(python())
            .args(["-c", SERVER])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let store = Self { server, port: line.trim().parse().unwrap() };
        let answer = store.request("PUT", "/fleet", b"");
        assert!(answer.starts_with("HTTP/1.1 200") || answer.starts_with("HTTP/1.0 200"), "{answer}");
        Some(store)
    }

    /// Writes an object.
    pub fn put(&self, key: &str, content: &[u8]) {
        let answer = self.request("PUT", &format!("/fleet/{key}"), content);
        assert!(answer.contains(" 200 "), "{answer}");
    }

    /// The content at a link, as a browser reads it.
    pub fn follow(&self, link: &str) -> String {
        let path = link.strip_prefix(&format!("http://127.0.0.1:{}", self.port)).unwrap();
        let answer = self.request("GET", path, b"");
        assert!(answer.contains(" 200 "), "{answer}");
        answer.split_once("\r\n\r\n").unwrap().1.to_owned()
    }

    fn request(&self, method: &str, path: &str, content: &[u8]) -> String {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
            content.len()
        )
        .unwrap();
        stream.write_all(content).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// Keys and content hashes of all objects below a prefix.
    pub fn objects(&self, prefix: &str) -> Vec<(String, String)> {
        let listed = self.request("GET", &format!("/fleet?list-type=2&max-keys=1000&prefix={prefix}"), b"");
        assert!(listed.contains("<IsTruncated>false"), "{listed}");
        let value = |text: &str, name: &str| {
            let (_, rest) = text.split_once(&format!("<{name}>")).unwrap();
            rest.split_once('<').unwrap().0.to_owned()
        };
        listed.split("<Contents>").skip(1).map(|o| (value(o, "Key"), value(o, "ETag"))).collect()
    }

    /// The environment of a process that uses the store on this port: its own, or that of a proxy.
    pub fn environment(&self, port: u16, cache: &std::path::Path) -> Vec<(String, String)> {
        let of = |name: &str, value: String| (name.to_owned(), value);
        vec![
            of("AWS_ENDPOINT_URL", format!("http://127.0.0.1:{port}")),
            of("AWS_REGION", "us-east-1".into()),
            of("AWS_ACCESS_KEY_ID", "AKIAIOSFODNN7EXAMPLE".into()),
            of("AWS_SECRET_ACCESS_KEY", SECRET.into()),
            of("AWS_SESSION_TOKEN", TOKEN.into()),
            of("AWS_CONFIG_FILE", "/nowhere".into()),
            of("AWS_SHARED_CREDENTIALS_FILE", "/nowhere".into()),
            of("WHYROAD_CACHE", cache.display().to_string()),
            of("NO_PROXY", "127.0.0.1".into()),
        ]
    }
}

impl Drop for Store {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// What the proxy does to a request.
#[derive(Clone, Copy, Debug)]
pub enum Fault {
    /// Nothing.
    Pass,
    /// Answers with this status; the store never sees the request.
    Status(u16),
    /// Ends the connection; the store never sees the request.
    Refuse,
    /// The store carries the request out, and the answer is lost.
    LoseAnswer,
    /// Half of the answer comes.
    CutAnswer,
    /// The request comes late.
    Delay(Duration),
    /// No answer ever.
    Hang,
}

/// A proxy before the store. It ends with the test.
pub struct Proxy {
    pub port: u16,
    pub requests: Arc<AtomicUsize>,
}

impl Proxy {
    /// `fault` says what to do with request number `n`, from 0, given its first line.
    pub fn before(store: &Store, fault: impl Fn(usize, &str) -> Fault + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let requests = Arc::new(AtomicUsize::new(0));
        let (to, counted, fault) =
            (SocketAddr::from(([127, 0, 0, 1], store.port)), Arc::clone(&requests), Arc::new(fault));
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (counted, fault) = (Arc::clone(&counted), Arc::clone(&fault));
                std::thread::spawn(move || {
                    // A connection that the client gives up is not this test's business.
                    let _ = serve(stream, to, |line| fault(counted.fetch_add(1, Ordering::SeqCst), line));
                });
            }
        });
        Self { port, requests }
    }
}

fn serve(mut client: TcpStream, to: SocketAddr, fault: impl Fn(&str) -> Fault) -> std::io::Result<()> {
    let mut reader = BufReader::new(client.try_clone()?);
    let (mut head, mut length) = (String::new(), 0);
    loop {
        let mut line = String::new();
        if reader.read_line(&mut line)? == 0 {
            return Ok(());
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("content-length")
        {
            length = value.trim().parse().unwrap_or(0);
        }
        if line.trim().is_empty() {
            break;
        }
        // One request per connection.
        if !line.to_ascii_lowercase().starts_with("connection:") {
            head += &line;
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body)?;
    let fault = fault(head.lines().next().unwrap_or_default());
    match fault {
        Fault::Status(status) => {
            let text = format!("<Error><Code>SlowDown</Code><Message>not now {status}</Message></Error>");
            write!(
                client,
                "HTTP/1.1 {status} Slow\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{text}",
                text.len()
            )?;
            return client.shutdown(Shutdown::Both);
        }
        Fault::Refuse => return client.shutdown(Shutdown::Both),
        Fault::Delay(time) => std::thread::sleep(time),
        Fault::Hang => {
            std::thread::sleep(Duration::from_secs(600));
            return Ok(());
        }
        Fault::Pass | Fault::LoseAnswer | Fault::CutAnswer => {}
    }
    let mut store = TcpStream::connect(to)?;
    store.write_all(format!("{head}Connection: close\r\n\r\n").as_bytes())?;
    store.write_all(&body)?;
    let mut answer = Vec::new();
    store.read_to_end(&mut answer)?;
    match fault {
        Fault::LoseAnswer => {}
        Fault::CutAnswer => client.write_all(&answer[..answer.len() / 2])?,
        _ => client.write_all(&answer)?,
    }
    client.shutdown(Shutdown::Both)
}
