//! The axis of a file that points up, and rotation of recordings so that y points up.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use glam::{DQuat, DVec3};
use serde::Deserialize;

use crate::Recording;

/// An axis of a file that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// The x axis.
    X,
    /// The y axis, as in most motion capture.
    Y,
    /// The z axis, as in Blender, ROS and Vicon's programs.
    Z,
}

impl Up {
    /// Returns the axis as a unit vector.
    pub const fn axis(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }
}

impl FromStr for Up {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim().to_ascii_lowercase().as_str() {
            "x" => Ok(Self::X),
            "y" => Ok(Self::Y),
            "z" => Ok(Self::Z),
            _ => Err("expected x, y or z".to_owned()),
        }
    }
}

impl Display for Up {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(axis_name(self.axis()))
    }
}

/// Returns the name of an axis with its sign: `y`, `-z`; `?` for a vector along no axis.
pub fn axis_name(axis: DVec3) -> &'static str {
    let names = [(DVec3::X, ["x", "-x"]), (DVec3::Y, ["y", "-y"]), (DVec3::Z, ["z", "-z"])];
    let axis = axis.normalize_or_zero();
    for (known, [along, against]) in names {
        if axis.dot(known) > 0.9 {
            return along;
        }
        if axis.dot(known) < -0.9 {
            return against;
        }
    }
    "?"
}

/// Returns the rotation that turns an axis to y; for a coordinate axis, by a multiple of 90 deg.
pub fn to_y(axis: DVec3) -> DQuat {
    DQuat::from_rotation_arc(axis, DVec3::Y)
}

impl Recording {
    /// Returns the motion with y up. `up` is the unit axis that points up in its world; `rest_up` is the unit axis that
    /// points up in the pose without rotations, which may differ.
    #[must_use]
    pub fn upright(mut self, up: DVec3, rest_up: DVec3) -> Self {
        let (world, rest) = (to_y(up), to_y(rest_up));
        if (up, rest_up) == (DVec3::Y, DVec3::Y) {
            return self;
        }
        for joint in &mut self.skeleton.joints {
            joint.offset_m = rest * joint.offset_m;
            for end in &mut joint.end_sites_m {
                *end = rest * *end;
            }
        }
        for frame in &mut self.frames {
            for (joint, sample) in self.skeleton.joints.iter().zip(frame) {
                let Some(sample) = sample else { continue };
                // The root moves in the world, and all other joints in their parent's frame, which has the axes of
                // the rest pose.
                let parent = if joint.parent.is_none() { world } else { rest };
                sample.rotation = (parent * sample.rotation * rest.inverse()).normalize();
                sample.position_m = parent * sample.position_m;
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{JointSample, Skeleton, SkeletonJoint, forward_kinematics};

    fn recording() -> Recording {
        let joint = |name: &str, parent, offset_m| SkeletonJoint {
            name: name.to_owned(),
            parent,
            offset_m,
            end_sites_m: vec![DVec3::new(0.1, 0.2, 0.3)],
        };
        let sample = |angle, position_m| JointSample {
            rotation: DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), angle),
            position_m,
        };
        let bone_m = DVec3::new(0.0, 0.1, 0.9);
        Recording {
            name: "test".to_owned(),
            skeleton: Skeleton {
                joints: vec![joint("a", None, DVec3::ZERO), joint("b", Some(0), bone_m)],
            },
            frames: vec![vec![
                Some(sample(0.7, DVec3::new(1.0, 2.0, 3.0))),
                Some(sample(-0.4, bone_m)),
            ]],
            frame_time_s: Some(0.01),
            metres_per_unit: Some(1.0),
            notes: Vec::new(),
        }
    }

    fn places_m(recording: &Recording) -> Vec<DVec3> {
        let local: Vec<JointSample> = recording.frames[0].iter().flatten().copied().collect();
        let poses = forward_kinematics(&recording.skeleton, &local);
        let ends = poses
            .iter()
            .zip(&recording.skeleton.joints)
            .map(|(pose, joint)| pose.position_m + pose.rotation * joint.end_sites_m[0]);
        poses.iter().map(|pose| pose.position_m).chain(ends).collect()
    }

    #[test]
    fn every_place_is_turned_alike_whatever_the_rest_pose_is() {
        for rest_up in [DVec3::Z, DVec3::Y, DVec3::NEG_X] {
            let turned = recording().upright(DVec3::Z, rest_up);
            for (before, after) in places_m(&recording()).into_iter().zip(places_m(&turned)) {
                let expected = DVec3::new(before.x, before.z, -before.y);
                assert!(after.distance(expected) < 1e-12, "{rest_up}: {after} {expected}");
            }
            let rest_m = turned.skeleton.rest_positions_m()[1];
            let expected = to_y(rest_up) * DVec3::new(0.0, 0.1, 0.9);
            assert!(rest_m.distance(expected) < 1e-12, "{rest_m}");
        }
        assert_eq!(recording().upright(DVec3::Y, DVec3::Y), recording());
    }

    #[test]
    fn axes_have_names() {
        for up in [Up::X, Up::Y, Up::Z] {
            assert_eq!(up.to_string().parse(), Ok(up));
            assert_eq!(axis_name(-up.axis()), format!("-{up}"));
        }
        assert_eq!("w".parse::<Up>(), Err("expected x, y or z".to_owned()));
        assert_eq!(axis_name(0.01 * DVec3::Y), "y");
        assert_eq!(axis_name(DVec3::ONE), "?");
        assert_eq!(axis_name(DVec3::ZERO), "?");
    }
}
