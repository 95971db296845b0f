//! Resolves a mapping's names on a rig and a clip.

use glam::DVec3;
use sinew_mocap::Skeleton;
use sinew_rig::Mechanism;

use super::{Mapping, MappingError, all};
use crate::LandmarkMap;
use crate::performer::PerformerJoints;
use crate::rig::{Group, RigMatch, RigPoint};
use crate::solve::Settings;

impl Mapping {
    /// Returns the match of the rig that the mapping describes.
    ///
    /// # Errors
    /// [`MappingError`] with landmark, name and the names of the rig.
    pub fn rig_match(&self, mechanism: &Mechanism) -> Result<RigMatch, MappingError> {
        let forward = self.performance.forward.map(DVec3::from_array);
        Ok(RigMatch::of_groups(mechanism, self.groups(mechanism)?, forward)?)
    }

    /// Checks that all names exist, on the rig and in the clip.
    ///
    /// # Errors
    /// [`MappingError`] with all unknown names.
    pub fn check(&self, mechanism: &Mechanism, skeleton: &Skeleton) -> Result<(), MappingError> {
        all([
            self.performer_joints(skeleton).map(drop),
            self.groups(mechanism).map(drop),
            self.curves(mechanism, skeleton).map(drop),
        ])
        .map(drop)
    }

    fn groups(&self, mechanism: &Mechanism) -> Result<Vec<Group>, MappingError> {
        let with_rig =
            self.landmarks.iter().filter(|entry| !entry.rig.is_empty() || entry.point.is_some());
        all(with_rig.map(|entry| {
            let item = format!("landmark {}", entry.landmark.name());
            let joints =
                entry.rig.iter().map(|name| joint(mechanism, &format!("{item}.rig"), name));
            let point = entry.point.as_ref().map(|point| {
                let body = body(mechanism, &format!("{item}.point.body"), &point.body)?;
                Ok::<_, MappingError>(RigPoint { body, position_m: point.position_m.into() })
            });
            let (joints, point) = (all(joints), point.transpose());
            let mistakes = [joints.as_ref().err(), point.as_ref().err()].into_iter().flatten();
            all(mistakes.cloned().map(Err::<(), _>))?;
            Ok(Group {
                landmark: entry.landmark,
                joints: joints?,
                point: point?,
                confidence: entry.confidence,
                reason: entry.reason.clone(),
            })
        }))
    }

    /// Returns the joints of the clip that the mapping names.
    ///
    /// # Errors
    /// [`MappingError`] with landmark, name and the names of the clip.
    pub fn performer_joints(&self, skeleton: &Skeleton) -> Result<PerformerJoints, MappingError> {
        let of_clip = self.landmarks.iter().filter_map(|entry| {
            let item = format!("landmark {}.clip", entry.landmark.name());
            Some((entry.landmark, clip_joint(skeleton, &item, entry.clip.as_ref()?)))
        });
        let found = all(of_clip.map(|(landmark, joint)| joint.map(|joint| (landmark, joint))))?;
        let mut joints = LandmarkMap::default();
        for (landmark, joint) in found {
            joints[landmark] = Some(joint);
        }
        Ok(PerformerJoints::of(skeleton, joints))
    }

    /// Returns the settings of the performance for the solver.
    pub fn settings(&self) -> Settings {
        let performance = &self.performance;
        Settings {
            speed_rad_s: performance.speed_rad_s,
            scale: performance.scale,
            is_mirrored: performance.mirror,
            arms: performance.arms,
            legs: performance.legs,
            travels: performance.travels,
            tilt_rad: performance.tilt_rad,
        }
    }
}

/// Returns the index of the body that a joint of the rig moves.
pub(super) fn joint(mechanism: &Mechanism, item: &str, name: &str) -> Result<usize, MappingError> {
    let names = || mechanism.bodies.iter().skip(1).map(|link| link.joint_name.as_str());
    let place = names().position(|joint| joint == name).map(|place| place + 1);
    place.ok_or_else(|| {
        MappingError::value(item, listed("a joint of the rig", names()), shown(name))
    })
}

fn body(mechanism: &Mechanism, item: &str, name: &str) -> Result<usize, MappingError> {
    let names = || mechanism.bodies.iter().map(|link| link.name.as_str());
    let place = names().position(|body| body == name);
    place
        .ok_or_else(|| MappingError::value(item, listed("a body of the rig", names()), shown(name)))
}

pub(super) fn clip_joint(
    skeleton: &Skeleton,
    item: &str,
    name: &str,
) -> Result<usize, MappingError> {
    let names = || skeleton.joints.iter().map(|joint| joint.name.as_str());
    let place = skeleton.find(name);
    place.ok_or_else(|| {
        MappingError::value(item, listed("a joint of the clip", names()), shown(name))
    })
}

fn shown(name: &str) -> String {
    format!("`{name}`")
}

/// Lists the valid names, up to a readable number.
fn listed<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> String {
    const MOST: usize = 40;
    let names: Vec<&str> = names.collect();
    let more = if names.len() > MOST { ", ..." } else { "" };
    let shown = names[..names.len().min(MOST)].join(", ");
    format!("{what} ({shown}{more})")
}
