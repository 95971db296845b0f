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
        "the board's port no longer works: {0}. Was the board unplugged? Without this program the rig holds its pose; \
         after 2 s it is lowered, and torque is switched off"
    )]
    Line(io::Error),
    /// Nothing answers a greeting.
    #[error(
        "no controller answers. Is the board powered and flashed (`sinew board flash`)? To try without hardware, use \
         `sinew board simulate`"
    )]
    NoController,
    /// Servos answer, and no controller.
    #[error(
        "{}: {} servos answer here at {baud} baud, no controller. This port is an adapter of servos: use it with \
         `sinew servo --port`",
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
    #[error("the controller has not answered {0:?}: is the cable bad?")]
    NoAnswer(Box<Command>),
    /// Nothing valid came for so long.
    #[error(
        "no valid message has arrived from the board for {} s: is the wire from the board broken? The board was asked \
         to stop, and this program sends nothing more: the rig goes to its rest pose or holds; 2 s later it is \
         lowered, and torque is switched off",
        .0.as_secs_f64()
    )]
    Deaf(Duration),
    /// The session is over.
    #[error("the session is over: the board has restarted, or another program uses it now")]
    SessionOver,
    /// The firmware is too old for something.
    #[error(
        "this needs version {needs} of the host link, the board's firmware has {has}: update it with `sinew board \
         flash`"
    )]
    Old {
        /// What it takes.
        needs: Version,
        /// What both speak.
        has: Version,
    },
    /// An answer of the wrong kind came.
    #[error("the controller's answer to {0} is of another kind")]
    Unexpected(&'static str),
    /// A name cannot be sent.
    #[error("`{0}`: the name of the approver must have 1 to 60 bytes, without control characters")]
    Approver(String),
    /// It takes too long.
    #[error("{0}")]
    Impatient(String),
}
