//! Connections that do not wait for ever: one that sends or takes nothing for a while is closed, so that slow or dead
//! clients cannot use up all there are. While the service itself works on a request, the connection may be silent.

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

/// Longest silence, both ways. A page that is open sends a heartbeat more often than that, or opens a new connection.
const SILENCE: Duration = Duration::from_secs(75);

/// A listener whose connections have patience for [`SILENCE`].
pub(super) struct Patient(pub(super) TcpListener);

impl Listener for Patient {
    type Io = Timed;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Timed, SocketAddr) {
        let (stream, address) = Listener::accept(&mut self.0).await;
        // Small answers go at once.
        let _ = stream.set_nodelay(true);
        (Timed { stream, timer: Box::pin(sleep(SILENCE)), at_work: Arc::default() }, address)
    }

    fn local_addr(&self) -> Result<SocketAddr> {
        self.0.local_addr()
    }
}

/// A connection with a timer that each byte sets back.
pub(super) struct Timed {
    stream: TcpStream,
    timer: Pin<Box<Sleep>>,
    /// Requests of this connection that are being worked on.
    at_work: Arc<AtomicUsize>,
}

impl Timed {
    fn checked<T>(&mut self, cx: &mut Context<'_>, result: Poll<Result<T>>) -> Poll<Result<T>> {
        if result.is_ready() {
            self.timer.as_mut().reset(Instant::now() + SILENCE);
            return result;
        }
        while self.timer.as_mut().poll(cx).is_ready() {
            if self.at_work.load(Ordering::SeqCst) == 0 {
                return Poll::Ready(Err(Error::new(ErrorKind::TimedOut, "silent for too long")));
            }
            self.timer.as_mut().reset(Instant::now() + SILENCE);
        }
        Poll::Pending
    }
}

impl AsyncRead for Timed {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<Result<()>> {
        let result = Pin::new(&mut self.stream).poll_read(cx, buf);
        self.checked(cx, result)
    }
}

impl AsyncWrite for Timed {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &[u8]) -> Poll<Result<usize>> {
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

/// Who is at the other end.
#[derive(Clone, Debug)]
pub(super) struct Peer {
    pub(super) address: SocketAddr,
    at_work: Arc<AtomicUsize>,
}

impl Peer {
    /// Says that a request of this connection is being worked on, until the answer to this is dropped.
    pub(super) fn works(self) -> AtWork {
        self.at_work.fetch_add(1, Ordering::SeqCst);
        AtWork(self.at_work)
    }
}

/// See [`Peer::works`].
pub(super) struct AtWork(Arc<AtomicUsize>);

impl Drop for AtWork {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Connected<IncomingStream<'_, Patient>> for Peer {
    fn connect_info(stream: IncomingStream<'_, Patient>) -> Self {
        Self { address: *stream.remote_addr(), at_work: Arc::clone(&stream.io().at_work) }
    }
}
