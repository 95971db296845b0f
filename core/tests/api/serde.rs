//! Values survive writing and reading bit by bit, and reading validates its input.

use serde::Serialize;
use serde::de::DeserializeOwned;
use sinew_core::control::{ControlLaw, Gains, LimitReason, Limited, TorqueLimit};
use sinew_core::dynamics::{OuterJoints, ReflectedInertia};
use sinew_core::finite_difference::Scheme;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::importance::Importance;
use sinew_core::projection::{BodyWeight, BodyWeights, JointRange};
use sinew_core::state_error::{
    Aim, AimStatus, Aims, Compensation, Method, RateTerm, References, StateError,
};
use sinew_core::{
    Body, BodySet, BodyState, Inertia, JointKind, JointState, JointStates, JointTargets,
    RotationalInertia, TorqueController, Transform, Tree, Twist, Workspace, Wrench, math,
};

/// Writes and reads a value as text and in a compact format for microcontrollers.
#[track_caller]
fn round_trip<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(value: &T) {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(&serde_json::from_str::<T>(&text).unwrap(), value, "{text}");
    let mut buffer = [0; 4096];
    let bytes = postcard::to_slice(value, &mut buffer).unwrap();
    assert_eq!(&postcard::from_bytes::<T>(bytes).unwrap(), value);
}

/// Returns the error message for a refused text.
#[track_caller]
fn refused<T: DeserializeOwned + std::fmt::Debug>(text: &str) -> String {
    serde_json::from_str::<T>(text).unwrap_err().to_string()
}

/// Returns numbers that use all digits.
fn vector(seed: f32) -> Vec3 {
    Vec3::new(0.1 + seed, -0.3 * seed, 1e-7 / (1.0 + seed))
}

fn transform(seed: f32) -> Transform {
    Transform::new(math::exp(vector(seed)), vector(0.7 * seed))
}

fn motion(seed: f32) -> Twist {
    Twist::new(vector(seed), vector(seed + 0.1))
}

fn inertia() -> Inertia {
    Inertia {
        mass_kg: 1.1,
        center_of_mass_m: vector(0.2),
        rotational_kg_m2: RotationalInertia {
            xy: 0.001,
            ..RotationalInertia::diagonal(0.1, 0.2, 0.15)
        },
    }
}

fn joint_kinds() -> [JointKind; 6] {
    [
        JointKind::Free,
        JointKind::Fixed,
        JointKind::Revolute { axis: Vec3::Z },
        JointKind::Prismatic { axis: -Vec3::X },
        JointKind::Universal { first: Vec3::X, second: Vec3::Y },
        JointKind::Spherical,
    ]
}

/// Returns a tree: a root with two children; bodies 2 to 5 are a chain.
fn tree() -> Tree<8> {
    let mut tree = Tree::new();
    for (index, joint) in joint_kinds().into_iter().enumerate() {
        let parent = [None, Some(0), Some(0), Some(2), Some(3), Some(4)][index];
        let placement = Transform::from_translation(vector(0.5));
        let has_drive = !matches!(joint, JointKind::Fixed | JointKind::Free);
        let rotor_inertia = if has_drive { 1.3e-3 } else { 0.0 };
        tree.push(Body { parent, joint, placement, inertia: inertia(), rotor_inertia }).unwrap();
    }
    tree
}

#[test]
fn plain_types_come_back() {
    round_trip(&transform(0.3));
    round_trip(&motion(0.3));
    round_trip(&Wrench::new(vector(1.0), vector(2.0)));
    round_trip(&JointState { pose: transform(0.3), velocity: motion(0.4) });
    round_trip(&BodyState { pose: transform(0.3), velocity: motion(0.4) });
    round_trip(&inertia());
    round_trip(&joint_kinds());
    round_trip(&tree().bodies()[3]);
    round_trip(&StateError {
        angular_rad: vector(0.1),
        linear_m: vector(0.2),
        angular_rate_rad_s: vector(0.3),
        linear_rate_m_s: vector(0.4),
    });
    round_trip(&BodyWeight::new(1.0, 0.3));
    round_trip(&[
        JointRange::Any,
        JointRange::Axis([-0.1, 1.2]),
        JointRange::Axes([[-0.1, 1.2], [0.0, 0.3]]),
        JointRange::Turn(0.7),
    ]);
    round_trip(&[RateTerm::Corrected, RateTerm::AsPrinted, RateTerm::None]);
    round_trip(&[AimStatus::Leaf, AimStatus::Compensated, AimStatus::ZeroAim]);
    round_trip(&[ControlLaw::ProportionalDerivative, ControlLaw::InverseDynamics]);
    round_trip(&[Scheme::Forward, Scheme::Backward, Scheme::Central]);
    round_trip(&[OuterJoints::Locked, OuterJoints::Free]);
    round_trip(&ReflectedInertia {
        angular_kg_m2: RotationalInertia::diagonal(0.1, 0.2, 0.3),
        linear_kg: 1.3,
    });
    round_trip(&Limited { value: 1.5f32, reason: Some(LimitReason::Torque) });
    round_trip(&Limited { value: Wrench::ZERO, reason: None });
    round_trip(&Gains::critically_damped(200.0).unwrap().with_linear(3.0, 0.1).unwrap());
    round_trip(&TorqueLimit::new(3.0, 0.1).unwrap());
    round_trip(&TorqueLimit::NONE);
    round_trip(&Importance::<8>::new(&[0.5, 0.0, 1e-3]).unwrap());
    let set: BodySet = [0, 3, 64, 127].into_iter().collect();
    round_trip(&set);
    round_trip(&(0..BodySet::CAPACITY).collect::<BodySet>());
    round_trip(&[Aim::None, Aim::Child(3), Aim::Children(set), Aim::Point(vector(0.1))]);
}

#[test]
fn what_belongs_to_a_tree_comes_back() {
    let tree = tree();
    round_trip(&tree);
    round_trip(&Tree::<0>::new());
    let mut states = JointStates::rest(&tree);
    states
        .set(
            0,
            JointState { pose: Transform::from_translation(vector(0.3)), velocity: motion(0.4) },
        )
        .unwrap();
    round_trip(&states);
    let mut targets = JointTargets::rest(&tree);
    targets.set(2, states.as_slice()[0], motion(0.9)).unwrap();
    round_trip(&targets);
    round_trip(&Aims::heaviest_child(&tree));
    round_trip(&Aims::all_children(&tree));
    round_trip(&References::egocentric(&tree));
    round_trip(&References::generations(&tree, 2));
    round_trip(&BodyWeights::rotations(&tree));
}

#[test]
fn controllers_come_back() {
    let tree = tree();
    let methods = [
        Method::Local,
        Method::World,
        Method::Accumulated(References::egocentric(&tree)),
        Method::LinearCompensation {
            aims: Aims::all_children(&tree),
            settings: Compensation { beta: 0.7, rate_term: RateTerm::AsPrinted },
        },
        Method::ResolvedAcceleration { weights: BodyWeights::rotations(&tree) },
    ];
    let gains = Gains::critically_damped(200.0).unwrap();
    for method in methods {
        round_trip(&method);
        let controller = TorqueController::new(tree.clone(), gains, method).unwrap();
        round_trip(&controller.with_gravity(Vec3::new(0.0, -1.62, 0.0)).unwrap());
    }
    let limits: Vec<_> = (0..6u8).map(|i| TorqueLimit::new(f32::from(i), 0.0).unwrap()).collect();
    let own: Vec<_> = (0..6u8).map(|i| Gains::new(f32::from(i), 0.1).unwrap()).collect();
    let controller = TorqueController::new(tree, gains, Method::World)
        .unwrap()
        .with_limits(&limits)
        .unwrap()
        .with_joint_gains(&own)
        .unwrap()
        .with_inertia_scaled_pd(&[ReflectedInertia::default(); 6])
        .unwrap();
    round_trip(&controller);
    round_trip(&controller.with_law(ControlLaw::InverseDynamics).unwrap());
}

/// Reading normalises rotations once more.
#[test]
fn rotations_change_by_rounding_only() {
    let body = Body {
        parent: None,
        joint: JointKind::Free,
        placement: Transform::IDENTITY,
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    };
    let tree = Tree::<1>::from_bodies(&[body]).unwrap();
    let mut states = JointStates::rest(&tree);
    for step in 0..1000u16 {
        let pose = transform(f32::from(step) * 0.003);
        states.set(0, JointState { pose, velocity: Twist::ZERO }).unwrap();
        let text = serde_json::to_string(&states).unwrap();
        let read: JointStates<1> = serde_json::from_str(&text).unwrap();
        let [before, after] = [&states, &read].map(|states| states.as_slice()[0].pose.rotation);
        // The squared length is rounded four times, by half of EPSILON each. Half of its error goes into each
        // component, which is rounded once itself.
        assert!((before - after).to_array().iter().all(|off| off.abs() <= 1.5 * f32::EPSILON));
    }
}

#[test]
fn a_body_that_names_no_rotor_has_none() {
    let body = tree().bodies()[4];
    let text = serde_json::to_string(&body).unwrap();
    let before = text.replace(r#","rotor_inertia":0.0013"#, "");
    assert_ne!(before, text);
    let read: Body = serde_json::from_str(&before).unwrap();
    assert_eq!(read, Body { rotor_inertia: 0.0, ..body });
}

#[test]
fn numbers_are_written_as_people_write_them() {
    let text = serde_json::to_string(&Transform::new(Quat::IDENTITY, Vec3::X)).unwrap();
    assert_eq!(text, r#"{"rotation":[0.0,0.0,0.0,1.0],"translation_m":[1.0,0.0,0.0]}"#);
    let text = serde_json::to_string(&JointKind::Revolute { axis: Vec3::Z }).unwrap();
    assert_eq!(text, r#"{"revolute":{"axis":[0.0,0.0,1.0]}}"#);
    assert_eq!(serde_json::to_string(&JointKind::Free).unwrap(), r#""free""#);
    let text = serde_json::to_string(&TorqueLimit::new(3.0, f32::INFINITY).unwrap()).unwrap();
    assert_eq!(text, r#"{"moment_nm":3.0,"force_n":null}"#);
    let set: BodySet = [5, 0].into_iter().collect();
    assert_eq!(serde_json::to_string(&set).unwrap(), "[0,5]");
}

/// Checks that a value is refused, through a format that can hold every bit pattern.
#[track_caller]
fn bad<T: Serialize + DeserializeOwned>(value: &T) {
    let mut buffer = [0; 256];
    let bytes = postcard::to_slice(value, &mut buffer).unwrap();
    assert!(postcard::from_bytes::<T>(bytes).is_err(), "{}", std::any::type_name::<T>());
}

/// Returns `true` if a number was refused as too large: either because it is not finite, or by the JSON reader
/// itself. The reader refuses it if a crate of the workspace enables exact reading of numbers.
fn too_large(message: &str) -> bool {
    message.contains("not finite") || message.contains("number out of range")
}

/// Text has no NaN, but has numbers that are too large for f32. The compact format has both.
#[test]
fn what_is_not_finite_is_refused() {
    let message = refused::<Twist>(r#"{"angular":[0,1e39,0],"linear":[0,0,0]}"#);
    assert!(too_large(&message) && message.contains("line 1"), "{message}");
    let message = refused::<Gains>(r#"{"kp":1e39,"kd":0,"linear_kp":0,"linear_kd":0}"#);
    assert!(too_large(&message) || message.contains("kp"), "{message}");

    for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let v = Vec3::new(0.0, x, 0.0);
        let pose = Transform::from_translation(v);
        let velocity = Twist::new(Vec3::ZERO, v);
        bad(&pose);
        bad(&Transform::new(Quat::from_xyzw(0.0, x, 0.0, 1.0), Vec3::ZERO));
        bad(&velocity);
        bad(&Twist::new(v, Vec3::ZERO));
        bad(&Wrench::new(v, Vec3::ZERO));
        bad(&Wrench::new(Vec3::ZERO, v));
        bad(&JointState { pose, velocity: Twist::ZERO });
        bad(&BodyState { pose: Transform::IDENTITY, velocity });
        bad(&Inertia { mass_kg: x, ..inertia() });
        bad(&Inertia { center_of_mass_m: v, ..inertia() });
        for at in 0..6 {
            let mut i = RotationalInertia::default();
            *[&mut i.xx, &mut i.xy, &mut i.xz, &mut i.yy, &mut i.yz, &mut i.zz][at] = x;
            bad(&i);
        }
        bad(&JointKind::Revolute { axis: v });
        bad(&JointKind::Prismatic { axis: v });
        bad(&JointKind::Universal { first: v, second: Vec3::X });
        bad(&JointKind::Universal { first: Vec3::X, second: v });
        bad(&StateError { angular_rad: v, ..StateError::ZERO });
        bad(&StateError { linear_m: v, ..StateError::ZERO });
        bad(&StateError { angular_rate_rad_s: v, ..StateError::ZERO });
        bad(&StateError { linear_rate_m_s: v, ..StateError::ZERO });
        bad(&BodyWeight::new(x, 1.0));
        bad(&BodyWeight::new(1.0, x));
        bad(&Compensation { beta: x, ..Compensation::default() });
        bad(&ReflectedInertia { linear_kg: x, ..ReflectedInertia::default() });
        bad(&Limited { value: Wrench::new(v, Vec3::ZERO), reason: None });
        bad(&JointRange::Axis([0.0, x]));
        bad(&JointRange::Axes([[0.0, 1.0], [x, 1.0]]));
        bad(&JointRange::Turn(x));
        bad(&Aim::Point(v));
        let body = Body { placement: pose, ..tree().bodies()[0] };
        bad(&body);
        bad(&Body { rotor_inertia: x, placement: Transform::IDENTITY, ..body });
    }
}

#[test]
fn what_breaks_a_rule_is_refused_by_its_name() {
    let message = refused::<Transform>(r#"{"rotation":[0,0,0,2],"translation_m":[0,0,0]}"#);
    assert!(message.contains("squared length 4") && message.contains("[x, y, z, w]"), "{message}");
    // The square overflows.
    refused::<Transform>(r#"{"rotation":[0,0,0,3e38],"translation_m":[0,0,0]}"#);
    let message = refused::<JointKind>(r#"{"revolute":{"axis":[0,3,4]}}"#);
    assert!(message.contains("length 5") && message.contains("unit vector"), "{message}");

    let message = refused::<Gains>(r#"{"kp":-1,"kd":0,"linear_kp":0,"linear_kd":0}"#);
    assert!(message.contains("kp is negative"), "{message}");
    let message = refused::<TorqueLimit>(r#"{"moment_nm":-1,"force_n":null}"#);
    assert!(message.contains("zero or more"), "{message}");
    let message = refused::<TorqueLimit>(r#"{"moment_nm":1}"#);
    assert!(message.contains("missing field `force_n`"), "no bound must be asked for: {message}");
    let message = refused::<Gains>(r#"{"kp":1,"kv":0,"linear_kp":0,"linear_kd":0}"#);
    assert!(message.contains("unknown field `kv`"), "{message}");

    let most = BodySet::CAPACITY;
    let beyond = refused::<BodySet>(&format!("[1, {most}]"));
    assert!(beyond.contains(&format!("body {most} must be below {most}")), "{beyond}");
    assert!(refused::<BodySet>("[1, 1]").contains("body 1 is in the set twice"));
    assert!(refused::<BodySet>("[-1]").contains("-1"));
}

#[test]
fn a_tree_is_checked_as_every_tree_is() {
    let mut bodies: serde_json::Value = serde_json::to_value(tree()).unwrap();
    let with = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut bodies = bodies.clone();
        change(&mut bodies);
        refused::<Tree<8>>(&bodies.to_string())
    };
    let message = with(&|bodies| bodies[1]["parent"] = 1.into());
    assert!(message.contains("body 1 names body 1 as its parent"), "{message}");
    let message = with(&|bodies| bodies[1]["parent"] = serde_json::Value::Null);
    assert!(message.contains("body 1 has no parent"), "{message}");
    let message = with(&|bodies| bodies[2]["inertia"]["mass_kg"] = (-1).into());
    assert!(message.contains("body 2: the mass is negative"), "{message}");
    let message = with(&|bodies| {
        bodies[4]["joint"]["universal"]["second"] = serde_json::json!([1, 0, 0]);
    });
    assert!(message.contains("joint 4: the axes of a universal joint"), "{message}");
    let more = bodies.as_array().unwrap()[5].clone();
    bodies.as_array_mut().unwrap().extend([more.clone(), more.clone(), more]);
    let message = refused::<Tree<8>>(&bodies.to_string());
    assert!(message.contains("invalid length 9") && message.contains("at most 8"), "{message}");
}

#[test]
fn importance_that_is_none_is_refused() {
    let message = refused::<Importance<8>>("[1,-0.5]");
    assert!(message.contains("joint 1: the weight is -0.5"), "{message}");
    assert!(refused::<Importance<8>>("[0,0]").contains("sum is 0"));
    assert!(refused::<Importance<2>>("[1,1,1]").contains("invalid length 3"));
}

#[test]
fn what_fits_no_tree_is_refused_and_what_fits_another_by_the_controller() {
    // Body 2 is the child of a single body, and children follow their parents.
    let aims = |text: &str| refused::<Aims<8>>(text);
    assert!(aims(r#"["none",{"child":0}]"#).contains("body 1 cannot aim at body 0"));
    assert!(aims(r#"[{"child":2},{"child":2},"none"]"#).contains("body 1 cannot aim at body 2"));
    assert!(aims(r#"[{"children":[1,9]},"none"]"#).contains("body 0 cannot aim at body 9"));
    assert!(refused::<References<8>>("[null,0,2]").contains("body 2 cannot be the reference"));
    assert!(
        refused::<BodyWeights<8>>(r#"[{"position":1,"rotation_m":0}]"#).contains("0.01 to 100 m")
    );

    let tree = tree();
    let gains = Gains::critically_damped(200.0).unwrap();
    let mut controller =
        serde_json::to_value(TorqueController::new(tree, gains, Method::World).unwrap()).unwrap();
    // References for a chain, but the tree is not a chain.
    controller["method"] = serde_json::json!({"accumulated": [null, 0, 1, 2, 3, 4]});
    let message = refused::<TorqueController<8>>(&controller.to_string());
    assert!(message.contains("do not match") && message.contains("joint 2"), "{message}");
    controller["method"] = "world".into();
    controller["gains"].as_array_mut().unwrap().pop();
    let message = refused::<TorqueController<8>>(&controller.to_string());
    assert!(message.contains("6 joints need as many gains, 5 were given"), "{message}");
}

#[test]
fn states_and_targets_are_checked_joint_by_joint() {
    let tree = tree();
    let mut states = serde_json::to_value(JointStates::rest(&tree)).unwrap();
    states[3]["pose"]["rotation"] = serde_json::json!([0, 0, 0, 0]);
    let message = refused::<JointStates<8>>(&states.to_string());
    assert!(message.contains("unit quaternion"), "{message}");
    let mut targets = serde_json::to_value(JointTargets::rest(&tree)).unwrap();
    targets[3]["acceleration"]["linear"] = serde_json::json!([0, 0, -1e39]);
    let message = refused::<JointTargets<8>>(&targets.to_string());
    assert!(too_large(&message), "{message}");
}

/// Damaged bytes are refused, or give a controller that computes finite torques.
#[test]
fn damaged_bytes_are_refused_or_make_a_usable_controller() {
    let tree = tree();
    let method = Method::LinearCompensation {
        aims: Aims::all_children(&tree),
        settings: Compensation::default(),
    };
    let gains = Gains::critically_damped(200.0).unwrap();
    let limits = [TorqueLimit::new(30.0, 100.0).unwrap(); 6];
    let controller =
        TorqueController::new(tree, gains, method).unwrap().with_limits(&limits).unwrap();
    let mut buffer = [0; 4096];
    let bytes = postcard::to_slice(&controller, &mut buffer).unwrap();
    let mut workspace = Workspace::new();
    let (mut refused, mut usable) = (0, 0);
    for bit in 0..bytes.len() * 8 {
        bytes[bit / 8] ^= 1 << (bit % 8);
        if let Ok(read) = postcard::from_bytes::<TorqueController<8>>(bytes) {
            let (mut targets, measured) =
                (JointTargets::rest(read.tree()), JointStates::rest(read.tree()));
            let torques = read.tick(&mut targets, &measured, &[], &mut workspace);
            assert_eq!(torques.len(), 6);
            assert!(torques.iter().all(|torque| torque.value.is_finite()), "bit {bit}");
            usable += 1;
        } else {
            refused += 1;
        }
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    for length in 0..bytes.len() {
        assert!(postcard::from_bytes::<TorqueController<8>>(&bytes[..length]).is_err(), "{length}");
    }
    assert!(refused > 500 && usable > 500, "{refused} refused, {usable} usable");
}
