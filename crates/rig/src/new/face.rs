//! An animatronic face.

use super::turn::Turn;
use super::{face_shapes, shapes};
use crate::description::{
    Address, Body, Description, Drive, DriveKind, LinkedLimit, Servo, SignalLoss, Supply,
};

/// Axes of a face that looks along +z, with y up and its left side at +x. A positive angle turns the look up or to
/// the left, or tilts the face to its left shoulder.
const UP: [f64; 3] = [-1.0, 0.0, 0.0];
const LEFT: [f64; 3] = [0.0, 1.0, 0.0];
const TILT: [f64; 3] = [0.0, 0.0, -1.0];

/// Maximum speed and acceleration of each kind of joint, deg/s and deg/s².
const NECK: [f64; 2] = [120.0, 500.0];
/// Speed and acceleration of the jaw: to follow speech, it opens by 15 deg in 0.1 s.
const JAW: [f64; 2] = [400.0, 9000.0];
const EYE: [f64; 2] = [400.0, 6000.0];
/// A blink closes a lid by 45 deg in 0.1 s.
const LID: [f64; 2] = [500.0, 12000.0];
const BROW: [f64; 2] = [200.0, 2000.0];

/// Creates a face on hobby servos: a neck of three joints, a jaw, two eyes of two joints, four lids and two brows, all
/// on one PWM driver. The face has the shapes of 15 visemes and of `ARKit`.
///
/// The face is kinematic: its bodies have no mass, therefore range, speed and acceleration are limited, and no
/// torques are computed.
pub fn face() -> Description {
    let mut rig = Description {
        name: "face".to_owned(),
        supply: Some(Supply { voltage_v: 5.0, current_a: 10.0 }),
        bodies: vec![Body {
            name: "stand".to_owned(),
            shapes: face_shapes::of("stand"),
            ..Body::default()
        }],
        ..Description::default()
    };
    add(&mut rig, "neck_turn", "stand", [0.0, 0.2, 0.0], LEFT, [-60.0, 60.0, 0.0], NECK);
    add(&mut rig, "neck_nod", "neck_turn", [0.0, 0.03, 0.0], UP, [-30.0, 30.0, 0.0], NECK);
    add(&mut rig, "head", "neck_nod", [0.0, 0.03, 0.0], TILT, [-25.0, 25.0, 0.0], NECK);
    add(&mut rig, "jaw", "head", [0.0, 0.04, 0.02], UP, [-25.0, 0.0, 0.0], JAW);
    for (side, x) in [("left", 0.032), ("right", -0.032)] {
        let part = |name: &str| format!("{name}_{side}");
        let eye = [x, 0.1, 0.06];
        let (turn, upper, lower) = (part("eye_turn"), part("lid_upper"), part("lid_lower"));
        add(&mut rig, &turn, "head", eye, LEFT, [-35.0, 35.0, 0.0], EYE);
        add(&mut rig, &part("eye_nod"), &turn, [0.0; 3], UP, [-25.0, 25.0, 0.0], EYE);
        // Angles of the lids' edges above the middle of the eye.
        add(&mut rig, &upper, "head", eye, UP, [-10.0, 40.0, 30.0], LID);
        add(&mut rig, &lower, "head", eye, UP, [-35.0, 10.0, -25.0], LID);
        add(&mut rig, &part("brow"), "head", [x, 0.13, 0.07], TILT, [-20.0, 20.0, 0.0], BROW);
        // The upper edge must stay above the lower one.
        rig.limits.push(LinkedLimit {
            joint: upper,
            other: lower,
            least_rad: Some(0.0),
            ..LinkedLimit::default()
        });
    }
    rig.face_shapes = shapes::shapes();
    rig
}

/// Adds a body, the joint of its name, and the servo on the next channel.
fn add(
    rig: &mut Description,
    name: &str,
    parent: &str,
    position_m: [f64; 3],
    axis: [f64; 3],
    [least_deg, most_deg, home_deg]: [f64; 3],
    [speed_deg_s, acceleration_deg_s2]: [f64; 2],
) {
    let range_deg = [least_deg, most_deg];
    let joint = Turn {
        name,
        parent,
        position_m,
        axis,
        range_deg,
        home_deg,
        speed_deg_s,
        acceleration_deg_s2,
    };
    let part = name.trim_end_matches("_left").trim_end_matches("_right");
    let shapes = face_shapes::of(part);
    rig.bodies.push(Body { name: name.to_owned(), shapes, ..Body::default() });
    rig.joints.push(joint.joint());
    rig.drives.push(Drive {
        joints: vec![name.to_owned()],
        servos: vec![name.to_owned()],
        kind: DriveKind::one_to_one(1),
    });
    rig.servos.push(Servo {
        name: name.to_owned(),
        model: "MG90S".to_owned(),
        bus: "pwm".to_owned(),
        // There are 14 servos, therefore the number fits u8.
        address: Address::Channel(u8::try_from(rig.servos.len()).unwrap_or(u8::MAX)),
        on_signal_loss: SignalLoss::Hold,
        ..Servo::default()
    });
}
