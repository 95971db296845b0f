//! A motion as a CSV of joint coordinates.

use std::fmt::Write as _;

use glam::DQuat;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::Freedom;

use crate::feasibility::RigMotion;

/// Half a turn back about x, from Sinew's world (y up) to one with z up: x stays, y is its -z, z its y.
fn to_z_up() -> DQuat {
    DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2)
}

/// The motion as CSV: `time` in s, `start_s` in the first row; then a column for each coordinate by the joint's name,
/// rad and m.
///
/// A hinge or a slide has one column; other joints `NAME.0`, `NAME.1` (universal) or `NAME.x` to `NAME.w` (ball). A
/// driven base has `root_x root_y root_z root_qw root_qx root_qy root_qz`: the pose of its body in a world with z up,
/// as robot programs have it.
pub fn csv(mechanism: &Mechanism, motion: &RigMotion, start_s: f64) -> String {
    let mut text = String::from("time");
    for link in &mechanism.bodies {
        let name = &link.joint_name;
        let columns: Vec<String> = match link.joint {
            Freedom::Fixed => vec![],
            Freedom::Revolute(_) | Freedom::Prismatic(_) => vec![name.clone()],
            Freedom::Universal(_) => ["0", "1"].map(|axis| format!("{name}.{axis}")).to_vec(),
            Freedom::Spherical => {
                ["x", "y", "z", "w"].map(|part| format!("{name}.{part}")).to_vec()
            }
            Freedom::Free => {
                ["x", "y", "z", "qw", "qx", "qy", "qz"].map(|part| format!("root_{part}")).to_vec()
            }
        };
        for column in columns {
            text.push(',');
            text.push_str(&quoted(&column));
        }
    }
    text.push('\n');
    let ranges = mechanism.coordinate_ranges();
    for (row, q) in motion.rows.iter().enumerate() {
        number(&mut text, start_s + row as f64 * motion.dt_s);
        let poses = mechanism.poses(q);
        for ((link, range), pose) in mechanism.bodies.iter().zip(&ranges).zip(&poses) {
            if link.joint == Freedom::Free {
                let rotation = to_z_up() * pose.rotation;
                let position = to_z_up() * pose.position_m;
                let [x, y, z, w] = rotation.to_array();
                for value in position.to_array().into_iter().chain([w, x, y, z]) {
                    text.push(',');
                    number(&mut text, value);
                }
                continue;
            }
            for value in q.get(range.clone()).unwrap_or_default() {
                text.push(',');
                number(&mut text, *value);
            }
        }
        text.push('\n');
    }
    text
}

/// Nine digits; no negative zero.
fn number(text: &mut String, value: f64) {
    write!(text, "{:.9}", value + 0.0).expect("a string takes everything");
}

/// A name as a field of CSV.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
