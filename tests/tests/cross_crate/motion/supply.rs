//! The supply that all joints share: its bound, its optimality conditions in f64, its refusals and extremes.

use proptest::collection::vec;
use proptest::prelude::*;
use sinew_core::control::{Gains, LimitReason, Limited};
use sinew_core::dynamics::{BodyMotion, inverse_dynamics};
use sinew_core::glam::{DVec3, Vec3, Vec3Swizzles};
use sinew_core::state_error::Method;
use sinew_core::supply::{SupplyError, TorqueSupply};
use sinew_core::{
    Body, Inertia, JointKind, JointTargets, TorqueController, Transform, Tree, Twist, Workspace,
    Wrench,
};
use sinew_test_support::extreme::any_vector;
use sinew_test_support::property;
use sinew_test_support::rig::{CAPACITY, Joints, rigs};

type Torque = Limited<Wrench>;

/// Returns a share of a sum, in the core's precision.
#[expect(clippy::cast_possible_truncation, reason = "supplies are f32")]
fn share_nm(sum_nm: f64, share: f32) -> f32 {
    sum_nm as f32 * share
}

fn star(joints: usize, root: JointKind) -> Tree<CAPACITY> {
    let body = |index: usize| Body {
        parent: (index > 0).then_some(0),
        joint: if index == 0 { root } else { JointKind::Spherical },
        placement: Transform::IDENTITY,
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    };
    Tree::from_bodies(&(0..joints).map(body).collect::<Vec<_>>()).expect("a good tree")
}

fn torques(moments_nm: &[Vec3]) -> Vec<Torque> {
    let torque = |moment: &Vec3| Limited { value: Wrench::new(*moment, Vec3::Y), reason: None };
    moments_nm.iter().map(torque).collect()
}

fn moment(torque: &Torque) -> DVec3 {
    torque.value.moment_nm.as_dvec3()
}

fn sum_nm(torques: &[Torque]) -> f64 {
    torques.iter().map(|torque| moment(torque).length()).sum()
}

/// Moments of very different sizes, some of them zero, a weight for each, and a supply as a share of their sum.
fn cases() -> impl Strategy<Value = (Vec<(Vec3, f32)>, f32)> {
    let size = prop_oneof![Just(0.0_f32), (-3.0_f32..3.0).prop_map(|power| 10.0_f32.powf(power))];
    let component = || -1.0_f32..1.0;
    let moment = (component(), component(), component(), size)
        .prop_map(|(x, y, z, size)| Vec3::new(x, y, z) * size);
    let weight = (-4.0_f32..4.0).prop_map(|power| 10.0_f32.powf(power));
    (vec((moment, weight), 1..=CAPACITY), 0.0_f32..1.2)
}

proptest! {
    #![proptest_config(property(500))]

    #[test]
    fn what_is_cut_is_the_least_by_its_weights((joints, share) in cases(), alike in any::<bool>()) {
        let (moments, weights): (Vec<_>, Vec<_>) = joints.into_iter().unzip();
        let wanted = torques(&moments);
        let wanted_sum = sum_nm(&wanted);
        let supply_nm = share_nm(wanted_sum, share);
        let tree = star(moments.len(), JointKind::Spherical);
        let supply = TorqueSupply::new(&tree, supply_nm).unwrap();
        let supply = if alike { supply } else { supply.with_weights(&weights).unwrap() };
        let mut given = wanted.clone();
        supply.share(&mut given);

        if share > 1.001 {
            prop_assert_eq!(&given, &wanted, "there is enough: every bit stays");
        }
        // 128 sums of f32 have an error of at most 128 half units of the last place; about ten were observed.
        let rounding = 128.0 * f64::from(f32::EPSILON);
        prop_assert!(sum_nm(&given) <= f64::from(supply_nm) * (1.0 + rounding));
        let is_cut = share < 0.999 && wanted_sum > 0.0;
        if is_cut {
            // The whole supply is used.
            prop_assert!(sum_nm(&given) >= f64::from(supply_nm) - wanted_sum * rounding);
        }
        let rule = |joint: usize| if alike { None } else { Some(f64::from(weights[joint])) };
        let expected = optimum(&wanted, f64::from(supply_nm), rule);
        for ((given, wanted), expected_nm) in given.iter().zip(&wanted).zip(expected) {
            prop_assert_eq!(given.value.force_n, wanted.value.force_n);
            let (given_nm, wanted_nm) = (moment(given), moment(wanted));
            let length_nm = given_nm.length();
            prop_assert!((length_nm - expected_nm).abs() <= wanted_sum * rounding);
            prop_assert!(length_nm <= wanted_nm.length());
            prop_assert!(given_nm.dot(wanted_nm) >= length_nm * wanted_nm.length() * (1.0 - 1e-6));
            let reason = (given != wanted).then_some(LimitReason::Supply);
            prop_assert_eq!(given.reason, reason);
        }
    }

    #[test]
    fn what_carries_is_left_and_the_rest_is_cut_alike((joints, share) in cases(), carrying in 0.0_f32..1.5) {
        let (moments, others): (Vec<Vec3>, Vec<f32>) = joints.into_iter().unzip();
        let wanted = torques(&moments);
        // The carried moments are proportional to the wanted moments in size, and have another direction.
        let carried: Vec<Wrench> = moments
            .iter()
            .zip(&others)
            .map(|(moment, other)| Wrench::new((*moment + moment.yzx() * other.min(2.0)) * carrying, Vec3::ZERO))
            .collect();
        let supply_nm = share_nm(sum_nm(&wanted), share);
        let tree = star(moments.len(), JointKind::Spherical);
        let mut given = wanted.clone();
        TorqueSupply::new(&tree, supply_nm).unwrap().share_acceleration(&mut given, &carried);
        let rounding = 128.0 * f64::from(f32::EPSILON);
        prop_assert!(sum_nm(&given) <= f64::from(supply_nm) * (1.0 + rounding));
        if share > 1.001 {
            prop_assert_eq!(&given, &wanted);
        }
        let of = |wrench: &Wrench| wrench.moment_nm.as_dvec3();
        let sum_carried: f64 = carried.iter().map(|wrench| of(wrench).length()).sum();
        let (supply, sum) = (f64::from(supply_nm), sum_nm(&wanted));
        if share < 0.999 && sum > 0.0 {
            let (s, left) = if sum_carried < supply {
                let s = (supply - sum_carried) / (sum - sum_carried);
                (s, 1.0 - s)
            } else {
                (supply / sum, 0.0)
            };
            // The share s is known to a rounding of the sums, divided by their difference.
            let known = rounding * (sum + sum_carried) * (1.0 + sum / (sum - sum_carried).abs());
            for ((given, wanted), carried) in given.iter().zip(&wanted).zip(&carried) {
                let expected = of(carried) * left + moment(wanted) * s;
                prop_assert!((moment(given) - expected).length() <= known, "{given:?}, {expected}");
                let is_cut = given.value != wanted.value;
                prop_assert_eq!(given.reason, is_cut.then_some(LimitReason::Supply));
            }
        }
    }

    #[test]
    fn accelerations_of_a_free_root_are_cut_as_those_of_the_joints(
        rig in rigs(24, Joints::Mixed),
        share in 0.1_f32..0.9,
    ) {
        let bodies = rig.tree.bodies();
        let states = rig.states();
        let zeros = vec![Twist::ZERO; bodies.len()];
        let needed = |accelerations: &[Twist]| {
            let (mut scratch, mut out) = (vec![BodyMotion::default(); bodies.len()], vec![Wrench::ZERO; bodies.len()]);
            inverse_dynamics(bodies, states.as_slice(), accelerations, Vec3::NEG_Y * 9.81, &[], &mut scratch, &mut out);
            out
        };
        let (carried, commanded) = (needed(&zeros), needed(&rig.accelerations()));
        let wanted: Vec<Torque> = commanded.iter().map(|value| Limited { value: *value, reason: None }).collect();
        let counts = |index: usize| !matches!(bodies[index].joint, JointKind::Free);
        let sum = |of: &dyn Fn(usize) -> Vec3| -> f64 {
            (0..bodies.len()).filter(|index| counts(*index)).map(|index| of(index).as_dvec3().length()).sum()
        };
        let sum_carried = sum(&|index| carried[index].moment_nm);
        let sum_wanted = sum(&|index| commanded[index].moment_nm);
        prop_assume!(sum_wanted > sum_carried * 1.1 + 1e-3);
        let supply_nm = share_nm(sum_carried, 1.0) + share_nm(sum_wanted - sum_carried, share);
        let mut given = wanted.clone();
        TorqueSupply::new(&rig.tree, supply_nm).unwrap().share_acceleration(&mut given, &carried);
        // The torques for the same share of all accelerations, including the root's: torques are linear in them.
        for ((given, wanted), carried) in given.iter().zip(&commanded).zip(&carried) {
            let way = *wanted - *carried;
            let expected = *carried + Wrench::new(way.moment_nm * share, way.force_n * share);
            let size = wanted.moment_nm.length() + carried.moment_nm.length() + wanted.force_n.length() + carried.force_n.length();
            let off = given.value - expected;
            // The precision of the share: a rounding of the sums, divided by their difference.
            prop_assert!(off.moment_nm.length() + off.force_n.length() <= 1e-4 * size + 1e-5, "{off:?} of {size}");
        }
    }

    #[test]
    fn equal_weights_and_torques_are_cut_alike(
        count in 1_usize..=CAPACITY,
        weight in 1e-6_f32..1e6,
        share in 0.01_f32..0.99,
    ) {
        let moments = vec![Vec3::new(1.0, -2.0, 2.0); count];
        let tree = star(count, JointKind::Fixed);
        let alike = TorqueSupply::new(&tree, share * 3.0 * count as f32).unwrap();
        let weighted = alike.clone().with_weights(&vec![weight; count]).unwrap();
        let [mut one, mut other] = [torques(&moments), torques(&moments)];
        alike.share(&mut one);
        weighted.share(&mut other);
        for (one, other) in one.iter().zip(&other) {
            prop_assert!((moment(one) - moment(other)).length() < 1e-5);
        }
    }

    #[test]
    fn nothing_but_numbers_comes_out(
        moments in vec(any_vector(), 1..=16),
        supply_nm in prop_oneof![Just(0.0), Just(f32::INFINITY), Just(f32::MAX), Just(1e-38), 0.0_f32..100.0],
        extremes in vec(prop_oneof![Just(1e-12_f32), Just(1e12), Just(1.0)], 16),
        alike in any::<bool>(),
    ) {
        let tree = star(moments.len(), JointKind::Spherical);
        let supply = TorqueSupply::new(&tree, supply_nm).unwrap();
        let supply = if alike { supply } else { supply.with_weights(&extremes[..moments.len()]).unwrap() };
        let mut given = torques(&moments);
        supply.share(&mut given);
        for (given, wanted) in given.iter().zip(&moments) {
            prop_assert!(given.value.is_finite());
            if !wanted.is_finite() {
                let refused = Limited { value: Wrench::ZERO, reason: Some(LimitReason::NotFinite) };
                prop_assert_eq!(*given, refused);
            }
        }
        let within = f64::from(supply_nm) * 1.00001 + 1e-18 * f64::from(largest(&moments));
        prop_assert!(sum_nm(&given) <= within);
        let carried: Vec<_> = moments.iter().rev().map(|m| Wrench::new(*m, Vec3::ZERO)).collect();
        let mut given = torques(&moments);
        supply.share_acceleration(&mut given, &carried);
        prop_assert!(given.iter().all(|given| given.value.is_finite()));
        prop_assert!(sum_nm(&given) <= within);
    }
}

/// Returns the lengths of the moments that minimize the weighted sum of squared losses, by the Karush-Kuhn-Tucker
/// conditions: at a price per N m, each joint gives up the torque whose value, by its weight, is below the price.
/// Without a weight, joints are cut in proportion to their wanted torque.
fn optimum(wanted: &[Torque], supply_nm: f64, weight: impl Fn(usize) -> Option<f64>) -> Vec<f64> {
    let at = |price: f64| -> Vec<f64> {
        let lengths = wanted.iter().map(|torque| moment(torque).length()).enumerate();
        lengths
            .map(|(joint, nm)| (nm - price * weight(joint).map_or(nm, f64::recip)).max(0.0))
            .collect()
    };
    let within = |price: f64| at(price).iter().sum::<f64>() <= supply_nm;
    let (mut low, mut high) = (0.0, 1e12);
    if within(low) {
        return at(low);
    }
    for _ in 0..200 {
        let middle = f64::midpoint(low, high);
        *(if within(middle) { &mut high } else { &mut low }) = middle;
    }
    at(high)
}

fn largest(moments: &[Vec3]) -> f32 {
    let components = moments.iter().filter(|m| m.is_finite()).map(|m| m.abs().max_element());
    components.fold(0.0, f32::max)
}

#[test]
fn what_no_servo_drives_takes_nothing_and_keeps_everything() {
    let tree = star(3, JointKind::Free);
    let supply = TorqueSupply::new(&tree, 2.0).unwrap();
    let weighted = supply.clone().with_weights(&[1.0, 1.0, 4.0]).unwrap();
    for (supply, expected) in [(supply, [1.0, 1.0]), (weighted, [0.4, 1.6])] {
        let mut given = torques(&[Vec3::X * 900.0, Vec3::X * 2.0, Vec3::X * 2.0]);
        supply.share(&mut given);
        assert_eq!(given[0], torques(&[Vec3::X * 900.0])[0]);
        for (given, expected) in given[1..].iter().zip(expected) {
            assert!((moment(given).x - expected).abs() < 1e-6);
        }
    }
}

#[test]
fn accelerations_are_cut_alike() {
    let rig = sinew_test_support::rig::rigs(8, sinew_test_support::rig::Joints::Mixed);
    let mut runner = proptest::test_runner::TestRunner::new(property(100));
    runner
        .run(&(rig, 0.0_f32..1.0), |(rig, share)| {
            let (tree, measured) = (rig.tree.clone(), rig.states());
            let gains = Gains::new(30.0, 5.0).unwrap();
            let controller = TorqueController::new(tree.clone(), gains, Method::Local).unwrap();
            let mut workspace = Workspace::new();
            let mut targets = JointTargets::rest(&tree);
            controller.tick(&mut targets, &measured, &[], &mut workspace);
            let before = workspace.clone();
            let mut carried = [Wrench::ZERO; CAPACITY];
            controller.bias_wrenches(&measured, &[], &mut workspace, &mut carried);
            prop_assert_eq!(workspace.torques(), before.torques());
            prop_assert_eq!(workspace.commands(), before.commands());
            // The torques for a share of the commands, and for none, are on one line: dynamics is affine.
            let part: Vec<Twist> = tree
                .bodies()
                .iter()
                .zip(measured.as_slice())
                .zip(before.commands())
                .map(|((body, state), command)| {
                    let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
                    let bias = body.joint.bias_acceleration(in_joint, state.velocity);
                    bias + (*command - bias) * share
                })
                .collect();
            let (mut scratch, mut out) =
                (vec![BodyMotion::default(); tree.len()], vec![Wrench::ZERO; tree.len()]);
            inverse_dynamics(
                tree.bodies(),
                measured.as_slice(),
                &part,
                controller.gravity_m_s2(),
                &[],
                &mut scratch,
                &mut out,
            );
            let size: f32 = before
                .torques()
                .iter()
                .zip(&carried)
                .map(|(a, b)| a.value.moment_nm.length() + b.moment_nm.length())
                .sum();
            for (index, body) in tree.bodies().iter().enumerate() {
                let state = measured.as_slice()[index];
                let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
                let expected = body.joint.project_wrench(in_joint, out[index]).moment_nm;
                let wanted = before.torques()[index].value.moment_nm;
                let line = carried[index].moment_nm.lerp(wanted, share);
                prop_assert!((line - expected).length() <= 1e-4 * (1.0 + size), "{index}");
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn reasons_of_the_tick_stay_where_nothing_more_is_cut() {
    let tree = star(2, JointKind::Fixed);
    let enough = TorqueSupply::new(&tree, 3.0).unwrap();
    let mut given = torques(&[Vec3::X, Vec3::Y]);
    given[1].reason = Some(LimitReason::Torque);
    // There is one torque more than the tree has joints.
    given.push(given[0]);
    let before = given.clone();
    enough.share(&mut given);
    assert_eq!(given[..2], before[..2]);
    assert_eq!(given[2], Limited { value: Wrench::ZERO, reason: Some(LimitReason::NoRoom) });
    TorqueSupply::new(&tree, 1.0).unwrap().share(&mut given[..2]);
    assert_eq!(given[1].reason, Some(LimitReason::Supply));
    enough.share(&mut []);
}

#[test]
fn supplies_and_weights_that_cannot_be_are_refused() {
    let tree = star(2, JointKind::Fixed);
    for nm in [f32::NAN, -1.0, f32::NEG_INFINITY] {
        let error = TorqueSupply::new(&tree, nm).unwrap_err();
        assert!(matches!(error, SupplyError::Supply { .. }));
        assert!(error.to_string().contains("zero or more"), "{error}");
    }
    let supply = TorqueSupply::new(&tree, f32::INFINITY).unwrap();
    assert!(supply.supply_nm().is_infinite());
    let one = supply.clone().with_weights(&[1.0]);
    assert_eq!(one, Err(SupplyError::Count { expected: 2, found: 1 }));
    for value in [0.0, -1.0, 1e-13, 1e13, f32::NAN, f32::INFINITY] {
        let error = supply.clone().with_weights(&[1.0, value]).unwrap_err();
        assert!(matches!(error, SupplyError::Weight { joint: 1, .. }));
        assert!(error.to_string().contains("joint 1"), "{error}");
    }
}
