//! Feed-forward of a joint's friction.

use super::error::DriveError;
use super::numbers::bounded;

/// Speed from which Coulomb friction is fed forward in full, rad/s or m/s. Below it the share is proportional to
/// speed, so that a joint at rest gets no friction effort and a noisy target does not make the drive buzz.
pub const FULL_SPEED: f32 = 0.01;

/// Friction of one dof.
///
/// ```
/// use sinew_rig::drive::Friction;
/// let joint = Friction::new(0.1, 0.02)?;
/// assert!((joint.effort(3.0) - 0.16).abs() < 1e-6);
/// assert_eq!(joint.effort(-3.0), -joint.effort(3.0));
/// assert_eq!(joint.effort(0.0), 0.0);
/// assert!(Friction::new(-0.1, 0.0).is_err());
/// # Ok::<(), sinew_rig::drive::DriveError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Friction {
    coulomb: f32,
    viscous: f32,
}

impl Friction {
    /// Zero friction.
    pub const NONE: Self = Self { coulomb: 0.0, viscous: 0.0 };

    /// Creates the friction of a joint: Coulomb friction in N m or N, viscous friction in N m s/rad or N s/m.
    ///
    /// # Errors
    /// [`DriveError::Number`] if a number is negative or not finite.
    pub fn new(coulomb: f32, viscous: f32) -> Result<Self, DriveError> {
        let from_zero = |what, found| bounded(what, 0, found, [0.0, f32::MAX]);
        Ok(Self {
            coulomb: from_zero("coulomb friction", coulomb)?,
            viscous: from_zero("viscous friction", viscous)?,
        })
    }

    /// Returns whether the friction is zero.
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    /// Returns the effort that overcomes the friction at a commanded speed (rad/s or m/s), N m or N.
    pub fn effort(&self, speed: f32) -> f32 {
        self.coulomb * (speed / FULL_SPEED).clamp(-1.0, 1.0) + self.viscous * speed
    }
}
