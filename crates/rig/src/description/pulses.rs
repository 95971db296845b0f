//! Pulses of a hobby servo, and their positions.

use super::{Address, Description, Servo, ServoModel};

/// Usual pulses of hobby servos at the least position, in the middle, and at the greatest position, us.
const USUAL_US: [f64; 3] = [500.0, 1500.0, 2500.0];

/// Pulses of a hobby servo. The position is a linear function of the pulse's length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulses {
    /// Pulses at the least position, at position zero and at the greatest position, us.
    pub us: [f64; 3],
    /// Angle from the least to the greatest position, rad.
    pub travel_rad: f64,
    /// Whether the rig's file gives the pulses of this servo: its author has tried them.
    pub is_measured: bool,
}

impl Pulses {
    /// Returns the pulses of a kind of servo. Missing values are the usual ones.
    pub fn of_model(model: &ServoModel) -> Self {
        let given = [&model.pulse_least_us, &model.pulse_middle_us, &model.pulse_most_us];
        let mut us = USUAL_US;
        for (us, given) in us.iter_mut().zip(given) {
            *us = given.as_ref().map_or(*us, |given| given.value);
        }
        Self { us, travel_rad: model.range_rad.value, is_measured: false }
    }

    /// Returns these pulses with the measured values of a servo. If the servo has measured pulses but no travel, the
    /// angle per us stays.
    #[must_use]
    pub fn with(self, servo: &Servo) -> Self {
        let us = servo.pulse_us.unwrap_or(self.us);
        let travel_rad = servo.travel_rad.unwrap_or((us[2] - us[0]) / self.us_per_rad());
        Self { us, travel_rad, is_measured: servo.pulse_us.is_some() }
    }

    /// Returns the change of the pulse per angle, us/rad.
    pub fn us_per_rad(&self) -> f64 {
        (self.us[2] - self.us[0]) / self.travel_rad
    }

    /// Returns the pulse of a position, us.
    pub fn pulse_us(&self, position_rad: f64) -> f64 {
        self.us[1] + position_rad * self.us_per_rad()
    }

    /// Returns the position of a pulse, rad.
    pub fn position_rad(&self, pulse_us: f64) -> f64 {
        (pulse_us - self.us[1]) / self.us_per_rad()
    }

    /// Returns the positions of the shortest and the longest pulse, rad.
    pub fn range_rad(&self) -> [f64; 2] {
        [self.us[0], self.us[2]].map(|us| self.position_rad(us))
    }
}

impl Description {
    /// Returns the pulses of a hobby servo; `None` for a servo with an id, or of an unknown kind.
    pub fn pulses(&self, servo: &Servo) -> Option<Pulses> {
        match servo.address {
            Address::Channel(_) => {
                self.servo_model(&servo.model).map(|model| Pulses::of_model(&model).with(servo))
            }
            Address::Id(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_and_positions_are_inverse() {
        let model = ServoModel::built_in("MG90S").unwrap();
        let usual = Pulses::of_model(&model);
        assert!((usual.pulse_us(std::f64::consts::FRAC_PI_2) - 2500.0).abs() < 1.0);
        let narrow = Servo { pulse_us: Some([1000.0, 1450.0, 2000.0]), ..Servo::default() };
        let narrow = usual.with(&narrow);
        assert!((narrow.us_per_rad() - usual.us_per_rad()).abs() < 1e-9);
        assert!((narrow.travel_rad - 0.5 * usual.travel_rad).abs() < 1e-9);
        let [least, most] = narrow.range_rad();
        assert!(-least < most && (most - least - narrow.travel_rad).abs() < 1e-12);
        let measured = Servo { travel_rad: Some(2.0), ..Servo::default() };
        let measured = usual.with(&measured);
        assert!((measured.position_rad(measured.pulse_us(0.7)) - 0.7).abs() < 1e-12);
        assert!((measured.us_per_rad() - 1000.0).abs() < 1e-9);
    }
}
