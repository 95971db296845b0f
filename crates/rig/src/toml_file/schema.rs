//! Tables of the file and their keys, in the order in which they are written: one function for each table.

use super::pose::Pose;
use super::value::Ranges;
use super::visitor::{KEYS, Visitor};
use crate::description::{
    Address, Body, BodyShape, Description, Drive, DriveKind, FaceShape, InertiaMatrix, Joint,
    LinkedLimit, Mount, Servo, ServoModel, SourcedValue, Supply, UnitKeys, is_angle,
};

/// Form of a value with its source, for messages.
const SOURCED: &str = "{ value = .., source = \"who states it\" }";

pub(super) fn description<V: Visitor>(rig: &mut Description, v: &mut V) -> Result<(), V::Error> {
    v.required("name", &mut rig.name)?;
    let mut stands = (rig.mount != Mount::default()).then_some(rig.mount);
    v.section("mount", &mut stands, mount)?;
    rig.mount = stands.unwrap_or_default();
    v.section("supply", &mut rig.supply, supply)?;
    v.sections("body", &mut rig.bodies, body)?;
    v.sections("joint", &mut rig.joints, joint)?;
    v.sections("limit", &mut rig.limits, limit)?;
    let joints = &rig.joints;
    v.sections("drive", &mut rig.drives, |item, v| drive(item, joints, v))?;
    v.sections("servo", &mut rig.servos, servo)?;
    v.sections("servo_model", &mut rig.servo_models, servo_model)?;
    let joints = &rig.joints;
    v.sections("shape", &mut rig.face_shapes, |item, v| face_shape(item, joints, v))
}

/// Visits a shape of a face. Its numbers are in deg or mm, which depends on the joints.
fn face_shape<V: Visitor>(
    shape: &mut FaceShape,
    joints: &[Joint],
    v: &mut V,
) -> Result<(), V::Error> {
    v.required("name", &mut shape.name)?;
    let mut pose = Pose::of_si(&shape.pose, joints);
    v.required("pose", &mut pose)?;
    shape.pose = pose.into_si(joints);
    Ok(())
}

fn mount<V: Visitor>(mount: &mut Mount, v: &mut V) -> Result<(), V::Error> {
    let default = Mount::default();
    v.optional("base", &mut mount.base, default.base)?;
    v.optional("position_m", &mut mount.position_m, default.position_m)?;
    v.optional("rotation_xyzw", &mut mount.rotation_xyzw, default.rotation_xyzw)
}

fn supply<V: Visitor>(supply: &mut Supply, v: &mut V) -> Result<(), V::Error> {
    v.required("voltage_v", &mut supply.voltage_v)?;
    v.required("current_a", &mut supply.current_a)
}

fn body<V: Visitor>(body: &mut Body, v: &mut V) -> Result<(), V::Error> {
    v.required("name", &mut body.name)?;
    v.optional("mass_kg", &mut body.mass_kg, 0.0)?;
    v.optional("center_of_mass_m", &mut body.center_of_mass_m, [0.0; 3])?;
    v.optional("box_m", &mut body.box_m, None)?;
    v.optional_inline(
        "inertia_kg_m2",
        "{ xx = .., yy = .., zz = .. }",
        &mut body.inertia_kg_m2,
        inertia,
    )?;
    v.sections("shape", &mut body.shapes, shape)
}

fn shape<V: Visitor>(shape: &mut BodyShape, v: &mut V) -> Result<(), V::Error> {
    let default = BodyShape::default();
    v.required("type", &mut shape.kind)?;
    v.optional("size_m", &mut shape.size_m, None)?;
    v.optional("radius_m", &mut shape.radius_m, None)?;
    v.optional("length_m", &mut shape.length_m, None)?;
    v.optional("position_m", &mut shape.position_m, default.position_m)?;
    v.optional("rotation_xyzw", &mut shape.rotation_xyzw, default.rotation_xyzw)?;
    v.optional("color_rgb", &mut shape.color_rgb, None)
}

fn inertia<V: Visitor>(inertia: &mut InertiaMatrix, v: &mut V) -> Result<(), V::Error> {
    v.required("xx", &mut inertia.xx)?;
    v.required("yy", &mut inertia.yy)?;
    v.required("zz", &mut inertia.zz)?;
    v.optional("xy", &mut inertia.xy, 0.0)?;
    v.optional("xz", &mut inertia.xz, 0.0)?;
    v.optional("yz", &mut inertia.yz, 0.0)
}

fn joint<V: Visitor>(joint: &mut Joint, v: &mut V) -> Result<(), V::Error> {
    let default = Joint::default();
    v.required("name", &mut joint.name)?;
    v.optional("type", &mut joint.kind, default.kind)?;
    v.required("parent", &mut joint.parent)?;
    v.required("child", &mut joint.child)?;
    v.optional("position_m", &mut joint.position_m, default.position_m)?;
    v.optional("rotation_xyzw", &mut joint.rotation_xyzw, default.rotation_xyzw)?;
    v.optional("axis", &mut joint.axis, None)?;
    v.optional("second_axis", &mut joint.second_axis, None)?;
    ranges(&mut joint.range_rad, v)?;
    v.optional("range_m", &mut joint.range_m, None)?;
    v.optional("home_deg", &mut joint.home_rad, None)?;
    v.optional("home_m", &mut joint.home_m, None)?;
    v.optional("speed_deg_s", &mut joint.speed_rad_s, None)?;
    v.optional("speed_m_s", &mut joint.speed_m_s, None)?;
    v.optional("acceleration_deg_s2", &mut joint.acceleration_rad_s2, None)?;
    v.optional("acceleration_m_s2", &mut joint.acceleration_m_s2, None)?;
    v.optional("effort", &mut joint.effort, None)?;
    v.optional("rotor_inertia", &mut joint.rotor_inertia, None)?;
    v.optional("friction", &mut joint.friction, 0.0)?;
    v.optional("damping", &mut joint.damping, 0.0)
}

fn ranges<V: Visitor>(ranges: &mut Vec<[f64; 2]>, v: &mut V) -> Result<(), V::Error> {
    let mut pairs = Ranges(std::mem::take(ranges));
    v.optional("range_deg", &mut pairs, Ranges(Vec::new()))?;
    *ranges = pairs.0;
    Ok(())
}

fn limit<V: Visitor>(limit: &mut LinkedLimit, v: &mut V) -> Result<(), V::Error> {
    let default = LinkedLimit::default();
    v.required("joint", &mut limit.joint)?;
    v.required("other", &mut limit.other)?;
    v.optional("factor", &mut limit.factor, default.factor)?;
    v.optional("other_factor", &mut limit.other_factor, default.other_factor)?;
    v.optional("least_deg", &mut limit.least_rad, None)?;
    v.optional("most_deg", &mut limit.most_rad, None)?;
    v.optional("least_m", &mut limit.least_m, None)?;
    v.optional("most_m", &mut limit.most_m, None)
}

/// Visits a drive. The units of its numbers depend on its joints.
fn drive<V: Visitor>(drive: &mut Drive, joints: &[Joint], v: &mut V) -> Result<(), V::Error> {
    v.required("joints", &mut drive.joints)?;
    v.required("servos", &mut drive.servos)?;
    let moved = joints.iter().filter(|joint| drive.joints.contains(&joint.name));
    let keys = UnitKeys::of(moved);
    let one_to_one = DriveKind::one_to_one(drive.servos.len());
    let of_field = match &drive.kind {
        kind if *kind == one_to_one => None,
        DriveKind::Matrix { .. } => Some("matrix"),
        DriveKind::Curve { .. } => Some("curve"),
        DriveKind::FourBar { .. } => Some("four_bar"),
    };
    match v.which(&["matrix", "curve", "four_bar"], of_field)? {
        Some("matrix") => {
            let (mut rows, mut offset) = match &drive.kind {
                DriveKind::Matrix { rows, offset } => (rows.clone(), offset.clone()),
                _ => Default::default(),
            };
            v.inline(
                "matrix",
                "{ rows = [[..], ..] }",
                &mut (&mut rows, &mut offset),
                |(rows, offset), v| {
                    v.required("rows", *rows)?;
                    v.optional(keys.offset, *offset, Vec::new())
                },
            )?;
            drive.kind = DriveKind::Matrix { rows, offset };
        }
        Some("curve") => {
            let mut points = match &drive.kind {
                DriveKind::Curve { points } => points.clone(),
                _ => Vec::new(),
            };
            v.inline("curve", KEYS, &mut points, |points, v| curve_points(points, keys.points, v))?;
            drive.kind = DriveKind::Curve { points };
        }
        Some("four_bar") => {
            let mut bars = match &drive.kind {
                kind @ DriveKind::FourBar { .. } => kind.clone(),
                _ => DriveKind::FourBar {
                    ground_m: 0.0,
                    crank_m: 0.0,
                    coupler_m: 0.0,
                    rocker_m: 0.0,
                    crank_zero_rad: 0.0,
                    rocker_zero_rad: 0.0,
                    crossed: false,
                },
            };
            v.inline("four_bar", KEYS, &mut bars, four_bar)?;
            drive.kind = bars;
        }
        _ => drive.kind = one_to_one,
    }
    Ok(())
}

/// Visits pairs of the servo's angle and the joint's position.
fn curve_points<V: Visitor>(
    points: &mut Vec<[f64; 2]>,
    key: &'static str,
    v: &mut V,
) -> Result<(), V::Error> {
    if is_angle(key) {
        return v.required(key, points);
    }
    // For a joint that slides, only the servo's angle is in degrees.
    for [servo, _] in points.iter_mut() {
        *servo = servo.to_degrees();
    }
    v.required(key, points)?;
    for [servo, _] in points.iter_mut() {
        *servo = servo.to_radians();
    }
    Ok(())
}

fn four_bar<V: Visitor>(kind: &mut DriveKind, v: &mut V) -> Result<(), V::Error> {
    let DriveKind::FourBar {
        ground_m,
        crank_m,
        coupler_m,
        rocker_m,
        crank_zero_rad,
        rocker_zero_rad,
        crossed,
    } = kind
    else {
        return Ok(());
    };
    v.required("ground_m", ground_m)?;
    v.required("crank_m", crank_m)?;
    v.required("coupler_m", coupler_m)?;
    v.required("rocker_m", rocker_m)?;
    v.required("crank_zero_deg", crank_zero_rad)?;
    v.required("rocker_zero_deg", rocker_zero_rad)?;
    v.optional("crossed", crossed, false)
}

fn servo<V: Visitor>(servo: &mut Servo, v: &mut V) -> Result<(), V::Error> {
    let default = Servo::default();
    v.required("name", &mut servo.name)?;
    v.required("model", &mut servo.model)?;
    v.optional("bus", &mut servo.bus, default.bus)?;
    let (of_field, mut number) = match servo.address {
        Address::Id(id) => ("id", id),
        Address::Channel(channel) => ("channel", channel),
    };
    // An error for a servo without either key names the missing id.
    let key = v.which(&["id", "channel"], Some(of_field))?.unwrap_or("id");
    v.required(key, &mut number)?;
    servo.address = if key == "id" { Address::Id(number) } else { Address::Channel(number) };
    v.optional("direction", &mut servo.direction, default.direction)?;
    v.optional("offset_deg", &mut servo.offset_rad, None)?;
    v.optional("homing_offset_deg", &mut servo.homing_offset_rad, None)?;
    v.optional("gear", &mut servo.gear, default.gear)?;
    v.optional("pulse_us", &mut servo.pulse_us, None)?;
    v.optional("travel_deg", &mut servo.travel_rad, None)?;
    ranges(&mut servo.range_rad, v)?;
    v.optional("torque_nm", &mut servo.torque_nm, None)?;
    v.optional("speed_deg_s", &mut servo.speed_rad_s, None)?;
    v.optional("acceleration_deg_s2", &mut servo.acceleration_rad_s2, None)?;
    v.optional("p_gain", &mut servo.p_gain, None)?;
    v.optional("on_signal_loss", &mut servo.on_signal_loss, default.on_signal_loss)
}

fn servo_model<V: Visitor>(model: &mut ServoModel, v: &mut V) -> Result<(), V::Error> {
    v.required("name", &mut model.name)?;
    for (key, value) in model.values_mut() {
        v.inline(key, SOURCED, value, sourced)?;
    }
    for (key, value) in model.optional_values_mut() {
        v.optional_inline(key, SOURCED, value, sourced)?;
    }
    Ok(())
}

fn sourced<V: Visitor>(sourced: &mut SourcedValue, v: &mut V) -> Result<(), V::Error> {
    v.required("value", &mut sourced.value)?;
    v.required("source", &mut sourced.source)
}
