//! Distances of poses, and the metric from which they follow, over random rigs.

use proptest::collection::vec;
use proptest::prelude::*;
use sinew_core::glam::Vec3;
use sinew_core::pose_space::{
    BodyPoses, JointCoordinates, LineWorkspace, PoseCoordinates, PoseSpace, PoseSpaceError,
};
use sinew_core::{Body, Inertia, JointKind, Transform, Tree, Twist, math};
use sinew_test_support::property;
use sinew_test_support::rig::{CAPACITY, Coordinates, Joints, Rig, rigs};

/// Two poses of a rig, and weights.
#[derive(Debug, Clone)]
struct Case {
    rig: Rig,
    other: Vec<Coordinates>,
    weights: Vec<f32>,
    with_root: bool,
}

/// Rigs of 1 to `most` bodies, each with two poses: in the second, each joint has the coordinates that the next joint
/// has in the first.
fn cases(most: usize) -> impl Strategy<Value = Case> {
    (rigs(most, Joints::Mixed), vec(0.1f32..2.0, most), any::<bool>()).prop_map(
        |(rig, mut weights, with_root)| {
            let mut other = rig.motions.clone();
            other.rotate_left(1);
            weights.truncate(rig.tree.len());
            Case { rig, other, weights, with_root }
        },
    )
}

impl Case {
    fn space(&self) -> PoseSpace<'_, CAPACITY> {
        let space =
            PoseSpace::new(&self.rig.tree).with_weights(&self.weights).expect("good weights");
        if self.with_root { space.with_root() } else { space }
    }

    fn poses(&self, motions: &[Coordinates]) -> Vec<Transform> {
        let bodies = self.rig.tree.bodies().iter();
        bodies.zip(motions).map(|(body, motion)| motion.state(body).pose).collect()
    }

    fn ends(&self) -> [PoseCoordinates<CAPACITY>; 2] {
        [&self.rig.motions, &self.other]
            .map(|motions| self.space().coordinates(&self.poses(motions)).expect("good poses"))
    }

    /// Returns motions of all joints.
    fn motions(&self, seed: f32) -> Vec<Twist> {
        let number =
            |index: usize, axis: u8| sine(seed + 3.0 * index as f32 + 0.7 * f32::from(axis));
        (0..self.rig.tree.len())
            .map(|index| {
                let vector = |from: u8| {
                    Vec3::new(number(index, from), number(index, from + 1), number(index, from + 2))
                };
                Twist::new(vector(0), vector(3))
            })
            .collect()
    }
}

/// Returns the size of the figure, m.
fn size_m(poses: &BodyPoses<CAPACITY>) -> f32 {
    poses.positions_m().fold(0.1, |largest, position| largest.max(math::length(position)))
}

fn sine(x: f32) -> f32 {
    math::sin_cos(x).0
}

/// Returns the sum over all joints of the products of two lists of motions.
fn dot(a: &[Twist], b: &[Twist]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a.angular.dot(b.angular) + a.linear.dot(b.linear))).sum()
}

proptest! {
    #![proptest_config(property(200))]

    #[test]
    fn coordinates_and_poses_are_the_same(case in cases(CAPACITY)) {
        let (space, [a, _]) = (case.space(), case.ends());
        let mut poses = vec![Transform::IDENTITY; case.rig.tree.len()];
        space.joint_poses(&a, &mut poses);
        let back = space.coordinates(&poses).expect("good poses");
        prop_assert!(space.angle_distance(&a, &back) < 1e-4);
        let from = usize::from(!case.with_root);
        for (pose, expected) in poses.iter().zip(case.poses(&case.rig.motions)).skip(from) {
            let turn = math::log(pose.rotation.conjugate() * expected.rotation);
            prop_assert!(math::length(turn) < 2e-6);
            prop_assert!((pose.translation_m - expected.translation_m).abs().max_element() < 4e-6);
        }
        if case.with_root {
            let size_m = size_m(&space.body_poses(&a));
            for (ours, kinematics) in space.body_poses(&a).positions_m().zip(case.rig.world()) {
                let off_m = (ours - kinematics.pose.translation_m).abs().max_element();
                // Each joint of a chain adds a turn and an offset: about five roundings.
                prop_assert!(off_m < 1e-6 * size_m * CAPACITY as f32 * 0.2, "{off_m} of {size_m}");
            }
        }
    }

    #[test]
    fn distances_are_metrics(case in cases(40)) {
        let (space, [a, b]) = (case.space(), case.ends());
        let middle = space.on_line(&a, &b, 0.3);
        let mut workspace = LineWorkspace::new();
        let [at, bt, mt] = [&a, &b, &middle].map(|pose| space.body_poses(pose));
        let distances = |x: &PoseCoordinates<CAPACITY>, y: &PoseCoordinates<CAPACITY>, xt, yt| {
            let [xr, yr] = [x, y].map(|pose| space.joint_rotations(pose));
            let of_places = space.position_distance(xt, yt);
            [space.angle_distance(x, y), space.rotation_distance(&xr, &yr), of_places]
        };
        let (ab, ba) = (distances(&a, &b, &at, &bt), distances(&b, &a, &bt, &at));
        let (am, mb) = (distances(&a, &middle, &at, &mt), distances(&middle, &b, &mt, &bt));
        for kind in 0..3 {
            prop_assert!((ab[kind] - ba[kind]).abs() <= 1e-5 * ab[kind] + 1e-6);
            // Distances of rotation vectors are not a true metric: where a turn has two vectors, a path through a
            // third pose may be shorter.
            let holds = ab[kind] <= (am[kind] + mb[kind]) * 1.0001 + 1e-5;
            prop_assert!(holds || kind == 0, "triangle {kind}");
        }
        prop_assert_eq!(space.angle_distance(&a, &a).to_bits(), 0);
        // On a straight line in angles no part is longer than its share.
        prop_assert!(am[0] < 0.3 * ab[0] * 1.001 + 1e-5 && mb[0] < 0.7 * ab[0] * 1.001 + 1e-5);
        // No path is shorter than the straight one through space, and more points can only make a path longer.
        let by_steps = [1, 4, 16, 64].map(|steps| space.line_distance(&a, &b, steps, &mut workspace));
        let rounding_m = 1e-5 * size_m(&at) * 7.0;
        prop_assert!((by_steps[0] - ab[2]).abs() < rounding_m);
        for pair in by_steps.windows(2) {
            prop_assert!(pair[0] <= pair[1] + 64.0 * rounding_m, "{by_steps:?}");
        }
        prop_assert_eq!(space.line_distance(&a, &a, 10, &mut workspace).to_bits(), 0);
    }

    #[test]
    fn four_at_a_time_is_one_at_a_time(case in cases(CAPACITY), steps in 1u16..40) {
        let (space, [a, b]) = (case.space(), case.ends());
        let placed: Vec<_> = (0..=steps)
            .map(|k| space.body_poses(&space.on_line(&a, &b, f32::from(k) / f32::from(steps))))
            .collect();
        let one = space.curve_length(&placed);
        let four = space.line_distance(&a, &b, steps, &mut LineWorkspace::new());
        // Each body of a chain adds about five roundings to its position, of the size of the largest pose: by Higham
        // & Mary at most λ = 8 times the root of their number. A step is the difference of two positions of all
        // bodies, and there are two paths to it.
        let bodies = case.rig.tree.len() as f32;
        let largest_m = placed.iter().map(size_m).fold(0.0, f32::max);
        let of_position_m = 8.0 * (5.0 * bodies).sqrt() * f32::EPSILON / 12f32.sqrt() * largest_m;
        let rounding_m = 2.0 * of_position_m * bodies.sqrt() * f32::from(steps);
        prop_assert!((one - four).abs() < rounding_m, "{one} {four} {rounding_m}");
    }

    #[test]
    fn the_metric_is_that_of_the_jacobian(case in cases(30)) {
        let (space, [a, _]) = (case.space(), case.ends());
        let (placed, count) = (space.body_poses(&a), case.rig.tree.len());
        let (v, u) = (case.motions(0.3), case.motions(1.9));
        let mut product = vec![Twist::ZERO; count];
        space.metric_product(&placed, &v, &mut product);
        // J v, column by column.
        let moved = |v: &[Twist]| {
            let (mut sum, mut column) = (vec![Vec3::ZERO; count], vec![Vec3::ZERO; count]);
            for (joint, motion) in v.iter().enumerate() {
                space.jacobian_column(&placed, joint, *motion, &mut column);
                for (sum, column) in sum.iter_mut().zip(&column) {
                    *sum += *column;
                }
            }
            sum
        };
        let (jv, ju) = (moved(&v), moved(&u));
        let expected: f64 =
            jv.iter().zip(&ju).zip(&case.weights).map(|((v, u), w)| f64::from(*w * v.dot(*u))).sum();
        let scale: f64 = jv.iter().zip(&ju).zip(&case.weights).map(|((v, u), w)| f64::from(w * math::length(*v) * math::length(*u))).sum();
        prop_assert!((dot(&product, &u) - expected).abs() < 3e-6 * scale + 1e-6, "{} {expected}", dot(&product, &u));

        let mut trace = 0.0;
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let units = axes.map(|axis| Twist::new(axis, Vec3::ZERO)).into_iter().chain(axes.map(|axis| Twist::new(Vec3::ZERO, axis)));
        let units: Vec<Twist> = units.collect();
        for joint in 0..count {
            for unit in &units {
                let mut one = vec![Twist::ZERO; count];
                one[joint] = *unit;
                space.metric_product(&placed, &one, &mut product);
                // The trace of the projector over all six unit vectors equals that over the columns of the subspace.
                trace += dot(&product, &one);
            }
        }
        prop_assert!((f64::from(space.metric_trace(&placed)) / trace.max(1e-3) - 1.0).abs() < 1e-4 || trace < 1e-3, "{} {trace}", space.metric_trace(&placed));
    }

    #[test]
    fn the_gradient_is_that_of_the_energy(case in cases(12)) {
        let (space, [a, b]) = (case.space(), case.ends());
        let at = space.on_line(&a, &b, 0.4);
        let [before, here, after] = [&a, &at, &b].map(|pose| space.body_poses(pose));
        let mut gradient = vec![Twist::ZERO; case.rig.tree.len()];
        space.energy_gradient(&before, &here, &after, &mut gradient);
        let step = 3e-3;
        let motions = case.motions(0.7);
        let moved = |sign: f32| -> f64 {
            // Moved as far as the joints allow: the part of the pose that `coordinates` keeps.
            let motions: Vec<Twist> = motions.iter().map(|motion| *motion * (sign * step)).collect();
            let placed = space.body_poses(&space.moved(&at, &motions));
            f64::from(space.curve_energy(&[before.clone(), placed, after.clone()]))
        };
        let numeric = (moved(1.0) - moved(-1.0)) / f64::from(2.0 * step);
        let exact = dot(&gradient, &motions);
        let energy = f64::from(space.curve_energy(&[before.clone(), here, after.clone()]));
        // Tolerance: rounding of energies in f32, and third derivatives.
        let size = energy + f64::from(size_m(&before)).powi(2);
        let tolerance = size * case.rig.tree.len() as f64 * (3e-7 / f64::from(step) + 1e-3);
        prop_assert!((numeric - exact).abs() < tolerance, "{numeric} {exact} {tolerance}");
    }

    #[test]
    fn the_root_does_not_count_unless_it_is_to(case in cases(20)) {
        let case = Case { with_root: false, ..case };
        let (space, [a, _]) = (case.space(), case.ends());
        let mut elsewhere = case.poses(&case.rig.motions);
        elsewhere[0] = case.poses(&case.other)[0] * Transform::new(math::exp(Vec3::new(0.1, 0.4, 0.2)), Vec3::ONE);
        let elsewhere = space.coordinates(&elsewhere).expect("a good pose");
        prop_assert_eq!(space.angle_distance(&a, &elsewhere).to_bits(), 0);
        prop_assert_eq!(space.position_distance(&space.body_poses(&a), &space.body_poses(&elsewhere)).to_bits(), 0);
        let mut gradient = vec![Twist::ZERO; case.rig.tree.len()];
        space.metric_product(&space.body_poses(&a), &case.motions(0.2), &mut gradient);
        prop_assert_eq!(gradient[0], Twist::ZERO);
    }
}

fn link(parent: Option<usize>, joint: JointKind) -> Body {
    let placement = Transform::from_translation(Vec3::X * 0.3);
    Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 }
}

#[test]
fn angles_go_round_the_shorter_way() {
    let hinge = JointKind::Revolute { axis: Vec3::Z };
    let arm = Tree::<3>::from_bodies(&[
        link(None, JointKind::Fixed),
        link(Some(0), hinge),
        link(Some(1), JointKind::Fixed),
    ])
    .expect("a rig");
    let space = PoseSpace::new(&arm);
    let at = |angle: f32| {
        let mut poses: Vec<Transform> = arm.bodies().iter().map(|body| body.placement).collect();
        poses[1].rotation = math::exp(Vec3::Z * angle);
        space.coordinates(&poses).expect("a good pose")
    };
    let (a, b) = (at(3.0), at(-3.0));
    let across = 2.0 * math::PI - 6.0;
    assert!((space.angle_distance(&a, &b) - across).abs() < 1e-6);
    let turned = space.rotation_distance(&space.joint_rotations(&a), &space.joint_rotations(&b));
    assert!((turned - across).abs() < 1e-6);
    let way_m = space.line_distance(&a, &b, 50, &mut LineWorkspace::new());
    assert!((way_m - 0.3 * across).abs() < 1e-6, "{way_m}");
    assert_eq!(space.dimensions(), 1);
    assert_eq!(space.bone_lengths_m(), [0.3, 0.3, 0.0]);
    assert_eq!(a.as_slice()[0], JointCoordinates::ZERO);
}

#[test]
fn what_cannot_be_is_refused() {
    let arm = Tree::<2>::from_bodies(&[
        link(None, JointKind::Fixed),
        link(Some(0), JointKind::Spherical),
    ])
    .expect("a rig");
    let space = PoseSpace::new(&arm);
    let good = [Transform::IDENTITY; 2];
    for (joint, bad) in [
        (0, Transform::from_translation(Vec3::X * f32::NAN)),
        (1, Transform::from_translation(Vec3::X * f32::INFINITY)),
        (1, Transform::from_translation(Vec3::X * 2e6)),
        (1, Transform::new(sinew_core::glam::Quat::from_xyzw(0.0, 0.0, 0.0, 1.1), Vec3::ZERO)),
        (1, Transform::new(sinew_core::glam::Quat::from_xyzw(0.0, f32::NAN, 0.0, 1.0), Vec3::ZERO)),
    ] {
        let mut poses = good;
        poses[joint] = bad;
        assert_eq!(space.coordinates(&poses), Err(PoseSpaceError::Pose { joint }));
    }
    assert_eq!(space.coordinates(&good[..1]), Err(PoseSpaceError::Count { expected: 2, found: 1 }));
    for (joint, weights) in [(0, [-1.0, 1.0]), (1, [1.0, f32::INFINITY]), (0, [0.0, 0.0])] {
        let value = weights[joint];
        assert_eq!(
            space.clone().with_weights(&weights),
            Err(PoseSpaceError::Weight { joint, value })
        );
    }
    assert!(matches!(
        space.clone().with_weights(&[1.0, f32::NAN]),
        Err(PoseSpaceError::Weight { joint: 1, .. })
    ));
    assert_eq!(space.with_weights(&[1.0]), Err(PoseSpaceError::Count { expected: 2, found: 1 }));
}
