//! Where a servo's own zero is on its encoder.

use core::f32::consts::{PI, TAU};

use sinew_rig::servo::Servo;

use super::Refused;
use crate::SettingError;

/// A range may end this far beyond the encoder's turn: more than a step of any encoder, and the rounding of `2π`.
const SLACK_RAD: f32 = 2e-3;

/// A servo's encoder: positions on the bus count from its zero, those of the rig from the middle of the servo's range.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Encoder {
    /// Position on the bus where the servo's own position is zero, rad.
    pub zero_rad: f32,
    /// How far the encoder turns before it begins anew, rad.
    pub turn_rad: f32,
}

/// A turn, with the zero in its middle: Dynamixel X and MX, STS.
impl Default for Encoder {
    fn default() -> Self {
        Self { zero_rad: PI, turn_rad: TAU }
    }
}

impl Encoder {
    /// Refuses a range that goes over the seam of the encoder, where its reading jumps by a turn: a servo that starts
    /// there does not know on which side it is.
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
