//! Outcomes of commands.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::finite;

use super::{
    FaultReport, Feed, Health, Item, Limit, Numbered, Operator, Passed, State, TelemetrySetting,
    Value,
};

/// The answer to the command with the same session and number.
pub type Answer = Numbered<Outcome>;

/// The outcome of a command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    /// The command was executed as requested.
    Applied(Applied),
    /// The command was executed in part, up to a limit.
    Limited(Applied, Limit),
    /// The command was not executed.
    Refused(Refusal),
    /// The command is being executed. Ask again with the same number.
    Working,
}

/// The result of an executed command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Applied {
    /// The command was executed; there is no other result.
    Done,
    /// The rig is now in this state.
    State(State),
    /// This telemetry is sent from now on.
    Telemetry(TelemetrySetting),
    /// The setting has this value, as read back.
    Setting(Value),
    /// The requested record of the log of faults.
    Fault(FaultReport),
    /// This item is stored at the location; `None` if nothing is stored there.
    Stored(Option<Item>),
    /// All bytes below this offset are stored. Continue at the offset.
    Upload {
        /// Offset of the next block, in bytes.
        next: u32,
    },
    /// The servos sent these bytes.
    Passed(Passed),
    /// The controller's measurements of itself.
    Health(Health),
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Range => "the end of the range",
            Self::Speed => "the largest speed",
            Self::Acceleration => "the largest acceleration",
            Self::Effort => "the largest torque or force",
            Self::Current => "the largest current",
            Self::Offset => "the largest offset of a position servo",
            Self::Supply => "the supply",
            Self::Heat => "heat",
            Self::Stale => "no fresh reading",
            Self::NotFinite => "a number that is not finite",
            Self::Room => "the board's memory",
            Self::SoftStart => "the soft start",
            Self::Maintenance => "the slow speed of maintenance",
            Self::Link => "the capacity of the host link",
        })
    }
}

/// A reason for which a command was not executed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Refusal {
    /// The session is not the controller's current session.
    Session,
    /// A command with a higher number was executed before.
    Late,
    /// The command arrived before, and its answer is no longer kept.
    Forgotten,
    /// The command is not allowed in this state.
    State(State),
    /// Some servo has no valid and new reading.
    NotMeasured,
    /// The stop function was not tested since the rig became limp.
    StopUntested,
    /// The feed gives no poses.
    FeedSilent(Feed),
    /// This fault is present, or latched. Faults are numbered as in `docs/faults.md`.
    Fault(u8),
    /// This fault cannot be cleared, because its condition is still present. Nothing was cleared.
    StillThere(u8),
    /// Only an upload clears this fault.
    NeedsUpload(u8),
    /// No fault is latched.
    NoFault,
    /// This operator has the rig for maintenance.
    InMaintenance(Operator),
    /// There is no such servo, dof, setting, slot or fault.
    Unknown,
    /// The value is invalid.
    Value,
    /// The rig or show exceeds the board's capacity.
    Capacity {
        /// Capacity of the board.
        room: u32,
        /// Amount that the rig or show needs.
        needs: u32,
    },
    /// Every slot that is large enough holds a show.
    NoFreeSlot,
    /// The block or the end has a wrong offset: all bytes below this offset are stored.
    Offset {
        /// Offset at which to continue, in bytes.
        next: u32,
    },
    /// The uploaded bytes do not have the announced SHA-256. They are dropped.
    Hash,
    /// The show is for another rig.
    OtherRig {
        /// CRC of the show's rig.
        show: u32,
        /// CRC of the controller's rig.
        rig: u32,
    },
    /// The rig or show is invalid; the number is its decoder's error number.
    Content(u16),
    /// The flash memory failed to store the item. Start the upload again.
    Memory,
    /// This firmware does not support the command.
    Unsupported,
    /// The controller is busy with something else.
    Busy,
    /// Not all registers of all servos were compared with the rig's requirements.
    RegistersUnread,
    /// A register of a servo differs from the rig's requirement.
    RegisterDiffers {
        /// Index of the servo.
        servo: u16,
        /// Address of the register, in the manufacturer's table.
        address: u16,
        /// Value of the register, in its own counts.
        found: i32,
        /// Required value, in the same counts.
        expected: i32,
    },
    /// The rig is still moving on its own.
    Moving {
        /// Index of the dof that exceeds its limit most.
        dof: u16,
        /// Speed of the dof, mrad/s or mm/s.
        mrad_s: u32,
        /// Maximum speed, in the same unit.
        most_mrad_s: u32,
    },
    /// The value of a setting is out of range.
    Setting {
        /// Key of the setting.
        key: u16,
        /// Requested value.
        #[serde(with = "finite")]
        found: f32,
        /// Minimum valid value.
        #[serde(with = "finite")]
        least: f32,
        /// Maximum valid value.
        #[serde(with = "finite")]
        most: f32,
    },
    /// Some servo accepts only positions and no effort: the rig cannot float.
    NoEffort,
    /// To be held in the current pose or on the way to the show, a joint needs more torque than its servo gives.
    Overload {
        /// Index of the dof.
        dof: u16,
        /// Torque that the servo needs to give, mN m.
        mnm: u32,
        /// Maximum torque of the servo, mN m.
        most_mnm: u32,
    },
    /// To hold the rig in the current pose or on the way to the show, all servos together need more current than
    /// the supply gives.
    Supply {
        /// Index of the dof that needs most.
        dof: u16,
        /// Current of all servos, mA.
        ma: u32,
        /// Maximum current of the supply, mA.
        most_ma: u32,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Session => f.write_str("this is not the controller's session: say hello again"),
            Self::Late => f.write_str("a later command was executed before this one"),
            Self::Forgotten => {
                f.write_str("the command came before, and its answer is no longer kept")
            }
            Self::State(state) => write!(f, "the rig is {state}"),
            Self::NotMeasured => f.write_str(
                "not every servo has a valid and new reading: is each powered and plugged?",
            ),
            Self::StopUntested => f.write_str(
                "the way to stop was not tested since the rig became limp: test it first",
            ),
            Self::FeedSilent(feed) => write!(f, "the feed ({feed}) gives no poses: start it first"),
            Self::Fault(fault) => write!(f, "fault {fault}: remove its cause and clear it first"),
            Self::StillThere(fault) => {
                write!(f, "fault {fault} is still there: nothing was cleared")
            }
            Self::NeedsUpload(fault) => write!(f, "fault {fault} is cleared only by a new upload"),
            Self::NoFault => f.write_str("no fault is latched"),
            Self::InMaintenance(Operator(id)) => {
                write!(f, "operator {id} has the rig for maintenance, and must leave it first")
            }
            Self::Unknown => f.write_str("there is no such thing"),
            Self::Value => f.write_str("the value is invalid"),
            Self::Capacity { room, needs } => {
                write!(f, "the board has room for {room}, and this needs {needs}")
            }
            Self::NoFreeSlot => {
                f.write_str("every slot that is large enough holds a show: delete one first")
            }
            Self::Offset { next } => write!(f, "the next byte to send is that at {next}"),
            Self::Hash => f.write_str("the content has another SHA-256 than was announced: it is discarded"),
            Self::OtherRig { show, rig } => {
                write!(f, "the show is of rig {show:08x}, the controller has rig {rig:08x}")
            }
            Self::Content(number) => write!(f, "its content is wrong: error {number}"),
            Self::Memory => f.write_str("the memory did not store it: begin an upload again"),
            Self::Unsupported => f.write_str("this firmware cannot do it"),
            Self::Busy => f.write_str("something else is being done: try again"),
            Self::RegistersUnread => f.write_str(
                "not all registers of all servos were compared since the rig became limp: try again",
            ),
            Self::RegisterDiffers { servo, address, found, expected } => write!(
                f,
                "servo {servo}: its register {address} is {found}, it must be {expected}: `sinew servo apply` sets it"
            ),
            Self::Moving { dof, mrad_s, most_mrad_s } => write!(
                f,
                "the rig is moving: joint {dof} at {mrad_s} mrad/s, at most {most_mrad_s}; wait until it rests"
            ),
            Self::Setting { key, found, least, most } => {
                write!(f, "setting {key} is {found}; it must be a number from {least} to {most}")
            }
            Self::NoEffort => f.write_str(
                "not every servo accepts an effort: a servo driven by position cannot float; teach with torque off",
            ),
            Self::Overload { dof, mnm, most_mnm } => write!(
                f,
                "the rig cannot be held where it is, or on the way to the show's first pose: joint {dof} takes {mnm} \
                 mN m of its servo, which gives {most_mnm}"
            ),
            Self::Supply { dof, ma, most_ma } => write!(
                f,
                "the rig cannot be held where it is, or on the way to the show's first pose: all take {ma} mA, and \
                 joint {dof} most; the supply gives {most_ma}"
            ),
        }
    }
}

impl core::error::Error for Refusal {}
