//! A brushed motor and its bridge.

use super::Parameters;

/// The state of the bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Power {
    /// All switches are open: no current flows.
    Open,
    /// Applies a part of the supply voltage, as long as the current stays within a limit. A duty cycle of 0 brakes:
    /// the motor is shorted.
    Duty {
        /// Part of the supply voltage, -1 to 1.
        duty: f64,
        /// Maximum current in either direction, A; infinite for no limit.
        limit_a: f64,
    },
    /// Drives a current, as far as the allowed part of the supply voltage can.
    Current {
        /// Current, A.
        current_a: f64,
        /// Maximum part of the supply voltage in either direction.
        limit: f64,
    },
}

/// Torque as a function of speed during a step: `nm - nm_s * speed`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Characteristic {
    pub(crate) nm: f64,
    pub(crate) nm_s: f64,
}

/// The load of a servo on its supply.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Draw {
    /// Current, A; negative if a braking motor returns current.
    pub current_a: f64,
    /// Increase of the current with the voltage, A/V.
    pub conductance_a_v: f64,
}

/// State of the motor and its bridge.
#[derive(Debug, Clone, PartialEq)]
pub struct Motor {
    torque_constant_nm_a: f64,
    cold_ohm: f64,
    standby_a: f64,
    /// Current in the winding, A.
    pub current_a: f64,
    /// Part of the supply voltage at the winding, -1 to 1.
    pub duty: f64,
}

impl Motor {
    /// Creates a motor at rest.
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            torque_constant_nm_a: parameters.torque_constant_nm_a,
            cold_ohm: parameters.resistance_ohm,
            standby_a: parameters.standby_a,
            current_a: 0.0,
            duty: 0.0,
        }
    }

    pub(crate) fn characteristic(
        &self,
        power: Power,
        supply_v: f64,
        velocity_rad_s: f64,
        resistance_ratio: f64,
    ) -> Characteristic {
        let k = self.torque_constant_nm_a;
        let ohm = self.cold_ohm * resistance_ratio;
        let driven =
            |duty: f64| Characteristic { nm: k * duty * supply_v / ohm, nm_s: k * k / ohm };
        let held = |amps: f64| Characteristic { nm: k * amps, nm_s: 0.0 };
        let amps_at = |duty: f64| (duty * supply_v - k * velocity_rad_s) / ohm;
        match power {
            Power::Open => held(0.0),
            Power::Duty { duty, limit_a } => {
                let amps = amps_at(duty);
                if amps.abs() <= limit_a { driven(duty) } else { held(limit_a.copysign(amps)) }
            }
            Power::Current { current_a, limit } => {
                if current_a > amps_at(limit) {
                    driven(limit)
                } else if current_a < amps_at(-limit) {
                    driven(-limit)
                } else {
                    held(current_a)
                }
            }
        }
    }

    /// Sets the state from the torque and the speed at the end of a step. Returns the load on the supply, and the
    /// heating power of the winding, W.
    pub(crate) fn settle(
        &mut self,
        torque_nm: f64,
        velocity_rad_s: f64,
        supply_v: f64,
        resistance_ratio: f64,
    ) -> (Draw, f64) {
        let ohm = self.cold_ohm * resistance_ratio;
        self.current_a = torque_nm / self.torque_constant_nm_a;
        let volts = self.current_a * ohm + self.torque_constant_nm_a * velocity_rad_s;
        // An open bridge has the back-EMF at its terminals, and draws no current.
        self.duty = if self.current_a == 0.0 || supply_v <= 0.0 { 0.0 } else { volts / supply_v };
        let draw = Draw {
            current_a: self.duty * self.current_a + self.standby_a,
            conductance_a_v: self.duty * self.duty / ohm,
        };
        (draw, self.current_a * self.current_a * ohm)
    }
}
