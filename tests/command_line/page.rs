//! The page's server under attempts to get at the rig: from other sites of the same browser, from other machines, from
//! programs of this one.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread;
use std::time::{Duration, Instant};

use shared::control::{Command, Mode, State};
use shared::link::{LinkAct, LinkAnswer, Refusal, ToBoard};
use shared::model::params::BEAM_150;
use shared::settings::Settings;

use crate::boards::{Emulator, Toy, still, toy};
use crate::page_rig::{PAGE, Served};
use crate::support::Folder;

const UPGRADE: &str = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AQIDBAUGBwgJCgsMDQ4PEA==\r\n";

#[test]
fn the_page_comes_with_what_keeps_it_to_itself() {
    let folder = Folder::new();
    let board = still();
    let served = Served::start(&folder, &board.path);
    let host = format!("Host: {}\r\n", served.host);
    let (status, answer) = served.ask(&format!("GET {}", served.path("")), &host);
    assert_eq!(status, 200, "{answer}");
    let (head, body) = answer.split_once("\r\n\r\n").expect("a head");
    assert_eq!(body, PAGE);
    for header in [
        "Content-Security-Policy: default-src 'none'; script-src 'sha256-",
        "frame-ancestors 'none'",
        "X-Frame-Options: DENY",
        "X-Content-Type-Options: nosniff",
        "Referrer-Policy: no-referrer",
        "Cache-Control: no-store",
        "Cross-Origin-Resource-Policy: same-origin",
        "Content-Type: text/html; charset=utf-8",
    ] {
        assert!(head.contains(header), "{header} is not in {head}");
    }
    // Nobody else may read it: no header of CORS.
    assert!(!head.to_lowercase().contains("access-control"), "{head}");
    let (status, answer) = served.ask(&format!("GET {}", served.path("board")), &host);
    assert_eq!(status, 200);
    assert!(
        answer.contains(&format!("\"board\":\"{}\"", board.path)),
        "{answer}"
    );
}

#[test]
fn strangers_get_nothing() {
    let folder = Folder::new();
    let board = still();
    let served = Served::start(&folder, &board.path);
    let page = format!("GET {}", served.path(""));
    let wire = format!("GET {}", served.path("wire"));
    let host = format!("Host: {}\r\n", served.host);
    let own = format!("Origin: http://{}\r\n", served.host);
    let port = served.host.rsplit(':').next().expect("a port");
    let rebound = format!("Host: rebound.example:{port}\r\n");
    let attempts = [
        // A name of another site that was made to lead here.
        (&page, rebound.clone(), 403),
        (
            &wire,
            format!("{rebound}Origin: http://rebound.example:{port}\r\n{UPGRADE}"),
            403,
        ),
        (&page, String::new(), 403),
        (&page, format!("{host}{host}"), 400),
        // A page of another site, or of another port, in the same browser.
        (
            &wire,
            format!("{host}Origin: https://site.example\r\n{UPGRADE}"),
            403,
        ),
        (
            &wire,
            format!("{host}Origin: http://127.0.0.1:1\r\n{UPGRADE}"),
            403,
        ),
        (&wire, format!("{host}Origin: null\r\n{UPGRADE}"), 403),
        (
            &wire,
            format!("{host}{own}Sec-Fetch-Site: cross-site\r\n{UPGRADE}"),
            403,
        ),
        (
            &page,
            format!("{host}Origin: https://site.example\r\n"),
            403,
        ),
        // A program that is no browser.
        (&wire, format!("{host}{UPGRADE}"), 403),
        (&wire, format!("{host}{own}"), 426),
        // Without the secret, or with another.
        (&"GET /".to_owned(), host.clone(), 404),
        (
            &"GET /wire".to_owned(),
            format!("{host}{own}{UPGRADE}"),
            404,
        ),
        (
            &format!("GET /{}/wire", "0".repeat(64)),
            format!("{host}{own}{UPGRADE}"),
            404,
        ),
        (&format!("GET {}", served.path("other")), host.clone(), 404),
        (
            &format!("GET {}../../etc/passwd", served.path("")),
            host.clone(),
            404,
        ),
        (&page.replace("GET", "POST"), host.clone(), 405),
        (&page, format!("{host}Content-Length: 5\r\n"), 400),
        (&page, format!("{host}X: {}\r\n", "x".repeat(9000)), 431),
        (&page, format!("{host}{}", "A: b\r\n".repeat(100)), 431),
        (&page.replace('/', &"/".repeat(9000)), host.clone(), 431),
    ];
    for (line, headers, expected) in &attempts {
        let (status, answer) = served.ask(line, headers);
        let short = &headers[..headers.len().min(200)];
        assert_eq!(status, *expected, "{short} {answer}");
        assert!(
            !answer.contains(PAGE) && !answer.contains(&served.secret),
            "{answer}"
        );
    }
    assert_eq!(served.send(b"\x16\x03\x01\x02\x00\r\n\r\n").0, 400);
    assert_eq!(served.send(&[0; 100_000]).0, 431);
    // After all that it serves who may.
    assert_eq!(served.ask(&page, &host).0, 200);
    assert_eq!(
        served.page().client.status().expect("a status").state,
        State::Idle
    );
}

#[test]
fn other_addresses_of_this_machine_are_not_listened_to() {
    let folder = Folder::new();
    let board = still();
    let served = Served::start(&folder, &board.path);
    let port = served.host.rsplit(':').next().expect("a port");
    // The address by which this machine is known to others; no packet is sent to find it.
    let outward = std::net::UdpSocket::bind("0.0.0.0:0").and_then(|socket| {
        socket.connect("192.0.2.1:9")?;
        Ok(socket.local_addr()?.ip().to_string())
    });
    let mut tried = vec!["127.0.0.2".to_owned()];
    tried.extend(outward);
    for address in tried {
        let open = TcpStream::connect(format!("{address}:{port}"));
        assert!(open.is_err(), "{address} answers");
    }
    assert!(served.host.starts_with("127.0.0.1:"));
}

/// Connections that say nothing, little, or half of it.
#[test]
fn slow_and_half_open_connections_go_away_by_themselves() {
    let folder = Folder::new();
    let board = still();
    let served = Served::start(&folder, &board.path);
    let mut page = served.page();
    let every = ToBoard::StreamTelemetry { decimation: 200 };
    page.client.tell(every).expect("it streams");
    let began = Instant::now();
    let head = format!(
        "GET {} HTTP/1.1\r\nHost: {}\r\n",
        served.path(""),
        served.host
    );
    let mut slow: Vec<TcpStream> = (0..100).map(|_| served.connect()).collect();
    for (number, stream) in slow.iter_mut().enumerate() {
        if number % 2 == 0 {
            stream.write_all(head.as_bytes()).ok();
        }
    }
    let mut longest = Duration::ZERO;
    while began.elapsed() < Duration::from_secs(6) {
        for stream in &mut slow {
            stream.write_all(b"a").ok();
        }
        let asked = Instant::now();
        page.client.status().expect("a status");
        longest = longest.max(asked.elapsed());
        thread::sleep(Duration::from_millis(200));
    }
    // Else the drive of a page that commands would have been stopped for its silence.
    assert!(longest < Duration::from_secs(2), "{longest:?}");
    println!("longest answer beside a hundred of them: {longest:?}");
    // All of them have been sent away, with or without an answer.
    for stream in &mut slow {
        let mut rest = Vec::new();
        let ended = stream.read_to_end(&mut rest);
        let timeout = ended
            .as_ref()
            .is_err_and(|e| e.kind() == std::io::ErrorKind::WouldBlock);
        assert!(!timeout, "still open after {:?}", began.elapsed());
    }
    assert!(
        began.elapsed() < Duration::from_secs(10),
        "{:?}",
        began.elapsed()
    );
    let host = format!("Host: {}\r\n", served.host);
    assert_eq!(
        served.ask(&format!("GET {}", served.path("")), &host).0,
        200
    );
}

#[test]
fn one_page_commands_and_the_others_watch() {
    let folder = Folder::new();
    let board = still();
    let served = Served::start(&folder, &board.path);
    let mut one = served.page();
    let mut other = served.page();
    // Nobody has taken the command yet: a page that only connects cannot steer.
    let asked = one
        .client
        .open_session(true)
        .expect_err("it does not command");
    assert!(asked.to_string().contains("no longer steers"), "{asked}");
    one.command("take");
    let commander = one.number();
    let seat = other.told("seat", |seat| seat["commander"] == commander);
    assert_eq!(seat["pages"], 2);
    // A watcher that does not know its place: refused by the server, whatever it says.
    other.say("take");
    let refused = other.client.open_session(true).expect_err("it watches");
    assert!(
        refused.to_string().contains("another program steers"),
        "{refused}"
    );
    let settings = Settings::for_rig(&BEAM_150);
    for act in [
        LinkAct::Command(Command::Start(Mode::Automatic)),
        LinkAct::SetSettings(settings),
        LinkAct::Release,
    ] {
        for session in [0, 1, u32::MAX] {
            let steer = ToBoard::Steer {
                session,
                number: 1,
                act,
            };
            let answer = other.client.ask(steer).expect("an answer");
            assert_eq!(answer, LinkAnswer::Refused(Refusal::SomebodySteers));
        }
    }
    let start = ToBoard::Command(Command::Start(Mode::Automatic));
    let answer = other.client.ask(start).expect("an answer");
    assert_eq!(answer, LinkAnswer::Refused(Refusal::NoSession));
    let unchanged = other.client.ask(ToBoard::GetSettings).expect("an answer");
    assert_ne!(unchanged, LinkAnswer::Settings(settings));
    // It may look, and stop.
    assert_eq!(other.client.status().expect("a status").state, State::Idle);
    other.client.command(Command::Stop).expect("anybody may");
    // A hello of one ends no stream of the other.
    let every = ToBoard::StreamTelemetry { decimation: 200 };
    one.client.tell(every).expect("it streams");
    other.client.hello().expect("a hello");
    let streamed = one
        .client
        .streamed(Duration::from_secs(2))
        .expect("it streams");
    assert!(streamed.is_some());
    one.client
        .steer(LinkAct::SetSettings(settings))
        .expect("it commands");
}

#[test]
fn a_board_that_is_gone_is_told_and_nobody_commands_it() {
    let folder = Folder::new();
    let emulator = Emulator::start(&folder, "field");
    let served = Served::start(&folder, &emulator.1);
    let mut page = served.page();
    page.told("board", |board| board["up"] == true);
    page.command("take");
    drop(emulator);
    let lost = page.told("board", |board| board["up"] == false);
    let why = lost["why"].as_str().expect("words");
    assert!(why.contains("check the cable"), "{why}");
    page.told("seat", |seat| seat["commander"].is_null());
}

/// The cable is there, and nothing comes.
#[test]
fn a_board_that_is_silent_is_told() {
    let folder = Folder::new();
    let board = toy(Toy::new());
    let served = Served::start(&folder, &board.path);
    let mut page = served.page();
    page.told("board", |board| board["up"] == true);
    drop(board);
    let silent = page.told("board", |board| board["up"] == false);
    let why = silent["why"].as_str().expect("words");
    assert!(
        why.contains("silent") || why.contains("check the cable"),
        "{why}"
    );
}

#[test]
fn without_a_board_there_is_the_page_and_no_wire() {
    let folder = Folder::new().with("page.html", PAGE);
    let served = Served::run(folder.command(&["lab", "--no-open", "--page-file", "page.html"]));
    let host = format!("Host: {}\r\n", served.host);
    let own = format!("Origin: http://{}\r\n", served.host);
    let ask = |what: &str, rest: &str| {
        served.ask(
            &format!("GET {}", served.path(what)),
            &format!("{host}{rest}"),
        )
    };
    assert_eq!(ask("", "").0, 200);
    assert!(ask("board", "").1.contains("\"board\":null"));
    assert_eq!(ask("wire", &format!("{own}{UPGRADE}")).0, 404);
}

#[test]
fn what_cannot_be_served_is_told_in_one_line() {
    let folder = Folder::new().with("page.html", PAGE);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("its number").port();
    for (line, words) in [
        (
            format!("lab --no-open --page-file page.html --port {port}"),
            "cannot listen at 127.0.0.1:",
        ),
        (
            "lab --no-open --page-file none.html".to_owned(),
            "cargo xtask web",
        ),
        (
            "link /dev/no-such-port --page --no-open --page-file page.html".to_owned(),
            "cannot open /dev/no-such-port",
        ),
        ("link /dev/x --page status".to_owned(), "do not go together"),
        ("link /dev/x".to_owned(), "link /dev/x --page"),
        ("link /dev/x --no-open status".to_owned(), "--page"),
    ] {
        let ran = folder.run(&line);
        assert_eq!((ran.code, ran.out.as_str()), (Some(2), ""), "{ran:?}");
        assert_eq!(ran.err.trim_end().lines().count(), 1, "{ran:?}");
        assert!(ran.err.contains(words), "{ran:?}");
    }
    if !cfg!(feature = "page") {
        let ran = folder.run("lab --no-open");
        assert_eq!(ran.code, Some(2));
        assert!(ran.err.contains("built without the page") && ran.err.contains("cargo xtask lab"));
    }
}
