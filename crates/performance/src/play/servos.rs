//! Adds servos to joints that have none, such as those of an imported URDF.

use std::str::FromStr;

use sinew_rig::Description;
use sinew_rig::description::{Drive, DriveKind, JointType, Servo, ServoModel};
use sinew_rig::servo::Address;
use sinew_servo_sim::kind::Kind;
use thiserror::Error;

/// The highest id of a servo.
const MAX_ID: u8 = 252;

/// A kind of servo, and the joints that get it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServoChoice {
    /// A joint's name, or its beginning and `*`; `None` for all joints.
    joint: Option<String>,
    /// Name of the model, as the maker writes it.
    model: String,
}

/// Parses `KIND` or `JOINT=KIND`.
impl FromStr for ServoChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (joint, kind) = match text.split_once('=') {
            Some((joint, kind)) => (Some(joint.trim().to_owned()), kind),
            None => (None, text),
        };
        match Kind::named(kind.trim()).map_err(|error| error.to_string())? {
            Kind::Servo(kind) => Ok(Self { joint, model: kind.name }),
            Kind::Registers(table) => Err(format!(
                "the motor of {} has not been measured, so it cannot be simulated; expected another kind, such as xm430",
                ServoModel::with_article(table.name())
            )),
        }
    }
}

impl ServoChoice {
    fn is_for(&self, name: &str) -> bool {
        self.joint.as_deref().is_none_or(|joint| match joint.strip_suffix('*') {
            Some(beginning) => name.starts_with(beginning),
            None => name == joint,
        })
    }
}

/// Error of servos that cannot be added to joints.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PutError {
    /// The rig has no servos, and no kind of servo is given.
    #[error(
        "the rig has no servos; `--servo KIND` puts one on each joint, such as `--servo xm430`; `rig.toml` may \
         describe them, too"
    )]
    NoServos,
    /// A given name matches no joint that lacks a servo.
    #[error("--servo {0}: no joint without a servo has such a name")]
    NoJoint(String),
    /// All joints have servos.
    #[error("--servo: each joint has a servo already")]
    NoneFree,
    /// The joint neither turns about one axis nor about two, so servos cannot move it one to one.
    #[error(
        "joint `{joint}` is {kind:?}: describe its drive in rig.toml, `--servo` is for joints that turn"
    )]
    Joint {
        /// Name of the joint.
        joint: String,
        /// Type of the joint.
        kind: JointType,
    },
    /// A bus has too few ids.
    #[error("more joints than a bus has ids")]
    Ids,
}

/// Adds servos to the joints that have no drive, as far as `wanted` chooses a kind for them: one servo to a revolute
/// joint, one for each axis to a universal joint. A servo gets the joint's name (`NAME.1` and `NAME.2` for two axes)
/// and the bus `main`; the middle of its range is the middle of the joint's range. The joint keeps each limit of speed
/// and effort that the servo could exceed, and only those parts of its friction and damping that exceed the servo's.
/// Returns the number of joints that got servos.
///
/// # Errors
/// [`PutError`] names the joint and the valid choices.
pub fn put_servos(rig: &mut Description, wanted: &[ServoChoice]) -> Result<usize, PutError> {
    let is_moved = |name: &str| rig.drives.iter().any(|d| d.joints.iter().any(|j| j == name));
    let free: Vec<usize> = (0..rig.joints.len())
        .filter(|index| rig.joints[*index].kind != JointType::Fixed)
        .filter(|index| !is_moved(&rig.joints[*index].name))
        .collect();
    if wanted.is_empty() {
        return if rig.servos.is_empty() { Err(PutError::NoServos) } else { Ok(0) };
    }
    if free.is_empty() {
        return Err(PutError::NoneFree);
    }
    let unused =
        wanted.iter().find(|choice| !free.iter().any(|at| choice.is_for(&rig.joints[*at].name)));
    if let Some(joint) = unused.and_then(|choice| choice.joint.clone()) {
        return Err(PutError::NoJoint(joint));
    }
    let taken = rig.servos.iter().filter_map(|servo| match servo.address {
        Address::Id(id) => Some(id),
        Address::Channel(_) => None,
    });
    let first = taken.max().map_or(1, |id| id.saturating_add(1));
    let mut ids = first..=MAX_ID;
    let mut count = 0;
    for index in free {
        let name = rig.joints[index].name.clone();
        // A choice with a joint name has priority over a choice for all joints.
        let of_name = wanted.iter().rev().filter(|choice| choice.joint.is_some());
        let of_all = wanted.iter().rev().filter(|choice| choice.joint.is_none());
        let Some(choice) = of_name.chain(of_all).find(|choice| choice.is_for(&name)) else {
            continue;
        };
        let kind = rig.joints[index].kind;
        if !matches!(kind, JointType::Revolute | JointType::Universal) {
            return Err(PutError::Joint { joint: name, kind });
        }
        let Some(model) = ServoModel::built_in(&choice.model) else { continue };
        let dofs = kind.dof_count();
        let mut servos = Vec::new();
        for axis in 0..dofs {
            let own = if dofs == 1 { name.clone() } else { format!("{name}.{}", axis + 1) };
            let range = rig.joints[index].range_rad.get(axis);
            rig.servos.push(Servo {
                name: own.clone(),
                model: choice.model.clone(),
                address: Address::Id(ids.next().ok_or(PutError::Ids)?),
                offset_rad: range.map(|[least, most]| -0.5 * (least + most)),
                ..Servo::default()
            });
            servos.push(own);
        }
        let joint = &mut rig.joints[index];
        joint.speed_rad_s = joint.speed_rad_s.filter(|v| *v < model.no_load_speed_rad_s.value);
        joint.effort = joint.effort.filter(|effort| *effort < model.stall_torque_nm.value);
        // The friction of a joint without a servo includes the friction of its unknown drive: the servo's friction must
        // not count twice.
        joint.friction = (joint.friction - model.friction_nm.value).max(0.0);
        joint.damping = (joint.damping - model.damping_nm_s.value).max(0.0);
        let kind = DriveKind::one_to_one(dofs);
        rig.drives.push(Drive { joints: vec![name], servos, kind });
        count += 1;
    }
    Ok(count)
}

#[cfg(test)]
mod tests {
    use sinew_rig::new::arm;

    use super::*;

    fn bare() -> Description {
        let mut rig = arm(3).unwrap();
        (rig.servos, rig.drives) = (Vec::new(), Vec::new());
        rig
    }

    fn choices(texts: &[&str]) -> Vec<ServoChoice> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    #[test]
    fn each_joint_gets_the_servo_that_names_it_most_closely() {
        let mut rig = bare();
        assert_eq!(put_servos(&mut rig, &choices(&["bend*=xm430", "mx-28"])), Ok(3));
        let models: Vec<_> = rig.servos.iter().map(|servo| servo.model.as_str()).collect();
        assert_eq!(models, ["MX-28", "XM430-W350-T", "XM430-W350-T"]);
        assert_eq!(rig.servos[2].address, Address::Id(3));
        rig.mechanism().unwrap();
        assert_eq!(put_servos(&mut rig, &choices(&["mx-28"])), Err(PutError::NoneFree));
        assert_eq!(put_servos(&mut rig, &[]), Ok(0));
    }

    /// A joint with its servo has the friction in its file, or the servo's friction if that is larger.
    #[test]
    fn friction_is_counted_once() {
        let model = ServoModel::built_in("XM430-W350-T").unwrap();
        let [of_servo, dry] = [model.damping_nm_s.value, model.friction_nm.value];
        for damping in [0.5 * of_servo, 2.0 * of_servo] {
            let mut rig = bare();
            (rig.joints[1].damping, rig.joints[1].friction) = (damping, 0.0);
            put_servos(&mut rig, &choices(&["xm430"])).unwrap();
            let name = rig.joints[1].name.clone();
            let mechanism = rig.mechanism().unwrap();
            let link = mechanism.bodies.iter().find(|link| link.joint_name == name).unwrap();
            // The servo's numbers are stored as f32.
            assert!((link.damping - damping.max(of_servo)).abs() < 1e-7, "{}", link.damping);
            assert!((link.friction - dry).abs() < 1e-7, "{}", link.friction);
        }
    }

    #[test]
    fn what_cannot_be_is_refused_with_what_would_be_right() {
        assert_eq!(put_servos(&mut bare(), &[]), Err(PutError::NoServos));
        let elbow = put_servos(&mut bare(), &choices(&["xl330", "elbow=xl330"]));
        assert_eq!(elbow, Err(PutError::NoJoint("elbow".to_owned())));
        let mut slide = bare();
        slide.joints[1].kind = JointType::Prismatic;
        let refused = put_servos(&mut slide, &choices(&["xl330"])).unwrap_err().to_string();
        assert!(refused.contains("bend2") && refused.contains("rig.toml"), "{refused}");
        assert!("xc330".parse::<ServoChoice>().unwrap_err().contains("measured"));
        assert!("mg90s".parse::<ServoChoice>().unwrap_err().contains("pulses"));
    }
}
