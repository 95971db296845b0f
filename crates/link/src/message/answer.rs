//! What a command came to.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::finite;

use super::{
    FaultReport, Feed, Health, Item, Limit, Numbered, Operator, Passed, State, TelemetrySetting,
    Value,
};

/// The answer to the command of the same session and number.
pub type Answer = Numbered<Outcome>;

/// What a command came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    /// It was done, as it was asked.
    Applied(Applied),
    /// Less was done than was asked.
    Limited(Applied, Limit),
    /// Nothing was done.
    Refused(Refusal),
    /// It is being done. Ask again with the same number.
    Working,
}

/// What was done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Applied {
    /// It. There is no more to say.
    Done,
    /// It led to this state.
    State(State),
    /// This telemetry is sent.
    Telemetry(TelemetrySetting),
    /// The setting has this value, by reading it back.
    Setting(Value),
    /// The log of faults has this.
    Fault(FaultReport),
    /// This is stored at the place, if anything is.
    Stored(Option<Item>),
    /// All bytes below this offset are stored; go on there.
    Upload {
        /// The offset.
        next: u32,
    },
    /// Servos have said this.
    Passed(Passed),
    /// The controller has measured this of itself.
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

/// Why nothing was done.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Refusal {
    /// The session is not the controller's.
    Session,
    /// A command with a higher number was executed before.
    Late,
    /// It came before, and its answer is no longer kept.
    Forgotten,
    /// Not in this state.
    State(State),
    /// Some servo has no valid and new reading.
    NotMeasured,
    /// The way to stop was not tested since the rig became limp.
    StopUntested,
    /// The feed gives no poses.
    FeedSilent(Feed),
    /// This fault is there, or latched. Faults are numbered as in `docs/faults.md`.
    Fault(u8),
    /// This fault cannot be cleared: its condition is still there. Nothing was cleared.
    StillThere(u8),
    /// This fault is cleared by an upload alone.
    NeedsUpload(u8),
    /// No fault is latched.
    NoFault,
    /// This operator has the rig for maintenance.
    InMaintenance(Operator),
    /// There is no such servo, degree of freedom, setting, slot or fault.
    Unknown,
    /// The value cannot be.
    Value,
    /// The board has room for this many, and the rig or show has more.
    Capacity {
        /// What there is room for.
        room: u32,
        /// What it takes.
        needs: u32,
    },
    /// Every slot that is large enough holds a show.
    NoFreeSlot,
    /// The block or the end belongs elsewhere: all bytes below this offset are stored.
    Offset {
        /// The offset to go on at.
        next: u32,
    },
    /// The whole has another SHA-256 than was said. It is dropped.
    Hash,
    /// The show is of another rig.
    OtherRig {
        /// The rig of the show.
        show: u32,
        /// The rig of the controller.
        rig: u32,
    },
    /// What the rig or show is wrong in, as its decoder numbers it.
    Content(u16),
    /// The memory did not take it: begin an upload again.
    Memory,
    /// This firmware cannot do it.
    Unsupported,
    /// Not now: something else is being done.
    Busy,
    /// Not all registers of all servos were compared with what the rig asks.
    RegistersUnread,
    /// A servo is not set up as the rig asks.
    RegisterDiffers {
        /// Index of the servo.
        servo: u16,
        /// Address of the register, as its maker has it.
        address: u16,
        /// What it holds, in its own counts.
        found: i32,
        /// What it must hold.
        expected: i32,
    },
    /// The rig still moves by itself.
    Moving {
        /// The degree of freedom that is farthest beyond what it may.
        dof: u16,
        /// How fast it moves, mrad/s or mm/s.
        mrad_s: u32,
        /// How fast it may, in the same unit.
        most_mrad_s: u32,
    },
    /// A setting cannot be.
    Setting {
        /// Its number.
        key: u16,
        /// What it was to be.
        #[serde(with = "finite")]
        found: f32,
        /// The least that it may be.
        #[serde(with = "finite")]
        least: f32,
        /// The most.
        #[serde(with = "finite")]
        most: f32,
    },
    /// Some servo takes a position alone, and no effort: the rig cannot float.
    NoEffort,
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
        }
    }
}

impl core::error::Error for Refusal {}
