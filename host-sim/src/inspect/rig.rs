//! Facts about rigs: bodies with mass on joints with limits.

use std::path::Path;

use glam::DVec3;
use sinew_figure::measured::{self, Measured, UnitOverrides};
use sinew_mocap::{Up, axis_name};
use sinew_performance::rig::{at_home, load};
use sinew_pose_metrics::character;
use sinew_retarget::skeleton::SkeletonMatch;
use sinew_rig::Description;
use sinew_rig::description::JointType;
use sinew_rig::import::Options;

use super::inspected::{Common, Inspected, Kind, TreeJoint};
use super::{maker, rest};

pub(super) fn rig(path: &Path, units: UnitOverrides) -> Result<Inspected, String> {
    let options = Options {
        metres_per_unit: units.metres_per_unit,
        up: units.up.map(Up::axis),
        ..Options::default()
    };
    let loaded = match load(path, &options) {
        Ok(loaded) => loaded,
        // Its joints can be shown, although they do not form a valid tree of bodies.
        Err(error) => return as_character(path, units, &error.to_string()),
    };
    let rest = at_home(&loaded.description.name, &loaded.mechanism);
    let matched = SkeletonMatch::new(&rest.skeleton, &[]);
    // Robots may have any size.
    let measured = Measured { is_body: false, ..Measured::of_format(&rest, &matched) };
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
    // A rig need not be human: `sinew clip map --rig` reports which of its joints correspond to a body's.
    inspected.landmarks_missing.clear();
    (inspected.nearest, inspected.missing) = (None, Vec::new());
    let mass_kg: f64 = loaded.mechanism.bodies.iter().map(|body| body.mass_kg).sum();
    inspected.notes.push(format!("its mass is {mass_kg:.3} kg"));
    // The first note is the size.
    inspected.notes.extend(loaded.notes.into_iter().skip(usize::from(loaded.world.is_some())));
    (inspected.joints, inspected.tree) = tree(&loaded.description, &inspected.tree);
    if let Some(world) = loaded.world {
        inspected.metres_per_unit = Some(world.metres_per_unit);
        inspected.unit_reason = world.unit_reason;
        inspected.up = axis_name(world.up);
        inspected.up_reason = world.up_reason;
    }
    Ok(inspected)
}

fn as_character(path: &Path, units: UnitOverrides, why: &str) -> Result<Inspected, String> {
    let options = character::Options { units, frame: None };
    let character = character::read(path, &options).map_err(|_| why.to_owned())?;
    let mut inspected = rest::of_character(&character, "URDF", path, units);
    if units.up.is_none() {
        inspected.up = axis_name(DVec3::Z);
    }
    inspected.notes.push(format!("no rig as it is: {why}"));
    Ok(inspected)
}

/// Returns the number of joints of the description, also fixed ones, and all of these joints, parents first. Moving
/// joints have the length of their bone from `moving`.
fn tree(description: &Description, moving: &[TreeJoint]) -> (usize, Vec<TreeJoint>) {
    let joints = &description.joints;
    let mover = |body: &str| joints.iter().position(|joint| joint.child == body);
    let mut tree: Vec<TreeJoint> = Vec::with_capacity(joints.len());
    let mut place = vec![None; joints.len()];
    // A rig's joints form a tree: each round places the joints whose parents are placed.
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
            tree.push(TreeJoint {
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
