//! Drives convert the tracker's command for each joint to a command for each servo, and the servos' readings to the
//! state of joints.
//!
//! ```text
//! DofCommand of each dof ── rig's drive (matrix, curve, four-bar) ──> ShaftTarget of each servo ─ class ─> Command
//! Measured   of each dof <── the same drive, by virtual work ──────── Feedback of each servo
//! ```
//!
//! | class | for | uses | method | minimum rate |
//! | --- | --- | --- | --- | --- |
//! | [`CurrentDrive`] | servos in current mode | both efforts | effort and friction over torque constant | 200 Hz |
//! | [`VoltageDrive`] | servos in PWM mode | both efforts | (voltage for that current + back-EMF) / supply | 200 Hz |
//! | [`PositionDrive`] | servos by position | target, feed-forward effort | target, effort over stiffness | 50 Hz |
//! | [`TargetDrive`] | hobby servos, and others of unknown stiffness | target | the target, within its limits | 50 Hz |
//!
//! # Why a position servo gets no feedback effort
//! A position servo has its own controller, which runs a thousand times per second at the encoder. A feedback effort
//! on top would close a second loop around it: through the bus, several ticks later, with a position in steps. Two
//! loops of similar speed would share the motor, and each would see the other's correction as a disturbance. The
//! outer loop would have to be several times slower than the servo (2 to 4 Hz of bandwidth), so slow that it corrects
//! nothing that moves. The feed-forward effort closes no loop: it depends on the model, not on the servo's error.
//!
//! There is no outer loop. At a fifth of a servo's bandwidth it would take 0.3 s or more to act, so it could only
//! correct gravity at rest. The offset corrects gravity at once and without phase delay.
//!
//! # Refused settings
//! Construction returns a [`SetupError`] if the rate is below the class's minimum, the range crosses the encoder's
//! seam, a current or voltage drive has no torque constant, a position drive has no stiffness, or a drive has servos
//! of two classes.
//!
//! ```
//! use sinew_servo_bus::Command;
//! use sinew_core::coordinates::DofCommand;
//! use sinew_core::tracker::Timing;
//! use sinew_firmware::drives::{Condition, DriveSettings, Drives, PositionSettings};
//! # use sinew_rig::{board::BoardRig, new};
//! # let description = new::arm(1)?;
//! # let rig = BoardRig::<2, 1, 1>::bake(&description, &description.mechanism()?)?;
//! // An arm of one XL330 at 100 Hz.
//! let timing = Timing { dt_s: 0.01, latency_ticks: 1 };
//! let settings = DriveSettings::Position(PositionSettings { profile: false, ..PositionSettings::default() });
//! let mut drives = Drives::new(&rig, &[settings], timing)?;
//! let condition = Condition { temperature_c: Some(30.0), ..Condition::default() };
//! let asked = DofCommand { position: 0.1, ..DofCommand::default() };
//! let mut commands = [None];
//! for _ in 0..10 {
//!     drives.step(&[asked], &[condition], &mut commands)?;
//! }
//! let [Some(servo)] = commands else { unreachable!("it has a drive") };
//! // On the bus, zero is half a turn away.
//! let Command::Position(goal_rad) = servo.command else { unreachable!("it is driven by position") };
//! assert!((goal_rad - core::f32::consts::PI - 0.1).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Outside of this module
//! The caller decides whether anything may move. [`Command::Torque`] switches torque; no drive returns it.
//!
//! [`Command::Torque`]: sinew_servo_bus::Command::Torque

#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

mod class;
mod condition;
mod current;
mod drive;
mod encoder;
mod error;
pub(crate) mod follower;
mod measured;
mod position;
mod rig;
mod target;
mod turn;
mod voltage;

pub use class::{Class, ClassError};
pub use condition::{Condition, CutOff};
pub use current::{CurrentDrive, CurrentSettings};
pub use drive::{DriveSettings, ServoDrive};
pub use encoder::Encoder;
pub use error::{InputError, Refused, SetupError};
pub use measured::Measured;
pub use position::{PositionDrive, PositionSettings};
pub use rig::Drives;
pub use target::{TargetDrive, TargetSettings};
pub use voltage::{VoltageDrive, VoltageSettings};

use sinew_rig::limited::LimitReason;
use sinew_servo_bus::Command;

/// The target of a servo's shaft on the side of the drive: before gear, offset and direction of the servo.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ShaftTarget {
    /// Position of the shaft, rad.
    pub position_rad: f32,
    /// Velocity of the shaft, rad/s.
    pub velocity_rad_s: f32,
    /// Torque that the motion needs by the model, including gravity, N m.
    pub feedforward_nm: f32,
    /// Torque that corrects the error, N m.
    pub feedback_nm: f32,
}

/// The command of a servo, and the limit that was reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoCommand {
    /// Command for [`ServoBus::command`](sinew_servo_bus::ServoBus::command).
    pub command: Command,
    /// The limit that was reached, if any. If there are several, the last limit between target and command.
    pub limit: Option<Limit>,
}

/// A limit that changed a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Limit {
    /// End of the range.
    Range,
    /// Maximum speed.
    Speed,
    /// Maximum acceleration.
    Acceleration,
    /// Maximum torque.
    Torque,
    /// Maximum current.
    Current,
    /// Supply voltage, or the part of it that the servo's own torque and speed need.
    Voltage,
    /// Maximum offset.
    Offset,
    /// Maximum rate of change of the offset.
    OffsetRate,
    /// The last reading is too old, or there is none.
    Stale,
    /// The servo is hot.
    Heat,
}

impl From<LimitReason> for Limit {
    fn from(reason: LimitReason) -> Self {
        match reason {
            LimitReason::Range => Self::Range,
            LimitReason::Speed => Self::Speed,
            LimitReason::Acceleration => Self::Acceleration,
            LimitReason::Torque => Self::Torque,
        }
    }
}
