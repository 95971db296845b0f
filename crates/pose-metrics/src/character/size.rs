//! Size and up axis of a character: from its format or from the user, with a check of plausibility.

use glam::DVec3;
use sinew_figure::measured::{Measured, UnitOverrides};
use sinew_mocap::{Recording, Skeleton, SkeletonJoint, to_y};
use sinew_retarget::skeleton::SkeletonMatch;

use super::error::{Refusal, refuse};
use super::model::{Character, Joint};

/// Longest plausible bone, m: as long as the tallest figure.
pub(super) const BONE_MAX_M: f64 = 3.0;

impl Character {
    /// Returns the rest pose as a recording without frames, in metres.
    pub fn at_rest(&self) -> Recording {
        let joints = &self.joints;
        // Recordings list parents first: sorted by depth, then in the order of the file.
        let depth = |joint: usize| {
            std::iter::successors(joints[joint].parent, |p| joints[*p].parent).count()
        };
        let mut order: Vec<usize> = (0..joints.len()).collect();
        order.sort_by_key(|joint| depth(*joint));
        let mut place = vec![0; joints.len()];
        for (index, joint) in order.iter().enumerate() {
            place[*joint] = index;
        }
        let joint = |joint: &usize| {
            let Joint { name, parent, position_m } = &joints[*joint];
            SkeletonJoint {
                name: name.clone(),
                parent: parent.map(|parent| place[parent]),
                offset_m: parent
                    .map_or(*position_m, |parent| *position_m - joints[parent].position_m),
                end_sites_m: Vec::new(),
            }
        };
        Recording {
            name: self.name.clone(),
            skeleton: Skeleton { joints: order.iter().map(joint).collect() },
            frames: Vec::new(),
            frame_time_s: None,
            metres_per_unit: Some(1.0),
            notes: Vec::new(),
        }
    }

    /// Scales every position by `metres_per_unit`, and rotates the character to turn `up` into y.
    #[must_use]
    fn placed(mut self, metres_per_unit: f64, up: DVec3) -> Self {
        let turn = to_y(up);
        let placed = |position_m: &mut DVec3| *position_m = turn * *position_m * metres_per_unit;
        self.joints.iter_mut().for_each(|joint| placed(&mut joint.position_m));
        if let Some(mesh) = &mut self.mesh {
            mesh.positions_m.iter_mut().for_each(placed);
        }
        self
    }

    /// Refuses a bone that is longer than any body, as a sign of a wrong unit.
    fn check_bones(&self) -> Result<(), Refusal> {
        let long = (0..self.joints.len()).find(|joint| self.bone_length_m(*joint) > BONE_MAX_M);
        let Some(joint) = long else { return Ok(()) };
        let item = format!("the bone to joint `{}`", self.joints[joint].name);
        let expected = format!(
            "at most {BONE_MAX_M} m (if the file's unit is not the metre, say so: --metres-per-unit 0.01 for centimetres)"
        );
        Err(refuse(item, expected, format!("{:.2} m", self.bone_length_m(joint))))
    }
}

/// Applies the user's unit and up axis to a character whose format prescribes both. `in_character` converts the
/// file's axes to the character's. Rigs may be machines, and have bones of any length.
///
/// # Errors
/// [`Refusal`] for a bone that is longer than any body, unless the user gave the unit or the character is a rig.
pub(super) fn of_format(
    character: Character,
    units: UnitOverrides,
    in_character: fn(DVec3) -> DVec3,
    is_rig: bool,
) -> Result<Character, Refusal> {
    let up = units.up.map_or(DVec3::Y, |up| in_character(up.axis()));
    let mut character = character.placed(units.metres_per_unit.unwrap_or(1.0), up);
    if units.metres_per_unit.is_none() && !is_rig {
        character.check_bones()?;
    }
    let rest = character.at_rest();
    let mut measured = Measured::of_format(&rest, &SkeletonMatch::new(&rest.skeleton, &[]));
    // Robots have any size.
    measured.is_body &= !is_rig;
    if let Some(metres_per_unit) = units.metres_per_unit {
        measured.height_units /= metres_per_unit;
        measured.metres_per_unit = Some(metres_per_unit);
        "as you specified".clone_into(&mut measured.unit_reason);
    }
    if units.up.is_some() {
        "after the turn that you asked for".clone_into(&mut measured.up.reason);
    }
    let size = std::iter::once(measured.to_string()).chain(measured.warnings());
    character.notes.splice(0..0, size);
    Ok(character)
}
