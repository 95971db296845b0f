//! Simulated servos, with their bus.
//!
//! ```text
//! master ── bytes ──> Bench ──> Servo (registers of a `bus` device) ──> firmware ──> motor, gear, heat ──> Plant
//!                       │                                                              ▲
//!                       └── faults to order, time on the wire                          Supply: one for all
//! ```
//!
//! - [`model`]: the physics of a servo: [`model::Motor`], [`model::Gear`] and [`model::Heat`], created from
//!   [`model::Parameters`].
//! - [`firmware`]: the maker's program: loops for position, speed, current and PWM, profiles, shutdown.
//! - [`device`]: the firmware connected to the registers of `sinew-servo-bus`' devices.
//! - [`supply`], [`fault`], [`load`]: the servos' common supply, their faults, and their loads.
//! - [`mod@bench`]: servos, line, supplies and loads together in simulated time.
//! - [`variation`]: servos and rigs that differ from the model of their controller.
//! - [`registers`]: servos without physics; [`kind`]: the known servo kinds by name.
//! - [`mod@rig`]: the servos of a rig, each with its own separate load; [`plant`]: the whole rig on its servos.
//! - [`mod@line`]: a stream of bytes to a bench and back, in simulated or real time.
//! - [`fleet`]: requested servos, with a line for each bus.
//! - `port`, on Unix: a line as a serial port of this machine.
//! - [`published`]: published figures of servos compared with simulated ones.
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
//! SI units and radians, f64, at the servo's own output shaft: the gear ratio is included in the torque constant and
//! the rotor's inertia. Positive torque accelerates towards larger positions. Elementary functions are those of `libm`,
//! and the simulation reads no clock: every run on every machine gives the same bits.
//!
//! # What is left out
//! The motor's inductance (its time constant is below a millisecond), PWM ripple, cogging, demagnetization and wear.
//!
//! # Files
//! - `line`, `wire`, `port`: bytes in both directions, each at its time; which device listens and sends; a
//!   pseudo-terminal.
//! - `bench/`: simulated time, on one line, on several lines (`branch`), or with a PCA9685 (`chip`).
//! - `registers`: servos without physics, for tests of protocols.
//! - `device/`, `firmware/`, `model/`: registers; the maker's program; motor, gear and temperature.
//! - `load`, `rig`, `plant/`, `supply`: loads of servos, separate or together, and their supply.
//! - `fault/`: faults of servos and lines, and their text form.
//! - `kind`, `fleet`: kinds by name; any servos, with a line for each bus.
//! - `variation`: differences between a simulated plant and its rig's file, and their text form.
//! - `published/`, `models/`: published figures compared with simulated ones; figures that `sinew-rig` lacks.

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
