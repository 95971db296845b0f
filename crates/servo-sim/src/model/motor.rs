//! A brushed motor and its bridge.

use super::Parameters;

/// What the bridge does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Power {
    /// All switches open: no current.
    Open,
    /// A part of the supply, -1 to 1, as long as the current stays within a limit. 0 brakes: the motor is shorted.
    Duty {
        /// Part of the supply.
        duty: f64,
        /// The most current either way, A; infinite for no limit.
        limit_a: f64,
    },
    /// A current, as far as a part of the supply can drive it.
    Current {
        /// A.
        current_a: f64,
        /// The most part of the supply either way.
        limit: f64,
    },
}

/// Torque over speed, for a step: `nm - nm_s * speed`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Characteristic {
    pub(crate) nm: f64,
    pub(crate) nm_s: f64,
}

/// What a servo takes from its supply.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Draw {
    /// A; negative where a braked motor gives back.
    pub current_a: f64,
    /// How it grows with the voltage, A/V.
    pub conductance_a_v: f64,
}

/// The electrical side.
#[derive(Debug, Clone, PartialEq)]
pub struct Motor {
    torque_constant_nm_a: f64,
    cold_ohm: f64,
    standby_a: f64,
    /// Current in the winding, A.
    pub current_a: f64,
    /// Part of the supply that is at the winding, -1 to 1.
    pub duty: f64,
}

impl Motor {
    /// A motor at rest.
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

    /// Takes the torque and the speed that came out of a step. Returns what the supply gives for it, and the heat of
    /// the winding, W.
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
        // An open bridge has the back-EMF at its ends, and takes nothing.
        self.duty = if self.current_a == 0.0 || supply_v <= 0.0 { 0.0 } else { volts / supply_v };
        let draw = Draw {
            current_a: self.duty * self.current_a + self.standby_a,
            conductance_a_v: self.duty * self.duty / ohm,
        };
        (draw, self.current_a * self.current_a * ohm)
    }
}
