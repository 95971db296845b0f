//! Position of a servo's own zero on its encoder.

use core::f32::consts::{PI, TAU};

use sinew_rig::servo::Servo;

use super::Refused;
use crate::SettingError;

/// Maximum distance by which a range may exceed the encoder's turn, rad: more than a step of any encoder and the
/// rounding of `2π`.
const SLACK_RAD: f32 = 2e-3;

/// A servo's encoder. Positions on the bus count from the encoder's zero. The servo's own positions count from
/// [`zero_rad`](Self::zero_rad), usually the middle of the encoder's turn.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Encoder {
    /// Position on the bus at which the servo's own position is zero, rad.
    pub zero_rad: f32,
    /// Range of the encoder, after which its reading starts again at zero, rad.
    pub turn_rad: f32,
}

/// A full turn with the zero in its middle, as in Dynamixel X and MX and in STS.
impl Default for Encoder {
    fn default() -> Self {
        Self { zero_rad: PI, turn_rad: TAU }
    }
}

impl Encoder {
    /// Returns an error if a setting is invalid, or the range crosses the encoder's seam, where the reading jumps by a
    /// turn: a servo that starts near the seam does not know on which side of it the shaft is.
    pub(super) fn check(self, servo: &Servo) -> Result<(), Refused> {
        SettingError::check("encoder turn_rad", self.turn_rad, [0.1, 1e3])?;
        SettingError::check("encoder zero_rad", self.zero_rad, [-1e3, 1e3])?;
        let [least, most] = servo.settings().range_rad.map(|own| own + self.zero_rad);
        if least < -SLACK_RAD || most > self.turn_rad + SLACK_RAD {
            return Err(Refused::Seam { range_rad: [least, most], turn_rad: self.turn_rad });
        }
        Ok(())
    }
}
