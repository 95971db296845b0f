//! Servo protocols as codecs: they convert bytes, without I/O, clock, allocation or panic.
//!
//! - [`dynamixel`]: Dynamixel protocol 2.0; [`feetech`]: STS, SMS and SCS servos; [`pca9685`]: hobby servos on a PWM
//!   chip.
//! - Each protocol has both sides: the controller's, and a `Device` that answers as a servo does. Both sides write and
//!   parse packets with the same code.
//! - [`ServoBus`] is the common interface of all buses: it accepts commands, returns a cycle of packets, processes
//!   replies, and reports feedback and errors for each servo.
//! - [`Schedule`] computes at construction the rate that a bus allows, and spreads reads over ticks if one tick is too
//!   short.
//! - [`settings`] lists the register values that a rig requires of a servo. A bus compares them in the time that ticks
//!   leave.
//! - [`Line`] connects simulated devices to one half-duplex line.
//!
//! # A tick
//! ```
//! use sinew_servo_bus::dynamixel::table::{MODELS, Table};
//! use sinew_servo_bus::dynamixel::{Bus, Device, Mode, ServoSetup, Settings, traffic};
//! use sinew_servo_bus::{Command, Line, Schedule, ServoBus, Timing};
//!
//! // One XL330 at 1 Mbps, 200 times a second.
//! let timing = Timing { baud: 1_000_000, return_delay_us: 2, turnaround_us: 5 };
//! let schedule = Schedule::new(timing, &traffic(1, 4, false), 200)?;
//! let model = MODELS.iter().find(|model| model.name == "XL330-M288").expect("it is in the list");
//! let neck = ServoSetup {
//!     id: 1,
//!     model,
//!     mode: Mode::Position,
//!     range_rad: [1.0, 5.0],
//!     current_a: 0.8,
//!     pwm: 1.0,
//!     speed_rad_s: 11.0,
//! };
//! let mut bus = Bus::<8>::new(&[neck], schedule, Settings { fast: false, retries: 1 })?;
//!
//! // What a board sends over its UART goes to a simulated servo here.
//! let mut memory = [0; 228];
//! let mut servos = [Device::<256>::new(Table { model, firmware: 52 }, 1, &mut memory)];
//! let mut line = Line::new(&mut servos);
//!
//! bus.command(0, Command::Torque(true))?;
//! let limit = bus.command(0, Command::Position(2.0))?;
//! assert_eq!(limit, None);
//! let mut out = [0; 128];
//! let request = bus.plan(&mut out)?;
//! line.exchange(&out[..request.len], &mut [0; 256], |reply, _| {
//!     bus.reply(reply);
//! });
//! assert_eq!(bus.feedback(0).expect("it has answered").position_rad, 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//! - The interface of [`ServoBus`] uses SI units and radians; raw counts stay inside. A servo's own position is zero
//!   where its encoder counts zero, and grows with the encoder's count.
//! - Streams may be split anywhere. A parser has a fixed buffer; after damage it finds the next whole packet, even if
//!   that packet begins inside the damaged one.
//! - A reply counts only if its id, its kind and its length match the request.
//! - Only elementary arithmetic in f32 and integers: results have the same bits on every machine.
//!
//! # Files
//! - `servo_bus`, `servo_state`, `plausible`, `counts`: the interface of a bus; the state of one servo; which readings
//!   to believe; conversion to counts.
//! - `schedule`: the rate that a bus allows, and which servos are read in which tick.
//! - `table`, `settings`, `compare`: control tables as data; the registers that a rig requires; their comparison.
//! - `dynamixel/` and `feetech/`: each has `frame`, `instruction`, `status`, `parser`; `table/` (models and registers);
//!   `bus/` (the controller's side; `bus/servo` converts counts to positions); `device/` (the servo's side).
//! - `pca9685/`: the chip's registers, the controller's side, a simulated chip.
//! - `line`, `sink`, `finder`, `window`: a half-duplex line for simulated devices; helpers for bytes in slices and
//!   streams.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]
#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::arithmetic_side_effects,
        reason = "a test may fail by panicking"
    )
)]

mod compare;
mod counts;
pub mod dynamixel;
mod error;
pub mod feetech;
mod finder;
mod line;
pub mod pca9685;
mod plausible;
mod schedule;
mod servo_bus;
mod servo_state;
pub mod settings;
mod sink;
pub mod table;
mod window;

pub use compare::{Compared, Difference};
pub use error::{CommandError, EncodeError, SetupError};
pub use line::{BusDevice, Line};
pub use plausible::Plausible;
pub use schedule::{Cost, Schedule, ScheduleError, Timing, Traffic};
pub use servo_bus::{Command, Effort, Feedback, Health, Limit, Request, ServoBus};
