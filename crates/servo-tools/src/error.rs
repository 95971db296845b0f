//! Why something could not be done with a servo.

use std::fmt;
use std::io;
use std::path::PathBuf;

use sinew_rig::description::ServoModel;
use sinew_servo_bus::EncodeError;
use sinew_servo_bus::dynamixel::ErrorCode;

/// Why something could not be done. Each says what would be right, where that is known.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServiceError {
    /// The port cannot be opened.
    #[error("{}: {what}", path.display())]
    Port {
        /// The port.
        path: PathBuf,
        /// What is wrong, and what helps.
        what: String,
    },
    /// The line is gone.
    #[error("the port no longer works: {0}. Was the adapter unplugged?")]
    Line(io::Error),
    /// Who passes packets on does not do it now, or the line is no port.
    #[error("{0}")]
    Passing(io::Error),
    /// The line does not do this rate.
    #[error("the port does not do {baud} baud: {why}")]
    Baud {
        /// Bits per second.
        baud: u32,
        /// What the system says.
        why: io::Error,
    },
    /// Nothing came.
    #[error(
        "servo {id} does not answer at {baud} baud. Is it powered, and is this its id and rate? \
         `sinew servo scan` looks at all of them"
    )]
    Silent {
        /// Whom we asked.
        id: u8,
        /// At what rate.
        baud: u32,
    },
    /// Nothing came at any rate.
    #[error(
        "servo {id} does not answer at any rate of {protocols}. Is it powered? `sinew servo scan` shows who is there"
    )]
    Nowhere {
        /// Whom we asked.
        id: u8,
        /// Which protocols were tried.
        protocols: String,
    },
    /// Something came that is no reply.
    #[error(
        "what servo {id} answers is no packet. Two servos of the same id talk at once: connect them one at a time, \
         and use `set-id`; or cable and ground are bad"
    )]
    Noise {
        /// Whom we asked.
        id: u8,
    },
    /// It answers pings only.
    #[error(
        "servo {id} answers pings, but no reads: its Status Return Level is 0. \
         `sinew servo write {id} status-return-level 2` makes it answer"
    )]
    Mute {
        /// Which.
        id: u8,
    },
    /// The servo refuses, and says why.
    #[error("servo {id} refuses: {}", refusal(*code))]
    Refused {
        /// Which.
        id: u8,
        /// Why.
        code: ErrorCode,
    },
    /// A packet cannot be written.
    #[error(transparent)]
    Packet(#[from] EncodeError),
    /// Its model is not in the tables.
    #[error(
        "servo {id} says that it is model {number}, which is not in the list. If its registers are those of a known \
         model, name that one with `--model`, one of: {known}"
    )]
    UnknownModel {
        /// Which.
        id: u8,
        /// What it says.
        number: u16,
        /// Names that there are.
        known: String,
    },
    /// No model has this name.
    #[error("there is no model {name:?}; expected one of: {known}")]
    NoModel {
        /// The name.
        name: String,
        /// Names that there are.
        known: String,
    },
    /// Something about a register.
    #[error(transparent)]
    Register(#[from] Registers),
    /// Another servo has the id.
    #[error(
        "id {id} is taken: {} answers there; choose one that is free, or change that one first",
        ServoModel::with_article(model)
    )]
    IdTaken {
        /// The id.
        id: u8,
        /// Who has it.
        model: String,
    },
    /// No servo can have the id.
    #[error("no servo can have id {0}; expected one from 0 to 252")]
    BadId(u8),
    /// The servo has no such rate.
    #[error("{} cannot do {baud} baud; expected one of: {known}", ServoModel::with_article(model))]
    NoBaud {
        /// Which model.
        model: String,
        /// What was asked for.
        baud: u32,
        /// What it can do.
        known: String,
    },
    /// It did not come back after a change of its id or rate.
    #[error(
        "{what} was written to servo {id}, and now it answers neither there nor as before; scan for it"
    )]
    Lost {
        /// Its id before.
        id: u8,
        /// What was changed.
        what: String,
    },
    /// A signal came: Ctrl-C, or the system's wish that the program ends.
    #[error("it was ended by a signal")]
    Stopped,
    /// It failed, and the servo is not as it was before.
    #[error("{why}. And servo {id} is not as it was: {left}")]
    NotRestored {
        /// Which.
        id: u8,
        /// Why it failed.
        why: Box<Self>,
        /// The registers that could not be put back.
        left: Box<Self>,
    },
    /// It is in trouble.
    #[error("servo {id} reports {what}. {help}")]
    Fault {
        /// Which.
        id: u8,
        /// What it reports.
        what: String,
        /// What helps.
        help: &'static str,
    },
    /// It cannot be done as it stands.
    #[error("servo {id}: {what}")]
    State {
        /// Which.
        id: u8,
        /// What stands in the way, and what would be right.
        what: String,
    },
    /// Another model than the rig file says.
    #[error(
        "{name} (id {id}) is {}; the rig file says {should}. Change the file, or the servo",
        ServoModel::with_article(has)
    )]
    WrongModel {
        /// The rig's name for it.
        name: String,
        /// Its id.
        id: u8,
        /// The value that was found.
        has: String,
        /// What the file says.
        should: String,
    },
    /// The rig file asks for what the servo cannot do.
    #[error("{name}: {what}")]
    Rig {
        /// The part of the rig.
        name: String,
        /// What is wrong, and what would be right.
        what: String,
    },
}

/// What is wrong with reading or writing a register.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Registers {
    /// No such name.
    #[error("{} has no register {name:?}; {near}", ServoModel::with_article(model))]
    Unknown {
        /// Which model.
        model: &'static str,
        /// The name.
        name: String,
        /// Which ones come near.
        near: String,
    },
    /// It can only be read.
    #[error("{0} can only be read")]
    ReadOnly(&'static str),
    /// It is written by a command of its own, or not at all.
    #[error("{name} cannot be written directly; use {instead}")]
    Elsewhere {
        /// The register.
        name: &'static str,
        /// What would be right.
        instead: String,
    },
    /// No such number.
    #[error("{name} takes {takes}; found {found}")]
    Value {
        /// The register.
        name: &'static str,
        /// What it takes.
        takes: String,
        /// What was given.
        found: String,
    },
    /// EEPROM, and torque is on.
    #[error(
        "{name} is kept in EEPROM, which is written only at rest, and the torque of servo {id} is on. \
         `sinew servo write {id} torque-enable 0` lets go of what it holds"
    )]
    TorqueOn {
        /// Which servo.
        id: u8,
        /// The register.
        name: &'static str,
    },
    /// The servo did not keep it.
    #[error("servo {id}: {wrote} was written to {name}, and it reads {reads}")]
    NotKept {
        /// Which servo.
        id: u8,
        /// The register.
        name: &'static str,
        /// What was written.
        wrote: String,
        /// What it has.
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
        // The system's own errors have nothing inside.
        if error.get_ref().is_some() { Self::Passing(error) } else { Self::Line(error) }
    }
}
