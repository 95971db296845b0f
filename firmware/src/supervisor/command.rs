//! Commands, and their answers.

use core::fmt;

use super::{Fault, Feed, Moving, Operator, RegisterDiffers, State};

/// What people ask of the supervisor. Each gets an [`Answer`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// Torque on, at the measured pose. From limp alone, and from rest.
    Arm,
    /// Lowered, then limp. Never refused.
    Disarm,
    /// Follow a feed.
    Play(Feed),
    /// Stand where it was commanded last.
    Hold,
    /// To the rest pose, lowered, then limp. In maintenance and while arming: lowered at once. Never refused.
    Stop,
    /// Ranges are found by hand. From limp alone.
    Calibrate,
    /// Poses are shown by hand, torque off. From limp alone.
    Teach,
    /// Poses are shown by hand, while the rig carries its own weight. From holding alone: so it was armed.
    Float,
    /// An operator takes the rig for maintenance, and nobody else may move or arm it until he or she leaves it.
    Maintain(Operator),
    /// The operator holds the enabling button: to be sent again and again, as long as it is held.
    Enable(Operator),
    /// The operator gives the rig back: it holds.
    Leave(Operator),
    /// Clears latched faults. Moves nothing.
    ClearFaults,
    /// Torque off at once; latched. Never refused.
    EStop,
}

/// What became of a command: the state that it led to, or why it was refused.
pub type Answer = Result<State, Refused>;

/// Why a command was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refused {
    /// Not in this state.
    InState(State),
    /// Some servo has no valid and new reading.
    NotMeasured,
    /// Not all registers of all servos were read and compared since the rig became limp, or since one was silent.
    RegistersUnread,
    /// A servo is not set up as the rig asks.
    RegisterDiffers(RegisterDiffers),
    /// The way to stop was not tested since the rig became limp.
    StopUntested,
    /// It still moves by itself.
    Moving(Moving),
    /// The feed gives no poses.
    FeedSilent(Feed),
    /// Some servo takes a position alone, and no effort.
    NoEffort,
    /// A fault is there, or latched.
    Fault(Fault),
    /// A fault cannot be cleared: its condition is still there. Nothing was cleared.
    StillThere(Fault),
    /// A fault is cleared by an upload alone.
    NeedsUpload(Fault),
    /// No fault is latched.
    NoFault,
    /// Somebody has the rig for maintenance.
    InMaintenance(Operator),
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InState(state) => write!(f, "the rig is {state}: {}", way_from(*state)),
            Self::NotMeasured => f.write_str(
                "not every servo has a valid and new reading: is each powered and plugged?",
            ),
            Self::RegistersUnread => f.write_str(
                "not all registers of all servos were compared since the rig became limp: try again",
            ),
            Self::RegisterDiffers(differs) => {
                write!(f, "{differs}: `sinew servo apply` sets it")
            }
            Self::StopUntested => f.write_str(
                "the way to stop was not tested since the rig became limp: test it first",
            ),
            Self::Moving(moving) => {
                write!(f, "the rig is moving: {moving}; wait until it rests")
            }
            Self::FeedSilent(feed) => write!(f, "the feed ({feed}) gives no poses: start it first"),
            Self::NoEffort => f.write_str(
                "not every servo accepts an effort: a servo driven by position cannot float; teach with torque off",
            ),
            Self::Fault(fault) => write!(f, "{fault}: remove its cause and clear it first"),
            Self::StillThere(fault) => write!(f, "{fault} is still there: nothing was cleared"),
            Self::NeedsUpload(fault) => write!(f, "{fault} is cleared only by a new upload"),
            Self::NoFault => f.write_str("no fault is latched"),
            Self::InMaintenance(Operator(id)) => {
                write!(f, "operator {id} has the rig for maintenance, and must leave it first")
            }
        }
    }
}

impl core::error::Error for Refused {}

/// What one can do in a state in which a command was refused.
const fn way_from(state: State) -> &'static str {
    match state {
        State::Off => "it waits until every servo and its registers were read",
        State::Limp => "arm it first",
        State::Calibrating | State::Teaching => "disarm it first",
        State::Arming | State::Stopping | State::Lowering => "wait until that is over",
        State::Holding => "it is armed already; work by hand needs the state limp",
        State::Playing | State::Floating => "hold it, or disarm it, first",
        State::Maintenance => "the operator must leave it first",
        State::Faulted => "clear the fault first",
    }
}
