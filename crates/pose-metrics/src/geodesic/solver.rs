//! The least energy of a curve between two poses: Newton's method with a trust region in Levenberg's form, joint ranges
//! by barriers that get lower and lower (a primal-dual interior-point method: Nocedal & Wright 2006, chapter 19).

use super::curve::Curve;
use super::joint::JointPosition;
use super::model::{Model, NextCurve};
use super::rig::{Rig, RigError};

/// How to solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Number of steps of the curve, N of the paper: there are N - 1 poses to find.
    pub steps: usize,
    /// Ends when no component of the gradient is above this share of the energy at the start (per rad or m), nor the
    /// product of any limit's force and distance; or above what rounding comes to.
    pub tolerance: f64,
    /// Gives up after so many iterations.
    pub iterations: usize,
    /// Whether second derivatives of the positions are used; without, it is the method of Gauss and Newton.
    pub second_derivatives: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { steps: 10, tolerance: 1e-9, iterations: 200, second_derivatives: true }
    }
}

/// A curve of least energy.
#[derive(Debug, Clone, PartialEq)]
pub struct Geodesic {
    /// All poses, both ends among them.
    pub poses: Vec<Vec<JointPosition>>,
    /// Σ of the squared steps, m².
    pub energy_m2: f64,
    /// Σ of the steps, m.
    pub length_m: f64,
    /// The length of the curve that it started from: every joint on its own shortest way, m.
    pub line_length_m: f64,
    /// Largest component of the gradient that no range keeps.
    pub gradient: f64,
    /// Whether the gradient is as small as was asked for.
    pub converged: bool,
    /// What every iteration came to.
    pub course: Vec<Iteration>,
}

/// After an iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// The energy, m².
    pub energy_m2: f64,
    /// Largest component of the gradient that no range keeps.
    pub gradient: f64,
    /// Levenberg's factor.
    pub damping: f64,
}

/// Factor on the damping of a step that was as good as predicted.
const SLOWEST: f64 = 1.0 / 3.0;

/// Height of barriers at the start, as a share of the energy, and how much lower the next ones are.
const HEIGHT: f64 = 1e-2;
const LOWER: f64 = 0.1;

/// How far from the ends of ranges the curve starts, as a share of their widths.
const MARGIN: f64 = 1e-2;

/// The curve of least energy (eq. 6) from one pose to another, each brought within the ranges: of several, the one
/// downhill from every joint's own shortest way. An iteration takes O(steps · columns³), and of a rig with many more
/// columns than steps O(joints · steps³).
///
/// # Errors
/// [`RigError`] if a pose is not one of the rig.
pub fn solve(
    rig: &Rig,
    from: &[JointPosition],
    to: &[JointPosition],
    options: &Options,
) -> Result<Geodesic, RigError> {
    let (from, to) = (rig.checked(from)?, rig.checked(to)?);
    let steps = options.steps.max(1);
    let poses = (0..=steps).map(|k| rig.between(&from, &to, k as f64 / steps as f64));
    // Within the ranges, where those are not convex in turns.
    let line = Curve::new(rig, poses.collect()).within(rig, 0.0);
    let line_length_m = line.length_m();
    let scale = line.energy_m2;
    // Of poses that are nearly the same, gradients are not known better than positions are rounded.
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
        // What is left to gain on barriers of this height is less than what lower ones give.
        let is_centred = decrement_m2 <= height_m2;
        let lower_m2 = if is_centred { (LOWER * height_m2).max(LOWER * enough) } else { height_m2 };
        let is_lower = model_now.press_m2 > enough && lower_m2 < height_m2;
        // Near the end, energies differ by their rounding only: there the model is trusted while it gets flatter.
        let is_rounding = predicted_m2 < 1e-12 * curve.energy_m2;
        let next_model = (gain_m2 > 0.0 || is_rounding).then(|| model(&next, lower_m2));
        match next_model {
            Some(next_model) if !is_rounding || is_lower || off(&next_model) < off(&model_now) => {
                let ratio = if is_rounding { 1.0 } else { gain_m2 / predicted_m2 };
                // Nielsen's rule: smoothly down as the model proves good, ever faster up as it does not.
                damping *= f64::max(SLOWEST, 1.0 - (2.0 * ratio - 1.0).powi(3));
                damping = damping.max(1e-14);
                growth = 2.0;
                (curve, model_now, height_m2) = (next, next_model, lower_m2);
            }
            // Rounding is all that is left.
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
