//! Listens on loopback, hands out the page and lets pages in.

use std::borrow::Cow;
use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use files::UserError;
use tungstenite::handshake::derive_accept_key;

use super::answer::HttpAnswer;
use super::bridge::Door;
use super::guard::{DoorWanted, Doorkeeper, TurnedAway};
use super::policy::Policy;
use super::request::{self, Bad, HttpRequest};
use super::secret::Secret;
use super::socket;

/// Connections at a time; further ones are closed at once. Those without the secret last for seconds at most.
const MAX_CONNECTIONS: usize = 64;

/// What a browser that was refused may still send, so that it reads the answer before the connection ends.
const LAST_BYTES: usize = 64 * 1024;
const LAST_WAIT: Duration = Duration::from_millis(300);

/// What a browser may do with a refusal.
const NOTHING: &str = "default-src 'none'; frame-ancestors 'none'";

/// What a server has to offer: the page, and a board behind it.
#[derive(Debug)]
pub struct Site {
    /// The page as HTML.
    pub page: Cow<'static, [u8]>,
    /// A board, if there is one.
    pub board: Option<BoardConnection>,
}

/// A board and the way to it.
#[derive(Clone, Debug)]
pub struct BoardConnection {
    /// Name of the board's port.
    pub name: String,
    /// Where pages come in.
    pub door: Arc<Door>,
}

/// A server that runs until the program ends.
#[derive(Debug)]
pub struct PageServer {
    site: Site,
    policy: Policy,
    guard: Doorkeeper,
    connections: AtomicUsize,
}

/// Serves `site` at `port` (0: any that is free) of this machine's loopback. Returns the address to open.
///
/// # Errors
/// If the port is in use, or the system gives no randomness.
pub fn serve(site: Site, port: u16) -> Result<String, UserError> {
    let failed = |e| {
        UserError::new(format!(
            "cannot listen at 127.0.0.1:{port}: {e}; another program may use that port: give another, or none"
        ))
    };
    let listener = listen(Ipv4Addr::LOCALHOST.into(), port).map_err(failed)?;
    let port = listener.local_addr().map_err(failed)?.port();
    let guard = Doorkeeper::new(Secret::new()?, port);
    let address = guard.address();
    let server = Arc::new(PageServer {
        policy: Policy::of(&site.page),
        site,
        guard,
        connections: AtomicUsize::new(0),
    });
    // A machine may have no IPv6; the printed address does without.
    let both = [
        Some(listener),
        listen(Ipv6Addr::LOCALHOST.into(), port).ok(),
    ];
    for listener in both.into_iter().flatten() {
        let server = Arc::clone(&server);
        thread::spawn(move || accept(&server, &listener));
    }
    Ok(address)
}

fn listen(address: IpAddr, port: u16) -> std::io::Result<TcpListener> {
    TcpListener::bind((address, port))
}

fn accept(server: &Arc<PageServer>, listener: &TcpListener) {
    loop {
        let Ok((stream, _)) = listener.accept() else {
            // Out of descriptors for the moment.
            thread::sleep(Duration::from_millis(50));
            continue;
        };
        let present = server.connections.fetch_add(1, Ordering::AcqRel);
        let here = Present(Arc::clone(server));
        if present < MAX_CONNECTIONS {
            let spawned = thread::Builder::new().spawn(move || {
                let server = Arc::clone(&here.0);
                server.connection(stream);
                drop(here);
            });
            // Without a thread the connection ends.
            drop(spawned);
        }
    }
}

/// Counts a connection until it is dropped.
struct Present(Arc<PageServer>);

impl Drop for Present {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::AcqRel);
    }
}

impl PageServer {
    fn connection(&self, mut stream: TcpStream) {
        let request = match request::read(&mut stream, request::PATIENCE) {
            Ok(request) => request,
            Err(why) => {
                let refused = match why {
                    Bad::Late => TurnedAway(408, "too late"),
                    Bad::TooLong => TurnedAway(431, "too long"),
                    Bad::Malformed => TurnedAway(400, "not a request"),
                };
                return Self::refuse(stream, refused);
            }
        };
        // Checked by the guard before anything but a refusal is sent.
        let host = request.header("host").unwrap_or_default();
        match self.guard.admit(&request) {
            Ok(DoorWanted::Page) => {
                self.send(
                    &mut stream,
                    host,
                    "text/html; charset=utf-8",
                    &self.site.page,
                );
            }
            Ok(DoorWanted::Board) => {
                let board = self.site.board.as_ref().map(|board| &board.name);
                let version = env!("CARGO_PKG_VERSION");
                let body = serde_json::json!({ "board": board, "version": version });
                self.send(
                    &mut stream,
                    host,
                    "application/json",
                    body.to_string().as_bytes(),
                );
            }
            Ok(DoorWanted::Wire) => self.wire(stream, &request),
            Err(refused) => Self::refuse(stream, refused),
        }
    }

    fn send(&self, stream: &mut TcpStream, host: &str, kind: &'static str, body: &[u8]) {
        let answer = HttpAnswer {
            status: 200,
            kind,
            body,
        };
        // A browser that goes away needs no answer.
        let _ = answer.send(stream, &self.policy.header(host));
    }

    fn refuse(mut stream: TcpStream, TurnedAway(status, why): TurnedAway) {
        let body = format!("{why}\n");
        let answer = HttpAnswer {
            status,
            kind: "text/plain; charset=utf-8",
            body: body.as_bytes(),
        };
        if answer.send(&mut stream, NOTHING).is_ok() {
            let _ = stream.shutdown(Shutdown::Write);
            read_on(&mut stream);
        }
    }

    /// A page at the board.
    fn wire(&self, mut stream: TcpStream, request: &HttpRequest) {
        let Some(board) = &self.site.board else {
            return Self::refuse(stream, TurnedAway(404, "there is no board here"));
        };
        let Some(mailbox) = board.door.enter() else {
            return Self::refuse(stream, TurnedAway(503, "too many pages; close some"));
        };
        let key = request.header("sec-websocket-key").unwrap_or_default();
        let accept = derive_accept_key(key.as_bytes());
        let head = format!(
            "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: {accept}\r\n\r\n"
        );
        if stream.write_all(head.as_bytes()).is_ok() {
            socket::serve(stream, &mailbox);
        }
        mailbox.leave();
        board.door.leave();
    }
}

/// Reads what is still on the way; a connection that ends with something unread takes its answer with it.
fn read_on(stream: &mut TcpStream) {
    let until = Instant::now() + LAST_WAIT;
    let mut bytes = [0; 4096];
    let mut left = LAST_BYTES;
    let _ = stream.set_read_timeout(Some(LAST_WAIT));
    while left > 0 && Instant::now() < until {
        match stream.read(&mut bytes) {
            Ok(count) if count > 0 => left = left.saturating_sub(count),
            _ => return,
        }
    }
}
