//! What a browser may do with the page.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use sha2::{Digest, Sha256};

/// The check sums of the page's own scripts: nothing else in it may run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Policy(String);

impl Policy {
    /// For a page whose scripts stand in it.
    pub fn of(page: &[u8]) -> Self {
        let mut sources = String::new();
        for script in scripts(page) {
            let sum = BASE64_STANDARD.encode(Sha256::digest(script));
            // Writing to a string does not fail.
            let _ = write!(sources, "'sha256-{sum}' ");
        }
        Self(sources)
    }

    /// The value of `Content-Security-Policy`, for a page at `host`: its own scripts and workers, WebAssembly, its own
    /// styles and pictures, and no connection but to this server.
    pub fn header(&self, host: &str) -> String {
        let scripts = &self.0;
        format!(
            "default-src 'none'; script-src {scripts}'wasm-unsafe-eval' blob:; worker-src blob:; style-src 'unsafe-inline'; \
             img-src data: blob:; font-src data:; connect-src 'self' ws://{host} blob: data:; base-uri 'none'; form-action 'none'; \
             frame-ancestors 'none'"
        )
    }
}

/// What stands between `<script …>` and `</script`, as a browser reads it.
fn scripts(page: &[u8]) -> Vec<&[u8]> {
    let mut found = Vec::new();
    let mut rest = page;
    while let Some(begin) = position(rest, b"<script") {
        rest = &rest[begin..];
        let Some(open) = rest.iter().position(|byte| *byte == b'>') else {
            break;
        };
        rest = &rest[open + 1..];
        let Some(end) = position(rest, b"</script") else {
            break;
        };
        found.push(&rest[..end]);
        rest = &rest[end..];
    }
    found
}

/// Where `what` stands, in letters of any case.
fn position(bytes: &[u8], what: &[u8]) -> Option<usize> {
    bytes
        .windows(what.len())
        .position(|window| window.eq_ignore_ascii_case(what))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scripts_of_the_page_may_run_and_no_other() {
        let page =
            b"<p>x</p><script type=\"module\">let a = '<script>';</SCRIPT ><script>b</script>";
        let found = scripts(page);
        assert_eq!(found, [&b"let a = '<script>';"[..], &b"b"[..]]);
        let header = Policy::of(page).header("127.0.0.1:1");
        // Of "b", by sha256sum and base64.
        assert!(
            header.contains("'sha256-PiPoFgA5WUoziU9lZOGxNIu9egCI1CxKy3PurtWcAJ0='"),
            "{header}"
        );
        assert!(!header.contains("'unsafe-inline' 'wasm"), "{header}");
        assert!(header.contains("frame-ancestors 'none'") && header.contains("default-src 'none'"));
    }

    #[test]
    fn a_page_without_scripts_has_none() {
        assert_eq!(scripts(b"<p>no</p><scrip"), Vec::<&[u8]>::new());
        assert_eq!(scripts(b"<script>cut off"), Vec::<&[u8]>::new());
    }
}
