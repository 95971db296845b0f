//! Measures the time of a geodesic, compared with a general optimizer: `cargo bench -p sinew-host-bench --bench
//! geodesic`.
//!
//! The cases are pairs of poses of the built-in clips, far apart in time and in different clips, with curves of ten
//! steps. All methods start from the same straight line, and take turns on each pair, so that a slow phase of the
//! machine affects all. Our methods use their own coordinates and stop by their own gradient. `argmin`'s L-BFGS
//! uses rotation vectors, with cost and gradient written here in the simplest O(n) form, without code of ours.
//! Therefore all are compared by energy: its excess over the lowest energy that any method found for the pair.

use std::error::Error;
use std::time::Instant;

use argmin::core::{CostFunction, Executor, Gradient, State as _};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use glam::{DMat3, DQuat, DVec3};
use sinew_core::JointKind;
use sinew_core::projection::JointRange;
use sinew_figure::builtin;
use sinew_mocap::Skeleton;
use sinew_pose_metrics::geodesic::{self, JointPosition, Options, Rig, RigJoint};

/// Number of steps of a curve, as in the paper.
const STEPS: usize = 10;
/// Largest number of iterations of every method.
const ITERATIONS: u64 = 5_000;
/// Largest relative excess of an energy over the lowest at which both count as the same minimum.
const SAME: f64 = 1e-6;

/// A method to find the curve, with its results.
struct Contender {
    name: &'static str,
    solve: fn(&Pair) -> Result<Found, Box<dyn Error>>,
    found: Vec<Found>,
}

struct Found {
    energy_m2: f64,
    iterations: u64,
    time_ms: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let quick = std::env::args().any(|argument| argument == "--quick" || argument == "--test")
        || !std::env::args().any(|argument| argument == "--bench");
    let pairs = pairs(if quick { 3 } else { 40 })?;
    let mut contenders = [
        contender("Newton, block-tridiagonal", |pair| ours(pair, Options::default())),
        contender("the same, first derivatives", |pair| {
            ours(pair, Options { second_derivatives: false, ..Options::default() })
        }),
        contender("argmin L-BFGS, gradient 1e-4", |pair| l_bfgs(pair, 1e-4)),
        contender("argmin L-BFGS, gradient 1e-6", |pair| l_bfgs(pair, 1e-6)),
    ];
    for (turn, pair) in pairs.iter().enumerate() {
        for shift in 0..contenders.len() {
            let index = (turn + shift) % contenders.len();
            let contender = &mut contenders[index];
            contender.found.push((contender.solve)(pair)?);
        }
    }
    let least: Vec<f64> = (0..pairs.len())
        .map(|pair| {
            contenders.iter().map(|c| c.found[pair].energy_m2).fold(f64::INFINITY, f64::min)
        })
        .collect();
    let joints = pairs.first().map_or(0, |pair| pair.parents.len());
    println!("geodesics of {STEPS} steps, {joints} joints, {} pairs of poses", pairs.len());
    println!(
        "{:30}{:>12}{:>12}{:>12}{:>14}{:>12}{:>10}",
        "", "time, ms", "slowest", "iterations", "above least", "worst", "same"
    );
    for contender in &contenders {
        let of = |value: fn(&Found) -> f64| contender.found.iter().map(value).collect::<Vec<_>>();
        let above: Vec<f64> = of(|found| found.energy_m2)
            .iter()
            .zip(&least)
            .map(|(energy, least)| energy / least - 1.0)
            .collect();
        let same = above.iter().filter(|above| **above <= SAME).count();
        println!(
            "{:30}{:>12.2}{:>12.2}{:>12.0}{:>14.1e}{:>12.1e}{:>7} %",
            contender.name,
            median(of(|found| found.time_ms)),
            of(|found| found.time_ms).into_iter().fold(0.0, f64::max),
            median(of(|found| found.iterations as f64)),
            median(above.clone()),
            above.into_iter().fold(0.0, f64::max),
            100 * same / pairs.len().max(1),
        );
    }
    println!("medians; `same`: pairs whose energy is within {SAME:e} of the least that any found");
    Ok(())
}

fn contender(name: &'static str, solve: fn(&Pair) -> Result<Found, Box<dyn Error>>) -> Contender {
    Contender { name, solve, found: Vec::new() }
}

/// Two poses of a skeleton of spherical joints, as rotation vectors in rad.
struct Pair {
    parents: Vec<Option<usize>>,
    offsets_m: Vec<DVec3>,
    rig: Rig,
    from: Vec<DVec3>,
    to: Vec<DVec3>,
}

fn pairs(count: usize) -> Result<Vec<Pair>, Box<dyn Error>> {
    let clips = builtin::clips();
    let skeleton = clips.first().map(|clip| clip.skeleton.clone()).ok_or("there are no clips")?;
    let poses: Vec<Vec<DVec3>> = clips
        .iter()
        .flat_map(|clip| clip.frames.iter().step_by(10))
        .filter_map(|frame| {
            frame.iter().map(|joint| joint.map(|joint| rotation_vector(joint.rotation))).collect()
        })
        .collect();
    (0..count)
        .map(|pair| {
            // A large prime spreads the pairs over all poses; the second pose is half the list ahead.
            let place = |ahead: usize| poses[(7919 * pair + ahead) % poses.len()].clone();
            Pair::new(&skeleton, place(0), place(poses.len() / 2))
        })
        .collect()
}

impl Pair {
    fn new(skeleton: &Skeleton, from: Vec<DVec3>, to: Vec<DVec3>) -> Result<Self, Box<dyn Error>> {
        let joint = |joint: &sinew_mocap::SkeletonJoint| RigJoint {
            parent: joint.parent,
            kind: JointKind::Spherical,
            rotation: DQuat::IDENTITY,
            offset_m: joint.offset_m,
            range: JointRange::Any,
            weight: 1.0,
        };
        let rig = Rig::new(&skeleton.joints.iter().map(joint).collect::<Vec<_>>())?;
        let parents = skeleton.joints.iter().map(|joint| joint.parent).collect();
        let offsets_m = skeleton.joints.iter().map(|joint| joint.offset_m).collect();
        // The root is left out; the other joints turn the shorter way.
        let mut pair = Self { parents, offsets_m, rig, from, to };
        (pair.from[0], pair.to[0]) = (DVec3::ZERO, DVec3::ZERO);
        for (from, to) in pair.from.iter().zip(&mut pair.to) {
            let round = *to - to.normalize_or_zero() * std::f64::consts::TAU;
            if (round - *from).length() < (*to - *from).length() {
                *to = round;
            }
        }
        Ok(pair)
    }

    /// Returns world rotations and positions of all joints.
    fn place(&self, pose: &[DVec3]) -> (Vec<DQuat>, Vec<DVec3>) {
        let (mut rotations, mut positions_m) = (Vec::new(), Vec::<DVec3>::new());
        for (joint, vector) in pose.iter().enumerate() {
            let own = DQuat::from_scaled_axis(*vector);
            let (rotation, position_m) = match self.parents[joint] {
                Some(parent) => {
                    let of_parent: DQuat = rotations[parent];
                    (of_parent * own, positions_m[parent] + of_parent * self.offsets_m[joint])
                }
                None => (DQuat::IDENTITY, DVec3::ZERO),
            };
            rotations.push(rotation);
            positions_m.push(position_m);
        }
        (rotations, positions_m)
    }

    /// Returns all poses of a curve: both ends, and the poses between them from a vector of numbers.
    fn curve(&self, between: &[f64]) -> Vec<Vec<DVec3>> {
        let vectors: Vec<DVec3> = between.chunks_exact(3).map(DVec3::from_slice).collect();
        let mut curve = vec![self.from.clone()];
        curve.extend(vectors.chunks_exact(self.parents.len()).map(<[DVec3]>::to_vec));
        curve.push(self.to.clone());
        curve
    }

    fn line(&self) -> Vec<f64> {
        (1..STEPS)
            .flat_map(|step| {
                let t = step as f64 / STEPS as f64;
                self.from.iter().zip(&self.to).map(move |(from, to)| from.lerp(*to, t))
            })
            .flat_map(|vector| vector.to_array())
            .collect()
    }
}

impl CostFunction for &Pair {
    type Param = Vec<f64>;
    type Output = f64;

    /// Returns the energy, eq. (6).
    fn cost(&self, between: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        let placed: Vec<_> = self.curve(between).iter().map(|pose| self.place(pose).1).collect();
        let steps = placed.windows(2).flat_map(|pair| pair[0].iter().zip(&pair[1]));
        Ok(steps.map(|(a, b)| (*b - *a).length_squared()).sum())
    }
}

impl Gradient for &Pair {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    /// Returns the gradient, eq. (7) with corrected sign.
    fn gradient(&self, between: &Vec<f64>) -> Result<Vec<f64>, argmin::core::Error> {
        let curve = self.curve(between);
        let placed: Vec<_> = curve.iter().map(|pose| self.place(pose)).collect();
        let mut gradient = Vec::with_capacity(between.len());
        for (k, pose) in curve.iter().enumerate().take(STEPS).skip(1) {
            let (rotations, positions_m) = &placed[k];
            let (before, after) = (&placed[k - 1].1, &placed[k + 1].1);
            let mut forces: Vec<DVec3> = (0..pose.len())
                .map(|joint| 2.0 * (2.0 * positions_m[joint] - before[joint] - after[joint]))
                .collect();
            let mut torques = vec![DVec3::ZERO; pose.len()];
            for joint in (1..pose.len()).rev() {
                if let Some(parent) = self.parents[joint] {
                    let (force, torque) = (forces[joint], torques[joint]);
                    forces[parent] += force;
                    torques[parent] +=
                        torque + (positions_m[joint] - positions_m[parent]).cross(force);
                }
            }
            torques[0] = DVec3::ZERO;
            let of_vectors =
                pose.iter().zip(rotations).zip(&torques).map(|((vector, rotation), torque)| {
                    right_jacobian(*vector).transpose() * (rotation.inverse() * *torque)
                });
            gradient.extend(of_vectors.flat_map(|vector| vector.to_array()));
        }
        Ok(gradient)
    }
}

fn ours(pair: &Pair, options: Options) -> Result<Found, Box<dyn Error>> {
    let pose = |vectors: &[DVec3]| -> Vec<JointPosition> {
        vectors.iter().map(|v| JointPosition::Turn(DQuat::from_scaled_axis(*v))).collect()
    };
    let (from, to) = (pose(&pair.from), pose(&pair.to));
    let start = Instant::now();
    let found = geodesic::solve(&pair.rig, &from, &to, &Options { steps: STEPS, ..options })?;
    let time_ms = start.elapsed().as_secs_f64() * 1e3;
    Ok(Found { energy_m2: found.energy_m2, iterations: found.course.len() as u64, time_ms })
}

/// Minimizes by L-BFGS. Stops when the gradient's norm is below a share of the energy at the start, when the line
/// search finds no improvement, or after `ITERATIONS`.
fn l_bfgs(pair: &Pair, tolerance: f64) -> Result<Found, Box<dyn Error>> {
    let start = Instant::now();
    let line = pair.line();
    let at_start = pair.cost(&line)?;
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), 10)
        .with_tolerance_grad(tolerance * at_start)?
        .with_tolerance_cost(0.0)?;
    let run = Executor::new(pair, solver)
        .configure(|state| state.param(line).max_iters(ITERATIONS))
        .run()?;
    let time_ms = start.elapsed().as_secs_f64() * 1e3;
    let state = run.state();
    Ok(Found { energy_m2: state.get_best_cost(), iterations: state.get_iter(), time_ms })
}

/// Returns the rotation vector of at most half a turn.
fn rotation_vector(rotation: DQuat) -> DVec3 {
    let shorter = if rotation.w < 0.0 { -rotation } else { rotation };
    shorter.to_scaled_axis()
}

/// Returns the change of a rotation in its own axes per change of its vector (Solà et al. 2018, eq. 143).
fn right_jacobian(vector: DVec3) -> DMat3 {
    let angle = vector.length();
    let skew = DMat3::from_cols(
        DVec3::new(0.0, vector.z, -vector.y),
        DVec3::new(-vector.z, 0.0, vector.x),
        DVec3::new(vector.y, -vector.x, 0.0),
    );
    let (first, second) = if angle < 1e-4 {
        (0.5, 1.0 / 6.0)
    } else {
        ((1.0 - angle.cos()) / angle.powi(2), (angle - angle.sin()) / angle.powi(3))
    };
    DMat3::IDENTITY - skew * first + skew * skew * second
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
