use super::*;
use crate::description::{Drive, DriveKind, Joint, JointType, Servo};

fn rig(joints: Vec<Joint>, kind: DriveKind, servos: usize) -> Description {
    let servo = |index: usize| Servo {
        name: format!("s{index}"),
        model: "XL330-M288-T".to_owned(),
        ..Servo::default()
    };
    let drive = Drive {
        joints: joints.iter().map(|joint| joint.name.clone()).collect(),
        servos: (0..servos).map(|index| format!("s{index}")).collect(),
        kind,
    };
    Description {
        joints,
        drives: vec![drive],
        servos: (0..servos).map(servo).collect(),
        ..Description::default()
    }
}

fn joints(kinds: &[JointType]) -> Vec<Joint> {
    let joint = |(index, kind): (usize, &JointType)| Joint {
        name: format!("j{index}"),
        kind: *kind,
        ..Joint::default()
    };
    kinds.iter().enumerate().map(joint).collect()
}

fn matrix(rows: &[&[f64]]) -> DriveKind {
    DriveKind::Matrix { rows: rows.iter().map(|row| row.to_vec()).collect(), offset: Vec::new() }
}

fn defaults(rig: &Description) -> Vec<JointDefaults> {
    let all = rig.actuation().unwrap().joint_defaults(rig);
    all.into_iter().map(|joint| joint.expect("it has a drive")).collect()
}

/// Asserts equality up to a few roundings of f32.
#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-5 * expected.abs(), "{found} for {expected}");
}

#[test]
fn one_servo_gives_its_joint_what_its_kind_says() {
    let mut rig = rig(joints(&[JointType::Revolute]), matrix(&[&[1.0]]), 1);
    let [own] = defaults(&rig)[..] else { panic!("one joint") };
    assert_near(own.rotor_inertia, 0.00181);
    assert_near(own.friction, 0.0128);
    assert_near(own.damping, 0.0037);
    assert_near(own.effort, 0.52);
    assert_near(own.speed, 10.786);
    // A gear of 3 turns of the servo for 1 turn of the joint, and limits of its own.
    rig.servos[0].gear = 3.0;
    rig.servos[0].torque_nm = Some(0.2);
    let [geared] = defaults(&rig)[..] else { panic!("one joint") };
    assert_near(geared.rotor_inertia, 9.0 * 0.00181);
    assert_near(geared.friction, 3.0 * 0.0128);
    assert_near(geared.damping, 9.0 * 0.0037);
    assert_near(geared.effort, 0.6);
    assert_near(geared.speed, 10.786 / 3.0);
}

#[test]
fn servos_that_share_a_joint_add_up() {
    let [pair] = defaults(&rig(joints(&[JointType::Revolute]), matrix(&[&[0.5, -0.5]]), 2))[..]
    else {
        panic!("one joint")
    };
    assert_near(pair.rotor_inertia, 2.0 * 0.00181);
    assert_near(pair.friction, 2.0 * 0.0128);
    assert_near(pair.effort, 1.04);
    assert_near(pair.speed, 10.786);
}

#[test]
fn one_servo_that_moves_two_joints_is_counted_once() {
    let kinds = [JointType::Revolute, JointType::Prismatic];
    let found = defaults(&rig(joints(&kinds), matrix(&[&[1.0], &[0.01]]), 1));
    let [turn, slide] = found[..] else { panic!("two joints") };
    assert_near(turn.speed, 10.786);
    assert_near(slide.speed, 0.10786);
    assert_near(slide.effort, 52.0);
    // At a given speed of the servo, energy and losses of both joints together are those of the servo.
    let both =
        |of: fn(&JointDefaults) -> f64, power: i32| of(&turn) + of(&slide) * 0.01_f64.powi(power);
    assert_near(both(|joint| joint.rotor_inertia, 2), 0.00181);
    assert_near(both(|joint| joint.damping, 2), 0.0037);
    assert_near(both(|joint| joint.friction, 1), 0.0128);
}

#[test]
fn a_ball_joint_has_the_mean_of_its_dofs() {
    let rows: [&[f64]; 3] = [&[1.0, 0.0, 0.0], &[0.0, 0.5, 0.0], &[0.0, 0.0, 0.5]];
    let [ball] = defaults(&rig(joints(&[JointType::Spherical]), matrix(&rows), 3))[..] else {
        panic!("one joint")
    };
    assert_near(ball.rotor_inertia, 3.0 * 0.00181);
    assert_near(ball.effort, 0.52);
    assert_near(ball.speed, 0.5 * 10.786);
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let message = |rig: &Description| rig.actuation().unwrap_err().to_string();
    let mut unknown = rig(joints(&[JointType::Revolute]), matrix(&[&[1.0]]), 1);
    unknown.servos[0].model = "XL330-M288".to_owned();
    assert_eq!(
        message(&unknown),
        "servo[0].model of servo \"s0\": expected a known kind of servo, such as \"XL330-M288-T\", \
         found \"XL330-M288\""
    );
    let kinds = [JointType::Revolute, JointType::Revolute];
    let singular = rig(joints(&kinds), matrix(&[&[1.0, 1.0], &[1.0, 1.0]]), 2);
    let found = message(&singular);
    assert!(found.starts_with("drive[0].matrix of drive \"j0, j1\": expected a drive"), "{found}");
    // A servo that turns a whole turn would move any linkage through a toggle.
    let four_bar = DriveKind::FourBar {
        ground_m: 0.05,
        crank_m: 0.02,
        coupler_m: 0.05,
        rocker_m: 0.03,
        crank_zero_rad: 1.5,
        rocker_zero_rad: 1.5,
        crossed: false,
    };
    let mut linkage = rig(joints(&[JointType::Revolute]), four_bar, 1);
    let found = message(&linkage);
    assert!(found.contains("drive[0].four_bar") && found.contains("width"), "{found}");
    linkage.servos[0].range_rad = vec![[-0.6, 0.6]];
    assert!(linkage.actuation().is_ok());
    // The servo's offset sets the drive's zero: now the range passes a toggle at 21.8 deg of the crank.
    linkage.servos[0].offset_rad = Some(1.0);
    assert!(message(&linkage).contains("one line"), "{}", message(&linkage));
}
