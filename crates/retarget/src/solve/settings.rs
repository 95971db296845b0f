//! Settings of the solver.

use crate::rig::RigMatch;

/// Priority in a limb that has too few joints for both of its parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Limb {
    /// Both parts have equal weight.
    #[default]
    Both,
    /// The direction from shoulder to hand, or from hip to foot.
    End,
    /// The direction of the upper arm, or of the thigh.
    Upper,
    /// The place of the end relative to the shoulder or the hip, scaled by the lengths of the limbs.
    Path,
}

/// Settings by which a rig follows a performance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Maximum speed of turning joints without a speed limit, rad/s.
    pub speed_rad_s: f64,
    /// Distance that the rig travels per metre of the performer; `None`: the ratio of leg lengths.
    pub scale: Option<f64>,
    /// Whether left and right are exchanged.
    pub is_mirrored: bool,
    /// For a rig with a fixed base: angle by which the performance is tilted, rad; 90 deg turns a hanging limb to
    /// point forward. See [`super::best_tilt`].
    pub tilt_rad: f64,
    /// Priority in arms with too few joints.
    pub arms: Limb,
    /// Priority in legs with too few joints.
    pub legs: Limb,
    /// Whether the rig's free base travels and its feet stand; otherwise it turns on the spot.
    pub travels: bool,
}

impl Settings {
    /// Returns the default settings for a rig. A rig that is only one arm is too small for the directions of a
    /// performer's arm, so its hand goes along the performer's path.
    pub fn of(rig: &RigMatch) -> Self {
        let default = Self::default();
        if rig.is_one_arm() { Self { arms: Limb::Path, ..default } } else { default }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            // In walks and fights, this limit has no measurable effect.
            speed_rad_s: 12.0,
            scale: None,
            is_mirrored: false,
            tilt_rad: 0.0,
            arms: Limb::Both,
            legs: Limb::Both,
            travels: true,
        }
    }
}
