//! Bits of the register Phase (18) of STS and SMS servos.
//!
//! Source: Feetech's memory table, "servo phase". Bits 1, 5 and 6 describe the servo's own electronics: brushes,
//! bridge, PWM frequency.

/// Torque of the motor is reversed.
pub const REVERSED_MOTOR: u8 = 1;
/// One count of speed is one count of position per second, not 50.
pub const FINE_SPEED: u8 = 1 << 2;
/// A speed of 0 is the highest speed of a move to a position; without this bit the servo stays.
pub const ZERO_IS_FASTEST: u8 = 1 << 3;
/// The present position counts whole turns; without this bit it stays within one turn.
pub const ALL_TURNS: u8 = 1 << 4;
/// Positions count against the encoder.
pub const REVERSED_ENCODER: u8 = 1 << 7;

/// Value of a new STS3215; 76, with another PWM frequency, occurs too.
pub const SHIPPED: i32 = (FINE_SPEED | ZERO_IS_FASTEST) as i32;
/// Bits that change what a controller's goals and a servo's readings mean.
pub const MEANING: u8 =
    REVERSED_MOTOR | FINE_SPEED | ZERO_IS_FASTEST | ALL_TURNS | REVERSED_ENCODER;
