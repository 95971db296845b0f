//! Errors of a rig that is to play.

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

/// An error of a rig whose controller and lines cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PartsError {
    /// It has no compact form.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// Its servos cannot be simulated.
    #[error(transparent)]
    Servos(#[from] RigServosError),
    /// Its gears say nothing of its loop.
    #[error(transparent)]
    Tracking(#[from] TrackingError),
    /// A servo cannot have the P gain that the file states.
    #[error(transparent)]
    Gain(#[from] sinew_servo_tools::ServiceError),
    /// A joint shakes by itself: its observer, which is as slow as the rule makes it, is too fast for the gear.
    #[error(
        "servo `{servo}` would shake its joint: an observer of {} rad/s at {rate_hz} Hz is too fast for its gear; take a \
         stiffer gear, less load, or `--drive {}` (`sinew rig check` has the loops)",
        shown((*bandwidth_rad_s).into(), 0),
        if *voltage_bears { "voltage" } else { "position" }
    )]
    Shakes {
        /// The servo.
        servo: String,
        /// Bandwidth of the observer.
        bandwidth_rad_s: f32,
        /// Ticks a second.
        rate_hz: u32,
        /// Whether it would not, by voltage.
        voltage_bears: bool,
    },
    /// It travels.
    #[error("the rig's base is not held: no servo moves it; `--base stand` bolts it to a stand")]
    Travels,
    /// It has no servos.
    #[error("the rig has no servos")]
    NoServos,
    /// A servo is where its kind cannot be.
    #[error(
        "servo `{servo}` is {}: expected {expected}, found {found}",
        ServoModel::with_article(model)
    )]
    Address {
        /// The servo.
        servo: String,
        /// Its kind.
        model: String,
        /// Where it could be.
        expected: &'static str,
        /// Where it is.
        found: String,
    },
    /// Servos of two makers share a line.
    #[error(
        "bus {bus:?} has servos of two protocols ({one}, {other}): give one of them a bus of its own"
    )]
    TwoProtocols {
        /// The bus.
        bus: String,
        /// A servo.
        one: String,
        /// One of the other protocol.
        other: String,
    },
    /// Servos on one drive, of which some take pulses.
    #[error(
        "servos `{one}` and `{other}` share a drive, and `{one}` alone takes pulses: expected both on a bus, or both on \
         pulses"
    )]
    Mixed {
        /// A servo that takes pulses.
        one: String,
        /// One that does not.
        other: String,
    },
    /// A kind of servo cannot be driven so.
    #[error(
        "--drive {0}: servo `{servo}` is {1}, which {2}",
        drive.name(),
        ServoModel::with_article(model),
        instead(*drive, takes)
    )]
    NotSo {
        /// The drive that was asked for.
        drive: Drive,
        /// The servo.
        servo: String,
        /// Its kind.
        model: String,
        /// How it can be driven.
        takes: Vec<Drive>,
    },
    /// A line cannot have this rate.
    #[error("--baud {baud}: bus {bus:?} can have {known}")]
    Baud {
        /// What was asked for.
        baud: u32,
        /// The bus.
        bus: String,
        /// What it could have.
        known: String,
    },
    /// The lines have no time.
    #[error(transparent)]
    Rate(#[from] RateError),
    /// Two servos have one id, or a number cannot be.
    #[error("bus {bus:?}: {reason}")]
    Bus {
        /// The bus.
        bus: String,
        /// Why.
        reason: sinew_servo_bus::SetupError,
    },
}

/// Says what a servo lacks that cannot be driven as asked, and what it takes.
fn instead(asked: Drive, takes: &[Drive]) -> String {
    if takes.contains(&Drive::Pulses) {
        return "takes pulses alone; leave `--drive` out".to_owned();
    }
    let takes: Vec<&str> = takes.iter().map(|drive| drive.name()).collect();
    format!("has no {} mode; choose {}", asked.name(), takes.join(" or "))
}

/// An error of a rig that cannot be simulated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SimulatedRigError {
    /// A line cannot be.
    #[error(transparent)]
    Parts(#[from] PartsError),
    /// The controller does not take the rig.
    #[error("the controller refuses the rig: {0}")]
    Controller(#[from] ControllerError),
    /// A servo cannot be simulated.
    #[error("servo `{servo}`: {reason}")]
    Servo {
        /// Which.
        servo: String,
        /// Why.
        reason: ServoError,
    },
    /// The show does not play on the rig.
    #[error("the show does not play on this rig: {0}")]
    Show(#[from] ShowError),
}
