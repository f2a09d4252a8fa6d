//! A response that is generated while it is sent: chunk by chunk from a thread that may block, never completely in
//! memory. A slow receiver makes the thread wait; one that disconnects stops it.

use crate::problem::{Answer, Problem};
use axum::body::{Body, Bytes, HttpBody};
use flate2::{Compression, write::GzEncoder};
use http_body::Frame;
use std::io::{BufWriter, Write};
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};
use tokio::sync::mpsc::{Receiver, Sender, channel};

/// Bytes per chunk, and number of chunks that wait for the receiver.
const CHUNK: usize = 64 * 1024;
const WAITING: usize = 4;

type Make = Box<dyn FnOnce(&mut dyn Write) -> Answer<()> + Send>;

/// Writes a response; it runs once.
#[derive(Clone)]
pub struct Stream(Arc<Mutex<Option<Make>>>);

impl std::fmt::Debug for Stream {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Stream")
    }
}

impl Stream {
    /// A response that `make` writes.
    pub fn new(make: impl FnOnce(&mut dyn Write) -> Answer<()> + Send + 'static) -> Self {
        Self(Arc::new(Mutex::new(Some(Box::new(make)))))
    }

    /// The body, compressed if `gzip`. `failed` is called with an error that interrupts the response; the receiver then
    /// sees a broken connection, not a short file.
    pub(super) fn body(&self, gzip: bool, failed: impl FnOnce(&Problem) + Send + 'static) -> Body {
        let make = self.0.lock().ok().and_then(|mut make| make.take());
        let (sender, chunks) = channel(WAITING);
        tokio::task::spawn_blocking(move || {
            let Some(make) = make else { return };
            let out = BufWriter::with_capacity(CHUNK, Chunks(sender.clone()));
            let result = if gzip {
                let mut out = GzEncoder::new(out, Compression::fast());
                make(&mut out)
                    .and_then(|()| out.finish().and_then(|mut out| out.flush()).map_err(Problem::store))
            } else {
                let mut out = out;
                make(&mut out).and_then(|()| out.flush().map_err(Problem::store))
            };
            if let Err(why) = result {
                // Not where the receiver has disconnected: that is not an error of the service.
                if sender.blocking_send(Err(std::io::Error::other("interrupted"))).is_ok() {
                    failed(&why);
                }
            }
        });
        Body::new(Chunked(chunks))
    }

    /// The complete response, for callers without a socket.
    pub fn whole(&self) -> Answer<Vec<u8>> {
        let make = self.0.lock().map_err(Problem::store)?.take();
        let mut out = Vec::new();
        make.map_or(Ok(()), |make| make(&mut out))?;
        Ok(out)
    }
}

/// Writes into the channel.
struct Chunks(Sender<std::io::Result<Bytes>>);

impl Write for Chunks {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let gone = |_| std::io::Error::from(std::io::ErrorKind::BrokenPipe);
        self.0.blocking_send(Ok(Bytes::copy_from_slice(bytes))).map_err(gone)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

struct Chunked(Receiver<std::io::Result<Bytes>>);

impl HttpBody for Chunked {
    type Data = Bytes;
    type Error = std::io::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<std::io::Result<Frame<Bytes>>>> {
        self.0.poll_recv(context).map(|chunk| chunk.map(|c| c.map(Frame::data)))
    }
}
