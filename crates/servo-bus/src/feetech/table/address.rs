//! Addresses that this crate itself uses.

/// Model number.
pub const MODEL: u8 = 3;
/// Id.
pub const ID: u8 = 5;
/// Code of the baud rate.
pub const BAUD: u8 = 6;
/// Return delay, in 2 us; has no effect on STS according to the manuals.
pub const RETURN_DELAY: u8 = 7;
/// Whether the servo answers writes.
pub const STATUS_LEVEL: u8 = 8;
/// Minimum position.
pub const MIN_POSITION: u8 = 9;
/// Maximum position.
pub const MAX_POSITION: u8 = 11;
/// Temperature limit.
pub const MAX_TEMPERATURE: u8 = 13;
/// Minimum supply voltage.
pub const MIN_VOLTAGE: u8 = 15;
/// Maximum torque after power-up.
pub const MAX_TORQUE: u8 = 16;
/// Faults that make the servo switch torque off.
pub const UNLOADING: u8 = 19;
/// Position P gain.
pub const POSITION_P: u8 = 21;
/// Position D gain.
pub const POSITION_D: u8 = 22;
/// Position I gain.
pub const POSITION_I: u8 = 23;
/// Operating mode of STS.
pub const OPERATING_MODE: u8 = 33;
/// Torque switch: 0 off, 1 on, 2 damped; 128 declares the middle.
pub const TORQUE_ENABLE: u8 = 40;
/// Acceleration.
pub const ACCELERATION: u8 = 41;
/// Goal position; time and speed follow.
pub const GOAL_POSITION: u8 = 42;
/// Torque limit of STS.
pub const TORQUE_LIMIT: u8 = 48;
/// Present position; speed, load, voltage, temperature follow.
pub const PRESENT_POSITION: u8 = 56;
/// Whether a registered write waits for an action.
pub const REGISTERED: u8 = 64;
/// Status bits: faults of the servo.
pub const STATUS: u8 = 65;
/// Present current of STS.
pub const PRESENT_CURRENT: u8 = 69;
