//! Drives: from what a tracker asks of each joint to what each servo is commanded, and from what servos measure to
//! joints.
//!
//! ```text
//! DofCommand of each dof ── rig's drive (matrix, curve, four-bar) ──> ShaftTarget of each servo ─ class ─> Command
//! Measured   of each dof <── the same drive, by virtual work ──────── Feedback of each servo
//! ```
//!
//! | class | for | takes | method | least rate |
//! | --- | --- | --- | --- | --- |
//! | [`CurrentDrive`] | servos in current mode | both efforts | effort and friction over torque constant | 200 Hz |
//! | [`VoltageDrive`] | servos in PWM mode | both efforts | that current's voltage and back-EMF over supply | 200 Hz |
//! | [`PositionDrive`] | servos by position | target, feed-forward effort | target, effort over stiffness | 50 Hz |
//! | [`TargetDrive`] | hobby servos, and others of unknown stiffness | target | the target, within its limits | 50 Hz |
//!
//! # Why a position servo gets no feedback effort
//! It has a controller of its own, a thousand times a second, at the encoder. A feedback effort on top closes a second
//! loop round that one: through the bus, several ticks later, from a position in steps. Two loops of like speed share
//! one motor, and each sees the other's correction as a disturbance; the outer one has to be several times slower than
//! the servo (2 to 4 Hz of bandwidth), so slow that it corrects nothing that moves. The feed-forward effort closes no
//! loop: it depends on the model, not on the servo's error.
//!
//! No such outer loop is offered. At a fifth of a servo's bandwidth it would act within 0.3 s and more: that is a
//! correction of gravity at rest, which the offset makes at once and without a phase.
//!
//! # What is refused
//! [`SetupError`] says it at construction: a rate below the class's least, a range that crosses the encoder's seam, a
//! current or voltage drive without a torque constant, a position drive without a stiffness, servos of two classes on
//! one drive.
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
//! # Not here
//! Whether anything may move: that is for whoever calls. [`Command::Torque`] switches torque; no drive gives it.
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

/// What the shaft of a servo has to do, as its drive sees it: before gear, offset and direction of the servo.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ShaftTarget {
    /// Where to be, rad.
    pub position_rad: f32,
    /// How fast, rad/s.
    pub velocity_rad_s: f32,
    /// What the motion takes by the model, gravity among it, N m.
    pub feedforward_nm: f32,
    /// What corrects the error, N m.
    pub feedback_nm: f32,
}

/// What a servo is commanded, and what limited it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoCommand {
    /// For [`ServoBus::command`](sinew_servo_bus::ServoBus::command).
    pub command: Command,
    /// What limited it, if anything did; of several the last in the way from target to command.
    pub limit: Option<Limit>,
}

/// What limited a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Limit {
    /// The end of the range.
    Range,
    /// The largest speed.
    Speed,
    /// The largest acceleration.
    Acceleration,
    /// The largest torque.
    Torque,
    /// The largest current.
    Current,
    /// The supply's voltage, or the part of it that the servo's own torque and speed take.
    Voltage,
    /// The largest offset.
    Offset,
    /// The fastest change of the offset.
    OffsetRate,
    /// Nothing was read for too long, or never.
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
