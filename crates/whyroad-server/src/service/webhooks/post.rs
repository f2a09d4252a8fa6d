//! One HTTP/1.1 POST, plain or over TLS, with time limits, without other HTTP features: no redirects, no keep-alive.

use super::reach::Reach;
use super::tls::Trust;
use std::io::{Error, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};
use whyroad_model::Bilingual;

/// Maximum time for connecting, and for each read or write.
const WAIT: Duration = Duration::from_secs(5);
/// Maximum time for the whole request.
const DEADLINE: Duration = Duration::from_secs(15);

/// Protocol of a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scheme {
    /// `http://`
    Plain,
    /// `https://`
    Tls,
}

/// The parsed `http://` or `https://` address of a receiver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Receiver {
    scheme: Scheme,
    host: String,
    port: u16,
    path: String,
}

impl Receiver {
    /// The host for name resolution.
    pub(super) fn host(&self) -> &str {
        self.host.trim_matches(['[', ']'])
    }

    /// False if the host is an IP address that `reach` excludes. The addresses of a host name are checked when it is
    /// called.
    pub(super) fn may_be_reached(&self, reach: &Reach) -> bool {
        let address = self.host().parse::<std::net::IpAddr>();
        address.map_or(true, |ip| reach.allows(self.host(), self.port, ip))
    }

    /// The host for the `host` header; without the port if it is the default of the scheme.
    fn authority(&self) -> String {
        match (self.scheme, self.port) {
            (Scheme::Plain, 80) | (Scheme::Tls, 443) => self.host.clone(),
            (_, port) => format!("{}:{port}", self.host),
        }
    }

    /// Parses an address; returns an error text.
    pub fn parse(url: &str) -> Result<Self, Bilingual> {
        let (scheme, usual_port, rest) = match (url.strip_prefix("http://"), url.strip_prefix("https://")) {
            (Some(rest), _) => (Scheme::Plain, 80, rest),
            (_, Some(rest)) => (Scheme::Tls, 443, rest),
            _ => {
                return Err(Bilingual::new(
                    "不以 http:// 或 https:// 开头",
                    "it does not start with http:// or https://",
                ));
            }
        };
        let (place, path) = rest.split_at(rest.find(['/', '?']).unwrap_or(rest.len()));
        let (host, port) = match place.rsplit_once(':') {
            Some((host, port)) if !port.contains(']') => {
                (host, port.parse().map_err(|_| Bilingual::new("端口不是数字", "the port is not a number"))?)
            }
            _ => (place, usual_port),
        };
        // Characters that could break out of the request's lines, or hide another host.
        let odd = |c: char| c.is_whitespace() || c.is_control() || c == '@';
        if host.is_empty() || url.chars().any(odd) || !url.is_ascii() || url.contains('#') {
            return Err(Bilingual::new(
                "没有主机名，或含有网址不能有的字符",
                "it has no host, or characters that are not allowed in an address",
            ));
        }
        let slash = if path.starts_with('/') { "" } else { "/" };
        Ok(Self { scheme, host: host.to_owned(), port, path: format!("{slash}{path}") })
    }
}

/// Sends `body` as JSON. An error text unless the receiver answers with a status of 200 to 299.
pub fn post(
    to: &Receiver,
    (reach, trust): (&Reach, &Trust),
    headers: &[(&str, &str)],
    body: &[u8],
) -> Result<(), Bilingual> {
    let stream = Hurried { stream: connect(to, reach)?, until: Instant::now() + DEADLINE };
    match to.scheme {
        Scheme::Plain => exchange(stream, to, headers, body),
        Scheme::Tls => exchange(trust.secure(stream, to.host())?, to, headers, body),
    }
}

fn exchange(
    mut stream: impl Read + Write,
    to: &Receiver,
    headers: &[(&str, &str)],
    body: &[u8],
) -> Result<(), Bilingual> {
    let mut head = format!(
        "POST {} HTTP/1.1\r\nhost: {}\r\nuser-agent: whyroad\r\nconnection: close\r\ncontent-type: application/json\r\ncontent-length: {}\r\n",
        to.path,
        to.authority(),
        body.len()
    );
    for (name, value) in headers {
        head.push_str(&format!("{name}: {value}\r\n"));
    }
    head.push_str("\r\n");
    let sent =
        stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(body)).and_then(|()| stream.flush());
    sent.map_err(|e| Bilingual::new(format!("发送失败：{e}"), format!("sending failed: {e}")))?;
    let line = status_line(&mut stream)?;
    let status = line.split(' ').nth(1).and_then(|s| s.parse::<u16>().ok());
    match status {
        Some(200..=299) if line.starts_with("HTTP/1.") => Ok(()),
        Some(status) => Err(Bilingual::new(
            format!("接收方回答状态 {status}"),
            format!("the receiver answered with status {status}"),
        )),
        None => Err(Bilingual::new("接收方的回答不是 HTTP", "the receiver's answer is not HTTP")),
    }
}

fn connect(to: &Receiver, reach: &Reach) -> Result<TcpStream, Bilingual> {
    let host = to.host();
    let places = (host, to.port)
        .to_socket_addrs()
        .map_err(|e| Bilingual::new(format!("找不到 {host}：{e}"), format!("{host} was not found: {e}")))?;
    let mut why = Bilingual::new(format!("{host} 没有地址"), format!("{host} has no address"));
    for place in places {
        if !reach.allows(host, to.port, place.ip()) {
            why = not_reached(host);
            continue;
        }
        match TcpStream::connect_timeout(&place, WAIT) {
            Ok(stream) => return Ok(stream),
            // Without the resolved IP address, which is internal to the network.
            Err(e) => {
                why =
                    Bilingual::new(format!("连接不上 {host}：{e}"), format!("no connection to {host}: {e}"));
            }
        }
    }
    Err(why)
}

/// Message that nothing is sent to `host`.
pub(super) fn not_reached(host: &str) -> Bilingual {
    Bilingual::new(
        format!("本服务不向 {host} 发送（见 whyroad serve --webhook-to）"),
        format!("this service sends nothing to {host} (see whyroad serve --webhook-to)"),
    )
}

/// A connection that waits at most [`WAIT`] each time and not beyond a deadline: a slow receiver delays nobody.
struct Hurried {
    stream: TcpStream,
    until: Instant,
}

impl Hurried {
    /// Current maximum wait.
    fn wait(&self) -> std::io::Result<Option<Duration>> {
        let left = self.until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(Error::new(ErrorKind::TimedOut, "it took too long"));
        }
        Ok(Some(left.min(WAIT)))
    }
}

impl Read for Hurried {
    fn read(&mut self, buf: &mut [u8]) -> std::io::Result<usize> {
        self.stream.set_read_timeout(self.wait()?)?;
        self.stream.read(buf)
    }
}

impl Write for Hurried {
    fn write(&mut self, buf: &[u8]) -> std::io::Result<usize> {
        self.stream.set_write_timeout(self.wait()?)?;
        self.stream.write(buf)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.stream.flush()
    }
}

/// The first line of the response. The rest is not read.
fn status_line(stream: &mut impl Read) -> Result<String, Bilingual> {
    let (mut line, mut byte) = (Vec::new(), [0]);
    while line.len() < 200 {
        match stream.read(&mut byte) {
            Ok(1) if byte[0] != b'\n' => line.push(byte[0]),
            Ok(_) => break,
            Err(e) => return Err(Bilingual::new(format!("没有回答：{e}"), format!("no answer: {e}"))),
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
        assert_eq!(of("https://ci.local/h"), Ok(("ci.local".into(), 443, "/h".into())));
        let authority = |url: &str| Receiver::parse(url).unwrap().authority();
        assert_eq!(authority("https://ci.local:443/"), "ci.local");
        assert_eq!(authority("https://ci.local:80/"), "ci.local:80");
        for bad in [
            "https://",
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
