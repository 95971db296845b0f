//! What all images share, for their build scripts and for `cargo xtask`: the list of boards, the link arguments, and
//! the show that is baked in.
//!
//! A board's build script is one line:
//!
//! ```no_run
//! sinew_image::board(&[]);
//! ```

#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(feature = "bake")]
mod bake;
mod boards;
mod link;

pub use boards::{BOARDS, Baked, Board, EMULATED};
pub use link::link;

/// The build script of the board whose crate this is called for: links the board's image, with `scripts` beside
/// `link.x`, and bakes the show in that `SINEW_SHOW` names, if the board performs one by itself.
///
/// The image takes both with `include!(concat!(env!("OUT_DIR"), "/baked.rs"))`: `SHOW`, and `CAPACITY`, the bodies
/// that the board holds.
///
/// # Panics
/// If the board is not in [`BOARDS`], has no memory, or has no show that it could perform. A board that performs a show
/// by itself needs the feature `bake`.
pub fn board(scripts: &[&str]) {
    let board = Board::named(&link::variable("CARGO_PKG_NAME"));
    if link(board, scripts)
        && let Some(baked) = board.baked
    {
        #[cfg(feature = "bake")]
        bake::bake(board.name, baked.bodies);
        #[cfg(not(feature = "bake"))]
        panic!("{}, of {} bodies, needs the feature `bake`", board.name, baked.bodies);
    }
}
