//! The pose of the figure that is nearest to the clip's. It depends only on the figure's bones, not on a
//! controller.
//!
//! If the figure's dimensions differ from the clip's, either the bodies' rotations can equal the clip's, or their
//! positions can be nearer to the clip's. The nearest pose minimizes, over the rotations `R_i` of all bodies in
//! the world and the root's position,
//!
//! `Σ |p_i - p_d,i|² + w² Σ |Log(R_i R_d,iᵀ)|²`
//!
//! with the rotation weight w, a length: a point of a body at that distance from its joint counts as much as the joint.
//! Over all w the nearest poses are a curve from World's rotations to the nearest positions. Since squares are
//! minimised, another pose may have a slightly smaller mean of absolute errors.

use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;
use sinew_figure::plant::Pose;
use sinew_figure::{BODIES, FigureMotion, Root};

use super::error::{EvaluateError, RunError};
use super::evaluation::Protocol;
use super::metrics::Errors;
use super::motion::count_steps;
use super::reference::Performance;
use super::rig::Rig;
use super::setup::Setup;

/// Rotation weights of a curve, in metres: from World's rotations to the nearest positions.
pub const WEIGHTS_M: [f64; 10] = [10.0, 1.0, 0.7, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1, 0.05];

/// Approximate number of frames of all clips together for a curve; each clip may add one more.
const FRAMES: usize = 2000;

/// The part of the root's pose that is fixed to the clip's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RootConstraint {
    /// Nothing is fixed.
    Free,
    /// The position is fixed.
    Position,
    /// Position and rotation are fixed, as for a figure that is bolted to its stand.
    Pose,
}

/// The nearest poses for figures of every scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimum {
    /// A pose was computed for every `every`-th frame.
    pub every: usize,
    /// Number of poses whose search was abandoned. The last pose of such a search is counted in the errors.
    pub unsolved: usize,
    /// Curves by scale, in the protocol's order, and for each scale by root constraint.
    pub scales: Vec<Vec<Curve>>,
}

/// The nearest poses for one figure, for every weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Constraint of the root.
    pub held: RootConstraint,
    /// Points in the order of [`WEIGHTS_M`].
    pub points: Vec<CurvePoint>,
}

/// The nearest poses for one figure with one weight.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePoint {
    /// Rotation weight in metres.
    pub weight_m: f64,
    /// Errors of the poses over all clips.
    pub errors: Errors,
}

/// Computes the curves of the figures of all scales. The search is parallel; the result does not depend on the
/// number of threads. Long clips are sampled at equal intervals of frames.
///
/// # Errors
/// [`EvaluateError::Run`] if no body model fits a clip's skeleton.
pub fn optimum(motions: &[FigureMotion], protocol: &Protocol) -> Result<Optimum, EvaluateError> {
    let seconds = protocol.seconds;
    let frames: usize = motions.iter().map(|motion| count_steps(motion, seconds)).sum();
    let every = frames.div_ceil(FRAMES).max(1);
    let held: &[RootConstraint] = match protocol.setup.root {
        Root::Driven => &[RootConstraint::Free, RootConstraint::Position],
        Root::Fixed => &[RootConstraint::Pose],
    };
    let mut unsolved = 0;
    let mut scales = Vec::with_capacity(protocol.scales.len());
    for scale in &protocol.scales {
        let method = protocol.setup.controller.method;
        let setup = protocol.setup_of(*scale, method);
        let mut curves = Vec::with_capacity(held.len());
        for held in held.iter().copied() {
            let mut points = Vec::with_capacity(WEIGHTS_M.len());
            for weight_m in WEIGHTS_M {
                let clips: Vec<_> = motions
                    .par_iter()
                    .map(|motion| {
                        nearest_poses(motion, &setup, seconds, every, weight_m, held).map_err(
                            |kind| {
                                let (clip, scale) = (motion.name.clone(), *scale);
                                EvaluateError::Run { clip, scale, method, kind }
                            },
                        )
                    })
                    .collect();
                let mut errors = Errors::default();
                for clip in clips {
                    let (of_clip, given_up) = clip?;
                    errors.merge(&of_clip);
                    unsolved += given_up;
                }
                points.push(CurvePoint { weight_m, errors });
            }
            curves.push(Curve { held, points });
        }
        scales.push(curves);
    }
    Ok(Optimum { every, unsolved, scales })
}

/// Returns the errors of the poses that are nearest to every `every`-th measured frame of a run, and the number of
/// abandoned searches.
///
/// # Errors
/// [`RunError`] if no body model fits the clip's skeleton.
pub fn nearest_poses(
    motion: &FigureMotion,
    setup: &Setup,
    seconds: Option<f64>,
    every: usize,
    weight_m: f64,
    held: RootConstraint,
) -> Result<(Errors, usize), RunError> {
    let model = setup.model(motion)?;
    let rig = Rig::new(model.mechanism(setup.root))?;
    let performance = Performance { motion, setup, links: rig.links() };
    let mut search = Search::new(&model.offset_m, weight_m, held);
    let (mut errors, mut unsolved, mut desired) = (Errors::default(), 0, Vec::new());
    for frame in (1..=count_steps(motion, seconds)).step_by(every) {
        performance.desired(frame, &mut desired);
        unsolved += usize::from(!search.solve(&desired));
        errors.add(&desired, &search.poses, &rig);
    }
    Ok((errors, unsolved))
}

/// The search for the nearest pose: Newton's method, where each step is halved until it decreases the error.
#[derive(Debug, Clone)]
pub struct Search<'a> {
    /// Positions of the joints in their parents' frames, in metres.
    offset_m: &'a [DVec3],
    weight_m: f64,
    held: RootConstraint,
    /// Nearest pose found, in the world.
    pub poses: Vec<Pose>,
    /// Deviation of that pose from the desired pose, in rad. The next search begins with this deviation.
    deviation_rad: Vec<DVec3>,
    shift_m: DVec3,
}

/// A step of the search: the root's shift and the rotations of all bodies, in the world.
struct Change {
    shift_m: DVec3,
    turn_rad: Vec<DVec3>,
}

impl<'a> Search<'a> {
    /// Convergence limit: the search ends if its step turns no body by more than this (in rad) and shifts the root
    /// by no more (in m).
    pub const ENOUGH: f64 = 1e-9;
    /// Number of steps after which the search is abandoned.
    const STEPS: usize = 1000;
    /// Tolerated rounding error of the energy, as a share of it.
    const ROUNDING: f64 = 1e-12;

    /// Creates a search for a figure with these joint positions in their parents' frames, in metres, and a
    /// rotation weight above 0, in metres.
    pub fn new(offset_m: &'a [DVec3], weight_m: f64, held: RootConstraint) -> Self {
        Self {
            offset_m,
            weight_m,
            held,
            poses: vec![Pose::IDENTITY; offset_m.len()],
            deviation_rad: vec![DVec3::ZERO; offset_m.len()],
            shift_m: DVec3::ZERO,
        }
    }

    /// Searches for the pose nearest to a desired pose, starting at the deviation of the last search. Returns
    /// whether it was found.
    pub fn solve(&mut self, desired: &[Pose]) -> bool {
        let turned = self.deviation_rad.iter().zip(desired).map(|(deviation_rad, desired)| {
            DQuat::from_scaled_axis(*deviation_rad) * desired.rotation
        });
        self.poses = self.assembled(desired[0].position_m + self.shift_m, turned);
        let mut solved = false;
        for _ in 0..Self::STEPS {
            let step = self.step(desired);
            let largest = step.turn_rad.iter().map(|turn| turn.length()).fold(0.0, f64::max);
            solved = largest.max(step.shift_m.length()) <= Self::ENOUGH;
            if solved || !self.go(&step, desired) {
                break;
            }
        }
        self.deviation_rad.clear();
        let deviations =
            self.poses.iter().zip(desired).map(|(at, desired)| deviation_rad(at, desired));
        self.deviation_rad.extend(deviations);
        self.shift_m = self.poses[0].position_m - desired[0].position_m;
        solved
    }

    /// Returns the objective of the search, in m².
    fn energy_m2(&self, poses: &[Pose], desired: &[Pose]) -> f64 {
        let of_body = |(pose, desired): (&Pose, &Pose)| {
            (pose.position_m - desired.position_m).length_squared()
                + self.weight_m * self.weight_m * deviation_rad(pose, desired).length_squared()
        };
        poses.iter().zip(desired).map(of_body).sum()
    }

    /// Returns the poses of the figure with its root at `root_m` and these rotations of its bodies in the world.
    fn assembled(&self, root_m: DVec3, rotations: impl Iterator<Item = DQuat>) -> Vec<Pose> {
        let mut poses: Vec<_> =
            rotations.map(|rotation| Pose { rotation, position_m: root_m }).collect();
        for (body, place) in BODIES.iter().enumerate() {
            if let Some(parent) = place.parent {
                let parent = poses[parent];
                poses[body].position_m = parent.position_m + parent.rotation * self.offset_m[body];
            }
        }
        poses
    }

    /// Takes the step, halved until it does not increase the energy. Returns `false` if every part of the step
    /// increases the energy.
    fn go(&mut self, step: &Change, desired: &[Pose]) -> bool {
        let limit = self.energy_m2(&self.poses, desired) * (1.0 + Self::ROUNDING);
        let mut part = 1.0;
        while part > Self::ENOUGH {
            let rotations = step.turn_rad.iter().zip(&self.poses).map(|(turn_rad, pose)| {
                let turn = DQuat::from_scaled_axis(*turn_rad * part);
                (turn * pose.rotation).normalize()
            });
            let poses = self.assembled(self.poses[0].position_m + step.shift_m * part, rotations);
            if self.energy_m2(&poses, desired) <= limit {
                self.poses = poses;
                return true;
            }
            part *= 0.5;
        }
        false
    }

    /// Returns Newton's step, or, where the energy is not convex, the Gauss-Newton step, which always descends.
    fn step(&self, desired: &[Pose]) -> Change {
        let step = self.eliminated(desired, true).or_else(|| self.eliminated(desired, false));
        step.expect("without the curvature, the normal equations are positive definite")
    }

    /// Solves the normal equations exactly by elimination from the leaves to the root: O(n). `curved` includes the
    /// second derivative of the positions, which is large if the figure cannot reach them; the equations may then
    /// have no minimum, and the result is `None`.
    ///
    /// With x the shift of body b, its subtree costs `xᵀ A_b x - 2 b_bᵀ x` plus a constant if its own rotation d
    /// is optimal, `M d = q - B x`. A child is shifted by `x + d × l`, with l from b to the child.
    fn eliminated(&self, desired: &[Pose], curved: bool) -> Option<Change> {
        let weight_m2 = self.weight_m * self.weight_m;
        let turns = |body: usize| body > 0 || self.held != RootConstraint::Pose;
        let arm_m =
            |child: usize, parent: usize| self.poses[parent].rotation * self.offset_m[child];
        // The vectors below are A and b; M, which becomes its inverse after all children are added; B and q.
        let count = self.poses.len();
        let pairs = || self.poses.iter().zip(desired);
        let mut cost = vec![DMat3::IDENTITY; count];
        let mut residual_m: Vec<DVec3> =
            pairs().map(|(at, desired)| desired.position_m - at.position_m).collect();
        let mut pull_m = residual_m.clone();
        let mut own = vec![DMat3::from_diagonal(DVec3::splat(weight_m2)); count];
        let mut coupling = vec![DMat3::ZERO; count];
        let mut moment: Vec<DVec3> =
            pairs().map(|(at, desired)| -weight_m2 * deviation_rad(at, desired)).collect();
        for (body, place) in BODIES.iter().enumerate().rev() {
            if turns(body) {
                own[body] = inverse(own[body])?;
                let back = coupling[body].transpose() * own[body];
                cost[body] -= back * coupling[body];
                pull_m[body] -= back * moment[body];
            }
            if let Some(parent) = place.parent {
                // d × l = -[l] d.
                let arm_m = arm_m(body, parent);
                let cross = skew(arm_m);
                let turned = cross * cost[body];
                own[parent] -= turned * cross;
                coupling[parent] += turned;
                moment[parent] += cross * pull_m[body];
                let (cost_beyond, pull_beyond_m) = (cost[body], pull_m[body]);
                cost[parent] += cost_beyond;
                pull_m[parent] += pull_beyond_m;
                if curved {
                    // A rotation by d also shifts by d × (d × l) / 2.
                    let along = residual_m[body].dot(arm_m);
                    own[parent] += DMat3::from_diagonal(DVec3::splat(along))
                        - (outer(residual_m[body], arm_m) + outer(arm_m, residual_m[body])) * 0.5;
                }
                let beyond_m = residual_m[body];
                residual_m[parent] += beyond_m;
            }
        }
        let mut change = Change { shift_m: DVec3::ZERO, turn_rad: vec![DVec3::ZERO; count] };
        if self.held == RootConstraint::Free {
            change.shift_m = inverse(cost[0])? * pull_m[0];
        }
        let mut shift_m = vec![change.shift_m; count];
        for (body, place) in BODIES.iter().enumerate() {
            if let Some(parent) = place.parent {
                shift_m[body] =
                    shift_m[parent] + change.turn_rad[parent].cross(arm_m(body, parent));
            }
            if turns(body) {
                change.turn_rad[body] = own[body] * (moment[body] - coupling[body] * shift_m[body]);
            }
        }
        Some(change)
    }
}

/// Returns the rotation vector from the desired orientation to a pose's, in the world, of at most π.
fn deviation_rad(pose: &Pose, desired: &Pose) -> DVec3 {
    let turn = pose.rotation * desired.rotation.conjugate();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let sin = turn.xyz().length();
    if sin > 0.0 { turn.xyz() * (2.0 * libm::atan2(sin, turn.w) / sin) } else { DVec3::ZERO }
}

/// Returns the matrix of the cross product with a vector on the left.
fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}

/// Returns the matrix `a bᵀ`.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Returns the inverse of a symmetric matrix, if the matrix is positive definite.
fn inverse(m: DMat3) -> Option<DMat3> {
    let minor = m.x_axis.x * m.y_axis.y - m.x_axis.y * m.y_axis.x;
    (m.x_axis.x > 0.0 && minor > 0.0 && m.determinant() > 0.0).then(|| m.inverse())
}

#[cfg(test)]
mod tests {
    use sinew_core::projection::ProjectionWorkspace;

    use super::*;
    use crate::MethodName;
    use sinew_core::tracker::ProjectionSettings;
    use sinew_figure::fixture::moving;
    use sinew_figure::{BODY_COUNT, Dimensions};
    use sinew_host_util::random::{Random, Subject};

    const ALL_HELD: [RootConstraint; 3] =
        [RootConstraint::Free, RootConstraint::Position, RootConstraint::Pose];

    /// Returns a frame of a clip, and the joint positions of a figure whose dimensions differ from the clip's.
    fn desired_and_offsets(scale: f64) -> (Vec<Pose>, Vec<DVec3>) {
        let motion = moving("clip", 40);
        let dimensions = Dimensions { random: 0.2, seed: 3, ..Dimensions::uniform(scale) };
        let factors = dimensions.factors();
        let offset_m = motion.offset_m.iter().zip(factors).map(|(offset, factor)| *offset * factor);
        let offset_m = offset_m.collect();
        (desired(&motion, 30), offset_m)
    }

    fn desired(motion: &FigureMotion, frame: usize) -> Vec<Pose> {
        let setup = Setup::default();
        let mechanism = setup.model(motion).unwrap().mechanism(setup.root);
        let mut desired = Vec::new();
        Performance { motion, setup: &setup, links: &mechanism.bodies }
            .desired(frame, &mut desired);
        desired
    }

    /// Returns the figure with its root shifted and its bodies turned, all in the world, except for what is fixed.
    fn altered(search: &Search<'_>, shift_m: DVec3, turn_rad: &[DVec3]) -> Vec<Pose> {
        let root = &search.poses[0];
        let shift_m = if search.held == RootConstraint::Free { shift_m } else { DVec3::ZERO };
        let rotations =
            search.poses.iter().zip(turn_rad).enumerate().map(|(body, (pose, turn))| {
                let turns = body > 0 || search.held != RootConstraint::Pose;
                let turn = if turns { *turn } else { DVec3::ZERO };
                DQuat::from_scaled_axis(turn) * pose.rotation
            });
        search.assembled(root.position_m + shift_m, rotations)
    }

    #[test]
    fn nothing_that_is_free_leads_down() {
        const SMALL: f64 = 1e-4;
        for scale in [0.1, 0.9, 1.1, 3.0] {
            let (desired, offset_m) = desired_and_offsets(scale);
            for (weight_m, held) in WEIGHTS_M.iter().flat_map(|w| ALL_HELD.map(|held| (*w, held))) {
                let mut search = Search::new(&offset_m, weight_m, held);
                assert!(search.solve(&desired), "scale {scale}, weight {weight_m}, {held:?}");
                let least = search.energy_m2(&search.poses, &desired);
                for (axis, place) in
                    DVec3::AXES.iter().flat_map(|a| (0..=BODY_COUNT).map(move |p| (a, p)))
                {
                    let energy = |size: f64| {
                        let (mut shift_m, mut turn_rad) =
                            (DVec3::ZERO, vec![DVec3::ZERO; BODY_COUNT]);
                        *turn_rad.get_mut(place).unwrap_or(&mut shift_m) = *axis * size;
                        search.energy_m2(&altered(&search, shift_m, &turn_rad), &desired)
                    };
                    let (more, less) = (energy(SMALL), energy(-SMALL));
                    let slope = (more - less) / (2.0 * SMALL);
                    let curvature = (more - 2.0 * least + less) / (SMALL * SMALL);
                    // The step that remains along this coordinate alone is within the error of the differences.
                    assert!(slope.abs() <= 1e-6 * curvature, "{place}: {slope} {curvature}");
                }
            }
        }
    }

    #[test]
    fn no_pose_around_is_nearer() {
        let mut random = Random::new(1, Subject::Noise);
        for scale in [0.9, 1.1, 1.5] {
            let (desired, offset_m) = desired_and_offsets(scale);
            for (weight_m, held) in [
                (0.05, RootConstraint::Free),
                (0.3, RootConstraint::Position),
                (1.0, RootConstraint::Pose),
            ] {
                let mut search = Search::new(&offset_m, weight_m, held);
                assert!(search.solve(&desired));
                let least = search.energy_m2(&search.poses, &desired);
                for size in [1e-3, 1e-2, 0.1, 1.0] {
                    for _ in 0..200 {
                        let turn_rad: Vec<_> =
                            (0..BODY_COUNT).map(|_| random.normal3() * size).collect();
                        let poses = altered(&search, random.normal3() * size, &turn_rad);
                        assert!(search.energy_m2(&poses, &desired) > least);
                    }
                }
            }
        }
    }

    #[test]
    fn a_figure_of_equal_lengths_is_on_the_clip() {
        let motion = moving("clip", 40);
        let setup = Setup::default();
        for held in ALL_HELD {
            let (errors, unsolved) = nearest_poses(&motion, &setup, None, 1, 0.3, held).unwrap();
            assert_eq!((errors.all.n, unsolved), (38 * BODY_COUNT as u64, 0));
            // In degrees and centimetres: the rounding of a product of rotations.
            assert!(errors.all.figures().iter().all(|error| *error < 1e-12), "{errors:?}");
        }
    }

    /// Compares with the core's search in f32 by another method. After many sweeps both arrive at the same pose.
    #[test]
    fn the_projection_of_the_core_ends_at_the_optimum() {
        let motion = moving("clip", 40);
        for (held, root_held) in [(RootConstraint::Free, false), (RootConstraint::Pose, true)] {
            for weight_m in [1.0, 0.3, 0.1] {
                let mut setup = Setup { dimensions: Dimensions::uniform(1.1), ..Setup::default() };
                setup.controller.method = MethodName::ManifoldProjection;
                setup.controller.projection = ProjectionSettings {
                    rotation_m: weight_m,
                    root_held,
                    sweeps: 255,
                    ..ProjectionSettings::default()
                };
                let model = setup.model(&motion).unwrap();
                let mechanism = model.mechanism(Root::Driven);
                let tree = mechanism.tree::<BODY_COUNT>().unwrap();
                let settings = setup.controller_of(&mechanism.bodies).unwrap();
                let projection = settings.projection(&tree).unwrap().unwrap();
                let joints = motion.joint_poses(30);
                let mut nearest = joints.clone();
                projection
                    .project(&tree, &joints, &mut ProjectionWorkspace::new(), &mut nearest)
                    .unwrap();

                let mut search = Search::new(&model.offset_m, f64::from(weight_m), held);
                let desired = desired(&motion, 30);
                assert!(search.solve(&desired));
                let root_m = nearest[0].translation_m.as_dvec3();
                let mut rotation: Vec<_> =
                    nearest.iter().map(|joint| joint.rotation.as_dquat().normalize()).collect();
                for (body, place) in BODIES.iter().enumerate() {
                    if let Some(parent) = place.parent {
                        rotation[body] = rotation[parent] * rotation[body];
                    }
                }
                let poses = search.assembled(root_m, rotation.into_iter());
                // About ten roundings of f32 along a limb, in metres and radians.
                for (pose, optimum) in poses.iter().zip(&search.poses) {
                    assert!(pose.position_m.distance(optimum.position_m) < 2e-6);
                    assert!(deviation_rad(pose, optimum).length() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn with_a_large_weight_the_mean_residual_remains() {
        let (desired, offset_m) = desired_and_offsets(1.1);
        let mut search = Search::new(&offset_m, 1e4, RootConstraint::Free);
        assert!(search.solve(&desired));
        let world =
            search.assembled(desired[0].position_m, desired.iter().map(|pose| pose.rotation));
        let residuals = desired.iter().zip(&world).map(|(d, w)| d.position_m - w.position_m);
        let mean_m = residuals.sum::<DVec3>() / BODY_COUNT as f64;
        let shift_m = search.poses[0].position_m - desired[0].position_m;
        assert!(shift_m.distance(mean_m) < 1e-8, "{shift_m} {mean_m}");
    }

    #[test]
    fn heavier_rotations_are_followed_better_and_positions_worse() {
        let motions = [moving("one", 60), moving("two", 40)];
        let protocol = Protocol { scales: vec![1.1], ..Protocol::default() };
        let optimum = optimum(&motions, &protocol).unwrap();
        assert_eq!((optimum.every, optimum.unsolved, optimum.scales.len()), (1, 0, 1));
        for curve in &optimum.scales[0] {
            for pair in curve.points.windows(2) {
                let [heavy, light] = [&pair[0].errors.all, &pair[1].errors.all];
                assert!(heavy.angular_mean_deg() < light.angular_mean_deg());
                assert!(heavy.linear_mean_cm() > light.linear_mean_cm());
            }
        }
    }
}
