//! Why something could not be done with a controller.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use sinew_link::message::{Command, Misfit, Refusal, Version};
use sinew_servo_tools::{Protocol, ServiceError};

/// Why something could not be done. Each says what would be right, where that is known.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClientError {
    /// The port cannot be opened.
    #[error(transparent)]
    Port(#[from] ServiceError),
    /// The line is gone.
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
    /// Servos answer, and no controller.
    #[error(
        "{}: {} servos answer here at {baud} baud, no controller. This is an adapter at the servos: `sinew servo --port` takes it",
        path.display(),
        protocol.name()
    )]
    Servos {
        /// The port.
        path: PathBuf,
        /// Whose.
        protocol: Protocol,
        /// At what rate.
        baud: u32,
    },
    /// No port is given, and not one has a controller.
    #[error("no controller was found at {0}")]
    NoneFound(String),
    /// No port is given, and several have a controller.
    #[error("several controllers were found: {0}")]
    Several(String),
    /// The controller takes no session.
    #[error("{0}")]
    Misfit(Misfit),
    /// It refuses a command.
    #[error("the controller refused: {0}")]
    Refused(Refusal),
    /// No answer came.
    #[error("the controller has not answered {0:?}: is the line bad?")]
    NoAnswer(Box<Command>),
    /// Nothing valid came for so long.
    #[error(
        "nothing valid has come from the board for {} s: is the wire from the board broken? It was told to stop, and \
         this program is silent now: the rig goes to its rest pose or holds, and 2 s later it is lowered and limp",
        .0.as_secs_f64()
    )]
    Deaf(Duration),
    /// The session is over.
    #[error("the session is over: the board has started anew, or another program has it now")]
    SessionOver,
    /// The firmware is too old for something.
    #[error(
        "this takes version {needs} of the link, the board's firmware speaks {has}: `sinew board flash` brings a newer one"
    )]
    Old {
        /// What it takes.
        needs: Version,
        /// What both speak.
        has: Version,
    },
    /// An answer of the wrong kind came.
    #[error("the controller answered {0} with something else")]
    Unexpected(&'static str),
    /// A name cannot be sent.
    #[error("`{0}`: who approves has a name of 1 to 60 bytes, without control characters")]
    Approver(String),
    /// It takes too long.
    #[error("{0}")]
    Impatient(String),
}
