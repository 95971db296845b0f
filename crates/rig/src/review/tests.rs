use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;

use super::*;
use crate::mechanism::Link;

/// A point of 1 kg with a small inertia, on a joint.
fn link(parent: Option<usize>, joint: JointModel, position_m: DVec3, center_m: DVec3) -> Link {
    Link {
        name: "body".into(),
        joint_name: "joint".into(),
        mass_kg: 1.0,
        center_of_mass_m: center_m,
        inertia_kg_m2: DMat3::from_diagonal(DVec3::splat(1e-3)),
        ..Link::on(parent, joint, position_m)
    }
}

fn arm() -> Mechanism {
    let hinge = JointModel::Revolute(DVec3::Z);
    Mechanism {
        bodies: vec![
            link(None, JointModel::Fixed, DVec3::ZERO, DVec3::ZERO),
            link(Some(0), hinge, DVec3::Y * 0.1, DVec3::Y * 0.2),
            link(Some(1), hinge, DVec3::Y * 0.4, DVec3::Y * 0.3),
        ],
        linked: Vec::new(),
    }
}

#[test]
fn the_worst_pose_of_an_arm_is_stretched_out_level() {
    let arm = arm();
    assert!(worst_load(&arm, 1, 0).effort > 0.0, "home, upright, takes nothing");
    assert!((worst_load(&arm, 1, 0).effort - 9.81 * (0.2 + 0.4 + 0.3)).abs() < 1e-9);
    assert!((worst_load(&arm, 2, 0).effort - 9.81 * 0.3).abs() < 1e-9);
}

#[test]
fn ranges_are_kept() {
    let mut arm = arm();
    arm.bodies[1].ranges = vec![[-0.3, 0.2]];
    arm.bodies[2].ranges = vec![[0.0, 0.5]];
    // 0.2 and 0.5 rad are to the same side.
    let (upper, lower) = (0.2_f64.sin(), 0.7_f64.sin());
    let at_sum = 9.81 * (0.2 * upper + 0.4 * upper + 0.3 * lower);
    let worst = worst_load(&arm, 1, 0);
    assert!((worst.effort - at_sum).abs() < 1e-9, "{worst:?}");
    assert_eq!(worst.q, [0.2, 0.5]);
}

#[test]
fn a_slide_carries_what_is_on_it() {
    let mut lift = arm();
    lift.bodies[1].joint = JointModel::Prismatic(DVec3::Y);
    assert!((worst_load(&lift, 1, 0).effort - 2.0 * 9.81).abs() < 1e-9);
}

#[test]
fn a_mounted_rig_feels_gravity_in_its_own_axes() {
    // The base is on its side, therefore the hinge axes are vertical and carry no load.
    let mut arm = arm();
    arm.bodies[0].rotation = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    assert!(worst_load(&arm, 1, 0).effort < 1e-9);
}

#[test]
fn reach_is_all_links_end_to_end() {
    let arm = arm();
    assert!((reach_m(&arm, 1) - 0.7).abs() < 1e-12);
    assert!((reach_m(&arm, 2) - 0.3).abs() < 1e-12);
}

#[test]
fn a_review_says_what_is_too_heavy() {
    let arm = arm();
    let capability = |stall| Capability {
        servos: vec!["one".into()],
        continuous: 0.4 * stall,
        stall,
        no_load_speed: 5.0,
        resolution: 0.0015,
        current_per_effort: 2.0,
        guessed: false,
        reached: None,
        gear: None,
    };
    let servos = Servos {
        by_dof: vec![Some(capability(6.0)), Some(capability(20.0))],
        stall_current_a: 3.0,
        supply_a: Some(2.0),
        voltages: Vec::new(),
    };
    let control = Loop { rate_hz: 500.0, latency_ticks: 1, bandwidth_rad_s: None };
    let review = Review::of(&arm, &servos, control).unwrap();
    let of = |severity| -> Vec<&str> {
        let found = review.findings.iter().filter(|finding| finding.severity == severity);
        found.map(|finding| finding.about.as_str()).collect()
    };
    // 8.8 N m exceeds 6 N m; holding takes 2 A/(N m) times both loads, but the supply gives 2 A.
    assert_eq!(of(Severity::Fault), ["joint joint", "supply"], "{:?}", review.findings);
    let [upper, lower] = &review.by_dof[..] else { panic!("{review:?}") };
    // About the shoulder: two points of 1 kg, and their own inertia.
    assert!((upper.inertia - (0.2_f64.powi(2) + 0.7_f64.powi(2) + 2e-3)).abs() < 1e-6);
    assert!(upper.inertia_free < upper.inertia && lower.inertia > 0.0);
    assert!((lower.resolution_mm.unwrap() - 0.45).abs() < 1e-9);
}

/// A servo of 72 g has a gyration radius of about 25 mm if its inertia is in g mm². The hint must appear only for
/// numbers that the unit explains.
#[test]
fn units_are_doubted_where_others_explain_the_number() {
    let review_of = |mass_kg: f64, moment: f64| {
        let mut arm = arm();
        arm.bodies[2].mass_kg = mass_kg;
        arm.bodies[2].inertia_kg_m2 = DMat3::from_diagonal(DVec3::splat(moment));
        let control = Loop { rate_hz: 500.0, latency_ticks: 1, bandwidth_rad_s: None };
        let servos = Servos {
            by_dof: vec![None, None],
            stall_current_a: 0.0,
            supply_a: None,
            voltages: Vec::new(),
        };
        let findings = Review::of(&arm, &servos, control).unwrap().findings;
        let about = |finding: &&Finding| finding.text.contains("more than the whole rig's");
        findings.iter().find(about).map(|finding| finding.text.contains("g mm²"))
    };
    assert_eq!(review_of(0.072, 0.072 * 25.0_f64.powi(2) / 1.5 * 1e3), Some(true));
    // Placeholders for mass, for inertia, and for both.
    for (mass_kg, moment) in [(1e-9, 1e-3), (1e-3, 1e-2), (0.5, 1.0), (1.0, 1.0), (1e-5, 1.0)] {
        assert_eq!(review_of(mass_kg, moment), Some(false), "{mass_kg} kg, {moment} kg m²");
    }
    assert_eq!(review_of(1.0, 1e-3), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The search may miss the true worst pose, but no random pose is worse by more than 1 %.
    #[test]
    fn no_pose_met_by_chance_is_worse(
        joints in prop::collection::vec(
            (0..3_usize, prop::array::uniform3(-0.3..0.3_f64), prop::array::uniform3(-0.1..0.1_f64), -2.0..0.0_f64, 0.0..2.0_f64, 0..5_usize),
            1..6,
        ),
        poses in prop::collection::vec(prop::collection::vec(0.0..1.0_f64, 6), 200),
    ) {
        let mut bodies = vec![link(None, JointModel::Fixed, DVec3::ZERO, DVec3::ZERO)];
        for (index, (axis, position, center, least, most, parent)) in joints.into_iter().enumerate() {
            let hinge = JointModel::Revolute(DVec3::AXES[axis]);
            let mut next = link(Some(index.saturating_sub(parent / 4)), hinge, position.into(), center.into());
            next.ranges = vec![[least, most]];
            bodies.push(next);
        }
        let rig = Mechanism { bodies, linked: Vec::new() };
        for joint in 1..rig.bodies.len() {
            let worst = worst_load(&rig, joint, 0);
            let reached = holding_effort(&rig, &worst.q, joint, 0).abs();
            prop_assert!((worst.effort - reached).abs() < 1e-12);
            for pose in &poses {
                let q: Vec<f64> = rig.bodies[1..].iter().zip(pose).map(|(link, share)| {
                    let [least, most] = link.ranges[0];
                    least + share * (most - least)
                }).collect();
                let load = holding_effort(&rig, &q, joint, 0).abs();
                prop_assert!(load <= worst.effort * 1.01 + 1e-9, "{load} {}", worst.effort);
            }
        }
    }
}

#[test]
fn a_supply_that_is_too_high_or_too_low_is_found() {
    let mut rig = crate::new::arm(6).unwrap();
    let mut of = |voltage_v: f64| {
        rig.supply.as_mut().unwrap().voltage_v = voltage_v;
        let mechanism = rig.mechanism().unwrap();
        let servos = Servos::of(&rig, &mechanism).unwrap();
        let control = Loop { rate_hz: 500.0, latency_ticks: 1, bandwidth_rad_s: None };
        let review = Review::of(&mechanism, &servos, control).unwrap();
        let found = review.findings.iter().find(|finding| finding.text.contains(" V"));
        found.map(|finding| finding.severity)
    };
    assert_eq!(of(5.0), None);
    assert_eq!(of(24.0), Some(Severity::Fault));
    assert_eq!(of(3.0), Some(Severity::Warning));
}

#[test]
fn friction_that_no_drive_overcomes_is_found() {
    let mut arm = arm();
    let hinge = &mut arm.bodies[1];
    (hinge.friction, hinge.damping, hinge.speed, hinge.effort) = (1.0, 2.0, 8.0, 15.0);
    let control = Loop { rate_hz: 500.0, latency_ticks: 1, bandwidth_rad_s: None };
    let review = Review::of(&arm, &Servos::default(), control).unwrap();
    let found =
        review.findings.iter().any(|finding| finding.text.starts_with("friction takes 17.000"));
    assert!(found, "{:?}", review.findings);
}

/// An arm of XL330 servos in its old form, reviewed with the observer bandwidths of the rule and with 100 rad/s for
/// all joints.
#[test]
fn a_servo_that_reaches_less_than_its_joint_is_found() {
    let mut rig = crate::new::arm(2).unwrap();
    let reached = |rig: &crate::description::Description| {
        let mechanism = rig.mechanism().unwrap();
        Servos::of(rig, &mechanism).unwrap().by_dof[0].clone().unwrap().reached
    };
    assert_eq!(reached(&rig), None);
    // The servo turns by pi to each side, so behind a gear of 4 the joint turns by a quarter of it.
    let quarter = std::f64::consts::FRAC_PI_4;
    rig.servos[0].range_rad = vec![[-std::f64::consts::PI, std::f64::consts::PI]];
    rig.servos[0].gear = 4.0;
    let [joint_least, joint_most] = rig.joints[0].range_rad[0];
    assert!(joint_least < -quarter && joint_most > quarter);
    let [least, most] = reached(&rig).unwrap();
    assert!((least + quarter).abs() < 1e-3 && (most - quarter).abs() < 1e-3, "{least} {most}");
    rig.joints[0].range_rad[0] = [least, most];
    assert_eq!(reached(&rig), None);
}

#[test]
fn a_loop_that_its_gear_does_not_bear_is_found() {
    // The links of this old file are longer than those of the current arm.
    let rig = include_str!("../../../../tests/support/rigs/arm_62ff7e0.toml");
    let rig = crate::toml_file::read(rig).unwrap();
    let mechanism = rig.mechanism().unwrap();
    let of = |bandwidth_rad_s, latency_ticks, is_by_current: fn(&str) -> bool| {
        let servos = Servos::of(&rig, &mechanism).unwrap().with_loops_of(is_by_current);
        let control = Loop { rate_hz: 500.0, latency_ticks, bandwidth_rad_s };
        Review::of(&mechanism, &servos, control).unwrap()
    };
    let found = |review: &Review| -> Vec<(Severity, String)> {
        let found = review.findings.iter().filter(|finding| finding.text.contains("shake"));
        found.map(|finding| (finding.severity, finding.about.clone())).collect()
    };
    let by_rule = of(None, 1, |_| true);
    assert_eq!(found(&by_rule), []);
    for dof in &by_rule.by_dof {
        let control = dof.control.unwrap();
        let margins = control.nominal.margins.unwrap();
        assert!(margins.phase_deg > 30.0 && margins.gain.unwrap() > 2.0, "{dof:?}");
        assert!(control.worst.margins.is_some(), "{dof:?}");
        let [least, most] = control.load_inertia;
        assert!(0.0 < least && least <= most, "{dof:?}");
    }
    let fast = of(Some(100.0), 1, |_| true);
    let joints = ["joint turn1", "joint bend2", "joint bend3"];
    assert_eq!(found(&fast), joints.map(|name| (Severity::Warning, name.to_owned())));
    // A bandwidth 1 % below the reported limit is stable, and 1 % above it is not.
    let bearable = fast.by_dof[1].control.unwrap().bearable_rad_s.unwrap();
    assert_eq!(found(&of(Some(0.99 * bearable), 1, |_| true)), []);
    assert!(!found(&of(Some(1.01 * bearable), 1, |_| true)).is_empty());
    let too_late = of(Some(400.0), 4, |_| true);
    assert!(found(&too_late).iter().any(|(severity, _)| *severity == Severity::Fault));
    // A servo in position mode closes a loop of its own.
    let mixed = of(Some(100.0), 1, |servo| servo == "bend3");
    assert_eq!(found(&mixed), [(Severity::Warning, "joint bend3".to_owned())]);
    assert_eq!(mixed.by_dof.iter().filter(|dof| dof.control.is_some()).count(), 1);
}
