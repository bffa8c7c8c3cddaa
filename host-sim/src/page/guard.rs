//! Who is let in.

use super::request::HttpRequest;
use super::secret::Secret;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DoorWanted {
    /// The page as HTML, at the address that was printed.
    Page,
    /// Which board there is.
    Board,
    /// The WebSocket to the board.
    Wire,
}

/// Why somebody is not let in: a status of HTTP and a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TurnedAway(pub u16, pub &'static str);

/// The path is not one of ours, or its secret is not right: the answer is the same.
const NOT_FOUND: TurnedAway = TurnedAway(
    404,
    "not here: open the whole address that host-sim has printed",
);

/// The door of a server at a port.
#[derive(Clone, Debug)]
pub struct Doorkeeper {
    secret: Secret,
    /// What a browser of this machine may call the server.
    hosts: [String; 3],
}

impl Doorkeeper {
    /// For a server that listens at `port`.
    pub fn new(secret: Secret, port: u16) -> Self {
        let hosts = ["127.0.0.1", "[::1]", "localhost"].map(|name| format!("{name}:{port}"));
        Self { secret, hosts }
    }

    /// The address to open in a browser, with the secret.
    pub fn address(&self) -> String {
        let [host, ..] = &self.hosts;
        format!("http://{host}/{}/", self.secret.text())
    }

    /// What the request wants, if it may have it.
    ///
    /// # Errors
    /// Why not.
    pub fn admit(&self, request: &HttpRequest) -> Result<DoorWanted, TurnedAway> {
        let host = request.header("host").unwrap_or_default();
        if !self.hosts.iter().any(|known| known == host) {
            return Err(TurnedAway(
                403,
                "this server answers to its own name only: 127.0.0.1 and its port",
            ));
        }
        let origin = request.header("origin");
        let own = |origin: &str| origin.strip_prefix("http://") == Some(host);
        if !origin.is_none_or(own) {
            return Err(TurnedAway(403, "not for pages of other sites"));
        }
        if request.method != "GET" {
            return Err(TurnedAway(405, "GET only"));
        }
        let path = request.target.strip_prefix('/').unwrap_or_default();
        let (secret, rest) = path.split_once('/').unwrap_or_default();
        // Looked at whatever the rest is.
        if !self.secret.is(secret) {
            return Err(NOT_FOUND);
        }
        let wanted = match rest {
            "" => return Ok(DoorWanted::Page),
            "board" => DoorWanted::Board,
            "wire" => DoorWanted::Wire,
            _ => return Err(NOT_FOUND),
        };
        // Everything but the page is asked for by the page. Old browsers do not say by whom.
        let site = request.header("sec-fetch-site");
        if site.is_some_and(|site| site != "same-origin") {
            return Err(TurnedAway(403, "not for pages of other sites"));
        }
        if wanted == DoorWanted::Wire {
            self.upgrade(request, origin)?;
        }
        Ok(wanted)
    }

    /// A WebSocket, unlike a page, is opened by a script, which has an origin.
    fn upgrade(&self, request: &HttpRequest, origin: Option<&str>) -> Result<(), TurnedAway> {
        if origin.is_none() {
            return Err(TurnedAway(403, "not without an origin"));
        }
        let right = request.lists("upgrade", "websocket")
            && request.lists("connection", "upgrade")
            && request.header("sec-websocket-version") == Some("13")
            && request.header("sec-websocket-key").is_some();
        if right {
            Ok(())
        } else {
            Err(TurnedAway(426, "a WebSocket of version 13 is needed here"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UPGRADE: &str = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AQIDBAUGBwgJCgsMDQ4PEA==\r\n";

    fn status(guard: &Doorkeeper, line: &str, headers: &str) -> u16 {
        let head = format!("{line} HTTP/1.1\r\n{headers}\r\n");
        let request = HttpRequest::parse(head.as_bytes()).expect("a request");
        guard
            .admit(&request)
            .map_or_else(|TurnedAway(status, _)| status, |_| 200)
    }

    #[test]
    fn only_who_has_the_secret_and_is_of_this_origin_is_let_in() {
        let secret = Secret::new().expect("randomness");
        let guard = Doorkeeper::new(secret.clone(), 4000);
        let text = secret.text();
        assert_eq!(guard.address(), format!("http://127.0.0.1:4000/{text}/"));
        let page = format!("GET /{text}/");
        let ask = |line: &str, headers: &str| status(&guard, line, headers);
        for name in ["127.0.0.1", "[::1]", "localhost"] {
            assert_eq!(ask(&page, &format!("Host: {name}:4000\r\n")), 200);
        }
        for host in [
            "",
            "Host: \r\n",
            "Host: 127.0.0.1\r\n",
            "Host: 127.0.0.1:4001\r\n",
            "Host: rebound.example:4000\r\n",
            "Host: 127.0.0.1:4000.rebound.example\r\n",
            "Host: 127.0.0.1:4000@rebound.example\r\n",
        ] {
            assert_eq!(ask(&page, host), 403, "{host}");
        }
        let host = "Host: 127.0.0.1:4000\r\n";
        let wrong = Secret::new().expect("randomness");
        for path in [
            "/".to_owned(),
            "//".to_owned(),
            format!("/{text}"),
            format!("/{text}/other"),
            format!("/{text}/../"),
            format!("/{text}/?x"),
            format!("/{}/", wrong.text()),
            format!("/{}/", &text[..63]),
            format!("/x/{text}/"),
            format!("http://127.0.0.1:4000/{text}/"),
        ] {
            assert_eq!(ask(&format!("GET {path}"), host), 404, "{path}");
        }
        for method in ["POST", "HEAD", "OPTIONS", "PUT"] {
            assert_eq!(ask(&format!("{method} /{text}/"), host), 405, "{method}");
        }
    }

    #[test]
    fn no_page_of_another_site_reads_or_moves_anything() {
        let secret = Secret::new().expect("randomness");
        let guard = Doorkeeper::new(secret.clone(), 4000);
        let line = |what: &str| format!("GET /{}/{what}", secret.text());
        let ask = |what: &str, headers: &str| {
            status(
                &guard,
                &line(what),
                &format!("Host: 127.0.0.1:4000\r\n{headers}"),
            )
        };
        let own = "Origin: http://127.0.0.1:4000\r\n";
        assert_eq!(ask("board", own), 200);
        assert_eq!(ask("wire", &format!("{own}{UPGRADE}")), 200);
        for origin in [
            "https://site.example",
            "null",
            "http://127.0.0.1:4001",
            "https://127.0.0.1:4000",
            "http://localhost:4000",
            "http://127.0.0.1:4000.site.example",
            "file://",
            "",
        ] {
            for what in ["", "board", "wire"] {
                let headers = format!("Origin: {origin}\r\n{UPGRADE}");
                assert_eq!(ask(what, &headers), 403, "{origin} {what}");
            }
        }
        // No origin: not a script of a browser.
        assert_eq!(ask("wire", UPGRADE), 403);
        for site in ["cross-site", "same-site", "none"] {
            let headers = format!("{own}Sec-Fetch-Site: {site}\r\n{UPGRADE}");
            assert_eq!(ask("wire", &headers), 403, "{site}");
            assert_eq!(ask("board", &headers), 403, "{site}");
        }
        assert_eq!(ask("wire", own), 426);
        let old = UPGRADE.replace("13", "8");
        assert_eq!(ask("wire", &format!("{own}{old}")), 426);
    }
}
