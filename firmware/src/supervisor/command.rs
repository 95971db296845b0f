//! Commands and their answers.

use core::fmt;

use super::{Fault, Feed, Moving, Operator, Overload, RegisterDiffers, State};

/// A user's command to the supervisor. Each gets an [`Answer`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// Switches torque on at the measured pose. Allowed only in the state limp, while the rig is at rest.
    Arm,
    /// Lowers the rig, then switches torque off. Never refused.
    Disarm,
    /// Follows a feed.
    Play(Feed),
    /// Holds the last commanded pose.
    Hold,
    /// Moves to the rest pose, lowers the rig, then switches torque off. In maintenance and while arming, lowers
    /// the rig at once. Never refused.
    Stop,
    /// Lets a user move the rig by hand to find ranges. Allowed only in the state limp.
    Calibrate,
    /// Lets a user show poses by hand, with torque off. Allowed only in the state limp.
    Teach,
    /// Lets a user show poses by hand, while the rig carries its own weight. Allowed only in the state holding, so
    /// that the rig has been armed.
    Float,
    /// Gives the rig to an operator for maintenance. Nobody else may move or arm it until this operator leaves it.
    Maintain(Operator),
    /// Reports that the operator holds the enabling button. It must be sent repeatedly while the button is held.
    Enable(Operator),
    /// Ends the operator's maintenance: the rig holds.
    Leave(Operator),
    /// Clears latched faults. Moves nothing.
    ClearFaults,
    /// Switches torque off at once, and latches a fault. Never refused.
    EStop,
}

/// Answer to a command: the state that it led to, or the reason for its refusal.
pub type Answer = Result<State, Refused>;

/// A reason why a command was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refused {
    /// The command is not possible in this state.
    InState(State),
    /// A servo has no valid and new reading.
    NotMeasured,
    /// Not all registers of all servos were read and compared since the rig became limp, or since a servo was silent.
    RegistersUnread,
    /// A servo's registers differ from the rig's requirements.
    RegisterDiffers(RegisterDiffers),
    /// The way to stop was not tested since the rig became limp.
    StopUntested,
    /// The rig still moves by itself.
    Moving(Moving),
    /// The servos or the supply cannot hold the rig.
    Overload(Overload),
    /// The feed has no poses.
    FeedSilent(Feed),
    /// A servo accepts only positions, and no effort.
    NoEffort,
    /// A fault is present or latched.
    Fault(Fault),
    /// A fault cannot be cleared because its condition is still present. Nothing was cleared.
    StillThere(Fault),
    /// The fault is cleared only by an upload.
    NeedsUpload(Fault),
    /// No fault is latched.
    NoFault,
    /// An operator has the rig for maintenance.
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
            Self::Overload(overload) => write!(
                f,
                "the rig cannot be held where it is, or on the way to the show's first pose: {overload}"
            ),
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

/// Returns advice for a state in which a command was refused.
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
