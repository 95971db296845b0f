//! The least energy of a curve between two poses: Newton's method with a trust region in Levenberg's form, joint ranges
//! by holding what is pressed against their ends.

use super::joint::JointPosition;
use super::model::Model;
use super::rig::{Placed, Rig, RigError};

/// How to solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Number of steps of the curve, N of the paper: there are N - 1 poses to find.
    pub steps: usize,
    /// Ends when no component of the gradient is above this share of the energy at the start (per rad or m), or above
    /// what rounding comes to.
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
    let still = vec![0.0; rig.columns];
    let poses = (0..=steps)
        .map(|k| {
            // Within the ranges, where those are not convex in turns.
            rig.stepped(&rig.between(&from, &to, k as f64 / steps as f64), &still)
        })
        .collect();
    let mut curve = Curve::new(rig, poses);
    let line_length_m = curve.length_m();
    let scale = curve.energy_m2;
    let (mut damping, mut growth, mut course) = (1e-3, 2.0, Vec::new());
    let mut model = Model::new(rig, &curve, options.second_derivatives);
    // Of poses that are nearly the same, gradients are not known better than positions are rounded.
    let rounding = 64.0 * f64::EPSILON * curve.placed[0].f.norm_squared();
    let is_done = |model: &Model| model.gradient <= (options.tolerance * scale).max(rounding);
    while !is_done(&model) && course.len() < options.iterations {
        let Some((next, predicted)) = model.step(rig, &curve, damping) else {
            damping = (damping * 10.0).max(1e-8);
            if damping > 1e12 {
                break;
            }
            continue;
        };
        let gain = curve.energy_m2 - next.energy_m2;
        // Near the end, energies differ by their rounding only: there the model is trusted while it gets flatter.
        let is_rounding = predicted < 1e-12 * curve.energy_m2;
        let next_model =
            (gain > 0.0 || is_rounding).then(|| Model::new(rig, &next, options.second_derivatives));
        match next_model {
            Some(next_model) if !is_rounding || next_model.gradient < model.gradient => {
                let ratio = if is_rounding { 1.0 } else { gain / predicted };
                // Nielsen's rule: smoothly down as the model proves good, ever faster up as it does not.
                damping *= f64::max(SLOWEST, 1.0 - (2.0 * ratio - 1.0).powi(3));
                damping = damping.max(1e-14);
                growth = 2.0;
                (curve, model) = (next, next_model);
            }
            // Rounding is all that is left.
            _ if is_rounding && damping > 1.0 => break,
            _ => {
                damping = damping.max(1e-10) * growth;
                growth *= 2.0;
            }
        }
        course.push(Iteration { energy_m2: curve.energy_m2, gradient: model.gradient, damping });
        if damping > 1e12 {
            break;
        }
    }
    Ok(Geodesic {
        energy_m2: curve.energy_m2,
        length_m: curve.length_m(),
        line_length_m,
        gradient: model.gradient,
        converged: is_done(&model),
        poses: curve.poses,
        course,
    })
}

/// A curve, and where it puts the joints.
pub(super) struct Curve {
    pub(super) poses: Vec<Vec<JointPosition>>,
    pub(super) placed: Vec<Placed>,
    energy_m2: f64,
}

impl Curve {
    pub(super) fn new(rig: &Rig, poses: Vec<Vec<JointPosition>>) -> Self {
        let placed: Vec<_> = poses.iter().map(|pose| rig.place(pose)).collect();
        let energy_m2 =
            placed.windows(2).map(|pair| (&pair[1].f - &pair[0].f).norm_squared()).sum();
        Self { poses, placed, energy_m2 }
    }

    /// The poses between the ends.
    pub(super) fn inner(&self) -> &[Placed] {
        &self.placed[1..self.placed.len() - 1]
    }

    fn length_m(&self) -> f64 {
        self.placed.windows(2).map(|pair| (&pair[1].f - &pair[0].f).norm()).sum()
    }
}
