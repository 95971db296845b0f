//! Errors of a rig that cannot play.

use sinew_firmware::controller::ControllerError;
use sinew_rig::board::BakeError;
use sinew_rig::description::ServoModel;
use sinew_rig::review::shown;
use sinew_rig::tracking::TrackingError;
use sinew_servo_sim::device::ServoError;
use sinew_servo_sim::rig::RigServosError;
use sinew_show::ShowError;
use thiserror::Error;

use super::schedule::RateError;
use super::servo_part::Drive;

/// An error of a rig whose controller and lines cannot be created.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PartsError {
    /// The rig has no compact form.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// The servos cannot be simulated.
    #[error(transparent)]
    Servos(#[from] RigServosError),
    /// The loop cannot be computed from the gears.
    #[error(transparent)]
    Tracking(#[from] TrackingError),
    /// A servo cannot have the P gain that the file states.
    #[error(transparent)]
    Gain(#[from] sinew_servo_tools::ServiceError),
    /// A joint would oscillate by itself: the observer, with the bandwidth that `Bandwidth::of_loaded_gear` gives, is
    /// too fast for the gear.
    #[error(
        "servo `{servo}` would shake its joint: an observer of {} rad/s at {rate_hz} Hz is too fast for its gear; take \
         a stiffer gear, less load, or `--drive {}` (`sinew rig check` shows the loops)",
        shown((*bandwidth_rad_s).into(), 0),
        if *voltage_bears { "voltage" } else { "position" }
    )]
    Shakes {
        /// Name of the servo.
        servo: String,
        /// Bandwidth of the observer, rad/s.
        bandwidth_rad_s: f32,
        /// Tick rate, Hz.
        rate_hz: u32,
        /// Whether the joint is stable with the drive `voltage`.
        voltage_bears: bool,
    },
    /// The base of the rig moves.
    #[error("the rig's base is not held: no servo moves it; `--base stand` bolts it to a stand")]
    Travels,
    /// The rig has no servos.
    #[error("the rig has no servos")]
    NoServos,
    /// A servo has a kind of address that its model does not support.
    #[error(
        "servo `{servo}` is {}: expected {expected}, found {found}",
        ServoModel::with_article(model)
    )]
    Address {
        /// Name of the servo.
        servo: String,
        /// Model of the servo.
        model: String,
        /// Kind of address that the model needs.
        expected: &'static str,
        /// Address in the file.
        found: String,
    },
    /// Servos of two protocols share a line.
    #[error(
        "bus {bus:?} has servos of two protocols ({one}, {other}): give one of them a bus of its own"
    )]
    TwoProtocols {
        /// Name of the bus.
        bus: String,
        /// A servo of the bus.
        one: String,
        /// A servo of the other protocol.
        other: String,
    },
    /// Servos share a drive, but only some of them use pulses.
    #[error(
        "servos `{one}` and `{other}` share a drive, and only `{one}` is driven by pulses: expected both on a bus, or \
         both on pulses"
    )]
    Mixed {
        /// A servo that uses pulses.
        one: String,
        /// A servo that does not.
        other: String,
    },
    /// A kind of servo does not support the drive.
    #[error(
        "--drive {0}: servo `{servo}` is {1}, which {2}",
        drive.name(),
        ServoModel::with_article(model),
        instead(*drive, takes)
    )]
    NotSo {
        /// The requested drive.
        drive: Drive,
        /// Name of the servo.
        servo: String,
        /// Model of the servo.
        model: String,
        /// Drives that the model supports.
        takes: Vec<Drive>,
    },
    /// A line does not support the rate.
    #[error("--baud {baud}: bus {bus:?} can have {known}")]
    Baud {
        /// The requested rate, bit/s.
        baud: u32,
        /// Name of the bus.
        bus: String,
        /// The rates that the line supports.
        known: String,
    },
    /// The lines have too little time for the tick rate.
    #[error(transparent)]
    Rate(#[from] RateError),
    /// Two servos have one id, or a number is invalid.
    #[error("bus {bus:?}: {reason}")]
    Bus {
        /// Name of the bus.
        bus: String,
        /// The invalid setting.
        reason: sinew_servo_bus::SetupError,
    },
}

/// Describes the drive that a servo lacks, and the drives that it supports.
fn instead(asked: Drive, takes: &[Drive]) -> String {
    if takes.contains(&Drive::Pulses) {
        return "is driven only by pulses; leave `--drive` out".to_owned();
    }
    let takes: Vec<&str> = takes.iter().map(|drive| drive.name()).collect();
    format!("has no {} mode; choose {}", asked.name(), takes.join(" or "))
}

/// An error of a rig that cannot be simulated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SimulatedRigError {
    /// A line cannot be created.
    #[error(transparent)]
    Parts(#[from] PartsError),
    /// The controller refuses the rig.
    #[error("the controller refuses the rig: {0}")]
    Controller(#[from] ControllerError),
    /// A servo cannot be simulated.
    #[error("servo `{servo}`: {reason}")]
    Servo {
        /// Name of the servo.
        servo: String,
        /// Reason of the failure.
        reason: ServoError,
    },
    /// The show does not play on the rig.
    #[error("the show does not play on this rig: {0}")]
    Show(#[from] ShowError),
}
