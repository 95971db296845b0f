//! Report of a motion's check.

use serde::Serialize;

/// Kind of limit that was exceeded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The position is beyond an end of the range.
    Range,
    /// A limit that joins two joints is exceeded.
    LinkedRange,
    /// The speed is too large.
    Speed,
    /// The acceleration is too large.
    Acceleration,
    /// The effort is too large.
    Effort,
    /// The mean square of the effort is too large, so that the drive overheats. The mean is over the drive's
    /// thermal time or, for a repeated motion, over the whole motion.
    Heat,
    /// A servo that closes its own loop is predicted to be so far behind for so long that the supervisor would end the
    /// show. [`check`](super::check()) does not find this: it needs the servos, not only limits.
    Following,
}

impl Kind {
    /// Number of kinds.
    pub(super) const COUNT: usize = 7;

    /// Returns the name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Range => "range",
            Self::LinkedRange => "linked range",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::Effort => "torque",
            Self::Heat => "heat",
            Self::Following => "following error",
        }
    }

    /// Returns the display unit, for a joint that turns or one that slides.
    pub fn unit(self, slides: bool) -> &'static str {
        match (self, slides) {
            (Self::Range | Self::LinkedRange | Self::Following, false) => "°",
            (Self::Range | Self::LinkedRange | Self::Following, true) => " mm",
            (Self::Speed, false) => " rad/s",
            (Self::Speed, true) => " m/s",
            (Self::Acceleration, false) => " rad/s²",
            (Self::Acceleration, true) => " m/s²",
            (Self::Effort | Self::Heat, false) => " N m",
            (Self::Effort | Self::Heat, true) => " N",
        }
    }

    /// Formats a value in [its unit](Self::unit), with three decimals.
    pub fn shown(self, slides: bool, value: f64) -> String {
        let value = match (self, slides) {
            (Self::Range | Self::LinkedRange | Self::Following, false) => value.to_degrees(),
            (Self::Range | Self::LinkedRange | Self::Following, true) => 1000.0 * value,
            _ => value,
        };
        format!("{value:.3}{}", self.unit(slides))
    }
}

/// A period during which a dof exceeds a limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Excess {
    /// Index of the dof, in the order of `qd`.
    #[serde(rename = "freedom")]
    pub dof: usize,
    /// Kind of limit.
    pub kind: Kind,
    /// Start of the period, s.
    pub from_s: f64,
    /// End of the period, s.
    pub to_s: f64,
    /// Time of the largest excess, s.
    pub worst_s: f64,
    /// Value at that time: rad, rad/s, rad/s² or N m; for a slide, m, m/s, m/s² or N.
    pub value: f64,
    /// Value of the limit.
    pub limit: f64,
}

/// Extreme values of a dof.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct DofPeaks {
    /// Minimum position, rad or m.
    pub least: f64,
    /// Maximum position, rad or m.
    pub most: f64,
    /// Largest speed, rad/s or m/s.
    pub speed: f64,
    /// Largest acceleration, rad/s² or m/s².
    pub acceleration: f64,
    /// Largest effort, N m or N.
    pub effort: f64,
    /// Root mean square effort over the whole motion, N m or N.
    pub effort_rms: f64,
}

/// Demands of a motion on a rig.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Duration of the motion, s.
    pub duration_s: f64,
    /// Largest values of each dof, in the order of `qd`.
    pub peaks: Vec<DofPeaks>,
    /// Excesses, sorted by dof, then by kind, then by time.
    pub excesses: Vec<Excess>,
}

impl Report {
    /// Adds excesses, and restores the order.
    pub fn add(&mut self, excesses: impl IntoIterator<Item = Excess>) {
        self.excesses.extend(excesses);
        self.excesses.sort_by(|a, b| {
            (a.dof, a.kind).cmp(&(b.dof, b.kind)).then(a.from_s.total_cmp(&b.from_s))
        });
    }
}
