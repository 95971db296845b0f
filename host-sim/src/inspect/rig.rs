//! Of rigs: bodies with mass on joints with limits.

use std::path::Path;

use glam::DVec3;
use sinew_mocap::{Recording, Skeleton, SkeletonJoint};
use sinew_retarget::skeleton::SkeletonMatch;
use sinew_rig::Description;
use sinew_rig::description::JointType;
use sinew_rig::import::Options;

use super::{Common, Inspected, Kind, maker, rest};
use crate::character;
use crate::measured::{self, Measured, Told};
use crate::rig::{Loaded, load};

pub(super) fn rig(path: &Path, told: Told) -> Result<Inspected, String> {
    let loaded = match load(path, &Options::default()) {
        Ok(loaded) => loaded,
        // Its joints can be seen, though no tree of bodies can be made of it as it is.
        Err(error) => return as_character(path, told, &error.to_string()),
    };
    let rest = at_home(&loaded);
    let matched = SkeletonMatch::new(&rest.skeleton, &[]);
    let measured = Measured::of_format(&rest, &matched);
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let format = match extension.to_str() {
        Some("toml") => "rig.toml",
        Some("urdf" | "xacro") => "URDF",
        _ => "MJCF or URDF",
    };
    let common = Common {
        kind: Kind::Rig,
        format,
        maker: maker::by_text(path),
        skeleton: &rest.skeleton,
        measured: &measured,
        matched: &matched,
        extents: measured::extents(&rest, DVec3::Y),
    };
    let mut inspected = common.inspected();
    // A rig is no body: which of its joints are whose is `sinew map --rig`'s to say.
    inspected.landmarks_missing.clear();
    (inspected.nearest, inspected.missing) = (None, Vec::new());
    let mass_kg: f64 = loaded.mechanism.bodies.iter().map(|body| body.mass_kg).sum();
    inspected.notes.push(format!("its mass is {mass_kg:.3} kg"));
    inspected.notes.extend(loaded.notes);
    (inspected.joints, inspected.tree) = tree(&loaded.description, &inspected.tree);
    if extension != "toml" {
        "as shown: turned from z, which its format has".clone_into(&mut inspected.up_reason);
    }
    Ok(inspected)
}

fn as_character(path: &Path, told: Told, why: &str) -> Result<Inspected, String> {
    let options = character::Options { told, frame: None };
    let character = character::read(path, &options).map_err(|_| why.to_owned())?;
    let mut inspected = rest::of_character(&character, "URDF", path, told);
    inspected.notes.push(format!("no rig as it is: {why}"));
    Ok(inspected)
}

/// The bodies that move, as a skeleton in the home pose.
fn at_home(loaded: &Loaded) -> Recording {
    let mechanism = &loaded.mechanism;
    let poses = mechanism.poses(&mechanism.home());
    let joint = |(index, body): (usize, &sinew_rig::mechanism::Link)| SkeletonJoint {
        name: body.joint_name.clone(),
        parent: body.parent,
        offset_m: body
            .parent
            .map_or(DVec3::ZERO, |parent| poses[index].position_m - poses[parent].position_m),
        end_sites_m: Vec::new(),
    };
    Recording {
        name: loaded.description.name.clone(),
        skeleton: Skeleton { joints: mechanism.bodies.iter().enumerate().map(joint).collect() },
        frames: Vec::new(),
        frame_time_s: None,
        metres_per_unit: Some(1.0),
        notes: Vec::new(),
    }
}

/// All joints of the description, fixed ones too, parents first; those that move have their bone's length from
/// `moving`.
fn tree(description: &Description, moving: &[super::TreeJoint]) -> (usize, Vec<super::TreeJoint>) {
    let joints = &description.joints;
    let mover = |body: &str| joints.iter().position(|joint| joint.child == body);
    let mut tree: Vec<super::TreeJoint> = Vec::with_capacity(joints.len());
    let mut place = vec![None; joints.len()];
    // A rig's joints are a tree: each round finds those whose parents are there.
    while tree.len() < joints.len() {
        let before = tree.len();
        for (index, joint) in joints.iter().enumerate() {
            let parent = mover(&joint.parent);
            let parent_place = parent.and_then(|parent| place[parent]);
            if place[index].is_some() || parent.is_some() && parent_place.is_none() {
                continue;
            }
            place[index] = Some(tree.len());
            let length_m = moving
                .iter()
                .find(|moving| moving.name == joint.name)
                .and_then(|moving| moving.length_m);
            tree.push(super::TreeJoint {
                name: joint.name.clone(),
                parent: parent_place,
                length_m,
                moves: Some(moves(joint.kind)),
            });
        }
        if tree.len() == before {
            break;
        }
    }
    (joints.len(), tree)
}

const fn moves(kind: JointType) -> &'static str {
    match kind {
        JointType::Fixed => "fixed",
        JointType::Revolute => "revolute",
        JointType::Prismatic => "prismatic",
        JointType::Universal => "universal",
        JointType::Spherical => "spherical",
        JointType::Free => "free",
    }
}
