//! The list of boards and the link arguments, for the build scripts of all images and for `cargo xtask`.
//!
//! A board's build script is one line:
//!
//! ```no_run
//! sinew_image::board(&[]);
//! ```
//!
//! # Files
//! - `boards`: the list of boards.
//! - `link`: link arguments.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod boards;
mod link;

pub use boards::{BOARDS, Board, EMULATED};
pub use link::link;

/// Links the image of the board whose build script calls this function, with the linker scripts `scripts` in addition
/// to `link.x`.
///
/// # Panics
/// Panics if the board is not in [`BOARDS`], or has no memory.
pub fn board(scripts: &[&str]) {
    link(Board::named(&link::variable("CARGO_PKG_NAME")), scripts);
}
