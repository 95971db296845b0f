//! A rig that still moves by itself, and is not armed until it rests.

use core::fmt;

/// The joint that is farthest beyond the speed at which it may be armed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Moving {
    /// Its dof.
    pub dof: u16,
    /// How fast it moves, mrad/s; of a slide mm/s.
    pub mrad_s: u32,
    /// How fast it may move, in the same unit.
    pub most_mrad_s: u32,
}

impl Moving {
    /// A dof with its speed and the most that it may have, rad/s; m/s of a slide.
    pub(crate) fn new(dof: usize, rad_s: f32, most_rad_s: f32) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
        let [mrad_s, most_mrad_s] = [rad_s, most_rad_s].map(|rad_s| (rad_s.abs() * 1e3) as u32);
        Self { dof: u16::try_from(dof).unwrap_or(u16::MAX), mrad_s, most_mrad_s }
    }

    /// How fast it moves, and how fast it may, rad/s; of a slide m/s.
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
