//! What a person may choose.

/// What comes first in a limb that has too few joints for both of its parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Limb {
    /// Both parts alike.
    #[default]
    Both,
    /// The way from shoulder to hand, or from hip to foot.
    End,
    /// The upper arm, or the thigh.
    Upper,
}

/// How a performance is taken over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Largest speed of turning joints that name none, rad/s.
    pub speed_rad_s: f64,
    /// How far the rig travels for a metre of the performer; `None`: by the length of the legs.
    pub scale: Option<f64>,
    /// Left and right changed.
    pub is_mirrored: bool,
    /// Of a rig whose base is fixed: how far the performance is tilted, rad; a quarter turn lifts what hangs to
    /// forward. See [`super::best_tilt`].
    pub tilt_rad: f64,
    /// Arms.
    pub arms: Limb,
    /// Legs.
    pub legs: Limb,
    /// Whether the rig's free base travels and its feet stand; else it turns on the spot.
    pub travels: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            // Costs nothing that can be measured in walks and fights.
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
