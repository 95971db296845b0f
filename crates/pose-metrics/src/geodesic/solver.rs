//! Minimizes the energy of a curve between two poses by Newton's method with a trust region in Levenberg's form.
//! Joint ranges are barriers of decreasing height (a primal-dual interior-point method: Nocedal & Wright 2006,
//! chapter 19).

use super::curve::Curve;
use super::joint::JointPosition;
use super::model::{Model, NextCurve};
use super::rig::{Rig, RigError};

/// Options of the solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Number of steps of the curve, N in the paper: N - 1 poses are unknown.
    pub steps: usize,
    /// Convergence limit, as a share of the initial energy. The solver ends when each component of the gradient (per
    /// rad or m) and each product of a limit's force and gap is at most this share, or at most the rounding error.
    pub tolerance: f64,
    /// Maximum number of iterations.
    pub iterations: usize,
    /// Whether second derivatives of the positions are used; otherwise the Gauss-Newton method is used.
    pub second_derivatives: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { steps: 10, tolerance: 1e-9, iterations: 200, second_derivatives: true }
    }
}

/// A curve of minimum energy.
#[derive(Debug, Clone, PartialEq)]
pub struct Geodesic {
    /// All poses, including both ends.
    pub poses: Vec<Vec<JointPosition>>,
    /// Sum of the squared steps, m².
    pub energy_m2: f64,
    /// Sum of the steps, m.
    pub length_m: f64,
    /// Length of the initial curve, on which every joint takes its own shortest path, m.
    pub line_length_m: f64,
    /// Largest component of the gradient that no range balances.
    pub gradient: f64,
    /// Whether the gradient, and the products of the limits' forces and gaps, are within the tolerance.
    pub converged: bool,
    /// State after every iteration.
    pub course: Vec<Iteration>,
}

/// The state after an iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// Energy, m².
    pub energy_m2: f64,
    /// Largest component of the gradient that no range balances.
    pub gradient: f64,
    /// Levenberg's damping factor.
    pub damping: f64,
}

/// Minimum factor on the damping after a step that was as good as predicted.
const SLOWEST: f64 = 1.0 / 3.0;

/// Initial height of the barriers, as a share of the energy. The next constant is the factor for each lower
/// barrier.
const HEIGHT: f64 = 1e-2;
const LOWER: f64 = 0.1;

/// Initial distance of the curve from the ends of ranges, as a share of their widths.
const MARGIN: f64 = 1e-2;

/// Computes the curve of minimum energy (eq. 6) from one pose to another, both moved into the ranges. If there are
/// several minima, the result is the one that the descent reaches from the curve on which every joint moves on its own
/// shortest path. An iteration costs O(steps · columns³), or O(joints · steps³) for a rig with many more columns than
/// steps.
///
/// # Errors
/// [`RigError`] if a pose does not fit the rig.
pub fn solve(
    rig: &Rig,
    from: &[JointPosition],
    to: &[JointPosition],
    options: &Options,
) -> Result<Geodesic, RigError> {
    let (from, to) = (rig.checked(from)?, rig.checked(to)?);
    let steps = options.steps.max(1);
    let poses = (0..=steps).map(|k| rig.between(&from, &to, k as f64 / steps as f64));
    // Moved into the ranges, since ranges of rotations are not convex.
    let line = Curve::new(rig, poses.collect()).within(rig, 0.0);
    let line_length_m = line.length_m();
    let scale = line.energy_m2;
    // For poses that are nearly equal, gradients are not more accurate than the rounding of positions.
    let rounding = 64.0 * f64::EPSILON * line.placed[0].f.norm_squared();
    let enough = (options.tolerance * scale).max(rounding);
    let mut height_m2 = (HEIGHT * scale).max(enough);
    let mut curve = line.within(rig, MARGIN);
    curve.push(height_m2);
    let model = |curve: &Curve, height| Model::new(rig, curve, options.second_derivatives, height);
    let mut model_now = model(&curve, height_m2);
    let (mut damping, mut growth, mut course) = (1e-3, 2.0, Vec::new());
    let off = |model: &Model| model.gradient.max(model.press_m2);
    while off(&model_now) > enough && course.len() < options.iterations {
        let Some(next) = model_now.step(rig, &curve, damping) else {
            damping = (damping * 10.0).max(1e-8);
            if damping > 1e12 {
                break;
            }
            continue;
        };
        let NextCurve { curve: next, gain_m2, predicted_m2, decrement_m2 } = next;
        // The remaining gain with barriers of this height is smaller than the gain from lower barriers.
        let is_centred = decrement_m2 <= height_m2;
        let lower_m2 = if is_centred { (LOWER * height_m2).max(LOWER * enough) } else { height_m2 };
        let is_lower = model_now.press_m2 > enough && lower_m2 < height_m2;
        // Near the end, energies differ only by rounding. The model is then trusted while its gradient decreases.
        let is_rounding = predicted_m2 < 1e-12 * curve.energy_m2;
        let next_model = (gain_m2 > 0.0 || is_rounding).then(|| model(&next, lower_m2));
        match next_model {
            Some(next_model) if !is_rounding || is_lower || off(&next_model) < off(&model_now) => {
                let ratio = if is_rounding { 1.0 } else { gain_m2 / predicted_m2 };
                // Nielsen's rule: a smooth decrease while the model is good, an accelerating increase while it is
                // not.
                damping *= f64::max(SLOWEST, 1.0 - (2.0 * ratio - 1.0).powi(3));
                damping = damping.max(1e-14);
                growth = 2.0;
                (curve, model_now, height_m2) = (next, next_model, lower_m2);
            }
            // Only rounding error is left.
            _ if is_rounding && damping > 1.0 => break,
            _ => {
                damping = damping.max(1e-10) * growth;
                growth *= 2.0;
            }
        }
        let Curve { energy_m2, .. } = curve;
        course.push(Iteration { energy_m2, gradient: model_now.gradient, damping });
        if damping > 1e12 {
            break;
        }
    }
    let converged = off(&model_now) <= enough;
    let curve = curve.within(rig, 0.0);
    Ok(Geodesic {
        energy_m2: curve.energy_m2,
        length_m: curve.length_m(),
        line_length_m,
        gradient: model_now.gradient,
        converged,
        poses: curve.poses,
        course,
    })
}
