//! Errors of the image in QEMU.

use std::io;
use std::path::PathBuf;
use std::process::ExitStatus;
use std::sync::Arc;

use sinew_firmware::supervisor::Command;
use sinew_link::message::Refusal;
use thiserror::Error;

/// An error of the image in QEMU: it does not play, or it plays something else.
#[derive(Debug, Clone, Error)]
#[non_exhaustive]
pub enum QemuError {
    /// There is no image.
    #[error(
        "{}: there is no image of the node. `cargo xtask node` builds it, and names it in {variable}",
        path.display()
    )]
    NoImage {
        /// Where it should be.
        path: PathBuf,
        /// The variable that names one.
        variable: &'static str,
    },
    /// There is no emulator.
    #[error("qemu-system-arm cannot be started ({0}): `cargo xtask setup` installs it")]
    NoQemu(#[source] Arc<io::Error>),
    /// The emulator has ended.
    #[error("QEMU has ended ({}): what it said stands above", status.map_or_else(|| "still there".to_owned(), |of| of.to_string()))]
    Left {
        /// How.
        status: Option<ExitStatus>,
    },
    /// It runs, and says nothing.
    #[error(
        "the image in QEMU says nothing more: is it of this version? `cargo xtask node` builds it anew ({image} names \
         another one)"
    )]
    Silent {
        /// The variable that names an image.
        image: &'static str,
    },
    /// What the image says is no message.
    #[error("the image is of another version of Sinew: `cargo xtask node` builds it anew")]
    Version,
    /// The node does not answer.
    #[error("the node in QEMU gives no answer to {0}")]
    NoAnswer(&'static str),
    /// It refuses what it is given.
    #[error("the node in QEMU refuses the {what}: {refusal}")]
    Refused {
        /// What.
        what: &'static str,
        /// Why.
        refusal: Refusal,
    },
    /// The rig is too large for the image.
    #[error("the rig has {found} {what}, the image in QEMU holds {holds}")]
    Holds {
        /// Of what it has too many.
        what: &'static str,
        /// How many it has.
        found: usize,
        /// How many there may be.
        holds: usize,
    },
    /// The rig cannot be wired to a board.
    #[error("the rig cannot be wired to the node in QEMU: {0}")]
    Wiring(String),
    /// A servo takes pulses.
    #[error("servo `{0}` takes pulses: the image was tried with serial lines alone")]
    Pulses(String),
    /// The node took the rig, and has no loop.
    #[error("the node in QEMU took the rig, and its controller refuses it")]
    NoLoop,
    /// A command that no message of the link carries.
    #[error("the command {0:?} cannot be sent over the link: it has no message for it")]
    Command(Command),
    /// Image and process differ.
    #[error(
        "tick {tick}: {what} of the image in QEMU are not those in process. Is it of this version? `cargo xtask node` \
         builds it anew ({image} names another one)"
    )]
    Differs {
        /// In which tick.
        tick: u64,
        /// What.
        what: &'static str,
        /// The variable that names an image.
        image: &'static str,
    },
}
