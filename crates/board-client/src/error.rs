//! Errors of a session with a controller.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use sinew_link::message::{Command, Misfit, Refusal, Version};
use sinew_servo_tools::{Protocol, ServiceError};

/// An error of a session with a controller. The message includes the remedy, if it is known.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClientError {
    /// The port cannot be opened.
    #[error(transparent)]
    Port(#[from] ServiceError),
    /// The line has failed.
    #[error(
        "the board's port no longer works: {0}. Was the board unplugged? Without this program its rig holds its pose, \
         and is lowered and limp after 2 s"
    )]
    Line(io::Error),
    /// Nothing answers a greeting.
    #[error(
        "no controller answers. Has the board power, and is it flashed (`sinew board flash`)? `sinew board simulate` is one \
         to try without hardware"
    )]
    NoController,
    /// Servos answer, but no controller.
    #[error(
        "{}: {} servos answer here at {baud} baud, no controller. This is an adapter at the servos: `sinew servo --port` takes it",
        path.display(),
        protocol.name()
    )]
    Servos {
        /// Path of the port.
        path: PathBuf,
        /// Protocol of the servos.
        protocol: Protocol,
        /// Baud rate, bit/s.
        baud: u32,
    },
    /// No port was given, and none has a controller.
    #[error("no controller was found at {0}")]
    NoneFound(String),
    /// No port was given, and several have a controller.
    #[error("several controllers were found: {0}")]
    Several(String),
    /// The controller refuses a session.
    #[error("{0}")]
    Misfit(Misfit),
    /// The controller refused a command.
    #[error("the controller refused: {0}")]
    Refused(Refusal),
    /// No answer arrived.
    #[error("the controller has not answered {0:?}: is the line bad?")]
    NoAnswer(Box<Command>),
    /// No valid message arrived for this time.
    #[error(
        "nothing valid has come from the board for {} s: is the wire from the board broken? It was told to stop, and \
         this program is silent now: the rig goes to its rest pose or holds, and 2 s later it is lowered and limp",
        .0.as_secs_f64()
    )]
    Deaf(Duration),
    /// The board has restarted, or another program has the rig.
    #[error("the session is over: the board has started anew, or another program has it now")]
    SessionOver,
    /// The firmware is too old for a function.
    #[error(
        "this takes version {needs} of the link, the board's firmware speaks {has}: `sinew board flash` brings a newer one"
    )]
    Old {
        /// Version that the function needs.
        needs: Version,
        /// Version that both ends support.
        has: Version,
    },
    /// An answer of the wrong kind arrived.
    #[error("the controller answered {0} with something else")]
    Unexpected(&'static str),
    /// The approver's name is invalid.
    #[error("`{0}`: who approves has a name of 1 to 60 bytes, without control characters")]
    Approver(String),
    /// An operation took too long.
    #[error("{0}")]
    Impatient(String),
}
