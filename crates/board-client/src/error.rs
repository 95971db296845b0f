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
    /// The port cannot be opened, or another program uses it.
    #[error(transparent)]
    Port(#[from] ServiceError),
    /// The line has failed.
    #[error(
        "the board's port no longer works: {0}. Was the board unplugged? Without this program the rig holds its pose; \
         after 2 s it is lowered, and torque is switched off"
    )]
    Line(io::Error),
    /// Nothing answers the greetings.
    #[error(
        "no controller answers. Is the board powered and flashed (`sinew board flash`)? To try without hardware, use \
         `sinew board simulate`"
    )]
    NoController,
    /// Servos answer, but no controller.
    #[error(
        "{}: {} servos answer here at {baud} baud, no controller. This port is an adapter of servos: use it with \
         `sinew servo --port`",
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
    /// None of the tried ports has a controller.
    #[error("no controller was found at {0}")]
    NoneFound(String),
    /// Several of the tried ports have a controller.
    #[error("several controllers were found: {0}")]
    Several(String),
    /// The controller refuses a session.
    #[error("{0}")]
    Misfit(Misfit),
    /// The controller refused a command.
    #[error("the controller refused: {0}")]
    Refused(Refusal),
    /// No answer to this command arrived.
    #[error("the controller has not answered {0:?}: is the cable bad?")]
    NoAnswer(Box<Command>),
    /// No valid message arrived for this time, so the rig was stopped.
    #[error(
        "no valid message has arrived from the board for {} s: is the wire from the board broken? The board was asked \
         to stop, and this program sends nothing more: the rig goes to its rest pose or holds; 2 s later it is \
         lowered, and torque is switched off",
        .0.as_secs_f64()
    )]
    Deaf(Duration),
    /// The board has restarted, or another program has the rig.
    #[error("the session is over: the board has restarted, or another program uses it now")]
    SessionOver,
    /// The firmware is too old for a function.
    #[error(
        "this needs version {needs} of the host link, the board's firmware has {has}: update it with `sinew board \
         flash`"
    )]
    Old {
        /// Version that the function needs.
        needs: Version,
        /// Version that both ends support.
        has: Version,
    },
    /// An answer of the wrong kind arrived.
    #[error("the controller's answer to {0} is of another kind")]
    Unexpected(&'static str),
    /// The approver's name is invalid.
    #[error("`{0}`: the name of the approver must have 1 to 60 bytes, without control characters")]
    Approver(String),
    /// An operation took too long, or was not possible.
    #[error("{0}")]
    Impatient(String),
}
