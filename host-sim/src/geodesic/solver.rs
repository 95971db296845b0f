//! The least energy of a curve between two poses: Newton's method with a trust region in Levenberg's form, its matrix
//! block-tridiagonal, joint ranges by holding what is pressed against their ends.

use nalgebra::{DMatrix, DVector};

use super::block_tridiagonal;
use super::joint::JointPosition;
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

/// What is added to second derivatives for every unit of the gradient.
const RIDGE: f64 = 0.3;

/// The curve of least energy (eq. 6) from one pose to another, each brought within the ranges: of several, the one
/// downhill from every joint's own shortest way. O(steps · columns³) for each iteration.
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
    let mut model = Model::new(rig, &curve, options);
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
        let next_model = (gain > 0.0 || is_rounding).then(|| Model::new(rig, &next, options));
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
struct Curve {
    poses: Vec<Vec<JointPosition>>,
    placed: Vec<Placed>,
    energy_m2: f64,
}

impl Curve {
    fn new(rig: &Rig, poses: Vec<Vec<JointPosition>>) -> Self {
        let placed: Vec<_> = poses.iter().map(|pose| rig.place(pose)).collect();
        let energy_m2 =
            placed.windows(2).map(|pair| (&pair[1].f - &pair[0].f).norm_squared()).sum();
        Self { poses, placed, energy_m2 }
    }

    fn length_m(&self) -> f64 {
        self.placed.windows(2).map(|pair| (&pair[1].f - &pair[0].f).norm()).sum()
    }
}

/// The energy near a curve, to second order, with what the ranges hold.
struct Model {
    diagonal: Vec<DMatrix<f64>>,
    above: Vec<DMatrix<f64>>,
    /// Without second derivatives, for where the other is not convex.
    convex: Vec<DMatrix<f64>>,
    downhill: Vec<DVector<f64>>,
    /// Largest component of the gradient that is not held.
    gradient: f64,
    /// What is added to the diagonal.
    ridge: f64,
}

impl Model {
    fn new(rig: &Rig, curve: &Curve, options: &Options) -> Self {
        let inner = 1..curve.placed.len() - 1;
        let jacobians: Vec<_> = inner.clone().map(|k| rig.jacobian(&curve.placed[k])).collect();
        let mut model = Self {
            diagonal: Vec::new(),
            above: Vec::new(),
            convex: Vec::new(),
            downhill: Vec::new(),
            gradient: 0.0,
            ridge: 0.0,
        };
        let mut held_before: Vec<bool> = Vec::new();
        for (row, k) in inner.enumerate() {
            let [before, at, after] = [k - 1, k, k + 1].map(|k| &curve.placed[k]);
            let force = ((&at.f - &before.f) - (&after.f - &at.f)) * 2.0;
            let jacobian = &jacobians[row];
            let mut downhill = -jacobian.tr_mul(&force);
            let ends = rig.ends(&curve.poses[k]);
            let held: Vec<bool> = ends
                .iter()
                .zip(&downhill)
                .map(|(end, downhill)| end[usize::from(*downhill > 0.0)])
                .collect();
            let mut convex = jacobian.tr_mul(jacobian) * 4.0;
            let mut diagonal = convex.clone();
            if options.second_derivatives {
                diagonal += rig.bend(at, &force);
            }
            // Who goes along the end of a turn's range is brought back onto it, uphill.
            for (column, bend) in rig.spheres(&curve.poses[k]) {
                if held[column] {
                    for across in [column + 1, column + 2] {
                        diagonal[(across, across)] += downhill[column] * bend;
                        convex[(across, across)] += downhill[column] * bend;
                    }
                }
            }
            for (index, _) in held.iter().enumerate().filter(|(_, held)| **held) {
                downhill[index] = 0.0;
                hold(&mut diagonal, index);
                hold(&mut convex, index);
            }
            if row > 0 {
                let mut above = jacobians[row - 1].tr_mul(jacobian) * -2.0;
                for (index, _) in held_before.iter().enumerate().filter(|(_, held)| **held) {
                    above.row_mut(index).fill(0.0);
                }
                for (index, _) in held.iter().enumerate().filter(|(_, held)| **held) {
                    above.column_mut(index).fill(0.0);
                }
                model.above.push(above);
            }
            model.gradient = model.gradient.max(downhill.amax());
            model.diagonal.push(diagonal);
            model.convex.push(convex);
            model.downhill.push(downhill);
            held_before = held;
        }
        if options.second_derivatives {
            model.ridge = RIDGE * model.gradient;
        }
        model
    }

    /// The curve after a step, and how much less its energy should be. `None` if the step cannot be found.
    fn step(&self, rig: &Rig, curve: &Curve, damping: f64) -> Option<(Curve, f64)> {
        // Turns of two joints that undo each other move nothing; second derivatives along them are as large as the
        // gradient, of either sign. A ridge of that size keeps them positive, and goes as the end is near.
        let damped = |blocks: &[DMatrix<f64>], ridge: f64| -> Vec<DMatrix<f64>> {
            let largest =
                self.convex.iter().map(|block| block.diagonal().max()).fold(0.0, f64::max);
            let pairs = blocks.iter().zip(&self.convex);
            pairs
                .map(|(block, convex)| {
                    let mut block = block.clone();
                    for (index, own) in convex.diagonal().iter().enumerate() {
                        // Turns that move next to nothing get a floor: without one they go anywhere.
                        block[(index, index)] +=
                            damping * own.max(1e-3 * largest) + 1e-12 * largest + ridge;
                    }
                    block
                })
                .collect()
        };
        let solve = |blocks: &[DMatrix<f64>], ridge: f64| {
            let damped = damped(blocks, ridge);
            let step = block_tridiagonal::solve(&damped, &self.above, &self.downhill)?;
            Some((step, blocks.to_vec()))
        };
        let (step, blocks) =
            solve(&self.diagonal, self.ridge).or_else(|| solve(&self.convex, 0.0))?;
        // What the model says of the step: -gᵀs - ½ sᵀHs.
        let mut predicted = 0.0;
        for (k, step_k) in step.iter().enumerate() {
            predicted += self.downhill[k].dot(step_k) - 0.5 * step_k.dot(&(&blocks[k] * step_k));
            if let Some(after) = step.get(k + 1) {
                predicted -= step_k.dot(&(&self.above[k] * after));
            }
        }
        let mut poses = curve.poses.clone();
        for (pose, step) in poses[1..].iter_mut().zip(&step) {
            *pose = rig.stepped(pose, step.as_slice());
        }
        Some((Curve::new(rig, poses), predicted))
    }
}

/// Takes a coordinate out of a block: it stays where it is.
fn hold(block: &mut DMatrix<f64>, index: usize) {
    block.row_mut(index).fill(0.0);
    block.column_mut(index).fill(0.0);
    block[(index, index)] = 1.0;
}
