//! A rig that still moves by itself. It cannot be armed until it rests.

use core::fmt;

/// The joint that most exceeds the speed at which the rig may be armed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Moving {
    /// Index of the dof.
    pub dof: u16,
    /// Speed of the dof, mrad/s; for a prismatic joint mm/s.
    pub mrad_s: u32,
    /// Maximum speed for arming, in the unit of `mrad_s`.
    pub most_mrad_s: u32,
}

impl Moving {
    /// Creates a record from a dof's speed and its maximum, rad/s; for a prismatic joint m/s.
    pub(crate) fn new(dof: usize, rad_s: f32, most_rad_s: f32) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
        let [mrad_s, most_mrad_s] = [rad_s, most_rad_s].map(|rad_s| (rad_s.abs() * 1e3) as u32);
        Self { dof: u16::try_from(dof).unwrap_or(u16::MAX), mrad_s, most_mrad_s }
    }

    /// Returns the speed and its maximum, rad/s; for a prismatic joint m/s.
    pub fn rad_s(&self) -> [f32; 2] {
        [self.mrad_s, self.most_mrad_s].map(|mrad_s| mrad_s as f32 * 1e-3)
    }
}

impl fmt::Display for Moving {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [now, most] = self.rad_s();
        write!(f, "joint {} at {now:.3} rad/s, at most {most:.3}", self.dof)
    }
}
