//! Writes a motion as a CSV table of joint coordinates, which [`super::keys`] reads.

use std::fmt::Write as _;

use glam::DQuat;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::columns::{HeaderUnits, columns};
use crate::feasibility::RigMotion;

/// Returns the rotation from Sinew's world (y up) to a world with z up: 90 deg about x. x is unchanged, y becomes
/// z, z becomes -y.
fn to_z_up() -> DQuat {
    DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2)
}

/// Returns the motion as CSV: `time` in s, which is `start_s` in the first row, then a column for each coordinate
/// with the joint's name and unit, deg or mm.
///
/// A hinge has the column `NAME_deg`, a slide `NAME_mm`; other joints have `NAME.0_deg`, `NAME.1_deg` (universal) or
/// `NAME.x` to `NAME.w` (ball, unit quaternion). A driven base has `root_x root_y root_z root_qw root_qx root_qy
/// root_qz`: the pose of its body, in m, in a world with z up, which is the convention of robot programs.
pub fn csv(mechanism: &Mechanism, motion: &RigMotion, start_s: f64) -> String {
    let mut text = String::from("time");
    let columns = columns(mechanism);
    for column in &columns {
        text.push(',');
        text.push_str(&quoted(&column.header()));
    }
    text.push('\n');
    let ranges = mechanism.coordinate_ranges();
    for (row, q) in motion.rows.iter().enumerate() {
        number(&mut text, start_s + row as f64 * motion.dt_s);
        let poses = mechanism.poses(q);
        for ((link, range), pose) in mechanism.bodies.iter().zip(&ranges).zip(&poses) {
            if link.joint == JointModel::Free {
                let rotation = to_z_up() * pose.rotation;
                let position = to_z_up() * pose.position_m;
                let [x, y, z, w] = rotation.to_array();
                for value in position.to_array().into_iter().chain([w, x, y, z]) {
                    text.push(',');
                    number(&mut text, value);
                }
                continue;
            }
            for index in range.clone() {
                let (value, unit) = (q[index], HeaderUnits::Degrees.of(columns[index].quantity));
                text.push(',');
                number(&mut text, unit.map_or(value, |unit| unit.of_si(value)));
            }
        }
        text.push('\n');
    }
    text
}

/// Appends a number with nine decimals, and without a negative zero.
fn number(text: &mut String, value: f64) {
    write!(text, "{:.9}", value + 0.0).expect("a string takes everything");
}

/// Returns a name as a field of CSV.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
