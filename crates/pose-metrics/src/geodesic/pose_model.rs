//! The energy near a curve, to second order, for one of its poses.

use nalgebra::DVector;

use super::curve::Curve;
use super::derivatives::Pull;
use super::rig::Rig;

/// The model of one pose, by column.
pub(super) struct PoseModel {
    /// Negative gradient.
    pub(super) downhill: DVector<f64>,
    /// Additions of the barriers to the diagonal.
    pub(super) barrier: DVector<f64>,
    /// Diagonal of the matrix, without the second derivatives of positions and without the barriers.
    pub(super) own: DVector<f64>,
    /// Effect of the forces that the curve's bends exert.
    pub(super) pull: Pull,
}

impl PoseModel {
    pub(super) fn new(rig: &Rig, curve: &Curve, k: usize) -> Self {
        let [before, at, after] = [k - 1, k, k + 1].map(|k| &curve.placed[k]);
        let force = ((&at.f - &before.f) - (&after.f - &at.f)) * 2.0;
        let pull = rig.pull(at, &force);
        let mut downhill = -&pull.along;
        let mut barrier = DVector::zeros(rig.columns);
        for limit in &curve.limits[k - 1] {
            downhill[limit.column] += limit.force * limit.slope;
            barrier[limit.column] += limit.force / limit.gap * limit.slope * limit.slope;
            for column in limit.column..limit.column + limit.bends {
                barrier[column] -= limit.force * limit.bend;
            }
        }
        Self { downhill, barrier, own: rig.squares(at) * 4.0, pull }
    }
}
