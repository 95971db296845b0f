//! Reads the skeleton of a motion as a character without a skin.
//!
//! An end site becomes a child joint `NAMEEnd` of its joint `NAME` (`NAMEEnd2` for the second), since it gives the
//! length of the last bone. An end site at its joint's position gives no length and is omitted.

use std::path::Path;

use glam::{DQuat, DVec3};
use sinew_figure::mapping;
use sinew_figure::measured::{MappingSource, Measured};
use sinew_mocap::damage::check_bones;
use sinew_mocap::{
    JointSample, Kind, Recording, Skeleton, SkeletonJoint, format, forward_kinematics,
};
use sinew_retarget::skeleton::SkeletonMatch;

use super::error::{Error, NAMES, Refusal, refuse};
use super::model::{Character, Joint};
use super::options::Options;
use super::size::BONE_MAX_M;

/// Reads the skeleton of a motion.
///
/// # Errors
/// [`Error::Motion`] if the motion cannot be read; [`Error::Refused`] if the file is not a motion, its unit of length
/// cannot be determined, a bone is too long, or the requested frame does not exist or has a gap.
pub(super) fn read(path: &Path, options: &Options) -> Result<Character, Error> {
    let recording = match format::read(path) {
        Ok(recording) => recording,
        Err(format::Error::Unknown { file, found }) => {
            let refusal = refuse("the file", NAMES, Kind::found(found));
            return Err(Error::Refused { file, refusal });
        }
        Err(error) => return Err(error.into()),
    };
    character(recording, options)
        .map_err(|refusal| Error::Refused { file: path.to_path_buf(), refusal })
}

fn character(recording: Recording, options: &Options) -> Result<Character, Refusal> {
    let matched = SkeletonMatch::of_recording(&recording);
    let known = mapping::choose(&recording.skeleton).ok();
    let by = known.map(|mapping| MappingSource { mapping, is_given: false });
    let measured = Measured::new(&recording, &matched, by, options.units);
    let unit = |reason| refuse("the skeleton", "one whose unit of length is known", reason);
    let recording = measured.apply(recording).map_err(unit)?;
    check_bones(&recording, BONE_MAX_M)
        .map_err(|long| refuse("the skeleton", "bones that a body can have", long))?;
    let skeleton = &recording.skeleton;
    let local = match options.frame {
        None => at_rest(skeleton),
        Some(frame) => in_frame(&recording, frame)?,
    };
    let poses = forward_kinematics(skeleton, &local);
    let mut joints: Vec<Joint> = Vec::new();
    // Index of each joint of the skeleton among `joints`. Parents precede their children.
    let mut places: Vec<usize> = Vec::with_capacity(poses.len());
    for (joint, pose) in skeleton.joints.iter().zip(&poses) {
        let place = joints.len();
        places.push(place);
        joints.push(Joint {
            name: joint.name.clone(),
            parent: joint.parent.map(|parent| places[parent]),
            position_m: pose.position_m,
        });
        let ends = joint.end_sites_m.iter().filter(|end| **end != DVec3::ZERO);
        for (end, number) in ends.zip(1..) {
            let number = if number > 1 { format!("{number}") } else { String::new() };
            joints.push(Joint {
                name: format!("{}End{number}", joint.name),
                parent: Some(place),
                position_m: pose.position_m + pose.rotation * *end,
            });
        }
    }
    let mut character = Character::new(recording.name.clone(), joints, None)?;
    character.notes.push(measured.to_string());
    character.notes.extend(measured.warnings());
    character.notes.extend(recording.notes);
    Ok(character)
}

/// Returns the rest pose: every joint at its offset, all rotations zero.
fn at_rest(skeleton: &Skeleton) -> Vec<JointSample> {
    let sample = |joint: &SkeletonJoint| JointSample {
        rotation: DQuat::IDENTITY,
        position_m: joint.offset_m,
    };
    skeleton.joints.iter().map(sample).collect()
}

/// Returns the pose of every joint in a frame.
fn in_frame(recording: &Recording, frame: usize) -> Result<Vec<JointSample>, Refusal> {
    let count = recording.frames.len();
    let samples = recording
        .frames
        .get(frame)
        .ok_or_else(|| refuse("--frame", format!("a frame below {count}"), frame))?;
    let sample = |(sample, joint): (&Option<JointSample>, &SkeletonJoint)| {
        let item = || format!("frame {frame}, joint `{}`", joint.name);
        sample.ok_or_else(|| refuse(item(), "a pose", "a gap"))
    };
    samples.iter().zip(&recording.skeleton.joints).map(sample).collect()
}
