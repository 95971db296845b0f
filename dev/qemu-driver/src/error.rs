//! Errors of the image in QEMU.

use std::io;
use std::path::PathBuf;
use std::process::ExitStatus;
use std::sync::Arc;

use sinew_firmware::supervisor::Command;
use sinew_link::message::Refusal;
use thiserror::Error;

/// An error of the image in QEMU: it does not play, or plays differently.
#[derive(Debug, Clone, Error)]
#[non_exhaustive]
pub enum QemuError {
    /// There is no image.
    #[error(
        "{}: there is no image of the node. `cargo xtask node` builds it, and names it in {variable}",
        path.display()
    )]
    NoImage {
        /// Path at which it is expected.
        path: PathBuf,
        /// Name of the environment variable that can name another image.
        variable: &'static str,
    },
    /// QEMU is not installed.
    #[error("qemu-system-arm cannot be started ({0}): `cargo xtask setup` installs it")]
    NoQemu(#[source] Arc<io::Error>),
    /// QEMU has ended.
    #[error("QEMU has ended ({}): its output is above", status.map_or_else(|| "still there".to_owned(), |of| of.to_string()))]
    Left {
        /// Exit status of the process.
        status: Option<ExitStatus>,
    },
    /// QEMU runs, but the image does not answer.
    #[error(
        "the image in QEMU no longer answers: is it of this version? `cargo xtask node` rebuilds it ({image} names \
         another one)"
    )]
    Silent {
        /// The variable that can name another image.
        image: &'static str,
    },
    /// The image's output is not a valid message.
    #[error("the image is of another version of Sinew: `cargo xtask node` rebuilds it")]
    Version,
    /// The node does not answer.
    #[error("the node in QEMU gives no answer to {0}")]
    NoAnswer(&'static str),
    /// The node refuses an upload.
    #[error("the node in QEMU refuses the {what}: {refusal}")]
    Refused {
        /// Name of the refused part.
        what: &'static str,
        /// Reason for the refusal.
        refusal: Refusal,
    },
    /// The rig is too large for the image.
    #[error("the rig has {found} {what}, the image in QEMU holds {holds}")]
    Holds {
        /// Name of the exceeded capacity.
        what: &'static str,
        /// Number in the rig.
        found: usize,
        /// Largest number in the image.
        holds: usize,
    },
    /// The rig cannot be wired to a board.
    #[error("the rig cannot be wired to the node in QEMU: {0}")]
    Wiring(String),
    /// A servo is driven by pulses.
    #[error("servo `{0}` is driven by pulses: the image was tested with serial lines only")]
    Pulses(String),
    /// The node accepted the rig, but its controller refuses it.
    #[error("the node in QEMU took the rig, and its controller refuses it")]
    NoLoop,
    /// The host link has no message for a command.
    #[error("the command {0:?} cannot be sent: the host link has no message for it")]
    Command(Command),
    /// The results of the image and of the controller in this process differ.
    #[error(
        "tick {tick}: {what} of the image in QEMU differ from those in process. Is it of this version? `cargo xtask \
         node` rebuilds it ({image} names another one)"
    )]
    Differs {
        /// Tick of the difference.
        tick: u64,
        /// The quantity that differs.
        what: &'static str,
        /// The variable that can name another image.
        image: &'static str,
    },
}
