//! Values of registers that a real servo obeys and the simulated servo does not: it refuses them, so that no program
//! is tried on a servo that seems to obey. The page of [registers](../../../docs/simulated-registers.md) has all others.

/// Returns whether a Dynamixel refuses a value of a register.
pub(super) fn dynamixel(address: u16, value: i32) -> bool {
    match address {
        // Protocol Type: another protocol, or the S.BUS of a remote control.
        13 => value != 2,
        // Acceleration Limit of the MX series.
        40 => value != 32_767,
        // Startup Configuration: torque on, or kept goals, at power-up.
        60 => value != 0,
        // PWM Slope.
        62 => value != 140,
        _ => false,
    }
}

/// Returns whether a Feetech refuses a value of a register.
pub(super) fn feetech(address: u8, value: i32) -> bool {
    match address {
        // D Coefficient: the damping of identified servos is that of motor and gear.
        22 => value != 32,
        // I Coefficient, Integral Limit, coefficients of the speed loop.
        23 | 25 | 37 | 39 => value != 0,
        // Angular Resolution.
        30 => value != 1,
        // Operating Mode: steps are not simulated.
        33 => value == 3,
        _ => false,
    }
}
