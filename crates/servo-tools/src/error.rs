//! Errors of the tools.

use std::fmt;
use std::io;
use std::path::PathBuf;

use sinew_rig::description::ServoModel;
use sinew_servo_bus::EncodeError;
use sinew_servo_bus::dynamixel::ErrorCode;

/// The reason why a tool failed. If a remedy is known, the message contains it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServiceError {
    /// The port cannot be opened.
    #[error("{}: {what}", path.display())]
    Port {
        /// Path of the port.
        path: PathBuf,
        /// Cause and remedy.
        what: String,
    },
    /// The line failed.
    #[error("the port no longer works: {0}. Was the adapter unplugged?")]
    Line(io::Error),
    /// The board that passes packets on does not do so now, or the line is not a serial port.
    #[error("{0}")]
    Passing(io::Error),
    /// The line does not support this baud rate.
    #[error("the port does not do {baud} baud: {why}")]
    Baud {
        /// Requested baud rate, bits per second.
        baud: u32,
        /// Error of the operating system.
        why: io::Error,
    },
    /// The servo does not answer.
    #[error(
        "servo {id} does not answer at {baud} baud. Is it powered, and is this its id and rate? `sinew servo scan` \
         searches all of them"
    )]
    Silent {
        /// Id that was asked.
        id: u8,
        /// Baud rate of the question, bits per second.
        baud: u32,
    },
    /// The servo does not answer at any rate.
    #[error(
        "servo {id} does not answer at any rate of {protocols}. Is it powered? `sinew servo scan` shows the servos \
         that answer"
    )]
    Nowhere {
        /// Id that was asked.
        id: u8,
        /// Protocols that were tried.
        protocols: String,
    },
    /// The bytes that arrived are not a reply.
    #[error(
        "the answer of servo {id} is not a valid packet. Either two servos have this id: connect them one at a time, \
         and use `set-id`; or the cable or its ground is bad"
    )]
    Noise {
        /// Id that was asked.
        id: u8,
    },
    /// The servo answers only pings.
    #[error(
        "servo {id} answers pings, but no reads: its Status Return Level is 0. \
         `sinew servo write {id} status-return-level 2` makes it answer"
    )]
    Mute {
        /// Id of the servo.
        id: u8,
    },
    /// The servo refused the instruction with an error number.
    #[error("servo {id} refuses: {}", refusal(*code))]
    Refused {
        /// Id of the servo.
        id: u8,
        /// Error number of the refusal.
        code: ErrorCode,
    },
    /// A packet could not be encoded.
    #[error(transparent)]
    Packet(#[from] EncodeError),
    /// The servo's model is unknown.
    #[error(
        "servo {id} reports model number {number}, which is not in the list. If its registers are those of a known \
         model, name that one with `--model`, one of: {known}"
    )]
    UnknownModel {
        /// Id of the servo.
        id: u8,
        /// Model number that the servo reports.
        number: u16,
        /// Names of the known models.
        known: String,
    },
    /// No model has this name.
    #[error("there is no model {name:?}; expected one of: {known}")]
    NoModel {
        /// Name that was given.
        name: String,
        /// Names of the known models.
        known: String,
    },
    /// A register could not be read or written.
    #[error(transparent)]
    Register(#[from] Registers),
    /// Another servo has the id.
    #[error(
        "id {id} is taken: {} has this id; choose a free id, or change the id of that servo first",
        ServoModel::with_article(model)
    )]
    IdTaken {
        /// Id that was requested.
        id: u8,
        /// Model of the servo that has the id.
        model: String,
    },
    /// No servo can have the id.
    #[error("no servo can have id {0}; expected one from 0 to 252")]
    BadId(u8),
    /// The servo does not support this baud rate.
    #[error("{} cannot do {baud} baud; expected one of: {known}", ServoModel::with_article(model))]
    NoBaud {
        /// Model of the servo.
        model: String,
        /// Requested rate, bits per second.
        baud: u32,
        /// Supported rates.
        known: String,
    },
    /// The servo no longer answers after a change of its id or rate.
    #[error(
        "{what} was written to servo {id}, and now it answers with neither the new nor the old value; scan for it"
    )]
    Lost {
        /// Id before the change.
        id: u8,
        /// Change that was made.
        what: String,
    },
    /// A signal ended the tool: Ctrl-C, or the system.
    #[error("it was ended by a signal")]
    Stopped,
    /// The tool failed, and the servo's previous state could not be restored.
    #[error("{why}. Also, servo {id} could not be restored to its previous state: {left}")]
    NotRestored {
        /// Id of the servo.
        id: u8,
        /// Cause of the failure.
        why: Box<Self>,
        /// Registers that could not be restored.
        left: Box<Self>,
    },
    /// The servo reports a fault.
    #[error("servo {id} reports {what}. {help}")]
    Fault {
        /// Id of the servo.
        id: u8,
        /// Fault that the servo reports.
        what: String,
        /// Remedy.
        help: &'static str,
    },
    /// The servo's state does not allow the operation.
    #[error("servo {id}: {what}")]
    State {
        /// Id of the servo.
        id: u8,
        /// Obstacle and remedy.
        what: String,
    },
    /// The servo's model differs from the rig file.
    #[error(
        "{name} (id {id}) is {}; the rig file says {should}. Change the file, or the servo",
        ServoModel::with_article(has)
    )]
    WrongModel {
        /// Name of the servo in the rig.
        name: String,
        /// Id of the servo.
        id: u8,
        /// Model that was found.
        has: String,
        /// Model in the rig file.
        should: String,
    },
    /// The rig file asks for something that the servo does not support.
    #[error("{name}: {what}")]
    Rig {
        /// Part of the rig that is concerned.
        name: String,
        /// Cause and remedy.
        what: String,
    },
}

/// The reason why a register could not be read or written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Registers {
    /// No register has this name.
    #[error("{} has no register {name:?}; {near}", ServoModel::with_article(model))]
    Unknown {
        /// Model of the servo.
        model: &'static str,
        /// Name that was given.
        name: String,
        /// Similar names.
        near: String,
    },
    /// The register can only be read.
    #[error("{0} can only be read")]
    ReadOnly(&'static str),
    /// The register has its own command, or must not be written.
    #[error("{name} cannot be written directly: {instead}")]
    Elsewhere {
        /// Name of the register.
        name: &'static str,
        /// Command to use instead, or the reason why there is none.
        instead: String,
    },
    /// The value is not allowed.
    #[error("{name} takes {takes}; found {found}")]
    Value {
        /// Name of the register.
        name: &'static str,
        /// Allowed values.
        takes: String,
        /// Value that was given.
        found: String,
    },
    /// The register is in EEPROM, and torque is on.
    #[error(
        "{name} is kept in EEPROM, which is written only while torque is off, and the torque of servo {id} is on. \
         `sinew servo write {id} torque-enable 0` switches it off; a load that it holds falls"
    )]
    TorqueOn {
        /// Id of the servo.
        id: u8,
        /// Name of the register.
        name: &'static str,
    },
    /// The servo did not store the value.
    #[error("servo {id}: {wrote} was written to {name}, and it reads {reads}")]
    NotKept {
        /// Id of the servo.
        id: u8,
        /// Name of the register.
        name: &'static str,
        /// Value that was written.
        wrote: String,
        /// Value that was read back.
        reads: String,
    },
}

fn refusal(code: ErrorCode) -> impl fmt::Display {
    match code {
        ErrorCode::ResultFail => "it could not be done (error 1)".to_owned(),
        ErrorCode::Instruction => "it does not know this instruction (error 2)".to_owned(),
        ErrorCode::Crc => "packets reach it damaged (error 3); look at cable and ground".to_owned(),
        ErrorCode::DataRange => "the value is out of range (error 4)".to_owned(),
        ErrorCode::DataLength => "the length is not that of the register (error 5)".to_owned(),
        ErrorCode::DataLimit => {
            "the value is beyond a limit in another register (error 6)".to_owned()
        }
        ErrorCode::Access => {
            "the register is read-only, or in EEPROM while torque is on (error 7)".to_owned()
        }
        ErrorCode::Unknown(number) => format!("error {number}, which the protocol does not define"),
    }
}

impl From<io::Error> for ServiceError {
    fn from(error: io::Error) -> Self {
        // The operating system's own errors have no inner error.
        if error.get_ref().is_some() { Self::Passing(error) } else { Self::Line(error) }
    }
}
