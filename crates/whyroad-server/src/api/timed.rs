//! Connections with time limits: a connection is closed if it sends or receives nothing for a while, or sends the head
//! of a request too slowly. Slow, dead or malicious clients cannot use up all connections. While the service itself
//! works on a request, the connection may be silent.

use axum::extract::connect_info::Connected;
use axum::serve::{IncomingStream, Listener};
use std::future::Future;
use std::io::{Error, ErrorKind, Result};
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, Sleep, sleep};

/// Maximum silence, in both directions. An open page sends a heartbeat more often than that, or opens a new connection.
const SILENCE: Duration = Duration::from_secs(75);
/// Maximum time for receiving the head of a request, and for a new connection to send its first byte. Bodies have a
/// separate limit.
const HEAD: Duration = Duration::from_secs(20);

/// A listener whose connections have these time limits.
pub(super) struct TimedListener {
    listener: TcpListener,
    head: Duration,
}

impl TimedListener {
    pub(super) fn new(listener: TcpListener) -> Self {
        Self { listener, head: HEAD }
    }
}

impl Listener for TimedListener {
    type Io = Timed;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Timed, SocketAddr) {
        let (stream, address) = Listener::accept(&mut self.listener).await;
        // Small responses are sent immediately.
        let _ = stream.set_nodelay(true);
        // Connections that never send anything must not use up the open files of the service.
        let timer = Box::pin(sleep(self.head));
        (Timed { stream, timer, head: self.head, begun: None, requests: Arc::default() }, address)
    }

    fn local_addr(&self) -> Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// Requests of one connection.
#[derive(Debug, Default)]
struct Requests {
    /// Requests whose head was received and whose response was not sent.
    open: AtomicUsize,
    /// Requests in work.
    at_work: AtomicUsize,
}

/// A connection with a timer that each byte resets.
pub(super) struct Timed {
    stream: TcpStream,
    timer: Pin<Box<Sleep>>,
    head: Duration,
    /// When the first byte of a head was received.
    begun: Option<Instant>,
    requests: Arc<Requests>,
}

impl Timed {
    fn checked<T>(&mut self, cx: &mut Context<'_>, result: Poll<Result<T>>) -> Poll<Result<T>> {
        if result.is_ready() {
            self.timer.as_mut().reset(Instant::now() + SILENCE);
            return result;
        }
        while self.timer.as_mut().poll(cx).is_ready() {
            if self.requests.at_work.load(Ordering::SeqCst) == 0 {
                return Poll::Ready(Err(Error::new(ErrorKind::TimedOut, "silent for too long")));
            }
            self.timer.as_mut().reset(Instant::now() + SILENCE);
        }
        Poll::Pending
    }

    /// False once a head has been incomplete for too long.
    fn head_in_time(&mut self) -> bool {
        if self.requests.open.load(Ordering::SeqCst) > 0 {
            self.begun = None;
            return true;
        }
        self.begun.get_or_insert_with(Instant::now).elapsed() <= self.head
    }
}

impl AsyncRead for Timed {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<Result<()>> {
        let result = Pin::new(&mut self.stream).poll_read(cx, buf);
        // Checked with each byte: a client that sends none is silent.
        if result.is_ready() && !self.head_in_time() {
            return Poll::Ready(Err(Error::new(ErrorKind::TimedOut, "the head of a request took too long")));
        }
        self.checked(cx, result)
    }
}

impl AsyncWrite for Timed {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &[u8]) -> Poll<Result<usize>> {
        // A response: what comes next is another head.
        self.begun = None;
        let result = Pin::new(&mut self.stream).poll_write(cx, buf);
        self.checked(cx, result)
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}

/// The client of a connection.
#[derive(Clone, Debug)]
pub(super) struct Peer {
    pub(super) address: SocketAddr,
    requests: Arc<Requests>,
}

impl Peer {
    /// Counts a request whose head was received, until the result is dropped.
    pub(super) fn asks(&self) -> Counted {
        Counted::up(&self.requests, |r| &r.open)
    }

    /// Counts a request of this connection as in work, until the result is dropped.
    pub(super) fn works(&self) -> Counted {
        Counted::up(&self.requests, |r| &r.at_work)
    }
}

/// One counted request, until it is dropped.
pub(super) struct Counted {
    requests: Arc<Requests>,
    which: fn(&Requests) -> &AtomicUsize,
}

impl Counted {
    fn up(requests: &Arc<Requests>, which: fn(&Requests) -> &AtomicUsize) -> Self {
        which(requests).fetch_add(1, Ordering::SeqCst);
        Self { requests: Arc::clone(requests), which }
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        (self.which)(&self.requests).fetch_sub(1, Ordering::SeqCst);
    }
}

impl Connected<IncomingStream<'_, TimedListener>> for Peer {
    fn connect_info(stream: IncomingStream<'_, TimedListener>) -> Self {
        Self { address: *stream.remote_addr(), requests: Arc::clone(&stream.io().requests) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::extract::ConnectInfo;
    use std::io::{Read, Write};
    use std::time;

    const STEP: Duration = Duration::from_millis(60);

    /// Sends one part per [`STEP`]; returns the response and the duration.
    fn drip(at: SocketAddr, parts: &[&str]) -> (String, Duration) {
        let mut stream = std::net::TcpStream::connect(at).unwrap();
        let start = time::Instant::now();
        for part in parts {
            // The client may have disconnected.
            if stream.write_all(part.as_bytes()).is_err() {
                break;
            }
            std::thread::sleep(STEP);
        }
        let mut text = String::new();
        let _ = stream.read_to_string(&mut text);
        (text, start.elapsed())
    }

    #[test]
    fn a_head_may_not_drip_but_a_body_may_and_a_connection_lives_on() {
        let runtime =
            tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
        let listener = runtime.block_on(TcpListener::bind("127.0.0.1:0")).unwrap();
        let at = listener.local_addr().unwrap();
        let length = async |ConnectInfo(peer): ConnectInfo<Peer>, request: axum::extract::Request| {
            let _open = peer.asks();
            axum::body::to_bytes(request.into_body(), 1000).await.map_or(0, |b| b.len()).to_string()
        };
        let service = axum::Router::new().fallback(length).into_make_service_with_connect_info::<Peer>();
        let listener = TimedListener { head: 4 * STEP, ..TimedListener::new(listener) };
        runtime.spawn(async { axum::serve(listener, service).await });

        let mut head = vec!["GET / HTTP/1.1\r\nx: "];
        head.extend(["y"; 100]);
        let (text, took) = drip(at, &head);
        assert!(text.is_empty() && took < 50 * STEP, "{text} after {took:?}");

        let mut body = vec!["POST / HTTP/1.1\r\nconnection: close\r\ncontent-length: 12\r\n\r\n"];
        body.extend(["y"; 12]);
        let (text, took) = drip(at, &body);
        assert!(text.ends_with("\r\n\r\n12") && took > 8 * STEP, "{text}");

        // A connection that sends nothing.
        let (text, took) = drip(at, &[]);
        assert!(text.is_empty() && took < 50 * STEP, "{text} after {took:?}");

        // One request after another, together longer than the limit for one head.
        let mut many = vec!["GET / HTTP/1.1\r\n\r\n"; 8];
        many.push("GET / HTTP/1.1\r\nconnection: close\r\n\r\n");
        assert_eq!(drip(at, &many).0.matches("200 OK").count(), 9);
    }
}
