//! The console: a page in a browser that shows a rig, moves it and stops it.
//!
//! ```text
//! page ─ WebSocket ─> server (threads) ─┐
//!                                       ├─> Hub (one thread, owns the Board) ─ link ─> node
//! other commands ─ Unix socket ─────────┘
//! ```
//!
//! - [`Console::open`] opens the page's port and makes the token of the address. [`Console::run`] is the hub: it
//!   owns the session with the board until the program is told to end.
//! - [`Scene`] describes the rig for the page.
//! - [`Hosted`] is the hub of a command without pages, such as `sinew play`: other terminals watch and stop its rig.
//!
//! The rules of safety are in `server` (which pages are accepted), `hub/wheel` (which page drives) and `hub/act`
//! (motions that end if their page is closed).
//!
//! # Files
//! - `server/`: listeners, request heads, sockets, and the limits of all of them. `page/`: the files it serves.
//! - `driver`: a program that drives like a page. `message`: text messages between page and hub; `frame`: the state of
//!   the rig as numbers.
//! - `hub/`: the loop, commands, sliders, shows, idle life, uploads, and hubs without pages.
//! - `replay/`: a recording instead of a board. `sounds`: sounds of shows, which pages play.
//! - `scene`: the rig as the page draws it. [`local`]: the Unix socket for commands in other terminals.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod console;
mod driver;
mod frame;
mod hub;
pub mod local;
mod message;
mod page;
mod replay;
mod scene;
mod server;
mod sounds;

pub use console::{Console, Options, execute};
pub use driver::Driver;
pub use hub::{
    BeginRecord, Ended, Hosted, NewRecord, OwnShow, OwnShows, Owner, RECORD_HZ, Records, idle_life,
};
pub use message::PageCommand;
pub use replay::{Replay, ReplayError};
pub use scene::{Scene, Source};
pub use sounds::OwnSound;
