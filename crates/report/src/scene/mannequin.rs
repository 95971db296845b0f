//! A mannequin: the shape of a rig, with round parts between the points of its bodies.

use glam::DVec3;
use sinew_figure::plant::Pose;

/// Points of a mannequin in the world, in metres.
pub type Points = Vec<DVec3>;

/// A round part: index of both points, shares of the distance at which it starts and ends, and radius at both
/// ends, in metres for a girth of 1.
pub(crate) type Part = (usize, usize, f64, f64, f64, f64);

/// Thickness of the measured mannequin relative to the desired one. It is drawn inside the desired one: if they
/// agree, an even white rim remains visible; otherwise red protrudes from it.
pub(crate) const MEASURED_GIRTH: f64 = 0.74;

/// The shape of a rig, only for display.
#[derive(Debug, Clone, PartialEq)]
pub struct Mannequin {
    /// Body of each point, and the point's position in the body's frame, in metres.
    pub(super) points: Vec<(usize, DVec3)>,
    pub(super) parts: Vec<Part>,
    /// Number of parts that make the trunk: the first ones of the list. They are drawn together, without sorting by
    /// depth.
    pub(super) trunk: usize,
    /// Factor on the thickness of all parts.
    pub(super) girth: f64,
}

impl Mannequin {
    /// Returns the mannequin with each body scaled by its own factor, and the thickness by the mean factor.
    pub(crate) fn scaled_by(&self, factors: &[f64]) -> Self {
        let mean = factors.iter().sum::<f64>() / factors.len() as f64;
        Self {
            points: self.points.iter().map(|(body, at)| (*body, *at * factors[*body])).collect(),
            girth: self.girth * mean,
            ..self.clone()
        }
    }

    /// Returns the factor on the thickness of all parts.
    pub fn girth(&self) -> f64 {
        self.girth
    }

    /// Returns the largest radius of a part, in metres.
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

    /// Returns the mannequin's points for poses of the bodies in the world.
    pub fn points(&self, poses: &[Pose]) -> Points {
        let in_world = |(body, at): &(usize, DVec3)| poses[*body].point(*at);
        self.points.iter().map(in_world).collect()
    }
}
