//! Numbers at the ends of the range of f32, and rigs and states that are made with them.
//!
//! The core refuses values that are not numbers, and quaternions that are not rotations; it accepts everything else
//! here. A *dose* is the percentage of numbers that are extreme: if all were extreme, everything would overflow, and
//! other errors would stay hidden.

use std::f32::consts::{FRAC_1_SQRT_2, PI};

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::{
    Body, Inertia, JointKind, JointState, JointStates, JointTargets, RotationalInertia, Transform,
    Tree, Twist, Wrench, math,
};

/// The ends of the range of f32, and the values at which squares, reciprocals and series change.
pub const FINITE: [f32; 30] = [
    0.0,
    -0.0,
    1e-45,
    -1e-45,
    f32::MIN_POSITIVE / 2.0,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1e-30,
    1e-20,
    -1e-19,
    1e-10,
    1e-4,
    f32::EPSILON,
    0.5,
    1.0,
    -1.0,
    1.0 + f32::EPSILON,
    PI,
    -PI,
    1e4,
    16_777_216.0,
    4_294_967_296.0,
    1e10,
    1e18,
    -1.8e19,
    2e19,
    1e30,
    -1e38,
    f32::MAX,
    f32::MIN,
];

/// Values that are not finite numbers.
pub const NOT_FINITE: [f32; 4] = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY];

/// Returns all these values.
pub fn all() -> impl Iterator<Item = f32> {
    FINITE.into_iter().chain(NOT_FINITE)
}

/// Returns rotations near which formulas differ: none, almost none, quarter and half turns, with either sign.
pub fn rotations() -> Vec<Quat> {
    let of = |x, y, z, w| Quat::from_xyzw(x, y, z, w);
    let half = FRAC_1_SQRT_2;
    let some = [
        Quat::IDENTITY,
        of(1.0, 0.0, 0.0, 0.0),
        of(0.0, 1.0, 0.0, -0.0),
        of(0.0, 0.0, 1.0, 1e-45),
        of(half, half, 0.0, 0.0),
        of(0.0, 0.0, 1.0, 1e-7),
        of(0.0, half, 0.0, half),
        of(1e-4, 0.0, 0.0, 1.0),
        of(0.0, 1e-20, 0.0, 1.0),
        of(0.0, 0.0, 1e-45, 1.0),
        of(0.5, 0.5, 0.5, 0.5),
        // The largest deviations from unit length that are accepted.
        of(0.0, 0.0, 0.6, 0.8) * 1.000_9,
        of(0.6, 0.0, 0.0, 0.8) * 0.999_1,
    ];
    some.into_iter().flat_map(|q| [q, -q]).collect()
}

/// A finite number, extreme in `dose` of a hundred cases.
pub fn number(dose: u32) -> impl Strategy<Value = f32> + Clone {
    prop_oneof![dose => select(FINITE.as_slice()), 100 - dose => -2.0f32..2.0]
}

/// Any value of f32, finite or not.
pub fn any_number() -> impl Strategy<Value = f32> + Clone {
    prop_oneof![
        4 => select(FINITE.as_slice()),
        2 => select(NOT_FINITE.as_slice()),
        2 => any::<u32>().prop_map(f32::from_bits),
        4 => -2.0f32..2.0,
    ]
}

/// A vector of [`number`]s.
pub fn vector(dose: u32) -> impl Strategy<Value = Vec3> + Clone {
    [number(dose), number(dose), number(dose)].prop_map(Vec3::from_array)
}

/// A vector of [`any_number`]s.
pub fn any_vector() -> impl Strategy<Value = Vec3> + Clone {
    [any_number(), any_number(), any_number()].prop_map(Vec3::from_array)
}

/// A rotation, special in `dose` of a hundred cases. Its length is within the tolerance of the core.
pub fn rotation(dose: u32) -> impl Strategy<Value = Quat> + Clone {
    let ordinary =
        [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0].prop_map(|v| math::exp(Vec3::from_array(v)));
    prop_oneof![dose => select(rotations()), 100 - dose => ordinary]
}

/// Four numbers that may be a rotation.
pub fn any_quaternion() -> impl Strategy<Value = Quat> + Clone {
    let numbers = [any_number(), any_number(), any_number(), any_number()];
    prop_oneof![rotation(50), numbers.prop_map(Quat::from_array)]
}

/// A pose with a rotation and a vector of this dose.
pub fn pose(dose: u32) -> impl Strategy<Value = Transform> + Clone {
    (rotation(dose), vector(dose)).prop_map(|(rotation, at)| Transform::new(rotation, at))
}

/// A pose, valid or not.
pub fn any_pose() -> impl Strategy<Value = Transform> + Clone {
    let wrong = (any_quaternion(), any_vector());
    prop_oneof![1 => wrong.prop_map(|(q, v)| Transform::new(q, v)), 2 => pose(20)]
}

/// An angular and a linear part of this dose.
pub fn motion(dose: u32) -> impl Strategy<Value = Twist> + Clone {
    (vector(dose), vector(dose)).prop_map(|(angular, linear)| Twist::new(angular, linear))
}

/// An angular and a linear part of any values.
pub fn any_motion() -> impl Strategy<Value = Twist> + Clone {
    (any_vector(), any_vector()).prop_map(|(angular, linear)| Twist::new(angular, linear))
}

/// A joint of any kind.
pub fn joint() -> impl Strategy<Value = JointKind> + Clone {
    let oblique = Vec3::new(0.6, 0.0, 0.8);
    select(vec![
        JointKind::Fixed,
        JointKind::Revolute { axis: oblique },
        JointKind::Revolute { axis: Vec3::Y },
        JointKind::Prismatic { axis: oblique },
        JointKind::Universal { first: Vec3::X, second: Vec3::Z },
        JointKind::Universal { first: oblique, second: Vec3::Y },
        JointKind::Spherical,
        JointKind::Spherical,
        JointKind::Free,
    ])
}

/// An inertia with a mass from zero to the largest f32, and moments that are physically possible.
pub fn inertia(dose: u32) -> impl Strategy<Value = Inertia> + Clone {
    (number(dose), vector(dose), vector(dose), any::<bool>()).prop_map(
        |(mass, center_of_mass_m, second_moments, point)| {
            let mass_kg = mass.abs();
            // A body with mass may have any three second moments; a body without mass must have none.
            let s = if point || mass_kg <= 0.0 { Vec3::ZERO } else { second_moments.abs() };
            let rotational_kg_m2 = RotationalInertia::diagonal(s.y + s.z, s.z + s.x, s.x + s.y);
            let good = Inertia { mass_kg, center_of_mass_m, rotational_kg_m2 };
            let point = Inertia { rotational_kg_m2: RotationalInertia::default(), ..good };
            if good.validate().is_ok() { good } else { point }
        },
    )
}

/// A tree, the desired and the actual motion of its joints, and external wrenches on its bodies.
#[derive(Debug, Clone)]
pub struct Scene<const N: usize> {
    /// Bodies and joints of the rig.
    pub tree: Tree<N>,
    /// Desired motion of the joints.
    pub targets: JointTargets<N>,
    /// Actual motion of the joints.
    pub measured: JointStates<N>,
    /// Wrenches on all bodies, or only on the first ones. They may contain NaN or infinity.
    pub external: Vec<Wrench>,
    /// Percentage of numbers that are extreme.
    pub dose: u32,
}

/// Scenes of 1 to `N` bodies.
pub fn scenes<const N: usize>() -> impl Strategy<Value = Scene<N>> {
    select(vec![1u32, 5, 30]).prop_flat_map(|dose| {
        let body = (any::<u16>(), joint(), pose(dose), inertia(dose), number(dose));
        let state = (pose(dose), motion(dose));
        let wrench = prop_oneof![9 => motion(dose), 1 => any_motion()]
            .prop_map(|motion| Wrench::new(motion.angular, motion.linear));
        let joint = (body, state.clone(), state, motion(dose));
        (vec(joint, 1..=N), vec(wrench, 0..=N)).prop_map(move |(joints, external)| {
            let mut tree = Tree::new();
            for (index, ((pick, joint, placement, inertia, rotor), ..)) in joints.iter().enumerate()
            {
                let parent = (index > 0).then(|| usize::from(*pick) % index.max(1));
                let (placement, joint, inertia) = (*placement, *joint, *inertia);
                let has_drive = !matches!(joint, JointKind::Fixed | JointKind::Free);
                let rotor_inertia = if has_drive { rotor.abs() } else { 0.0 };
                tree.push(Body { parent, joint, placement, inertia, rotor_inertia })
                    .expect("a possible body");
            }
            let (mut targets, mut measured) = (JointTargets::rest(&tree), JointStates::rest(&tree));
            for (joint, (_, desired, is, acceleration)) in joints.iter().enumerate() {
                let state = |&(pose, velocity): &(Transform, Twist)| JointState { pose, velocity };
                targets.set(joint, state(desired), *acceleration).expect("a possible target");
                measured.set(joint, state(is)).expect("a possible state");
            }
            Scene { tree, targets, measured, external, dose }
        })
    })
}
