//! Converts values to register contents.

use super::error::ServoError;
use crate::model::Parameters;

/// Returns the duty cycle per position error, 1/rad, that gives the factory stiffness without friction.
pub(crate) fn duty_per_rad(kind: &Parameters) -> f64 {
    let stall_nm = kind.torque_constant_nm_a * kind.voltage_v / kind.resistance_ohm;
    kind.position_gain_nm_rad / stall_nm
}

/// Returns the code of a baud rate.
pub(crate) fn code_of(baud: u32, bauds: &[u32]) -> Result<i32, ServoError> {
    let code = bauds.iter().position(|known| *known == baud);
    code.and_then(|code| i32::try_from(code).ok())
        .ok_or_else(|| ServoError::Baud { baud, known: bauds.to_vec() })
}

/// Rounds to the nearest whole number, limited to the range of i32.
pub(crate) fn whole(value: f64) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "the cast saturates, and NaN becomes 0")]
    let whole = libm::rint(value) as i32;
    whole
}
