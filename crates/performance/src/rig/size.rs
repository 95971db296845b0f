//! Estimates the size of an imported rig, and whether it is upright: robot formats prescribe metres and z up, but
//! files often differ.

use std::ops::RangeInclusive;

use glam::DVec3;
use sinew_mocap::{Recording, Skeleton, SkeletonJoint, axis_name, to_y};
use sinew_retarget::skeleton::SkeletonMatch;
use sinew_rig::Mechanism;
use sinew_rig::import::World;

/// Plausible sizes, m: from an eye to a float of a parade.
const SIZE_M: RangeInclusive<f64> = 0.005..=10.0;

/// Returns the moving bodies as a skeleton in the home pose.
pub fn at_home(name: &str, mechanism: &Mechanism) -> Recording {
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
        name: name.to_owned(),
        skeleton: Skeleton { joints: mechanism.bodies.iter().enumerate().map(joint).collect() },
        frames: Vec::new(),
        frame_time_s: None,
        metres_per_unit: Some(1.0),
        notes: Vec::new(),
    }
}

/// Returns the extents of joints and centres of mass in the home pose: along y, and the largest across, m.
fn extents_m(mechanism: &Mechanism) -> [f64; 2] {
    let poses = mechanism.poses(&mechanism.home());
    let places = poses.iter().zip(&mechanism.bodies).flat_map(|(pose, body)| {
        let center_m = (body.mass_kg > 0.0).then(|| pose.point(body.center_of_mass_m));
        std::iter::once(pose.position_m).chain(center_m)
    });
    let (low, high) = places.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), place| {
        (low.min(place), high.max(place))
    });
    let size = (high - low).max(DVec3::ZERO);
    [size.y, size.x.max(size.z)]
}

/// Returns the unit of a file whose rig has an implausible size in metres, with the reason; `None` if metres are
/// plausible.
///
/// # Errors
/// The reason why the unit is unknown, and the option that sets it.
pub(super) fn other_unit(mechanism: &Mechanism) -> Result<Option<(f64, String)>, String> {
    let [high, across] = extents_m(mechanism);
    let size = high.max(across);
    // If all points coincide, there is no size to measure.
    if size <= 0.0 || SIZE_M.contains(&size) {
        return Ok(None);
    }
    let body = SkeletonMatch::new(&at_home("", mechanism).skeleton, &[]).unit;
    let guess = body.and_then(|body| Some((body.metres_per_unit?, body.reason)));
    guess.map(Some).ok_or_else(|| {
        format!(
            "expected a rig from {} to {} m large, found {size:.4} m from end to end, if the unit is the metre: say what \
             it is (`sinew rig import FILE --metres-per-unit 0.001 -o rig.toml` for millimetres, 1 if it is the metre)",
            SIZE_M.start(),
            SIZE_M.end()
        )
    })
}

/// Describes the size and unit of a rig.
pub(super) fn size(mechanism: &Mechanism, world: &World) -> String {
    let [high, across] = extents_m(mechanism);
    let World { metres_per_unit, unit_reason, .. } = world;
    format!("{high:.3} m high, {across:.3} m across; a unit is {metres_per_unit} m ({unit_reason})")
}

/// Returns a note if the figure is not upright. `up`: the assumed up axis in the file, unit vector.
pub(super) fn lies(mechanism: &Mechanism, up: DVec3) -> Option<String> {
    /// Least mean agreement of the directions from feet to hips and to the head: within half a right angle.
    const AGREEMENT: f64 = 0.7;
    let body = SkeletonMatch::new(&at_home("", mechanism).skeleton, &[]).up?;
    (body.agreement > AGREEMENT && body.axis != DVec3::Y).then(|| {
        format!(
            "doubtful: the figure lies on its side or head down: from feet to head is along {} of the file, and {} is \
             taken for up. If that is wrong, say so with --up",
            axis_name(to_y(up).inverse() * body.axis),
            axis_name(up)
        )
    })
}
