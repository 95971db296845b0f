//! Errors of the measured figure relative to the desired figure, in the world, as the paper reports them.

use serde::{Deserialize, Serialize};
use sinew_figure::plant::Pose;

use super::pose_error::PoseError;
use super::rig::Rig;
use super::step::Step;

/// Errors over all bodies, and over the leaves alone (for the figure: head, hands, feet).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Errors {
    /// Errors over all bodies.
    pub all: ErrorTotals,
    /// Errors over the leaves.
    pub leaf: ErrorTotals,
    /// Errors of whole poses, in which every joint has the weight of the skin that it moves: see
    /// [`ImportanceWeights`](super::ImportanceWeights).
    pub weighted: WeightedTotals,
    /// Widest gap at a joint, in metres: a defect of the plant's constraints.
    pub widest_gap_m: f64,
    /// Number of times that a joint did not receive its desired torque.
    pub limited: u64,
}

/// Sums and maxima of the errors of many poses.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ErrorTotals {
    /// Number of poses.
    pub n: u64,
    angular_sum_rad: f64,
    linear_sum_m: f64,
    angular_max_rad: f64,
    linear_max_m: f64,
}

/// Sum and maximum of the importance-weighted errors of many poses.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WeightedTotals {
    /// Number of poses of the whole figure.
    pub n: u64,
    sum_m: f64,
    max_m: f64,
}

impl Errors {
    /// Adds one step: the desired and the measured poses of all bodies.
    pub fn add(&mut self, desired: &[Pose], measured: &[Pose], rig: &Rig) {
        let errors: Vec<PoseError> = PoseError::between(desired, measured).collect();
        self.add_errors(&errors, rig.importance_weights().error_m(desired, measured), rig);
    }

    fn add_errors(&mut self, errors: &[PoseError], weighted_m: f64, rig: &Rig) {
        self.weighted.add(weighted_m);
        for (body, error) in errors.iter().enumerate().skip(rig.first_judged()) {
            self.all.add(error);
            if rig.is_leaf(body) {
                self.leaf.add(error);
            }
        }
    }

    /// Adds one step of a run.
    pub fn add_step(&mut self, step: &Step<'_>) {
        let weighted_m = step.rig.importance_weights().error_m(step.desired, step.measured);
        self.add_errors(step.errors, weighted_m, step.rig);
        self.widest_gap_m = self.widest_gap_m.max(step.widest_gap_m());
        self.limited += step.limited as u64;
    }

    /// Adds the totals of another run.
    pub fn merge(&mut self, other: &Self) {
        self.all.merge(&other.all);
        self.leaf.merge(&other.leaf);
        self.weighted.merge(&other.weighted);
        self.widest_gap_m = self.widest_gap_m.max(other.widest_gap_m);
        self.limited += other.limited;
    }
}

impl ErrorTotals {
    #[inline]
    pub(super) fn add(&mut self, error: &PoseError) {
        let PoseError { angular_rad, linear_m } = *error;
        self.n += 1;
        self.angular_sum_rad += angular_rad;
        self.linear_sum_m += linear_m;
        self.angular_max_rad = self.angular_max_rad.max(angular_rad);
        self.linear_max_m = self.linear_max_m.max(linear_m);
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.n += other.n;
        self.angular_sum_rad += other.angular_sum_rad;
        self.linear_sum_m += other.linear_sum_m;
        self.angular_max_rad = self.angular_max_rad.max(other.angular_max_rad);
        self.linear_max_m = self.linear_max_m.max(other.linear_max_m);
    }

    /// Returns the mean angular error in degrees.
    pub fn angular_mean_deg(&self) -> f64 {
        (self.angular_sum_rad / self.n as f64).to_degrees()
    }

    /// Returns the mean linear error in centimetres.
    pub fn linear_mean_cm(&self) -> f64 {
        self.linear_sum_m / self.n as f64 * 100.0
    }

    /// Returns the largest angular error in degrees.
    pub fn angular_max_deg(&self) -> f64 {
        self.angular_max_rad.to_degrees()
    }

    /// Returns the largest linear error in centimetres.
    pub fn linear_max_cm(&self) -> f64 {
        self.linear_max_m * 100.0
    }

    /// Returns means and maxima in the order of the paper's tables: mean angular (deg), mean linear (cm), maximum
    /// angular (deg), maximum linear (cm).
    pub fn figures(&self) -> [f64; 4] {
        [
            self.angular_mean_deg(),
            self.linear_mean_cm(),
            self.angular_max_deg(),
            self.linear_max_cm(),
        ]
    }
}

impl WeightedTotals {
    fn add(&mut self, error_m: f64) {
        self.n += 1;
        self.sum_m += error_m;
        self.max_m = self.max_m.max(error_m);
    }

    fn merge(&mut self, other: &Self) {
        self.n += other.n;
        self.sum_m += other.sum_m;
        self.max_m = self.max_m.max(other.max_m);
    }

    /// Returns the mean in centimetres.
    pub fn mean_cm(&self) -> f64 {
        self.sum_m / self.n as f64 * 100.0
    }

    /// Returns the maximum in centimetres.
    pub fn max_cm(&self) -> f64 {
        self.max_m * 100.0
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::ImportanceWeights;
    use sinew_figure::fixture;

    fn pose(rotation_vector: DVec3, position_m: DVec3) -> Pose {
        Pose { rotation: DQuat::from_scaled_axis(rotation_vector), position_m }
    }

    #[test]
    fn means_and_maxima_are_those_of_known_errors() {
        let mechanism = fixture::mechanism();
        let weights = ImportanceWeights::zero(&mechanism);
        let rig = Rig::with_weights(mechanism, weights);
        let still = vec![pose(DVec3::ZERO, DVec3::ZERO); rig.links().len()];
        let mut off = still.clone();
        // Body 3, the head, is a leaf; body 0, the pelvis, is not.
        off[3] = pose(DVec3::new(0.0, 0.18, 0.0), DVec3::new(0.0, 0.03, 0.04));
        off[0] = pose(DVec3::ZERO, DVec3::new(0.36, 0.0, 0.0));
        // A quaternion with the opposite sign is the same orientation.
        off[7].rotation = -off[7].rotation;
        let mut errors = Errors::default();
        errors.add(&still, &off, &rig);
        let mut twice = errors;
        twice.merge(&errors);
        for errors in [errors, twice] {
            assert!((errors.all.angular_mean_deg() - 0.01f64.to_degrees()).abs() < 1e-12);
            assert!((errors.all.linear_mean_cm() - 41.0 / 18.0).abs() < 1e-12);
            assert!((errors.leaf.linear_mean_cm() - 1.0).abs() < 1e-12);
            assert!((errors.leaf.linear_max_cm() - 5.0).abs() < 1e-12);
            assert!((errors.all.linear_max_cm() - 36.0).abs() < 1e-12);
            assert!((errors.all.angular_max_deg() - 0.18f64.to_degrees()).abs() < 1e-12);
            // With zero weights, only the error of the root's position counts.
            assert!((errors.weighted.mean_cm() - 36.0).abs() < 1e-12);
            assert!((errors.weighted.max_cm() - 36.0).abs() < 1e-12);
        }
        assert_eq!((errors.all.n, errors.leaf.n, twice.all.n), (18, 5, 36));
        assert_eq!((errors.weighted.n, twice.weighted.n), (1, 2));
    }
}
