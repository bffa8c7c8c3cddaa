//! The head of an HTTP request, bounded in length and time.

use std::io::{ErrorKind, Read};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Longest head of a request that is read, bytes.
pub const MAX_HEAD: usize = 8 * 1024;

/// Most header lines of a request.
const MAX_HEADERS: usize = 64;

/// Longest time from the connection to the end of the head.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// Why there is no request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bad {
    /// It did not come in time, or the connection ended.
    Late,
    /// It is longer than [`MAX_HEAD`], or has too many lines.
    TooLong,
    /// It is not a request as a browser sends it.
    Malformed,
}

/// What the server looks at.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HttpRequest {
    /// The method as sent; only `GET` is let in.
    pub method: String,
    /// Path and query, as sent.
    pub target: String,
    /// Names in lower case, and values.
    headers: Vec<(String, String)>,
}

impl HttpRequest {
    /// The value of a header; none if it is missing.
    pub fn header(&self, name: &str) -> Option<&str> {
        let found = self.headers.iter().find(|(known, _)| known == name);
        found.map(|(_, value)| value.as_str())
    }

    /// Whether a header with values between commas has this one.
    pub fn lists(&self, name: &str, value: &str) -> bool {
        let list = self.header(name).unwrap_or_default();
        list.split(',')
            .any(|v| v.trim().eq_ignore_ascii_case(value))
    }

    /// From the bytes of a head.
    pub fn parse(head: &[u8]) -> Result<Self, Bad> {
        let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
        let mut parsed = httparse::Request::new(&mut headers);
        match parsed.parse(head) {
            Ok(httparse::Status::Complete(length)) if length == head.len() => {}
            Err(httparse::Error::TooManyHeaders) => return Err(Bad::TooLong),
            _ => return Err(Bad::Malformed),
        }
        let mut request = Self {
            method: parsed.method.unwrap_or_default().to_owned(),
            target: parsed.path.unwrap_or_default().to_owned(),
            headers: Vec::new(),
        };
        for header in parsed.headers.iter() {
            let name = header.name.to_ascii_lowercase();
            let value = str::from_utf8(header.value).map_err(|_| Bad::Malformed)?;
            // Two of them would leave open which one counts.
            if request.header(&name).is_some() || name == "transfer-encoding" {
                return Err(Bad::Malformed);
            }
            request.headers.push((name, value.trim().to_owned()));
        }
        match request.header("content-length") {
            None | Some("0") => Ok(request),
            Some(_) => Err(Bad::Malformed),
        }
    }
}

/// Reads a head.
///
/// # Errors
/// If none comes within `patience`, or it is too long or malformed.
pub fn read(stream: &mut TcpStream, patience: Duration) -> Result<HttpRequest, Bad> {
    let until = Instant::now() + patience;
    let mut head = Vec::new();
    let mut bytes = [0; 1024];
    loop {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
            return Err(Bad::Late);
        }
        let count = match stream.read(&mut bytes) {
            Ok(0) => return Err(Bad::Late),
            Ok(count) => count,
            Err(e) if e.kind() == ErrorKind::Interrupted => continue,
            Err(_) => return Err(Bad::Late),
        };
        // The end may lie across two reads.
        let looked = head.len().saturating_sub(3);
        head.extend_from_slice(&bytes[..count]);
        if head.len() > MAX_HEAD {
            return Err(Bad::TooLong);
        }
        if head[looked..].windows(4).any(|four| four == b"\r\n\r\n") {
            return HttpRequest::parse(&head);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(head: &str) -> Result<HttpRequest, Bad> {
        HttpRequest::parse(head.as_bytes())
    }

    #[test]
    fn a_browsers_request_is_read() {
        let request =
            parse("GET /a/ HTTP/1.1\r\nHost: x:1\r\nConnection: keep-alive, Upgrade\r\n\r\n")
                .expect("a request");
        assert_eq!(
            (request.method.as_str(), request.target.as_str()),
            ("GET", "/a/")
        );
        assert_eq!(request.header("host"), Some("x:1"));
        assert_eq!(request.header("origin"), None);
        assert!(request.lists("connection", "upgrade") && !request.lists("connection", "up"));
    }

    #[test]
    fn what_could_be_read_in_two_ways_is_refused() {
        for rest in [
            "Host: a\r\nHost: b\r\n",
            "Host: a\r\nContent-Length: 4\r\n",
            "Host: a\r\nTransfer-Encoding: chunked\r\n",
            "Host : a\r\n",
            "Host: \u{7f}\r\n",
        ] {
            let read = parse(&format!("GET / HTTP/1.1\r\n{rest}\r\n"));
            assert_eq!(read, Err(Bad::Malformed), "{rest:?}");
        }
        assert_eq!(parse("GET / HTTP/1.1\r\n\r\nmore"), Err(Bad::Malformed));
        assert_eq!(parse("\u{16}\u{3}\u{1}\r\n\r\n"), Err(Bad::Malformed));
        let many = "A: b\r\n".repeat(MAX_HEADERS + 1);
        assert_eq!(
            parse(&format!("GET / HTTP/1.1\r\n{many}\r\n")),
            Err(Bad::TooLong)
        );
    }
}
