//! What is sent back over HTTP.

use std::io::{self, ErrorKind, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::link::client::is_patience;

/// A browser takes the whole page within this time, or gets no more of it.
const PATIENCE: Duration = Duration::from_secs(20);

/// How long one write may wait.
const WRITE_WAIT: Duration = Duration::from_secs(1);

/// What goes with every answer: no other page may frame it, read it, keep it or learn its address.
const ALWAYS: &str = "X-Frame-Options: DENY\r\n\
     X-Content-Type-Options: nosniff\r\n\
     Referrer-Policy: no-referrer\r\n\
     Cache-Control: no-store\r\n\
     Cross-Origin-Resource-Policy: same-origin\r\n\
     Cross-Origin-Opener-Policy: same-origin\r\n";

/// An answer of HTTP.
#[derive(Clone, Copy, Debug)]
pub struct HttpAnswer<'a> {
    /// Status of HTTP, such as 404.
    pub status: u16,
    /// The type of the body.
    pub kind: &'static str,
    pub body: &'a [u8],
}

impl HttpAnswer<'_> {
    /// Sends it, under a policy for its contents.
    ///
    /// # Errors
    /// If the connection fails or is too slow.
    pub fn send(&self, stream: &mut TcpStream, policy: &str) -> io::Result<()> {
        let Self { status, kind, body } = self;
        let reason = match status {
            200 => "OK",
            400 => "Bad Request",
            403 => "Forbidden",
            404 => "Not Found",
            405 => "Method Not Allowed",
            408 => "Request Timeout",
            426 => "Upgrade Required",
            431 => "Request Header Fields Too Large",
            _ => "Service Unavailable",
        };
        let length = body.len();
        let head = format!(
            "HTTP/1.1 {status} {reason}\r\n{ALWAYS}Content-Security-Policy: {policy}\r\n\
             Content-Type: {kind}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n"
        );
        stream.set_write_timeout(Some(WRITE_WAIT))?;
        let until = Instant::now() + PATIENCE;
        write_until(stream, head.as_bytes(), until)?;
        write_until(stream, body, until)
    }
}

fn write_until(stream: &mut TcpStream, bytes: &[u8], until: Instant) -> io::Result<()> {
    let mut left = bytes;
    while !left.is_empty() {
        if Instant::now() > until {
            return Err(ErrorKind::TimedOut.into());
        }
        match stream.write(left) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(count) => left = &left[count..],
            Err(e) if is_patience(&e) => {}
            Err(e) => return Err(e),
        }
    }
    Ok(())
}
