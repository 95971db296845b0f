//! Simulated servos behind their bus.
//!
//! ```text
//! master ── bytes ──> Bench ──> Servo (registers of a `bus` device) ──> firmware ──> motor, gear, heat ──> Plant
//!                       │                                                              ▲
//!                       └── faults to order, time on the wire                          Supply: one for all
//! ```
//!
//! - [`model`]: a servo as physics: [`model::Motor`], [`model::Gear`] and [`model::Heat`], of [`model::Parameters`].
//! - [`firmware`]: what the maker's program does: position, speed, current and PWM loops, profiles, shutdown.
//! - [`device`]: the firmware behind the registers of `sinew-servo-bus`' devices.
//! - [`supply`], [`fault`], [`load`]: what servos share, what goes wrong, and what they move.
//! - [`mod@bench`]: all of it in simulated time.
//! - [`variation`]: servos and rigs that differ from what their controller believes.
//! - [`registers`]: servos without physics; [`kind`]: what there is of which servo, by its name.
//! - [`mod@rig`]: the servos of a rig, each with what it moves by itself; [`plant`]: the rig on all of them.
//! - [`mod@line`]: a stream of bytes to a bench and back, in simulated or real time.
//! - [`fleet`]: servos as somebody wants them, a line for each bus.
//! - `port`, on Unix: such a line as a serial port of this machine.
//! - [`published`]: what is published of servos against what is simulated.
//!
//! ```
//! use sinew_servo_bus::dynamixel::table::MODELS;
//! use sinew_servo_bus::dynamixel::{Bus, Mode, ServoSetup, Settings, traffic};
//! use sinew_servo_bus::{Command, Schedule, ServoBus, Timing};
//! use sinew_servo_sim::bench::Bench;
//! use sinew_servo_sim::device::{MEMORY_LEN, Servo};
//! use sinew_servo_sim::load::Arm;
//! use sinew_servo_sim::model::Parameters;
//! use sinew_servo_sim::supply::Supply;
//!
//! // An XL330 with 30 g on an arm of 10 cm, on a line at 1 Mbps.
//! let kind = Parameters::built_in("XL330-M288-T")?;
//! let mut memory = [0; MEMORY_LEN];
//! let mut servo = Servo::new(&kind, 1, &mut memory)?;
//! servo.set_baud(1_000_000)?;
//! let arm = Arm { inertia_kg_m2: 3e-4, gravity_nm: 0.03, ..Arm::default() };
//! let mut bench = Bench::new(vec![servo], vec![arm], Supply::stiff(5.0));
//!
//! let timing = Timing { baud: 1_000_000, return_delay_us: 500, turnaround_us: 5 };
//! let schedule = Schedule::new(timing, &traffic(1, 4, false), 100)?;
//! let model = MODELS.iter().find(|model| model.name == "XL330-M288").ok_or("no such model")?;
//! let setup = ServoSetup {
//!     id: 1,
//!     model,
//!     mode: Mode::Position,
//!     range_rad: [0.0, 6.0],
//!     current_a: 1.0,
//!     pwm: 1.0,
//!     speed_rad_s: 20.0,
//! };
//! let mut bus = Bus::<1>::new(&[setup], schedule, Settings { fast: false, retries: 1 })?;
//! bus.command(0, Command::Torque(true))?;
//! bus.command(0, Command::Position(1.0))?;
//! for _ in 0..100 {
//!     bench.tick(&mut bus, 10_000)?;
//! }
//! let feedback = bus.feedback(0).ok_or("it is silent")?;
//! // It sags: 0.03 N m cos(1) over some 0.7 N m/rad.
//! assert!((feedback.position_rad - 0.98).abs() < 0.03);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//! SI units and radians, f64, at the servo's own output shaft: the gear ratio is in the torque constant and the rotor's
//! inertia. Positive torque accelerates towards larger positions. Elementary functions are `libm`'s and nothing asks a
//! clock: same bits on every run and machine.
//!
//! # What is left out
//! The motor's inductance (its time constant is below a millisecond), PWM ripple, cogging, magnets that weaken, wear.
//!
//! # Files
//! - `line`, `wire`, `port`: bytes there and back, each at its time; who hears and who speaks; a pseudo-terminal.
//! - `bench/`: simulated time: on one line, on several (`branch`), behind a PCA9685 (`chip`).
//! - `registers`: servos without physics, for tests of protocols.
//! - `device/`, `firmware/`, `model/`: registers; the maker's program; motor, gear and heat.
//! - `load`, `rig`, `plant/`, `supply`: what servos move, alone or together, and what feeds them.
//! - `fault/`: faults of servos and lines, and the words that order them.
//! - `kind`, `fleet`: kinds by their names; any servos, on a line for each bus.
//! - `variation`: differences between a simulated plant and its rig's file, and the words that order them.
//! - `published/`, `models/`: published figures against simulated ones; figures that `sinew-rig` lacks.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod bench;
pub mod device;
pub mod fault;
pub mod firmware;
pub mod fleet;
pub mod kind;
pub mod line;
pub mod load;
pub mod model;
pub mod plant;
#[cfg(unix)]
pub mod port;
pub mod published;
mod random;
pub mod registers;
pub mod rig;
pub mod supply;
pub mod variation;
mod wire;
