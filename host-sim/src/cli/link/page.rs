//! `host-sim link PORT --page`: the board in a browser.

use std::sync::Arc;

use super::super::{interrupt, lab};
use super::Args;
use crate::link::client;
use crate::page::bridge::{self, Door, Port};
use crate::page::server::{BoardConnection, Site, serve};
use files::UserError;

/// Serves the page with the board at the port, until interrupted.
pub fn run(args: &Args) -> Result<i32, UserError> {
    let built = format!("cargo xtask lab --board {}", args.port);
    let page = lab::page(args.page_file.as_deref(), &built)?;
    let opened = client::open(&args.port, args.baud)?;
    super::say_the_rate(args, opened.baud);
    let door = Arc::new(Door::default());
    let site = Site {
        page,
        board: Some(BoardConnection {
            name: args.port.clone(),
            door: Arc::clone(&door),
        }),
    };
    let address = serve(site, args.page_port)?;
    // A page may command: the drive is stopped before the program ends.
    interrupt::finish_first();
    let _shown = lab::show(&address, args.no_open);
    let port = Port {
        name: args.port.clone(),
        opened,
    };
    bridge::run(&door, port, &interrupt::interrupted);
    Ok(interrupt::CODE)
}
