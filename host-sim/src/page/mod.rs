//! The page in a browser: a server on this machine's loopback, and a board behind it.
//!
//! | module | what |
//! |---|---|
//! | [`server`] | listens, hands out the page, lets pages in |
//! | `request`, `guard`, `answer` | a request's head; who is let in; what is sent back |
//! | `secret` | the random part of the address |
//! | `policy` | what a browser may do with the page |
//! | `mailbox` | what waits on the way to and from a page, bounded |
//! | `socket` | the WebSocket of a page |
//! | `hub` | many pages, one board: who commands, who gets which stream |
//! | `guest`, `requests`, `rules` | a page in it; whose answer is whose; what a page may not do |
//! | [`bridge`] | the hub at a serial port |
//!
//! ## How a rig is kept safe from a browser
//!
//! Any site that is open in the same browser can send requests to this server, and so can every program on this machine.
//! So a request must name this server as its host (a name that another site has had resolved to loopback is not it), must
//! not come from a page of another origin, and must carry a secret that only the printed address has. Of the pages that
//! are let in, one commands and the others watch: the server, not the page, refuses what a watcher sends. When the page
//! that commands goes or is silent, the server stops the drive at once; and since nobody then renews the board's
//! watch over the link, the drive goes off even if the server itself is gone.

mod answer;
pub mod bridge;
mod guard;
mod guest;
mod hub;
mod mailbox;
mod policy;
mod request;
mod requests;
mod rules;
mod secret;
pub mod server;
mod socket;
