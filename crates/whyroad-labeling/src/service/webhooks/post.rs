//! One HTTP/1.1 POST, with time limits, and nothing else of HTTP: no redirects, no keep-alive, no TLS.

use std::io::{Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

/// Time for connecting, and for each wait on the wire.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time for the whole.
const DEADLINE: Duration = Duration::from_secs(15);

/// Where to: an `http://` address taken apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Receiver {
    host: String,
    port: u16,
    path: String,
}

impl Receiver {
    /// Takes an address apart; in words what is wrong with it.
    pub fn parse(url: &str) -> Result<Self, String> {
        let rest = url.strip_prefix("http://").ok_or("it does not begin with http://")?;
        let (place, path) = rest.split_at(rest.find(['/', '?']).unwrap_or(rest.len()));
        let (host, port) = match place.rsplit_once(':') {
            Some((host, port)) if !port.contains(']') => {
                (host, port.parse().map_err(|_| "the port is no number")?)
            }
            _ => (place, 80),
        };
        // What could break out of the request's lines, or hides another host.
        let odd = |c: char| c.is_whitespace() || c.is_control() || c == '@';
        if host.is_empty() || url.chars().any(odd) || !url.is_ascii() || url.contains('#') {
            return Err("it has no host, or characters that an address has not".to_owned());
        }
        let slash = if path.starts_with('/') { "" } else { "/" };
        Ok(Self { host: host.to_owned(), port, path: format!("{slash}{path}") })
    }
}

/// Sends `body` as JSON. An error in words unless the receiver answers with a status of 200 to 299.
pub fn post(to: &Receiver, headers: &[(&str, &str)], body: &[u8]) -> Result<(), String> {
    let start = Instant::now();
    let mut stream = connect(to)?;
    let mut head = format!(
        "POST {} HTTP/1.1\r\nhost: {}:{}\r\nuser-agent: whyroad\r\nconnection: close\r\ncontent-type: application/json\r\ncontent-length: {}\r\n",
        to.path,
        to.host,
        to.port,
        body.len()
    );
    for (name, value) in headers {
        head.push_str(&format!("{name}: {value}\r\n"));
    }
    head.push_str("\r\n");
    let sent = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(body));
    sent.map_err(|e| format!("sending failed: {e}"))?;
    let line = status_line(&mut stream, start)?;
    let status = line.split(' ').nth(1).and_then(|s| s.parse::<u16>().ok());
    match status {
        Some(200..=299) if line.starts_with("HTTP/1.") => Ok(()),
        Some(status) => Err(format!("the receiver answered with status {status}")),
        None => Err("the receiver's answer is no HTTP".to_owned()),
    }
}

fn connect(to: &Receiver) -> Result<TcpStream, String> {
    let host = to.host.trim_matches(['[', ']']);
    let places = (host, to.port).to_socket_addrs().map_err(|e| format!("{host} is not known: {e}"))?;
    let mut why = format!("{host} has no address");
    for place in places {
        match TcpStream::connect_timeout(&place, PATIENCE) {
            Ok(stream) => {
                let limits =
                    stream.set_read_timeout(Some(PATIENCE)).and(stream.set_write_timeout(Some(PATIENCE)));
                limits.map_err(|e| e.to_string())?;
                return Ok(stream);
            }
            Err(e) => why = format!("no connection to {place}: {e}"),
        }
    }
    Err(why)
}

/// The first line of the answer. Reading stops there: what else a receiver says is of no interest.
fn status_line(stream: &mut TcpStream, start: Instant) -> Result<String, String> {
    let (mut line, mut byte) = (Vec::new(), [0]);
    while line.len() < 200 && start.elapsed() < DEADLINE {
        match stream.read(&mut byte) {
            Ok(1) if byte[0] != b'\n' => line.push(byte[0]),
            Ok(_) => break,
            Err(e) => return Err(format!("no answer: {e}")),
        }
    }
    Ok(String::from_utf8_lossy(&line).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_taken_apart_and_odd_ones_refused() {
        let of = |url: &str| Receiver::parse(url).map(|r| (r.host, r.port, r.path));
        assert_eq!(of("http://ci.local"), Ok(("ci.local".into(), 80, "/".into())));
        assert_eq!(of("http://ci.local:8081/hook?x=1"), Ok(("ci.local".into(), 8081, "/hook?x=1".into())));
        assert_eq!(of("http://[::1]:9/h"), Ok(("[::1]".into(), 9, "/h".into())));
        assert_eq!(of("http://ci?x"), Ok(("ci".into(), 80, "/?x".into())));
        for bad in [
            "https://a",
            "ftp://a",
            "http://",
            "http:///x",
            "http://a b",
            "http://a/\r\nx: y",
            "http://u@a",
            "http://a:x",
            "http://a#b",
        ] {
            assert!(of(bad).is_err(), "{bad}");
        }
    }
}
