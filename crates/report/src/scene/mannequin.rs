//! A rig as a mannequin: round parts between the points of its bodies.

use glam::DVec3;
use sinew_figure::plant::Pose;

/// Points of a mannequin in the world, in metres.
pub type Points = Vec<DVec3>;

/// A round part: between which points, from which to which share of the way, and how thick at both ends, in
/// metres for a girth of 1.
pub(crate) type Part = (usize, usize, f64, f64, f64, f64);

/// The measured mannequin is drawn inside the desired one, this much thinner: where they agree, an even white
/// rim is left, and where they do not, red stands out of it.
pub(crate) const MEASURED_GIRTH: f64 = 0.74;

/// The shape of a rig. It has no other meaning than to be looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Mannequin {
    /// The body that each point is on, and where in its frame, in metres.
    pub(super) points: Vec<(usize, DVec3)>,
    pub(super) parts: Vec<Part>,
    /// Number of the first parts that make one body of many, the trunk: they hide each other by no depth.
    pub(super) trunk: usize,
    /// Factor on the thickness of all parts.
    pub(super) girth: f64,
}

impl Mannequin {
    /// Every body in its own factor's dimensions, and as thick as they are on average.
    pub(crate) fn scaled_by(&self, factors: &[f64]) -> Self {
        let mean = factors.iter().sum::<f64>() / factors.len() as f64;
        Self {
            points: self.points.iter().map(|(body, at)| (*body, *at * factors[*body])).collect(),
            girth: self.girth * mean,
            ..self.clone()
        }
    }

    /// Factor on the thickness of all parts.
    pub fn girth(&self) -> f64 {
        self.girth
    }

    /// The largest radius of a part, in metres.
    pub(crate) fn thickest_m(&self) -> f64 {
        let radii = self.parts.iter().flat_map(|part| [part.4, part.5]);
        self.girth * radii.fold(0.0, f64::max)
    }

    pub(crate) fn parts(&self) -> &[Part] {
        &self.parts
    }

    pub(crate) fn trunk(&self) -> usize {
        self.trunk
    }

    /// Its points at poses of the bodies in the world.
    pub fn points(&self, poses: &[Pose]) -> Points {
        let in_world = |(body, at): &(usize, DVec3)| poses[*body].point(*at);
        self.points.iter().map(in_world).collect()
    }
}
