//! The solids of a subject as bodies of the figure.

use glam::DVec3;

use super::subject::Subject;
use crate::body::BODIES;
use crate::error::BodyModelError;
use crate::placement::{self, BodyPart, Placement, Skeleton, named};
use crate::plant::MassProperties;

/// Returns the mass properties of the subject's solids placed on a skeleton.
pub(crate) fn bodies(
    placement: &Placement<'_>,
    subject: &Subject,
) -> Result<Vec<MassProperties>, BodyModelError> {
    let scale = placement.leg_m / subject.inputs().leg_m();
    let [thorax] = named(["thorax"]);
    placement::each_body(|body| {
        let (part, segment) = (BodyPart::new(body), subject.segment(body));
        // A shoulder part keeps its place in the column that it was cut from.
        let place = placement.place(if part == BodyPart::Shoulder { thorax } else { body })?;
        let length_m =
            if part.is_limb() { place.bone_m.length() } else { segment.length_m * scale };
        let solid = segment.shape.solid(length_m);
        let center_of_mass_m = match part {
            BodyPart::Foot => place.along(solid.center_z_m - placement::HEEL_TO_ANKLE * length_m),
            BodyPart::Shoulder => {
                place.along(solid.center_z_m)
                    + place.left() * (side(body) * segment.shape.center_to_side_m())
                    - placement.offset_m(body)
            }
            _ => place.along(solid.center_z_m),
        };
        let [transverse, sagittal, longitudinal] = solid.inertia_over_mass_m2.to_array();
        let moments = segment.mass_kg * DVec3::new(sagittal, transverse, longitudinal);
        Ok(MassProperties {
            mass_kg: segment.mass_kg,
            center_of_mass_m,
            rotational_kg_m2: place.in_body_frame(moments),
        })
    })
}

/// Returns 1 for a body on the left, -1 on the right, 0 in the middle.
fn side(body: usize) -> f64 {
    let name = BODIES[body].name;
    f64::from(u8::from(name.ends_with("_l"))) - f64::from(u8::from(name.ends_with("_r")))
}

/// Joints and segment ends of a subject's own figure, standing with its arms down: x left, y up, z forward.
///
/// The model gives the lengths of the segments, but not where they are joined. These positions are our choice: the
/// pelvis joint is in the middle of the hips, each hip joint in the middle of its half of the hips' breadth. The
/// trunk's joints are on its axis. A shoulder joint is on the side of the upper trunk, level with its top, which
/// is also where head and clavicles are joined.
pub(crate) struct OwnSkeleton {
    pub offset_m: Vec<DVec3>,
    pub segment_end_m: Vec<DVec3>,
}

impl OwnSkeleton {
    pub(crate) fn new(subject: &Subject) -> Self {
        let inputs = subject.inputs();
        let half_breadth_m = 0.25 * (inputs.chest_breadth_m.get() + inputs.xyphion_breadth_m.get());
        let hip_m = 0.25 * inputs.hip_breadth_m.get();
        let segment_end = |body| {
            let length_m = subject.segment(body).length_m;
            match BodyPart::new(body) {
                BodyPart::LowerTrunk | BodyPart::MidTrunk | BodyPart::Thorax | BodyPart::Head => {
                    DVec3::Y * length_m
                }
                BodyPart::Shoulder => DVec3::new(side(body) * half_breadth_m, 0.0, 0.0),
                BodyPart::UpperArm
                | BodyPart::Forearm
                | BodyPart::Hand
                | BodyPart::Thigh
                | BodyPart::Shank => DVec3::NEG_Y * length_m,
                BodyPart::Foot => DVec3::Z * ((1.0 - placement::HEEL_TO_ANKLE) * length_m),
            }
        };
        let segment_end_m: Vec<DVec3> = (0..BODIES.len()).map(segment_end).collect();
        let offset = |body| match (BodyPart::new(body), BODIES[body].parent) {
            (_, None) => DVec3::ZERO,
            (BodyPart::Thigh, _) => DVec3::new(side(body) * hip_m, 0.0, 0.0),
            (_, Some(parent)) => segment_end_m[parent],
        };
        Self { offset_m: (0..BODIES.len()).map(offset).collect(), segment_end_m }
    }

    pub(crate) fn skeleton(&self) -> Skeleton<'_> {
        Skeleton { offset_m: &self.offset_m, segment_end_m: &self.segment_end_m }
    }
}
