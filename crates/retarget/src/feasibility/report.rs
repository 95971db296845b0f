//! The report of a motion's check.

use serde::Serialize;

/// What was exceeded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The position is beyond an end of the range.
    Range,
    /// A limit that joins two joints.
    LinkedRange,
    /// The speed.
    Speed,
    /// The acceleration.
    Acceleration,
    /// The effort.
    Effort,
    /// The mean square of the effort, over the drive's thermal time or, as if it were played again and again, over the
    /// whole: the drive becomes too hot.
    Heat,
}

impl Kind {
    /// How many there are.
    pub(super) const COUNT: usize = 6;

    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Range => "range",
            Self::LinkedRange => "linked range",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::Effort => "torque",
            Self::Heat => "heat",
        }
    }

    /// The unit that people read it in: of a joint that turns, or of one that slides.
    pub fn unit(self, slides: bool) -> &'static str {
        match (self, slides) {
            (Self::Range | Self::LinkedRange, false) => "°",
            (Self::Range | Self::LinkedRange, true) => " mm",
            (Self::Speed, false) => " rad/s",
            (Self::Speed, true) => " m/s",
            (Self::Acceleration, false) => " rad/s²",
            (Self::Acceleration, true) => " m/s²",
            (Self::Effort | Self::Heat, false) => " N m",
            (Self::Effort | Self::Heat, true) => " N",
        }
    }

    /// A value in [its unit](Self::unit), to three places.
    pub fn shown(self, slides: bool, value: f64) -> String {
        let value = match (self, slides) {
            (Self::Range | Self::LinkedRange, false) => value.to_degrees(),
            (Self::Range | Self::LinkedRange, true) => 1000.0 * value,
            _ => value,
        };
        format!("{value:.3}{}", self.unit(slides))
    }
}

/// A time over which a dof is beyond a limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Excess {
    /// The dof's index in the order of `qd`.
    #[serde(rename = "freedom")]
    pub dof: usize,
    /// Of what.
    pub kind: Kind,
    /// From when, s.
    pub from_s: f64,
    /// Until when, s.
    pub to_s: f64,
    /// When it is worst, s.
    pub worst_s: f64,
    /// The value there: rad, rad/s, rad/s², N m, or their likes of a slide.
    pub value: f64,
    /// The limit.
    pub limit: f64,
}

/// The largest values of a dof, without their signs.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct DofPeaks {
    /// Least position, rad or m.
    pub least: f64,
    /// Most position.
    pub most: f64,
    /// rad/s or m/s.
    pub speed: f64,
    /// rad/s² or m/s².
    pub acceleration: f64,
    /// N m or N.
    pub effort: f64,
    /// Root mean square over the whole motion, N m or N.
    pub effort_rms: f64,
}

/// What a motion asks of a rig.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// How long the motion is, s.
    pub duration_s: f64,
    /// By dof, in the order of `qd`.
    pub peaks: Vec<DofPeaks>,
    /// By dof, then in time.
    pub excesses: Vec<Excess>,
}
