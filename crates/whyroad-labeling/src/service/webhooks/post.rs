//! One HTTP/1.1 POST, with time limits, and nothing else of HTTP: no redirects, no keep-alive, no TLS.

use super::Reach;
use std::io::{Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};
use whyroad_model::Bilingual;

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
    /// The host as names are looked up by.
    pub(super) fn host(&self) -> &str {
        self.host.trim_matches(['[', ']'])
    }

    /// False where the host is a plain address that `reach` rules out. What a name leads to is seen when it is called.
    pub(super) fn may_be_reached(&self, reach: &Reach) -> bool {
        let address = self.host().parse::<std::net::IpAddr>();
        address.map_or(true, |ip| reach.allows(self.host(), self.port, ip))
    }

    /// Takes an address apart; in words what is wrong with it.
    pub fn parse(url: &str) -> Result<Self, Bilingual> {
        let no_scheme = || Bilingual::new("不以 http:// 开头", "it does not begin with http://");
        let rest = url.strip_prefix("http://").ok_or_else(no_scheme)?;
        let (place, path) = rest.split_at(rest.find(['/', '?']).unwrap_or(rest.len()));
        let (host, port) = match place.rsplit_once(':') {
            Some((host, port)) if !port.contains(']') => {
                (host, port.parse().map_err(|_| Bilingual::new("端口不是数字", "the port is no number"))?)
            }
            _ => (place, 80),
        };
        // What could break out of the request's lines, or hides another host.
        let odd = |c: char| c.is_whitespace() || c.is_control() || c == '@';
        if host.is_empty() || url.chars().any(odd) || !url.is_ascii() || url.contains('#') {
            return Err(Bilingual::new(
                "没有主机名，或含有网址不能有的字符",
                "it has no host, or characters that an address has not",
            ));
        }
        let slash = if path.starts_with('/') { "" } else { "/" };
        Ok(Self { host: host.to_owned(), port, path: format!("{slash}{path}") })
    }
}

/// Sends `body` as JSON. An error in words unless the receiver answers with a status of 200 to 299.
pub fn post(to: &Receiver, reach: &Reach, headers: &[(&str, &str)], body: &[u8]) -> Result<(), Bilingual> {
    let start = Instant::now();
    let mut stream = connect(to, reach)?;
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
    sent.map_err(|e| Bilingual::new(format!("发送失败：{e}"), format!("sending failed: {e}")))?;
    let line = status_line(&mut stream, start)?;
    let status = line.split(' ').nth(1).and_then(|s| s.parse::<u16>().ok());
    match status {
        Some(200..=299) if line.starts_with("HTTP/1.") => Ok(()),
        Some(status) => Err(Bilingual::new(
            format!("接收方回答状态 {status}"),
            format!("the receiver answered with status {status}"),
        )),
        None => Err(Bilingual::new("接收方的回答不是 HTTP", "the receiver's answer is no HTTP")),
    }
}

fn connect(to: &Receiver, reach: &Reach) -> Result<TcpStream, Bilingual> {
    let host = to.host();
    let places = (host, to.port)
        .to_socket_addrs()
        .map_err(|e| Bilingual::new(format!("找不到 {host}：{e}"), format!("{host} is not known: {e}")))?;
    let mut why = Bilingual::new(format!("{host} 没有地址"), format!("{host} has no address"));
    for place in places {
        if !reach.allows(host, to.port, place.ip()) {
            why = not_reached(host);
            continue;
        }
        match TcpStream::connect_timeout(&place, PATIENCE) {
            Ok(stream) => {
                let limits =
                    stream.set_read_timeout(Some(PATIENCE)).and(stream.set_write_timeout(Some(PATIENCE)));
                limits.map_err(|e| Bilingual::new(e.to_string(), e.to_string()))?;
                return Ok(stream);
            }
            // Not the address that the name led to: that is the network's own affair.
            Err(e) => {
                why =
                    Bilingual::new(format!("连接不上 {host}：{e}"), format!("no connection to {host}: {e}"));
            }
        }
    }
    Err(why)
}

/// That messages do not go to `host`.
pub(super) fn not_reached(host: &str) -> Bilingual {
    Bilingual::new(
        format!("本服务不向 {host} 发送（见 whyroad serve --webhook-to）"),
        format!("this service sends nothing to {host} (see whyroad serve --webhook-to)"),
    )
}

/// The first line of the answer. Reading stops there: what else a receiver says is of no interest.
fn status_line(stream: &mut TcpStream, start: Instant) -> Result<String, Bilingual> {
    let (mut line, mut byte) = (Vec::new(), [0]);
    while line.len() < 200 && start.elapsed() < DEADLINE {
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
