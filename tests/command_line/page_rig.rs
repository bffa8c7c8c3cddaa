//! A rig that is driven by real code all the way, a server before it, and browsers that are not there.

use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use emulator::record::{RunObserver, TickRow};
use emulator::run::run as emulate;
use emulator::scenario;
use files::UserError;
use host_sim::link::Client;
use host_sim::link::live::{self, Pace};
use serde_json::Value;
use serialport::SerialPort;
use shared::control::{Command, Mode, State};
use shared::fault::Fault;
use tungstenite::handshake::client::generate_key;
use tungstenite::http::Request;
use tungstenite::{Error, Message, WebSocket};

use crate::support::{Folder, finish};

/// Ticks of the plant per second of its time.
pub const TICKS_PER_S: u64 = 20_000;

/// What is true of the plant, tick by tick.
#[derive(Debug, Default)]
pub struct Truth {
    tick: AtomicU64,
    /// The last tick in which the drive had power.
    powered: AtomicU64,
}

impl Truth {
    /// Where the plant's time is.
    pub fn tick(&self) -> u64 {
        self.tick.load(Ordering::SeqCst)
    }

    /// Whether the drive had power in the last tick.
    pub fn is_powered(&self) -> bool {
        self.powered.load(Ordering::SeqCst) == self.tick()
    }

    /// Waits until the drive has had no power for half a second of the plant's time; how long after the tick `since` it went
    /// off, s of the plant's time.
    pub fn off_after(&self, since: u64) -> f64 {
        let began = Instant::now();
        loop {
            let last = self.powered.load(Ordering::SeqCst);
            if self.tick() > last.max(since) + TICKS_PER_S / 2 {
                return last.saturating_sub(since) as f64 / TICKS_PER_S as f64;
            }
            assert!(
                began.elapsed() < Duration::from_secs(60),
                "the drive stays on"
            );
            thread::sleep(Duration::from_millis(5));
        }
    }
}

struct Watch(Arc<Truth>);

impl RunObserver for Watch {
    fn tick(&mut self, row: &TickRow) {
        if row.powered {
            self.0.powered.store(row.tick, Ordering::SeqCst);
        }
        self.0.tick.store(row.tick, Ordering::SeqCst);
    }
}

/// An emulated rig with its board, in real time; it ends with the test program.
pub struct Rig {
    /// Path of the pseudo-terminal at which the board answers.
    pub path: String,
    pub truth: Arc<Truth>,
}

impl Rig {
    /// With the board's watch over the link set to so long.
    pub fn start(link_timeout_s: f32) -> Self {
        let mut scenario = scenario::load("field").expect("a scenario");
        scenario.events.clear();
        scenario.duration_s = 300.0;
        scenario.settings.trips.link_timeout_s = link_timeout_s;
        let board = live::board(&scenario.settings, 10);
        let (mut board, far_end) = board.expect("a pseudo-terminal");
        let path = far_end.name().expect("it has a name");
        let truth = Arc::new(Truth::default());
        let mut watch = (Watch(Arc::clone(&truth)), Pace::new(1.0));
        thread::spawn(move || {
            let done = emulate(&scenario, &mut board, &mut watch).map(|_| ());
            drop(far_end);
            done
        });
        Self { path, truth }
    }
}

/// `host-sim link PORT --page`.
pub struct Served {
    child: Option<Child>,
    /// Host and port of the server: `127.0.0.1:PORT`.
    pub host: String,
    pub secret: String,
}

impl Served {
    /// Starts it and waits for its address.
    pub fn start(folder: &Folder, port: &str) -> Self {
        std::fs::write(folder.path("page.html"), PAGE).expect("it is written");
        let words = [
            "link",
            port,
            "--page",
            "--no-open",
            "--page-file",
            "page.html",
        ];
        Self::run(folder.command(&words))
    }

    /// Runs a command that prints the address of a page.
    pub fn run(mut command: std::process::Command) -> Self {
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        let out = child.stdout.take().expect("it is piped");
        let mut address = String::new();
        BufReader::new(out)
            .read_line(&mut address)
            .expect("an address");
        let rest = address.trim().strip_prefix("http://").expect("an address");
        let (host, secret) = rest
            .trim_end_matches('/')
            .split_once('/')
            .expect("a secret");
        Self {
            child: Some(child),
            host: host.to_owned(),
            secret: secret.to_owned(),
        }
    }

    /// Sends what a browser would, with the headers given. Returns the status, and the whole answer.
    pub fn ask(&self, line: &str, headers: &str) -> (u16, String) {
        self.send(format!("{line} HTTP/1.1\r\n{headers}\r\n").as_bytes())
    }

    /// Sends bytes. Returns the status, 0 if there is none, and the whole answer.
    pub fn send(&self, bytes: &[u8]) -> (u16, String) {
        let mut stream = self.connect();
        // The server may have refused what it has read so far.
        let _ = stream.write_all(bytes);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let status = answer.get(9..12).and_then(|s| s.parse().ok());
        (status.unwrap_or(0), answer)
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).expect("it listens");
        let patience = Some(Duration::from_secs(20));
        stream.set_read_timeout(patience).expect("a timeout");
        stream
    }

    /// The path of something of the page.
    pub fn path(&self, what: &str) -> String {
        format!("/{}/{what}", self.secret)
    }

    /// A page in a browser.
    pub fn page(&self) -> Page {
        let request = Request::builder()
            .uri(format!("ws://{}{}", self.host, self.path("wire")))
            .header("Host", &self.host)
            .header("Origin", format!("http://{}", self.host))
            .header("Sec-Fetch-Site", "same-origin")
            .header("Connection", "keep-alive, Upgrade")
            .header("Upgrade", "websocket")
            .header("Sec-WebSocket-Version", "13")
            .header("Sec-WebSocket-Key", generate_key())
            .body(())
            .expect("a request");
        let (socket, _) = tungstenite::client(request, self.connect()).expect("it is let in");
        Page::new(socket)
    }

    /// Ends it as `kill -SIGNAL` does, and waits for it.
    pub fn kill(&mut self, signal: &str) -> Option<i32> {
        let child = self.child.take().expect("it runs");
        let mut kill = std::process::Command::new("kill");
        kill.args([signal, &child.id().to_string()]);
        assert_eq!(finish(kill).code, Some(0));
        crate::support::wait(child).code()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// A page, as the tests serve it.
pub const PAGE: &str = "<!doctype html><title>page</title><script>let page = 1;</script>";

/// What a script of a page can do: send and receive.
#[derive(Debug)]
pub struct Wire {
    socket: WebSocket<TcpStream>,
    bytes: VecDeque<u8>,
    words: Arc<Mutex<Vec<Value>>>,
    /// Whether it reads at all.
    reads: Arc<AtomicBool>,
}

impl Wire {
    /// Reads one message, if it comes soon.
    fn listen(&mut self) -> io::Result<()> {
        if !self.reads.load(Ordering::SeqCst) {
            thread::sleep(Duration::from_millis(5));
            return Ok(());
        }
        match self.socket.read() {
            Ok(Message::Binary(bytes)) => self.bytes.extend(bytes),
            Ok(Message::Text(text)) => {
                let words = serde_json::from_str(text.as_str()).expect("JSON");
                self.words.lock().expect("whole").push(words);
            }
            Ok(_) => {}
            Err(Error::Io(e)) if is_patience(&e) => {}
            Err(Error::Io(e)) => return Err(e),
            Err(_) => return Err(io::ErrorKind::ConnectionAborted.into()),
        }
        Ok(())
    }

    pub fn say(&mut self, act: &str) {
        let words = format!(r#"{{"act":"{act}"}}"#);
        self.socket
            .send(Message::Text(words.into()))
            .expect("it is sent");
    }
}

fn is_patience(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock
    )
}

impl Read for Wire {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.bytes.is_empty() {
            self.listen()?;
        }
        match self.bytes.read(out)? {
            0 => Err(io::ErrorKind::TimedOut.into()),
            count => Ok(count),
        }
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let message = Message::Binary(bytes.to_vec().into());
        match self.socket.send(message) {
            Ok(()) => Ok(bytes.len()),
            Err(_) => Err(io::ErrorKind::ConnectionAborted.into()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A page with the program's own client of the protocol in it.
pub struct Page {
    pub client: Client<Wire>,
    words: Arc<Mutex<Vec<Value>>>,
    pub reads: Arc<AtomicBool>,
}

impl Page {
    fn new(socket: WebSocket<TcpStream>) -> Self {
        let patience = Some(Duration::from_millis(5));
        let stream = socket.get_ref();
        stream.set_read_timeout(patience).expect("a timeout");
        let words = Arc::default();
        let reads = Arc::new(AtomicBool::new(true));
        let wire = Wire {
            socket,
            bytes: VecDeque::new(),
            words: Arc::clone(&words),
            reads: Arc::clone(&reads),
        };
        let mut client = Client::new(wire, "page");
        client.hello().expect("the board's name");
        Self {
            client,
            words,
            reads,
        }
    }

    /// Says an act to the server.
    pub fn say(&mut self, act: &str) {
        self.client.port().say(act);
    }

    /// The last notice of a kind, once there is one that is as wanted.
    pub fn told(&mut self, kind: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            let words = self.words.lock().expect("whole").clone();
            let last = words.iter().rfind(|words| words["kind"] == kind);
            if let Some(last) = last.filter(|last| wanted(last)) {
                return last.clone();
            }
            assert!(
                began.elapsed() < Duration::from_secs(20),
                "{kind} in {words:?}"
            );
            self.client.port().listen().expect("a connection");
        }
    }

    /// The number of this page.
    pub fn number(&mut self) -> u64 {
        let welcome = self.told("welcome", |_| true);
        welcome["page"].as_u64().expect("a number")
    }

    /// Takes the command and opens the board's session.
    pub fn command(&mut self, act: &str) {
        let number = self.number();
        self.say(act);
        self.told("seat", |seat| seat["commander"] == number);
        self.client.open_session(true).expect("a session");
    }

    /// Starts the drive by hand and waits until it moves the cart, by what is true.
    pub fn drive(&mut self, truth: &Truth) {
        self.try_drive(truth).expect("it drives");
    }

    /// As [`Self::drive`], where an answer of the board may be late: an error then.
    pub fn try_drive(&mut self, truth: &Truth) -> Result<(), UserError> {
        self.command("take");
        self.client.command(Command::Start(Mode::Manual))?;
        let began = Instant::now();
        loop {
            self.client.command(Command::Alive)?;
            let status = self.client.status()?;
            match status.state {
                State::Manual if truth.is_powered() => return Ok(()),
                // A computer with too much to do was not heard in time. The next sign of life ends that, and it is started again.
                State::Fault => {
                    let fault = status.fault.map(|record| record.fault);
                    assert_eq!(fault, Some(Fault::LinkTimeout), "{status:?}");
                }
                State::Idle => self.client.command(Command::Start(Mode::Manual))?,
                _ => {}
            }
            assert!(began.elapsed() < Duration::from_secs(60), "{status:?}");
            thread::sleep(Duration::from_millis(20));
        }
    }
}
