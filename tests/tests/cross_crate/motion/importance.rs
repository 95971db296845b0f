//! Importance of joints: compared with surface integrals in f64, with its estimate from points, and with finer and
//! finer meshes; and its change with the skeleton.

use std::num::NonZeroU16;

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::importance::{
    Importance, MeshSurface, RestPose, SurfaceSamples, cylinder_samples, cylinder_surface,
    descendants_length,
};
use sinew_core::{Body, Inertia, JointKind, Transform, Tree, math};
use sinew_test_support::cylinders::distance_integral_m3;
use sinew_test_support::property;

/// The core's largest capacity.
const N: usize = 128;

/// A skeleton of some metres, with thick bones.
#[derive(Debug, Clone)]
struct Skeleton {
    parents: Vec<Option<usize>>,
    positions_m: Vec<Vec3>,
    radii_m: Vec<f32>,
}

impl Skeleton {
    fn rest_pose(&self) -> RestPose<N> {
        RestPose::new(&self.parents, &self.positions_m).expect("a good skeleton")
    }

    fn lengths(&self, base_m: f32, discount: f32) -> Importance<N> {
        descendants_length(&self.rest_pose(), base_m, discount).expect("good settings")
    }

    fn cylinders(&self, base_m3: f32) -> Importance<N> {
        cylinder_surface(&self.rest_pose(), &self.radii_m, base_m3).expect("good settings")
    }

    /// Returns the weights of a mesh with a vertex at each joint, bound half to it and half to its parent.
    fn mesh(&self, base_m3: f32) -> Importance<N> {
        let mut surface = MeshSurface::new(self.rest_pose(), base_m3).expect("a good base");
        for (joint, (parent, position_m)) in self.parents.iter().zip(&self.positions_m).enumerate()
        {
            let influences = [(joint, 0.5), (parent.unwrap_or(joint), 0.5)];
            surface.add(*position_m, self.radii_m[joint], &influences).expect("a good vertex");
        }
        surface.importance().expect("weights")
    }

    /// Returns the skeleton with its joints in another order: joint `j` becomes joint `place[j]`.
    fn reordered(&self, place: &[usize]) -> Self {
        let mut other = self.clone();
        for (joint, &to) in place.iter().enumerate() {
            other.parents[to] = self.parents[joint].map(|parent| place[parent]);
            other.positions_m[to] = self.positions_m[joint];
            other.radii_m[to] = self.radii_m[joint];
        }
        other
    }
}

/// Skeletons of 1 to `most` joints, parents first: chains, stars and mixtures; some bones have no length or
/// thickness.
fn skeletons(most: usize) -> impl Strategy<Value = Skeleton> {
    let joint = (
        any::<prop::sample::Index>(),
        [-0.4f32..0.4, -0.4f32..0.4, -0.4f32..0.4],
        0.0f32..0.2,
        0..10u8,
    );
    (0..3u8, vec(joint, 1..=most)).prop_map(|(shape, joints)| {
        let mut skeleton =
            Skeleton { parents: Vec::new(), positions_m: Vec::new(), radii_m: Vec::new() };
        for (index, (parent, offset, radius_m, special)) in joints.into_iter().enumerate() {
            let parent = (index > 0).then(|| match shape {
                0 => index - 1,
                1 => 0,
                _ => parent.index(index),
            });
            let offset = if special == 0 { Vec3::ZERO } else { Vec3::from_array(offset) };
            let from = parent.map_or(Vec3::ZERO, |parent: usize| skeleton.positions_m[parent]);
            skeleton.parents.push(parent);
            skeleton.positions_m.push(from + offset);
            skeleton.radii_m.push(if special == 1 { 0.0 } else { radius_m });
        }
        skeleton
    })
}

/// A skeleton and another order of its joints.
fn with_order(most: usize) -> impl Strategy<Value = (Skeleton, Vec<usize>)> {
    skeletons(most).prop_flat_map(|skeleton| {
        let order: Vec<usize> = (0..skeleton.parents.len()).collect();
        (Just(skeleton), Just(order).prop_shuffle())
    })
}

/// Returns the largest difference of two lists of weights, relative to the expected weight.
fn worst(got: &[f32], expected: impl IntoIterator<Item = f64>) -> f64 {
    let off = |(got, expected): (&f32, f64)| (f64::from(*got) / expected - 1.0).abs();
    got.iter().zip(expected).map(off).fold(0.0, f64::max)
}

fn wide(importance: &Importance<N>) -> impl Iterator<Item = f64> {
    importance.as_slice().iter().map(|weight| f64::from(*weight))
}

proptest! {
    #![proptest_config(property(100))]

    #[test]
    fn the_order_of_the_joints_is_the_order_of_the_weights((skeleton, place) in with_order(N)) {
        let other = skeleton.reordered(&place);
        for joint in 0..place.len() {
            let below: Vec<usize> = {
                let mut below: Vec<_> =
                    skeleton.rest_pose().descendants(joint).iter().map(|j| place[j]).collect();
                below.sort_unstable();
                below
            };
            let found: Vec<_> = other.rest_pose().descendants(place[joint]).iter().collect();
            prop_assert_eq!(below, found);
        }
        for (first, second) in [
            (skeleton.lengths(0.1, 0.9), other.lengths(0.1, 0.9)),
            (skeleton.cylinders(1e-3), other.cylinders(1e-3)),
            (skeleton.mesh(1e-3), other.mesh(1e-3)),
        ] {
            let expected = place.iter().map(|to| f64::from(second.as_slice()[*to]));
            // The sums have another order: the error is a rounding or two, for any number of terms.
            let off = worst(first.as_slice(), expected);
            prop_assert!(off <= 2.0 * f64::from(f32::EPSILON), "{off:e}");
        }
    }

    #[test]
    fn weights_have_the_dimensions_of_their_units(skeleton in skeletons(N)) {
        // Twice as large, which f32 computes without rounding.
        let mut double = skeleton.clone();
        double.positions_m.iter_mut().for_each(|position_m| *position_m *= 2.0);
        double.radii_m.iter_mut().for_each(|radius_m| *radius_m *= 2.0);
        for (one, two, factor) in [
            (skeleton.lengths(0.1, 0.9), double.lengths(0.2, 0.9), 2.0),
            (skeleton.cylinders(1e-3), double.cylinders(8e-3), 8.0),
        ] {
            let scaled: Vec<f32> = one.as_slice().iter().map(|weight| factor * weight).collect();
            prop_assert_eq!(two.as_slice(), &scaled[..]);
            prop_assert_eq!(two.normalised(), one.normalised());
        }
    }

    #[test]
    fn weights_do_not_depend_on_where_the_skeleton_is(
        skeleton in skeletons(N),
        turn in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0],
        shift in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0],
    ) {
        let (turn, shift) = (math::exp(Vec3::from_array(turn)), Vec3::from_array(shift));
        let mut moved = skeleton.clone();
        for position_m in &mut moved.positions_m {
            *position_m = turn * *position_m + shift;
        }
        for (first, second) in [
            (skeleton.lengths(0.1, 0.9), moved.lengths(0.1, 0.9)),
            (skeleton.cylinders(1e-3), moved.cylinders(1e-3)),
        ] {
            // Positions of about 8 m are rounded to 5e-7 m; bones and base are at least 0.1 m.
            let off = worst(second.as_slice(), wide(&first));
            prop_assert!(off < 1e-5, "{off:e}");
        }
    }

    #[test]
    fn more_makes_no_weight_less(skeleton in skeletons(N), joint in any::<prop::sample::Index>()) {
        let least = |weights: Importance<N>, than: &Importance<N>| {
            // Rounding alone may reduce a weight by two units of the last place.
            let slack = 1.0 - 2.0 * f32::EPSILON;
            weights.as_slice().iter().zip(than.as_slice()).all(|(more, less)| *more >= less * slack)
        };
        let lengths = skeleton.lengths(0.1, 0.9);
        prop_assert!(least(skeleton.lengths(0.2, 0.9), &lengths));
        prop_assert!(least(skeleton.lengths(0.1, 0.95), &lengths));
        let cylinders = skeleton.cylinders(1e-3);
        prop_assert!(least(skeleton.cylinders(2e-3), &cylinders));
        let mut thicker = skeleton.clone();
        thicker.radii_m[joint.index(skeleton.radii_m.len())] += 0.05;
        prop_assert!(least(thicker.cylinders(1e-3), &cylinders));
        // A joint's weight is at least that of each descendant plus the distance to it.
        let rest_pose = skeleton.rest_pose();
        let whole = skeleton.lengths(0.1, 1.0);
        for (below, weight) in whole.as_slice().iter().enumerate() {
            if let Some(parent) = rest_pose.parent(below) {
                prop_assert!(whole.as_slice()[parent] > *weight);
            }
        }
    }

    #[test]
    fn normalised_weights_sum_to_one_in_the_same_ratios(skeleton in skeletons(N)) {
        for weights in [skeleton.lengths(0.1, 0.9), skeleton.cylinders(1e-3), skeleton.mesh(1e-3)] {
            let sum: f64 = wide(&weights).sum();
            let normalised = weights.normalised();
            // Rounding of the sum, and of each quotient.
            prop_assert!((wide(&normalised).sum::<f64>() - 1.0).abs() < f64::from(f32::EPSILON));
            let off = worst(normalised.as_slice(), wide(&weights).map(|weight| weight / sum));
            prop_assert!(off < 1.5 * f64::from(f32::EPSILON), "{off:e}");
        }
    }

    #[test]
    fn cylinders_of_whole_skeletons_are_as_exact_as_said((skeleton, place) in with_order(N)) {
        let skeleton = skeleton.reordered(&place);
        let rest_pose = skeleton.rest_pose();
        let at = |joint: usize| skeleton.positions_m[joint].as_dvec3();
        let base = 1e-3f32;
        let expected = (0..skeleton.parents.len()).map(|joint| {
            let integral = |bone: usize| {
                let start_m = at(rest_pose.parent(bone).expect("none but the root has none"));
                let radius_m = f64::from(skeleton.radii_m[bone]);
                distance_integral_m3(start_m, at(bone), radius_m, at(joint))
            };
            f64::from(base) + rest_pose.descendants(joint).iter().map(integral).sum::<f64>()
        });
        let off = worst(skeleton.cylinders(base).as_slice(), expected);
        prop_assert!(off < 1e-6, "{off:e}");
    }

    #[test]
    fn points_come_to_the_cylinders(skeleton in skeletons(12), seed in any::<u64>()) {
        const POINTS: NonZeroU16 = NonZeroU16::new(4000).expect("some");
        let rest_pose = skeleton.rest_pose();
        let exact = skeleton.cylinders(1e-3);
        let samples = SurfaceSamples::new(seed);
        let estimate = cylinder_samples(&rest_pose, &skeleton.radii_m, 1e-3, POINTS, samples)
            .expect("good settings");
        for (joint, (got, exact)) in estimate.as_slice().iter().zip(exact.as_slice()).enumerate() {
            // The distance of a point deviates by at most half of the largest distance between two points.
            let variance = rest_pose.descendants(joint).iter().map(|bone| {
                let radius_m = skeleton.radii_m[bone];
                let start_m = skeleton.positions_m[skeleton.parents[bone].expect("a descendant")];
                let length_m = start_m.distance(skeleton.positions_m[bone]);
                let deviation_m = 0.5 * length_m.hypot(2.0 * radius_m);
                (2.0 * math::PI * radius_m * length_m * deviation_m).powi(2) / f32::from(POINTS.get())
            });
            let error = variance.sum::<f32>().sqrt();
            prop_assert!((got - exact).abs() <= 4.0 * error + 1e-6 * exact, "{joint}: {got} {exact} ± {error}");
        }
    }
}

/// Returns two weights in m³ of one cylinder alone: of a joint at `point_m`, and of the joint at the cylinder's
/// start.
fn of_one(point_m: Vec3, start_m: Vec3, end_m: Vec3, radius_m: f32) -> [f32; 2] {
    let rest_pose = RestPose::<3>::new(&[None, Some(0), Some(1)], &[point_m, start_m, end_m])
        .expect("a good skeleton");
    let weights =
        cylinder_surface(&rest_pose, &[0.0, 0.0, radius_m], 0.0).expect("a cylinder has a surface");
    [weights.as_slice()[0], weights.as_slice()[1]]
}

#[test]
fn one_cylinder_is_as_exact_as_said_from_everywhere() {
    // In units of the cylinder's length: position of the point's foot on the axis, radius of the cylinder, and
    // distance of the point from the axis or the surface.
    let feet =
        [-100.0, -10.0, -1.0, -0.1, -0.01, -1e-4, 0.0, 1e-4, 0.01, 0.1, 0.3, 0.5, 0.9, 1.0, 7.0];
    let radii = [1e-5, 1e-4, 1e-3, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0, 1000.0];
    let sides = [0.0, 1e-5, 1e-3, 0.01, 0.1, 0.3, 1.0, 10.0, 100.0];
    let over = [0.5, 0.99, 0.9999, 1.0, 1.0001, 1.01, 2.0];
    let mut most = 0.0f64;
    for turn in [Vec3::ZERO, Vec3::new(2.0, -0.3, 0.4), Vec3::Y * math::PI] {
        let turn: Quat = math::exp(turn);
        for (foot, radius) in feet.iter().flat_map(|foot| radii.map(|radius| (*foot, radius))) {
            for side in sides.into_iter().chain(over.map(|over| over * radius)) {
                let [start_m, end_m] = [Vec3::ZERO, turn * (Vec3::Z * 0.3)];
                let point_m = turn * (Vec3::new(side, 0.0, foot) * 0.3);
                let radius_m = radius * 0.3;
                let got = of_one(point_m, start_m, end_m, radius_m);
                let (start, end) = (start_m.as_dvec3(), end_m.as_dvec3());
                for (got, point) in got.into_iter().zip([point_m.as_dvec3(), DVec3::ZERO]) {
                    let exact = distance_integral_m3(start, end, f64::from(radius_m), point);
                    let off = (f64::from(got) / exact - 1.0).abs();
                    assert!(off < 1e-6, "foot {foot}, side {side}, radius {radius}: {off:e}");
                    most = most.max(off);
                }
            }
        }
    }
    // The rule itself has an error of 1.6e-7 in the worst case.
    assert!(most > 1e-7, "{most:e}: say that it is better");
}

#[test]
fn points_on_a_grid_come_to_the_cylinders() {
    const SIDE: u16 = 96;
    const POINTS: NonZeroU16 = NonZeroU16::new(SIDE * SIDE).expect("some");
    let middle = |k: u16| (f32::from(k) + 0.5) / f32::from(SIDE);
    let grid = || (0..SIDE * SIDE).map(|k| (middle(k / SIDE), middle(k % SIDE)));
    // Upwards, downwards, almost downwards and oblique.
    for direction in [Vec3::Z, -Vec3::Z, Vec3::new(1e-4, 0.0, -1.0), Vec3::new(0.6, -0.3, -0.7)] {
        let start_m = Vec3::new(0.3, -0.2, 0.1);
        let positions_m = [Vec3::ZERO, start_m, start_m + direction * 0.4];
        let arm = RestPose::<3>::new(&[None, Some(0), Some(1)], &positions_m).expect("an arm");
        let radii_m = [0.0, 0.05, 0.07];
        let exact = cylinder_surface(&arm, &radii_m, 1e-3).expect("weights");
        let got = cylinder_samples(&arm, &radii_m, 1e-3, POINTS, grid().chain(grid()));
        let expected = exact.as_slice().iter().map(|weight| f64::from(*weight));
        // Error of the midpoint rule with 96 steps: (1 / 96)² / 24 times the second derivative.
        let off = worst(got.expect("weights").as_slice(), expected);
        assert!(off < 1e-5, "{direction}: {off:e}");
    }
}

/// Returns the corners of a tube of `sides` times `rings` rectangles, each with its area: every rectangle is two
/// triangles, and a third of a triangle's area belongs to each of its corners.
fn tube(sides: u16, rings: u16, radius_m: f32, length_m: f32) -> Vec<(Vec3, f32)> {
    let chord_m = 2.0 * radius_m * (math::PI / f32::from(sides)).sin();
    let rectangle_m2 = chord_m * length_m / f32::from(rings);
    (0..=rings)
        .flat_map(|ring| {
            // A corner at an end has three triangles, half of the six elsewhere.
            let area_m2 = if ring == 0 || ring == rings { 0.5 } else { 1.0 } * rectangle_m2;
            let along_m = length_m * f32::from(ring) / f32::from(rings);
            (0..sides).map(move |side| {
                let (y, z) = (2.0 * math::PI * f32::from(side) / f32::from(sides)).sin_cos();
                (Vec3::new(along_m, y * radius_m, z * radius_m), area_m2)
            })
        })
        .collect()
}

#[test]
fn the_mesh_of_a_tube_is_the_cylinder_and_many_vertices_cost_no_digits() {
    let positions_m = [Vec3::new(-0.2, 0.05, 0.1), Vec3::ZERO, Vec3::X * 0.4];
    let arm = RestPose::<3>::new(&[None, Some(0), Some(1)], &positions_m).expect("an arm");
    let cylinder = cylinder_surface(&arm, &[0.0, 0.0, 0.05], 1e-3).expect("weights");
    // The last mesh has 102,656 vertices.
    for (sides, rings, limit) in [(16, 20, 8e-3), (64, 80, 5e-4), (256, 400, 3e-5)] {
        let corners = tube(sides, rings, 0.05, 0.4);
        let mut mesh = MeshSurface::new(arm.clone(), 1e-3).expect("a base");
        for (position_m, area_m2) in &corners {
            // The elbow moves the skin of the bone to the hand.
            mesh.add(*position_m, *area_m2, &[(1, 1.0)]).expect("a vertex");
        }
        let weights = mesh.importance().expect("weights");
        let expected = cylinder.as_slice().iter().map(|weight| f64::from(*weight));
        // The perimeter of a polygon of n sides in a circle is too small by (π / n)² / 6, and the polygon is nearer
        // by half of that.
        let off = worst(weights.as_slice(), expected);
        assert!(off < limit, "{sides} sides: {off:e}");

        let exact = positions_m.iter().enumerate().map(|(joint, joint_m)| {
            let term = |(position_m, area_m2): &(Vec3, f32)| {
                f64::from(*area_m2) * (position_m.as_dvec3() - joint_m.as_dvec3()).length()
            };
            let sum: f64 = if joint < 2 { corners.iter().map(term).sum() } else { 0.0 };
            f64::from(1e-3f32) + sum
        });
        let off = worst(weights.as_slice(), exact);
        assert!(off < 1e-7, "{sides} sides: {off:e}");
    }
}

#[test]
fn a_tree_at_rest_is_a_skeleton() {
    let body = |parent, placement| Body {
        parent,
        joint: JointKind::Spherical,
        placement,
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    };
    let quarter = math::exp(Vec3::Z * (0.5 * math::PI));
    let turned = Transform::new(quarter, Vec3::X);
    let tree = Tree::<N>::from_bodies(&[
        body(None, turned),
        body(Some(0), turned),
        body(Some(1), turned),
        body(Some(0), Transform::IDENTITY),
    ])
    .expect("a tree");
    let rest_pose = RestPose::of_tree(&tree).expect("a skeleton");
    let expected = [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y, Vec3::X];
    for (joint, position_m) in expected.into_iter().enumerate() {
        assert!(rest_pose.position_m(joint).abs_diff_eq(position_m, 1e-6), "{joint}");
        assert_eq!(rest_pose.parent(joint), tree.parent(joint));
        let below: Vec<_> = tree.subtree(joint).iter().filter(|below| *below != joint).collect();
        assert_eq!(rest_pose.descendants(joint).iter().collect::<Vec<_>>(), below);
    }
}
