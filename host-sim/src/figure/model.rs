//! Mass properties of the figure's bodies from published regressions, on the dimensions of a clip.

use core::array;

use glam::{DMat3, DVec3};
use sinew_core::{
    Body as RigBody, Inertia, JointKind, RotationalInertia, Transform, Tree, TreeError,
};
use thiserror::Error;

use super::body::{BODIES, BODY_COUNT};
use super::segments::{self, Segment, UpperTrunkParts};
use crate::mocap::FigureMotion;

/// What a body weighs and how its mass is spread, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Mass in kg.
    pub mass_kg: f64,
    /// Centre of mass in the body frame, in metres.
    pub center_of_mass_m: DVec3,
    /// Rotational inertia about the centre of mass, body axes.
    pub rotational_kg_m2: DMat3,
}

/// The figure as a mechanism: where its joints are, and the mass properties of its bodies.
///
/// Built from de Leva's segment table, on the joints that a clip's skeleton has:
/// - A limb (upper arm, forearm, thigh, shank) is as long as in the clip: its ends are joint centres in
///   the table too. All other segments end at landmarks that a skeleton lacks (or has at no distance
///   from each other), so their lengths are the table's share of the stature, and the stature is the
///   one whose share the clip's legs are.
/// - The longitudinal axis of a segment points from its joint to its end. The sagittal axis is the
///   figure's forward direction made perpendicular to it; for a segment that points forward itself, as
///   the feet do, the transverse axis is the figure's left instead. Forward and left are those of the
///   zero pose, in which all body frames are parallel.
/// - The lower trunk's centre of mass is placed from the middle of the hips, not from the pelvis joint.
/// - The upper trunk is cut in thorax and shoulder parts (see `segments.rs`); a shoulder part lies along
///   its clavicle.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyModel {
    /// Position of joint `i` in the frame of body `i`'s parent, in metres; zero for the root.
    pub offset_m: [DVec3; BODY_COUNT],
    /// Mass properties by body.
    pub bodies: [MassProperties; BODY_COUNT],
}

/// Why a clip's skeleton cannot be given a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum BodyModelError {
    /// A dimension is NaN or infinite.
    #[error("the offset or the end of the {0} is not finite")]
    NonFinite(&'static str),
    /// A limb must have a length.
    #[error("the {0} has no length: its joint and the next one are at the same place")]
    NoLength(&'static str),
    /// Left and right, or up, cannot be told.
    #[error(
        "the hips are at the same place, or the neck is level with them: left and up cannot be told"
    )]
    NoOrientation,
}

/// Shorter than this a bone has no direction, in metres.
const SHORTEST_BONE_M: f64 = 1e-3;

impl BodyModel {
    /// The mean man of the table, 73 kg, with the dimensions of a clip.
    ///
    /// # Errors
    /// [`BodyModelError`] if a dimension is not finite, a limb has no length, or the hips coincide.
    pub fn from_motion(motion: &FigureMotion) -> Result<Self, BodyModelError> {
        for (body, (offset, end)) in motion.offset_m.iter().zip(&motion.segment_end_m).enumerate() {
            if !(offset.is_finite() && end.is_finite()) {
                return Err(BodyModelError::NonFinite(BODIES[body].name));
            }
        }
        let dimensions = Dimensions::of(motion)?;
        let bodies = (0..BODY_COUNT)
            .map(|body| dimensions.mass_properties(body))
            .collect::<Result<Vec<_>, _>>()?;
        let bodies = array::from_fn(|body| bodies[body]);
        Ok(Self { offset_m: motion.offset_m, bodies })
    }

    /// The same figure with all dimensions times `factor`, at the same density.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let (area, volume) = (factor * factor, factor * factor * factor);
        Self {
            offset_m: self.offset_m.map(|offset| offset * factor),
            bodies: self.bodies.map(|body| MassProperties {
                mass_kg: body.mass_kg * volume,
                center_of_mass_m: body.center_of_mass_m * factor,
                rotational_kg_m2: body.rotational_kg_m2 * (volume * area),
            }),
        }
    }

    /// Mass of the whole figure in kg.
    pub fn mass_kg(&self) -> f64 {
        self.bodies.iter().map(|body| body.mass_kg).sum()
    }

    /// The figure as the controller knows it, in f32: the root free, all other joints spherical.
    ///
    /// # Errors
    /// [`TreeError`] if the numbers do not survive f32.
    pub fn tree(&self) -> Result<Tree<BODY_COUNT>, TreeError> {
        let mut tree = Tree::new();
        for ((place, offset), body) in BODIES.iter().zip(&self.offset_m).zip(&self.bodies) {
            let joint = if place.parent.is_none() { JointKind::Free } else { JointKind::Spherical };
            tree.push(RigBody {
                parent: place.parent,
                joint,
                placement: Transform::from_translation(offset.as_vec3()),
                inertia: Inertia {
                    mass_kg: narrow(body.mass_kg),
                    center_of_mass_m: body.center_of_mass_m.as_vec3(),
                    rotational_kg_m2: rotational_f32(&body.rotational_kg_m2),
                },
            })?;
        }
        Ok(tree)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
fn narrow(x: f64) -> f32 {
    x as f32
}

fn rotational_f32(inertia: &DMat3) -> RotationalInertia {
    let i = inertia.as_mat3();
    RotationalInertia {
        xx: i.x_axis.x,
        xy: i.y_axis.x,
        xz: i.z_axis.x,
        yy: i.y_axis.y,
        yz: i.z_axis.y,
        zz: i.z_axis.z,
    }
}

/// What a clip's skeleton tells about the body.
struct Dimensions<'a> {
    motion: &'a FigureMotion,
    stature_m: f64,
    middle_of_hips_m: DVec3,
    left: DVec3,
    up: DVec3,
    forward: DVec3,
    upper_trunk: UpperTrunkParts,
}

/// How a segment lies on its body.
enum Lie {
    /// Along the bone, which is as long as in the table's definition.
    Limb,
    /// Along the bone, from its joint, as long as the table's share of stature.
    Share,
    /// Upwards from the middle of the hips.
    LowerTrunk,
    /// A shoulder part: the bone is its breadth.
    Shoulder,
}

impl<'a> Dimensions<'a> {
    fn of(motion: &'a FigureMotion) -> Result<Self, BodyModelError> {
        let [abdomen, thorax, head] = named(["abdomen", "thorax", "head"]);
        let [thigh_l, thigh_r] = named(["thigh_l", "thigh_r"]);
        let legs = named(["thigh_l", "shank_l", "thigh_r", "shank_r"]);
        let offset = &motion.offset_m;

        let two_legs: f64 = legs.iter().map(|leg| motion.segment_end_m[*leg].length()).sum();
        let stature_m = 0.5 * two_legs / (segments::THIGH.length + segments::SHANK.length);

        let middle_of_hips_m = 0.5 * (offset[thigh_l] + offset[thigh_r]);
        let neck = offset[abdomen] + offset[thorax] + offset[head];
        let left = (offset[thigh_l] - offset[thigh_r]).try_normalize();
        let forward = left.and_then(|left| left.cross(neck - middle_of_hips_m).try_normalize());
        let (Some(left), Some(forward)) = (left, forward) else {
            return Err(BodyModelError::NoOrientation);
        };
        Ok(Self {
            motion,
            stature_m,
            middle_of_hips_m,
            left,
            up: forward.cross(left),
            forward,
            upper_trunk: UpperTrunkParts::new(),
        })
    }

    fn mass_properties(&self, body: usize) -> Result<MassProperties, BodyModelError> {
        let name = BODIES[body].name;
        let (segment, lie) = self.segment(name);
        let bone = self.motion.segment_end_m[body];
        let direction = self.direction(body);
        let length = match lie {
            Lie::Limb if bone.length() < SHORTEST_BONE_M => {
                return Err(BodyModelError::NoLength(name));
            }
            Lie::Limb => bone.length(),
            _ => segment.length * self.stature_m,
        };
        let center_of_mass_m = match lie {
            Lie::Limb | Lie::Share => direction * (segment.center * length),
            Lie::LowerTrunk => self.middle_of_hips_m + direction * (segment.center * length),
            Lie::Shoulder => bone * segment.center,
        };
        // Columns: sagittal, transverse, longitudinal.
        let axes = match lie {
            Lie::Shoulder => {
                let forward = perpendicular(self.forward, direction);
                DMat3::from_cols(forward, direction, forward.cross(direction))
            }
            _ if direction.dot(self.forward).abs() < core::f64::consts::FRAC_1_SQRT_2 => {
                let forward = perpendicular(self.forward, direction);
                DMat3::from_cols(forward, direction.cross(forward), direction)
            }
            _ => {
                let left = perpendicular(self.left, direction);
                DMat3::from_cols(left.cross(direction), left, direction)
            }
        };
        let mass_kg = segment.mass * segments::MASS_KG;
        let [s, t, l] = segment.gyration.map(|k| mass_kg * (k * length) * (k * length));
        let rotational = axes * DMat3::from_diagonal(DVec3::new(s, t, l)) * axes.transpose();
        Ok(MassProperties {
            mass_kg,
            center_of_mass_m,
            // Rounding must not leave it unsymmetric.
            rotational_kg_m2: (rotational + rotational.transpose()) * 0.5,
        })
    }

    fn segment(&self, name: &str) -> (Segment, Lie) {
        match name.trim_end_matches("_l").trim_end_matches("_r") {
            "pelvis" => (segments::LOWER_TRUNK, Lie::LowerTrunk),
            "abdomen" => (segments::MID_TRUNK, Lie::Share),
            "thorax" => (self.upper_trunk.thorax, Lie::Share),
            "head" => (segments::HEAD, Lie::Share),
            "clavicle" => (self.upper_trunk.shoulder, Lie::Shoulder),
            "upper_arm" => (segments::UPPER_ARM, Lie::Limb),
            "forearm" => (segments::FOREARM, Lie::Limb),
            "hand" => (segments::HAND, Lie::Share),
            "thigh" => (segments::THIGH, Lie::Limb),
            "shank" => (segments::SHANK, Lie::Limb),
            _ => (segments::FOOT, Lie::Share),
        }
    }

    /// Unit direction of a segment. One whose end is at its joint goes on in the direction of its
    /// parent's, the trunk upwards.
    fn direction(&self, body: usize) -> DVec3 {
        let along = |v: DVec3| (v.length() >= SHORTEST_BONE_M).then(|| v.normalize());
        match BODIES[body].parent {
            None => self.up,
            Some(parent) => along(self.motion.segment_end_m[body])
                .or_else(|| along(self.motion.offset_m[body]))
                .unwrap_or_else(|| self.direction(parent)),
        }
    }
}

/// The unit vector of `v` made perpendicular to the unit vector `axis`; any perpendicular one if `v` is
/// along it.
fn perpendicular(v: DVec3, axis: DVec3) -> DVec3 {
    v.reject_from_normalized(axis).try_normalize().unwrap_or_else(|| axis.any_orthonormal_vector())
}

fn named<const K: usize>(names: [&str; K]) -> [usize; K] {
    names.map(|name| {
        BODIES.iter().position(|body| body.name == name).expect("the figure has this body")
    })
}

#[cfg(test)]
mod tests;
