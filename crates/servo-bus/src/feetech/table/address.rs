//! Addresses that this crate itself uses.

/// Address of the model number.
pub const MODEL: u8 = 3;
/// Address of the id.
pub const ID: u8 = 5;
/// Address of the baud rate code.
pub const BAUD: u8 = 6;
/// Address of the return delay, in 2 us. It has no effect on STS according to the manuals.
pub const RETURN_DELAY: u8 = 7;
/// Address of the setting whether the servo answers writes.
pub const STATUS_LEVEL: u8 = 8;
/// Address of the minimum position.
pub const MIN_POSITION: u8 = 9;
/// Address of the maximum position.
pub const MAX_POSITION: u8 = 11;
/// Address of the temperature limit.
pub const MAX_TEMPERATURE: u8 = 13;
/// Address of the minimum supply voltage.
pub const MIN_VOLTAGE: u8 = 15;
/// Address of the maximum torque after power-up.
pub const MAX_TORQUE: u8 = 16;
/// Address of Phase, whose bits are in [`super::phase`].
pub const PHASE: u8 = 18;
/// Address of the mask of faults that switch torque off.
pub const UNLOADING: u8 = 19;
/// Address of the position P gain.
pub const POSITION_P: u8 = 21;
/// Address of the position D gain.
pub const POSITION_D: u8 = 22;
/// Address of the position I gain.
pub const POSITION_I: u8 = 23;
/// Address of the offset that is subtracted from the encoder.
pub const HOMING_OFFSET: u8 = 31;
/// Address of the operating mode of STS.
pub const OPERATING_MODE: u8 = 33;
/// Address of the torque switch: 0 off, 1 on, 2 damped; 128 makes the present angle the middle.
pub const TORQUE_ENABLE: u8 = 40;
/// Address of the acceleration of the profile.
pub const ACCELERATION: u8 = 41;
/// Address of the goal position. Time and speed follow it in memory.
pub const GOAL_POSITION: u8 = 42;
/// Address of the speed of the profile, or of the speed mode.
pub const GOAL_SPEED: u8 = 46;
/// Address of the torque limit of STS.
pub const TORQUE_LIMIT: u8 = 48;
/// Address of the present position. Speed, load, voltage and temperature follow it in memory.
pub const PRESENT_POSITION: u8 = 56;
/// Address of the present speed.
pub const PRESENT_SPEED: u8 = 58;
/// Address of the flag that a registered write waits for an action.
pub const REGISTERED: u8 = 64;
/// Address of the status bits: faults of the servo.
pub const STATUS: u8 = 65;
/// Address of the present current of STS.
pub const PRESENT_CURRENT: u8 = 69;
