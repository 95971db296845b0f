//! Values of registers that a real servo obeys and the simulated servo does not. The simulated servo refuses them: if
//! it accepted them, a program would be tested on a servo that only seems to obey. The page of [simulated
//! registers](../../../docs/simulated-registers.md) lists the effects of all registers.

use sinew_servo_bus::table::{Obeys, Restriction};

/// Restrictions of a Dynamixel.
pub(super) const DYNAMIXEL: [Restriction; 4] = [
    // Protocol Type: another protocol, or the S.BUS of a remote control.
    of(13, Obeys::Only(2)),
    // Acceleration Limit of the MX series.
    of(40, Obeys::Only(32_767)),
    // Startup Configuration: torque on, or kept goals, at power-up.
    of(60, Obeys::Only(0)),
    // PWM Slope.
    of(62, Obeys::Only(140)),
];

/// Restrictions of a Feetech.
pub(super) const FEETECH: [Restriction; 7] = [
    // D Coefficient: the damping of identified servos is that of motor and gear.
    of(22, Obeys::Only(32)),
    // I Coefficient, Integral Limit, coefficients of the speed loop.
    of(23, Obeys::Only(0)),
    of(25, Obeys::Only(0)),
    of(37, Obeys::Only(0)),
    of(39, Obeys::Only(0)),
    // Angular Resolution.
    of(30, Obeys::Only(1)),
    // Operating Mode: steps are not simulated.
    of(33, Obeys::AllBut(3)),
];

const fn of(address: u16, obeys: Obeys) -> Restriction {
    Restriction { address, obeys }
}
