//! For each refusal, one rig that is invalid in that way.

use super::*;
use crate::description::{
    Address, Base, Body, BodyShape, Drive, DriveKind, FaceShape, InertiaMatrix, Joint, JointType,
    LinkedLimit, Servo, ServoModel, SourcedValue, Supply,
};

fn body(name: &str) -> Body {
    Body {
        name: name.to_owned(),
        mass_kg: 1.0,
        inertia_kg_m2: Some(InertiaMatrix { xx: 1.0, yy: 1.0, zz: 1.0, ..Default::default() }),
        ..Body::default()
    }
}

fn joint(name: &str, kind: JointType, parent: &str, child: &str) -> Joint {
    let mut joint = Joint {
        name: name.to_owned(),
        kind,
        parent: parent.to_owned(),
        child: child.to_owned(),
        ..Joint::default()
    };
    if matches!(kind, JointType::Revolute | JointType::Prismatic | JointType::Universal) {
        joint.axis = Some([0.0, 0.0, 1.0]);
    }
    if kind == JointType::Universal {
        joint.second_axis = Some([0.0, 1.0, 0.0]);
    }
    joint
}

fn servo(name: &str, id: u8) -> Servo {
    Servo {
        name: name.to_owned(),
        model: "MG90S".to_owned(),
        address: Address::Id(id),
        ..Servo::default()
    }
}

fn drive(joint: &str, servo: &str) -> Drive {
    Drive {
        joints: vec![joint.to_owned()],
        servos: vec![servo.to_owned()],
        kind: DriveKind::one_to_one(1),
    }
}

/// Joints 0 to 4 are hinge, hinge2, slide, cardan and ball, on bodies 1 to 5 in a row; body 0 is the base.
fn rig() -> Description {
    let kinds = [
        ("hinge", JointType::Revolute),
        ("hinge2", JointType::Revolute),
        ("slide", JointType::Prismatic),
        ("cardan", JointType::Universal),
        ("ball", JointType::Spherical),
    ];
    let joints = kinds.iter().enumerate().map(|(index, (name, kind))| {
        joint(name, *kind, &format!("b{index}"), &format!("b{}", index + 1))
    });
    Description {
        name: "rig".to_owned(),
        bodies: (0..=kinds.len()).map(|index| body(&format!("b{index}"))).collect(),
        joints: joints.collect(),
        limits: vec![LinkedLimit {
            joint: "hinge".to_owned(),
            other: "hinge2".to_owned(),
            least_rad: Some(-1.0),
            most_rad: Some(1.0),
            ..LinkedLimit::default()
        }],
        drives: vec![drive("hinge", "s0"), drive("hinge2", "s1")],
        servos: vec![servo("s0", 0), servo("s1", 1)],
        servo_models: vec![model("m0"), model("m1")],
        supply: Some(Supply { voltage_v: 5.0, current_a: 3.0 }),
        ..Description::default()
    }
}

fn model(name: &str) -> ServoModel {
    let mut model = ServoModel { name: name.to_owned(), ..ServoModel::default() };
    let tested = SourcedValue { value: 1.0, source: "guess: a test".to_owned() };
    for (_, value) in model.values_mut() {
        *value = tested.clone();
    }
    for (_, value) in model.optional_values_mut() {
        *value = Some(tested.clone());
    }
    let pulses = [&mut model.pulse_least_us, &mut model.pulse_middle_us, &mut model.pulse_most_us];
    for (pulse, us) in pulses.into_iter().zip([600.0, 1500.0, 2400.0]) {
        *pulse = Some(SourcedValue { value: us, ..tested.clone() });
    }
    model.friction_nm.value = 0.5;
    (model.resolution_rad.value, model.backlash_rad.value) = (0.01, 0.0);
    model
}

/// Breaks a valid rig, and asserts path and words of the error.
#[track_caller]
fn refused(breaks: impl FnOnce(&mut Description), path: &str, words: &str) {
    let mut rig = rig();
    assert_eq!(rig.check(), Ok(()), "the rig is right before");
    breaks(&mut rig);
    let error = rig.check().expect_err(path);
    assert_eq!(error.path.to_string(), path, "{error}");
    assert!(error.to_string().contains(words), "{error}");
    assert_eq!(rig.mechanism(), Err(error));
}

#[test]
fn names_are_there_once_and_known() {
    refused(|rig| rig.name.clear(), "name", "a name");
    refused(|rig| rig.bodies[2].name = " ".to_owned(), "body[2].name", "a name");
    refused(|rig| rig.bodies[2].name = "b1".to_owned(), "body[2].name", "body[1] already");
    refused(|rig| rig.joints[1].name.clear(), "joint[1].name", "a name");
    refused(|rig| rig.joints[1].name = "hinge".to_owned(), "joint[1].name", "joint[0] already");
    refused(|rig| rig.servos[1].name.clear(), "servo[1].name", "a name");
    refused(|rig| rig.servos[1].name = "s0".to_owned(), "servo[1].name", "servo[0] already");
    refused(|rig| rig.servo_models[1].name = "m0".to_owned(), "servo_model[1].name", "already");
    refused(|rig| rig.joints[1].parent = "b1x".to_owned(), "joint[1].parent", "such as \"b");
    refused(|rig| rig.joints[1].child = "?".to_owned(), "joint[1].child", "no body has");
    refused(|rig| rig.limits[0].joint = "hing".to_owned(), "limit[0].joint", "such as \"hinge\"");
    refused(|rig| rig.limits[0].other = "?".to_owned(), "limit[0].other", "no joint has");
    refused(|rig| rig.drives[0].joints[0] = "?".to_owned(), "drive[0].joints[0]", "no joint has");
    refused(|rig| rig.drives[0].servos[0] = "?".to_owned(), "drive[0].servos[0]", "no servo has");
    refused(|rig| rig.servos[0].model.clear(), "servo[0].model", "a name");
    refused(|rig| rig.servos[0].bus.clear(), "servo[0].bus", "a name");
}

#[test]
fn a_rig_is_a_tree_on_one_base() {
    refused(
        |rig| *rig = Description { name: "r".to_owned(), ..Description::default() },
        "body",
        "none",
    );
    refused(
        |rig| rig.joints[1].child = "b1".to_owned(),
        "joint[1].child",
        "\"hinge\" moves already",
    );
    refused(
        |rig| rig.bodies.push(body("alone")),
        "body[6]",
        "2 that no joint moves: \"b0\", \"alone\"",
    );
    let to_base = joint("back", JointType::Revolute, "b1", "b0");
    refused(|rig| rig.joints.push(to_base), "joint[5].parent", "the loop b0 on b1 on b0");
    let to_itself = joint("self", JointType::Revolute, "island", "island");
    refused(
        |rig| {
            rig.bodies.push(body("island"));
            rig.joints.push(to_itself);
        },
        "joint[5].parent",
        "the loop island on island",
    );
}

#[test]
fn bodies_are_counted_after_they_are_merged() {
    let chain = |fixed: usize| {
        let mut rig = Description { name: "chain".to_owned(), ..Description::default() };
        rig.bodies = (0..200).map(|index| body(&format!("b{index}"))).collect();
        rig.joints = (1..200)
            .map(|index| {
                let kind = if index <= fixed { JointType::Fixed } else { JointType::Revolute };
                joint(&format!("j{index}"), kind, &format!("b{}", index - 1), &format!("b{index}"))
            })
            .collect();
        rig
    };
    assert_eq!(chain(72).mechanism().unwrap().bodies.len(), 128);
    let error = chain(71).check().unwrap_err();
    assert_eq!(error.path.to_string(), "body");
    assert!(error.to_string().contains("at most 128 bodies") && error.found == "129", "{error}");
}

#[test]
fn numbers_are_finite_and_of_a_sign_that_can_be() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.1e6] {
        refused(|rig| rig.mount.position_m[1] = bad, "mount.position_m[1]", "finite");
        refused(|rig| rig.mount.rotation_xyzw[3] = bad, "mount.rotation_xyzw[3]", "finite");
        refused(|rig| rig.bodies[0].mass_kg = bad, "body[0].mass_kg", "1.0e6 kg");
        refused(
            |rig| rig.bodies[0].center_of_mass_m[2] = bad,
            "body[0].center_of_mass_m[2]",
            "finite",
        );
        refused(|rig| set_inertia(rig, |i| i.xy = bad), "body[0].inertia_kg_m2.xy", "finite");
        refused(|rig| set_inertia(rig, |i| i.zz = bad), "body[0].inertia_kg_m2.zz", "kg m²");
        refused(|rig| rig.joints[0].position_m[0] = bad, "joint[0].position_m[0]", "finite");
        refused(|rig| rig.joints[0].rotation_xyzw[0] = bad, "joint[0].rotation_xyzw[0]", "finite");
        refused(|rig| rig.joints[0].axis = Some([bad, 0.0, 0.0]), "joint[0].axis[0]", "finite");
        refused(|rig| rig.joints[0].range_rad = vec![[bad, 1.0]], "joint[0].range_deg[0]", " deg");
        refused(|rig| rig.joints[2].range_m = Some([0.0, bad]), "joint[2].range_m[1]", " m ");
        refused(|rig| rig.joints[0].home_rad = Some(bad), "joint[0].home_deg", " deg");
        refused(|rig| rig.joints[2].home_m = Some(bad), "joint[2].home_m", " m ");
        refused(|rig| rig.joints[0].damping = bad, "joint[0].damping", "a number from 0");
        refused(|rig| rig.limits[0].factor = bad, "limit[0].factor", "finite");
        refused(|rig| rig.limits[0].least_rad = Some(bad), "limit[0].least_deg", " deg");
        refused(|rig| rig.limits[0].most_rad = Some(bad), "limit[0].most_deg", " deg");
        refused(|rig| set_rows(rig, vec![vec![bad]]), "drive[0].matrix.rows[0][0]", "finite");
        refused(|rig| rig.servos[0].offset_rad = Some(bad), "servo[0].offset_deg", " deg");
        refused(|rig| rig.servos[0].gear = bad, "servo[0].gear", "above 0");
    }
    for bad in [f64::NAN, -0.5] {
        refused(|rig| rig.bodies[0].mass_kg = bad, "body[0].mass_kg", "a number from 0");
        refused(|rig| rig.joints[0].friction = bad, "joint[0].friction", "a number from 0");
        refused(|rig| rig.joints[0].damping = bad, "joint[0].damping", "a number from 0");
        refused(|rig| rig.joints[0].rotor_inertia = Some(bad), "joint[0].rotor_inertia", "from 0");
        refused(
            |rig| rig.servo_models[1].stall_torque_nm.value = bad,
            "servo_model[1].stall_torque_nm.value",
            "N m",
        );
        refused(
            |rig| set_gear(rig, "gear_damping_nm_s", bad),
            "servo_model[0].gear_damping_nm_s.value",
            "a number from 0",
        );
    }
    for bad in [f64::NAN, -0.5, 1.1] {
        refused(
            |rig| set_gear(rig, "output_friction_share", bad),
            "servo_model[0].output_friction_share.value",
            "a part from 0 to 1",
        );
    }
    for bad in [f64::NAN, -0.5, 0.0] {
        refused(|rig| rig.joints[0].speed_rad_s = Some(bad), "joint[0].speed_deg_s", "deg/s");
        refused(|rig| rig.joints[2].speed_m_s = Some(bad), "joint[2].speed_m_s", "m/s");
        let key = "joint[0].acceleration_deg_s2";
        refused(|rig| rig.joints[0].acceleration_rad_s2 = Some(bad), key, "deg/s²");
        refused(
            |rig| rig.joints[2].acceleration_m_s2 = Some(bad),
            "joint[2].acceleration_m_s2",
            "m/s²",
        );
        refused(|rig| rig.joints[0].effort = Some(bad), "joint[0].effort", "above 0");
        refused(
            |rig| set_gear(rig, "gear_stiffness_nm_rad", bad),
            "servo_model[0].gear_stiffness_nm_rad.value",
            "above 0",
        );
        refused(|rig| rig.servos[0].gear = bad, "servo[0].gear", "above 0");
        refused(|rig| rig.servos[0].torque_nm = Some(bad), "servo[0].torque_nm", "N m");
        refused(|rig| rig.servos[0].speed_rad_s = Some(bad), "servo[0].speed_deg_s", "deg/s");
        let key = "servo[0].acceleration_deg_s2";
        refused(|rig| rig.servos[0].acceleration_rad_s2 = Some(bad), key, "deg/s²");
        let supply = Supply { voltage_v: bad, current_a: 1.0 };
        refused(|rig| rig.supply = Some(supply), "supply.voltage_v", " V");
        let supply = Supply { voltage_v: 5.0, current_a: bad };
        refused(|rig| rig.supply = Some(supply), "supply.current_a", " A");
    }
    // Above 0, and yet no limit, no inertia and no gear.
    let slow = 1e-30;
    let key = "joint[0].acceleration_deg_s2";
    refused(|rig| rig.joints[0].acceleration_rad_s2 = Some(slow), key, "from 5.7e-4 deg/s²");
    refused(|rig| rig.joints[0].speed_rad_s = Some(slow), "joint[0].speed_deg_s", "deg/s");
    refused(|rig| rig.servos[0].speed_rad_s = Some(slow), "servo[0].speed_deg_s", "deg/s");
    refused(|rig| rig.servos[0].torque_nm = Some(slow), "servo[0].torque_nm", "from 1e-12");
    refused(
        |rig| {
            rig.servo_models[0].rotor_inertia_kg_m2.value = 1e-3;
            set_gear(rig, "gear_stiffness_nm_rad", 1.5e3);
        },
        "servo_model[0].gear_stiffness_nm_rad.value",
        "190 Hz",
    );
    let empty = String::new();
    refused(
        |rig| rig.servo_models[0].voltage_v.source = empty,
        "servo_model[0].voltage_v.source",
        "guess",
    );
}

/// Each number alone is possible; together they describe no real servo.
#[test]
fn a_kind_that_no_servo_can_be_is_refused() {
    fn value<'a>(rig: &'a mut Description, key: &str) -> &'a mut f64 {
        let values = rig.servo_models[1].values_mut();
        &mut values.into_iter().find(|(of, _)| *of == key).unwrap().1.value
    }
    for (key, bad, words) in [
        ("resolution_rad", 0.0, "above 0, at most 0.1 rad (5.7 deg), found 0 rad"),
        ("resolution_rad", f64::NAN, "above 0, at most 0.1 rad"),
        ("resolution_rad", 1.0, "above 0, at most 0.1 rad (5.7 deg), found 1 rad"),
        ("backlash_rad", 0.2, "from 0, at most 0.1 rad (5.7 deg), found 0.2 rad"),
        ("rotor_inertia_kg_m2", 0.0, "above 0, at most 1.0e6 kg m², found 0 kg m²"),
        ("stall_torque_nm", 0.0, "above 0, at most 1.0e6 N m, found 0 N m"),
        ("no_load_speed_rad_s", 0.0, "above 0, at most 1.0e6 rad/s, found 0 rad/s"),
        ("torque_constant_nm_a", 0.0, "found 0 N m/A"),
        (
            "friction_nm",
            100.0,
            "less than stall_torque_nm (1 N m), or it never turns, found 100 N m",
        ),
        ("friction_nm", 1.0, "less than stall_torque_nm (1 N m)"),
    ] {
        let path = format!("servo_model[1].{key}.value");
        refused(|rig| *value(rig, key) = bad, &path, words);
    }
    for key in super::servos::MAY_BE_ZERO {
        let mut rig = rig();
        *value(&mut rig, key) = 0.0;
        assert_eq!(rig.check(), Ok(()), "{key}");
    }
}

#[test]
fn poses_of_shapes_are_of_joints_within_their_ranges() {
    let shape = |rig: &mut Description, pose: &[(&str, f64)]| {
        let pose = pose.iter().map(|(joint, at)| ((*joint).to_owned(), *at)).collect();
        rig.face_shapes.push(FaceShape { name: "jawOpen".to_owned(), pose });
    };
    let at = "shape[0].pose";
    refused(|rig| shape(rig, &[("hing", 0.0)]), at, "such as \"hinge\"");
    refused(|rig| shape(rig, &[("hinge", 5000.0)]), at, "within its range");
    refused(|rig| shape(rig, &[("hinge", f64::NAN)]), at, "within its range");
    refused(|rig| shape(rig, &[("hinge", 0.0), ("hinge", 0.0)]), at, "twice");
    let twice = |rig: &mut Description| {
        shape(rig, &[]);
        shape(rig, &[]);
    };
    refused(twice, "shape[1].name", "shape[0] already");
}

/// Pulses must increase, and must belong to a servo that is driven by pulses.
#[test]
fn pulses_that_no_servo_takes_are_refused() {
    let on_channel = |rig: &mut Description, pulse_us| {
        rig.servos[0].address = Address::Channel(0);
        rig.servos[0].pulse_us = Some(pulse_us);
    };
    let mut rig = rig();
    on_channel(&mut rig, [600.0, 1480.0, 2350.0]);
    assert_eq!(rig.check(), Ok(()));
    for wrong in
        [[2350.0, 1480.0, 600.0], [600.0, 600.0, 2350.0], [0.6, 1.48, 2.35], [f64::NAN, 1.0, 2.0]]
    {
        refused(|rig| on_channel(rig, wrong), "servo[0].pulse_us", "rising, from 200 to 4000");
    }
    refused(|rig| rig.servos[0].pulse_us = Some([1.0; 3]), "servo[0].pulse_us", "take pulses");
    refused(|rig| rig.servos[0].travel_rad = Some(1.0), "servo[0].travel_deg", "take pulses");
    let path = "servo_model[0].pulse_middle_us.value";
    refused(|rig| set_gear(rig, "pulse_middle_us", 2500.0), path, "rising pulses");
}

fn set_gear(rig: &mut Description, key: &str, value: f64) {
    for (of, sourced) in rig.servo_models[0].optional_values_mut() {
        if let Some(sourced) = sourced.as_mut().filter(|_| of == key) {
            sourced.value = value;
        }
    }
}

fn set_inertia(rig: &mut Description, set: impl FnOnce(&mut InertiaMatrix)) {
    set(rig.bodies[0].inertia_kg_m2.get_or_insert_default());
}

fn set_rows(rig: &mut Description, rows: Vec<Vec<f64>>) {
    rig.drives[0].kind = DriveKind::Matrix { rows, offset: Vec::new() };
}

#[test]
fn inertias_are_those_of_bodies() {
    let at = "body[0].inertia_kg_m2";
    refused(|rig| set_inertia(rig, |i| i.xx = 2.01), at, "the sum of the other two");
    refused(|rig| set_inertia(rig, |i| i.yz = 0.6), at, "the sum of the other two");
    refused(|rig| rig.bodies[0].mass_kg = 0.0, at, "without mass");
    refused(|rig| rig.bodies[0].box_m = Some([1.0; 3]), "body[0].box_m", "both");
    let only_box = |rig: &mut Description, mass_kg, size_m| {
        let name = "b0".to_owned();
        rig.bodies[0] = Body { name, mass_kg, box_m: Some(size_m), ..Body::default() };
    };
    refused(|rig| only_box(rig, 0.0, [1.0; 3]), "body[0].box_m", "without mass");
    refused(|rig| only_box(rig, 1.0, [1.0, -1.0, 1.0]), "body[0].box_m[1]", "from 0");
}

#[test]
fn shapes_have_the_lengths_of_their_kinds() {
    fn shape(rig: &mut Description, shape: BodyShape) {
        rig.bodies[0].shapes.push(shape);
    }
    let at = |key: &str| format!("body[0].shape[0].{key}");
    let ball = BodyShape::sphere(1.0);
    let none = BodyShape { radius_m: None, ..ball.clone() };
    refused(|rig| shape(rig, none), &at("radius_m"), "the length of a sphere");
    let long = BodyShape { length_m: Some(1.0), ..ball.clone() };
    refused(|rig| shape(rig, long), &at("length_m"), "no such length of a sphere");
    refused(|rig| shape(rig, BodyShape::sphere(0.0)), &at("radius_m"), "above 0");
    let turned = ball.clone().at([0.0; 3], [0.0; 4]);
    refused(|rig| shape(rig, turned), &at("rotation_xyzw"), "length 1");
    let bright = ball.colored([2.0, 0.0, 0.0]);
    refused(|rig| shape(rig, bright), &at("color_rgb"), "from 0 to 1");
}

#[test]
fn axes_and_rotations_are_unit_and_where_they_belong() {
    refused(|rig| rig.mount.rotation_xyzw = [0.0; 4], "mount.rotation_xyzw", "of length 0");
    refused(
        |rig| rig.joints[0].rotation_xyzw = [0.0, 0.0, 0.0, 1.01],
        "joint[0].rotation_xyzw",
        "[0, 0, 0, 1]",
    );
    refused(
        |rig| rig.joints[0].axis = Some([3.0, 0.0, 4.0]),
        "joint[0].axis",
        "such as [0.6, 0, 0.8]",
    );
    refused(|rig| rig.joints[0].axis = None, "joint[0].axis", "found nothing");
    refused(|rig| rig.joints[3].second_axis = None, "joint[3].second_axis", "found nothing");
    let near = [0.0, 0.6, 0.8];
    refused(|rig| rig.joints[3].second_axis = Some(near), "joint[3].second_axis", "36.9 deg");
    let axis = Some([1.0, 0.0, 0.0]);
    refused(|rig| rig.joints[4].axis = axis, "joint[4].axis", "no axis, since a spherical joint");
    refused(|rig| rig.joints[0].second_axis = axis, "joint[0].second_axis", "no second_axis");
}

#[test]
fn keys_are_those_of_the_type() {
    let range = [-1.0, 1.0];
    refused(|rig| rig.joints[0].range_m = Some(range), "joint[0].range_m", "expected range_deg");
    refused(|rig| rig.joints[2].range_rad = vec![range], "joint[2].range_deg", "expected range_m");
    refused(|rig| rig.joints[0].home_m = Some(0.0), "joint[0].home_m", "expected home_deg");
    refused(|rig| rig.joints[2].home_rad = Some(0.0), "joint[2].home_deg", "expected home_m");
    refused(|rig| rig.joints[3].home_rad = Some(0.0), "joint[3].home_deg", "no home_deg");
    refused(
        |rig| rig.joints[0].speed_m_s = Some(1.0),
        "joint[0].speed_m_s",
        "expected speed_deg_s",
    );
    refused(
        |rig| rig.joints[2].speed_rad_s = Some(1.0),
        "joint[2].speed_deg_s",
        "expected speed_m_s",
    );
    let key = "joint[0].acceleration_m_s2";
    refused(|rig| rig.joints[0].acceleration_m_s2 = Some(1.0), key, "expected acceleration_deg_s2");
    let key = "joint[2].acceleration_deg_s2";
    refused(|rig| rig.joints[2].acceleration_rad_s2 = Some(1.0), key, "expected acceleration_m_s2");
    for kind in [JointType::Fixed, JointType::Free] {
        let replace = |rig: &mut Description| {
            rig.limits.clear();
            rig.drives.clear();
            rig.joints[0] = joint("hinge", kind, "b0", "b1");
        };
        for (set, key) in [
            ((|joint| joint.effort = Some(1.0)) as fn(&mut Joint), "effort"),
            (|joint| joint.rotor_inertia = Some(1.0), "rotor_inertia"),
            (|joint| joint.friction = 1.0, "friction"),
            (|joint| joint.damping = 1.0, "damping"),
            (|joint| joint.range_rad = vec![[0.0, 1.0]], "range_deg"),
        ] {
            let breaks = |rig: &mut Description| {
                replace(rig);
                set(&mut rig.joints[0]);
            };
            refused(breaks, &format!("joint[0].{key}"), &format!("no {key}"));
        }
    }
}

#[test]
fn ranges_are_ranges_and_homes_lie_in_them() {
    let turned = [1.0, -1.0];
    refused(|rig| rig.joints[0].range_rad = vec![turned], "joint[0].range_deg", "the least value");
    refused(|rig| rig.joints[2].range_m = Some(turned), "joint[2].range_m", "1 m, then -1 m");
    refused(|rig| rig.servos[0].range_rad = vec![turned], "servo[0].range_deg", "the least value");
    let range = [-1.0, 1.0];
    refused(|rig| rig.joints[0].range_rad = vec![range; 2], "joint[0].range_deg", "one pair");
    refused(|rig| rig.joints[3].range_rad = vec![range], "joint[3].range_deg", "two pairs");
    refused(|rig| rig.joints[4].range_rad = vec![range], "joint[4].range_deg", "[0, most]");
    refused(|rig| rig.joints[4].range_rad = vec![[0.0, 3.2]], "joint[4].range_deg", "180 deg");
    refused(|rig| rig.servos[0].range_rad = vec![range; 2], "servo[0].range_deg", "one pair");
    let home = |rig: &mut Description| {
        rig.joints[0].range_rad = vec![[0.0, 0.5]];
        rig.joints[0].home_rad = Some(90.0_f64.to_radians());
    };
    refused(home, "joint[0].home_deg", "found 90 deg");
    let home = |rig: &mut Description| {
        rig.joints[2].range_m = Some([0.0, 0.5]);
        rig.joints[2].home_m = Some(-0.1);
    };
    refused(home, "joint[2].home_m", "0 m to 0.5 m, found -0.1 m");
}

#[test]
fn linked_limits_join_two_joints_of_one_dof() {
    refused(|rig| rig.limits[0].other = "hinge".to_owned(), "limit[0].other", "twice");
    refused(|rig| rig.limits[0].other = "ball".to_owned(), "limit[0].other", "which is neither");
    refused(|rig| rig.limits[0].factor = 0.0, "limit[0].factor", "other than 0");
    refused(|rig| rig.limits[0].other_factor = -0.0, "limit[0].other_factor", "other than 0");
    refused(|rig| rig.limits[0].least_m = Some(0.0), "limit[0].least_m", "expected least_deg");
    refused(|rig| rig.limits[0].most_rad = Some(-2.0), "limit[0].most_deg", "at least");
    refused(|rig| rig.joints[0].home_rad = Some(1.5), "limit[0].most_deg", "a home pose");
    refused(|rig| rig.joints[0].home_rad = Some(-1.5), "limit[0].least_deg", "a home pose");
    let no_ends = |rig: &mut Description| {
        rig.limits[0].least_rad = None;
        rig.limits[0].most_rad = None;
    };
    refused(no_ends, "limit[0]", "least_deg or most_deg");
}

#[test]
fn drives_fit_their_joints_and_servos() {
    refused(
        |rig| rig.drives[1].joints[0] = "hinge".to_owned(),
        "drive[1].joints[0]",
        "drive[0] already",
    );
    refused(
        |rig| rig.drives[1].servos[0] = "s0".to_owned(),
        "drive[1].servos[0]",
        "drive[0] already",
    );
    let twice = |rig: &mut Description| rig.drives[0].joints.push("hinge".to_owned());
    refused(twice, "drive[0].joints[1]", "drive[0] already");
    refused(|rig| rig.drives[0].joints.clear(), "drive[0].joints", "at least one");
    refused(|rig| rig.drives[0].servos.clear(), "drive[0].servos", "at least one");
    refused(|rig| set_rows(rig, vec![vec![1.0, 2.0]]), "drive[0].matrix.rows[0]", "1 servos");
    refused(
        |rig| set_rows(rig, vec![vec![1.0]; 2]),
        "drive[0].matrix.rows",
        "1 degrees of freedom",
    );
    refused(
        |rig| rig.drives[0].joints[0] = "cardan".to_owned(),
        "drive[0].matrix.rows",
        "2 degrees",
    );
    let fixed = |rig: &mut Description| {
        rig.limits.clear();
        rig.joints[0] = joint("hinge", JointType::Fixed, "b0", "b1");
    };
    refused(fixed, "drive[0].joints[0]", "a joint that a drive can move");
    let with_offset = |offset: &[f64]| {
        let offset = offset.to_vec();
        move |rig: &mut Description| {
            rig.drives[0].kind = DriveKind::Matrix { rows: vec![vec![1.0]], offset };
        }
    };
    refused(with_offset(&[1.0, 2.0]), "drive[0].matrix.offset_deg", "each of the 1 rows");
    refused(with_offset(&[f64::NAN]), "drive[0].matrix.offset_deg[0]", "finite");
    let mixed = |rig: &mut Description| {
        rig.drives[0].joints.push("slide".to_owned());
        rig.drives[0].kind = DriveKind::Matrix { rows: vec![vec![1.0]; 2], offset: vec![0.0, 0.0] };
    };
    refused(mixed, "drive[0].matrix.offset_deg", "some slide");
    let curve = |points: &[[f64; 2]]| {
        let points = points.to_vec();
        move |rig: &mut Description| rig.drives[0].kind = DriveKind::Curve { points }
    };
    refused(curve(&[[0.0, 0.0]]), "drive[0].curve.points_deg", "at least two");
    refused(curve(&[[0.0, f64::NAN]]), "drive[0].curve.points_deg[0][1]", "finite");
    let two_servos = |rig: &mut Description| {
        rig.drives.pop();
        rig.drives[0].servos.push("s1".to_owned());
        curve(&[[0.0; 2]; 2])(rig);
    };
    refused(two_servos, "drive[0].servos", "one servo");
    let bars = |crank_m: f64, crank_zero_rad: f64| {
        move |rig: &mut Description| {
            rig.drives[0].kind = DriveKind::FourBar {
                ground_m: 0.1,
                crank_m,
                coupler_m: 0.1,
                rocker_m: 0.1,
                crank_zero_rad,
                rocker_zero_rad: 0.0,
                crossed: false,
            };
        }
    };
    refused(bars(0.0, 0.0), "drive[0].four_bar.crank_m", "above 0");
    refused(bars(0.1, f64::NAN), "drive[0].four_bar.crank_zero_deg", "finite");
    let slide = |rig: &mut Description| {
        bars(0.1, 0.0)(rig);
        rig.drives[0].joints[0] = "slide".to_owned();
    };
    refused(slide, "drive[0].joints", "a revolute joint");
}

#[test]
fn servos_have_places_and_senses() {
    refused(|rig| rig.servos[1].address = Address::Id(0), "servo[1].id", "as servo \"s0\" has");
    refused(|rig| rig.servos[0].address = Address::Id(253), "servo[0].id", "0 to 252");
    refused(|rig| rig.servos[0].address = Address::Channel(16), "servo[0].channel", "0 to 15");
    for direction in [0, 2, -2] {
        refused(|rig| rig.servos[0].direction = direction, "servo[0].direction", "1 or -1");
    }
    let mut two_buses = rig();
    two_buses.servos[1].address = Address::Id(0);
    two_buses.servos[1].bus = "other".to_owned();
    assert_eq!(two_buses.check(), Ok(()), "the same id on another bus");
}

#[test]
fn a_driven_base_is_free_and_what_has_no_mass_is_legal() {
    let mut rig = rig();
    rig.mount.base = Base::Driven;
    rig.bodies
        .iter_mut()
        .for_each(|body| *body = Body { name: body.name.clone(), ..Body::default() });
    let mechanism = rig.mechanism().unwrap();
    assert_eq!(mechanism.home()[..7], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    assert!(mechanism.tree::<8>().is_ok());
}
