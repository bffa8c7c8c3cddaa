//! `host-sim lab`: the page in a browser; and what `host-sim link PORT --page` shares with it.

use std::borrow::Cow;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use tempfile::NamedTempFile;

use super::interrupt;
use super::terminal::{print, say};
use crate::page::server::{Site, serve};
use files::UserError;

/// The page that is part of the program.
#[cfg(feature = "page")]
const PAGE: Option<&[u8]> = Some(include_bytes!("../../../target/web/index.html"));
#[cfg(not(feature = "page"))]
const PAGE: Option<&[u8]> = None;

/// Open the page in a browser: explore a rig, run an emulated one, watch a board
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  host-sim lab\n  host-sim lab --port 8420 --no-open\n\nThe page of a board: host-sim link PORT --page"
)]
pub struct Args {
    /// Port of this machine's loopback to serve at [default: any that is free]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,

    /// Print the address only; open no browser
    #[arg(long)]
    no_open: bool,

    /// Serve this file in place of the page in the program
    #[arg(long, value_name = "FILE", hide = true)]
    page_file: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<i32, UserError> {
    let site = Site {
        page: page(args.page_file.as_deref(), "cargo xtask lab")?,
        board: None,
    };
    let address = serve(site, args.port)?;
    interrupt::finish_first();
    let _shown = show(&address, args.no_open);
    while !interrupt::interrupted() {
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(interrupt::CODE)
}

/// The page: of a file, or the one in the program.
///
/// # Errors
/// If the file cannot be read, or the program has none; `built` is the command that builds one that has.
pub fn page(file: Option<&Path>, built: &str) -> Result<Cow<'static, [u8]>, UserError> {
    if let Some(path) = file {
        let read = std::fs::read(path).map_err(|e| {
            UserError::new(format!(
                "cannot read {}: {e}; build it: cargo xtask web",
                path.display()
            ))
        });
        return read.map(Cow::Owned);
    }
    PAGE.map(Cow::Borrowed).ok_or_else(|| {
        UserError::new(format!(
            "this program was built without the page; in the project's folder, `{built}` builds it with the page and runs it"
        ))
    })
}

/// Prints the address, and opens it in a browser. What is returned is to be kept until the program ends.
pub fn show(address: &str, no_open: bool) -> Option<NamedTempFile> {
    print(&format!("{address}\n"));
    say(
        "open that address in a browser of this machine; whoever has it can use the page, so do not pass it on. Ctrl-C ends",
    );
    if no_open {
        return None;
    }
    let file = browse(address);
    if file.is_none() {
        say("no browser could be started; open the address yourself");
    }
    file
}

/// Opens the address by a file that only this user can read: on a command line every user of the machine would see it.
fn browse(address: &str) -> Option<NamedTempFile> {
    let mut file = tempfile::Builder::new()
        .prefix("host-sim-")
        .suffix(".html")
        .tempfile()
        .ok()?;
    let lead = format!(
        "<!doctype html><meta charset=\"utf-8\"><title>host-sim</title><meta http-equiv=\"refresh\" content=\"0;url={address}\"><a href=\"{address}\">host-sim</a>\n"
    );
    file.write_all(lead.as_bytes()).ok()?;
    file.flush().ok()?;
    let mut opener = if cfg!(target_os = "macos") {
        Command::new("open")
    } else if cfg!(windows) {
        Command::new("explorer")
    } else {
        Command::new("xdg-open")
    };
    let opener = opener.arg(file.path()).stdin(Stdio::null());
    let started = opener.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    started.is_ok().then_some(file)
}
