//! Checks the shapes of a face.

use super::names::Names;
use super::part::Part;
use crate::description::error::{DescriptionError, Step};
use crate::description::{Description, FaceShape, JointType};

/// Tolerance for the rounding of a position at the end of a range, rad or m.
const ROUNDING: f64 = 1e-9;

pub(super) fn check(
    rig: &Description,
    joints: &Names<'_>,
    index: usize,
    shape: &FaceShape,
) -> Result<(), DescriptionError> {
    let part = Part::of("shape", index, &shape.name);
    let at = [Step::Key("pose")];
    for (place, (name, position)) in shape.pose.iter().enumerate() {
        let joint = &rig.joints[joints.find(part, &at, name)?];
        let (range, unit, scale) = match joint.kind {
            JointType::Revolute => (joint.range_rad.first().copied(), "deg", 1_f64.to_degrees()),
            JointType::Prismatic => (joint.range_m, "mm", 1000.0),
            _ => {
                let found = format!("{name:?}, which is neither");
                return Err(part.refuse(&at, "revolute and prismatic joints", found));
            }
        };
        if shape.pose[..place].iter().any(|(other, _)| other == name) {
            return Err(part.refuse(&at, "each joint once", format!("{name:?} twice")));
        }
        let [least, most] = range.unwrap_or([-1e3, 1e3]);
        // The comparison also refuses NaN.
        if !(least - ROUNDING..=most + ROUNDING).contains(position) {
            let expected = format!(
                "a position of joint {name:?} within its range, {:.3} to {:.3} {unit}",
                scale * least,
                scale * most
            );
            return Err(part.refuse(&at, expected, format!("{:.3} {unit}", scale * position)));
        }
    }
    Ok(())
}
