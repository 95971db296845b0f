//! The segments of a subject: shape, length and mass, checked for consistency.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use super::error::{InputError, Values, values};
use super::inputs::{Inputs, Metres};
use super::masses::Masses;
use super::shape::{Piece, Shape};
use crate::placement::BodyPart;

/// A segment of a subject.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Cross-sections of the segment.
    pub shape: Shape,
    /// Length along the longitudinal axis in metres.
    pub length_m: f64,
    /// Mass in kg.
    pub mass_kg: f64,
}

impl Segment {
    /// Returns the volume of the segment's solid in m³.
    pub fn volume_m3(&self) -> f64 {
        self.shape.solid(self.length_m).volume_m3
    }

    /// Returns the density, mass over volume, in kg/m³.
    pub fn density_kg_m3(&self) -> f64 {
        self.mass_kg / self.volume_m3()
    }
}

/// Computes the segment of each part, in the order of [`BodyPart::ALL`].
///
/// # Errors
/// [`InputError`] if a girth is too small for its breadth, or a mass or a density is impossible.
pub(super) fn segments(inputs: &Inputs) -> Result<[Segment; BodyPart::ALL.len()], InputError> {
    let i = inputs;
    let masses = Masses::new(i);
    let trunk = Trunk::new(i)?;
    let trunk_kg_m3 = masses.trunk / trunk.weighted_volume_m3(i);
    let make = |part| {
        let (shape, length) = match part {
            BodyPart::LowerTrunk => (trunk.lower, i.lower_trunk_length_m),
            BodyPart::MidTrunk => (trunk.mid, i.mid_trunk_length_m),
            BodyPart::Thorax => (trunk.upper(Piece::Middle), i.upper_trunk_length_m),
            BodyPart::Shoulder => (trunk.upper(Piece::Side), i.upper_trunk_length_m),
            BodyPart::Head => (ellipsoid(i.head_circumference_m), i.head_length_m),
            BodyPart::UpperArm => (
                cone(i.axillary_arm_circumference_m, i.elbow_circumference_m),
                i.upper_arm_length_m,
            ),
            BodyPart::Forearm => {
                (cone(i.elbow_circumference_m, i.wrist_circumference_m), i.forearm_length_m)
            }
            BodyPart::Hand => (ellipsoid(i.fist_circumference_m), i.wrist_to_knuckle_m),
            BodyPart::Thigh => (thigh(i)?, i.thigh_length_m),
            BodyPart::Shank => {
                (cone(i.knee_circumference_m, i.ankle_circumference_m), i.shank_length_m)
            }
            BodyPart::Foot => (foot(i)?, i.foot_length_m),
        };
        let length_m = length.get();
        let volume_m3 = shape.solid(length_m).volume_m3;
        let mass_kg = match part {
            BodyPart::LowerTrunk | BodyPart::MidTrunk => trunk_kg_m3 * ABDOMEN * volume_m3,
            BodyPart::Thorax | BodyPart::Shoulder => trunk_kg_m3 * THORAX * volume_m3,
            BodyPart::Head => masses.head,
            BodyPart::UpperArm => masses.upper_arm,
            BodyPart::Forearm => masses.forearm,
            BodyPart::Hand => masses.hand,
            BodyPart::Thigh => masses.thigh,
            BodyPart::Shank => masses.shank,
            BodyPart::Foot => masses.foot,
        };
        let segment = Segment { shape, length_m, mass_kg };
        check(part, i, &segment)?;
        Ok(segment)
    };
    let made = BodyPart::ALL.into_iter().map(make).collect::<Result<Vec<_>, _>>()?;
    Ok(core::array::from_fn(|part| made[part]))
}

/// Relative density of the upper trunk, which contains the lungs. `ABDOMEN` is that of the other two parts.
const THORAX: f64 = 0.92;
const ABDOMEN: f64 = 1.01;

/// Shapes of the trunk's parts. Each part's share of the trunk's mass is proportional to its relative density
/// times its volume.
struct Trunk {
    upper_a_m: f64,
    upper_b_m: f64,
    mid: Shape,
    lower: Shape,
}

impl Trunk {
    fn new(i: &Inputs) -> Result<Self, InputError> {
        let upper_a_m = half_breadth(&values!(i; chest_breadth_m, xyphion_breadth_m));
        let upper_b_m = other_semi_axis(
            "upper trunk",
            values!(i; chest_circumference_m, xyphion_circumference_m),
            values!(i; chest_breadth_m, xyphion_breadth_m),
        )?;
        let xyphion_b_m = other_semi_axis(
            "mid trunk",
            values!(i; xyphion_circumference_m),
            values!(i; xyphion_breadth_m),
        )?;
        let omphalion_b_m = other_semi_axis(
            "mid trunk",
            values!(i; omphalion_circumference_m),
            values!(i; omphalion_breadth_m),
        )?;
        let lower_b_m = other_semi_axis(
            "lower trunk",
            values!(i; omphalion_circumference_m, hip_circumference_m),
            values!(i; omphalion_breadth_m, hip_breadth_m),
        )?;
        Ok(Self {
            upper_a_m,
            upper_b_m,
            // The body's joint is at its lower end, which is listed first.
            mid: Shape::Elliptical {
                a_m: [i.omphalion_breadth_m.get() / 2.0, i.xyphion_breadth_m.get() / 2.0],
                b_m: [omphalion_b_m, xyphion_b_m],
            },
            lower: Shape::Column {
                a_m: half_breadth(&values!(i; omphalion_breadth_m, hip_breadth_m)),
                b_m: lower_b_m,
                piece: Piece::Whole,
            },
        })
    }

    fn upper(&self, piece: Piece) -> Shape {
        Shape::Column { a_m: self.upper_a_m, b_m: self.upper_b_m, piece }
    }

    fn weighted_volume_m3(&self, i: &Inputs) -> f64 {
        let volume = |shape: Shape, length: Metres| shape.solid(length.get()).volume_m3;
        THORAX * volume(self.upper(Piece::Whole), i.upper_trunk_length_m)
            + ABDOMEN * volume(self.mid, i.mid_trunk_length_m)
            + ABDOMEN * volume(self.lower, i.lower_trunk_length_m)
    }
}

fn ellipsoid(circumference: Metres) -> Shape {
    Shape::Ellipsoid { radius_m: circumference.get() / TAU }
}

fn cone(near: Metres, far: Metres) -> Shape {
    Shape::Cone { radius_m: [near.get() / TAU, far.get() / TAU] }
}

/// Returns the shape of the thigh: an ellipse at the hip, a circle at the knee.
fn thigh(i: &Inputs) -> Result<Shape, InputError> {
    let depths = values!(i; upper_thigh_depth_m);
    let b_m = half_breadth(&depths);
    let a_m = other_semi_axis("thigh", values!(i; upper_thigh_circumference_m), depths)?;
    let knee_m = i.knee_circumference_m.get() / TAU;
    Ok(Shape::Elliptical { a_m: [a_m, knee_m], b_m: [b_m, knee_m] })
}

/// Returns the shape of the foot: a circle at the heel, an ellipse at the toes. The sources disagree on the
/// ellipse's height; this function derives it from the mean girth, like the depth of the trunk.
fn foot(i: &Inputs) -> Result<Shape, InputError> {
    let breadths = values!(i; foot_breadth_m, toe_breadth_m);
    let a_m = half_breadth(&breadths);
    let girths = values!(i; ball_circumference_m, toe_circumference_m);
    let b_m = other_semi_axis("foot", girths, breadths)?;
    let heel_m = i.heel_circumference_m.get() / TAU;
    Ok(Shape::Elliptical { a_m: [heel_m, a_m], b_m: [heel_m, b_m] })
}

/// Returns half of the mean breadth.
fn half_breadth(breadths: &Values) -> f64 {
    breadths.mean() / 2.0
}

/// Returns the second semi-axis of an ellipse, from its perimeter, approximately π (a + b), and its breadth 2 a.
fn other_semi_axis(
    segment: &'static str,
    girths: Values,
    breadths: Values,
) -> Result<f64, InputError> {
    let a_m = half_breadth(&breadths);
    let b_m = girths.mean() / PI - a_m;
    if b_m > 0.0 {
        return Ok(b_m);
    }
    let least_m = FRAC_PI_2 * breadths.mean();
    Err(InputError::Girth { segment, girths, breadths, least_m })
}

/// Plausible densities of a segment in kg/m³. A density outside means that an input is wrong or in another unit.
const DENSITY_KG_M3: core::ops::RangeInclusive<f64> = 850.0..=1250.0;

fn check(part: BodyPart, inputs: &Inputs, segment: &Segment) -> Result<(), InputError> {
    let (name, values) = measured(part, inputs);
    let mass_kg = segment.mass_kg;
    if mass_kg <= 0.0 {
        return Err(InputError::Mass { segment: name, mass_kg, values });
    }
    let density_kg_m3 = segment.density_kg_m3();
    if DENSITY_KG_M3.contains(&density_kg_m3) {
        return Ok(());
    }
    let volume_m3 = segment.volume_m3();
    Err(InputError::Density { segment: name, density_kg_m3, mass_kg, volume_m3, values })
}

/// Returns the name of a part, and the inputs from which its mass and its shape are computed.
fn measured(part: BodyPart, i: &Inputs) -> (&'static str, Values) {
    match part {
        // The parts of the trunk share one mass, which makes each density depend on all of these inputs.
        BodyPart::LowerTrunk | BodyPart::MidTrunk | BodyPart::Thorax | BodyPart::Shoulder => (
            "trunk",
            values!(i; mass_kg, trunk_length_m, upper_trunk_length_m, mid_trunk_length_m,
                lower_trunk_length_m, chest_circumference_m, xyphion_circumference_m,
                omphalion_circumference_m, hip_circumference_m, chest_breadth_m, xyphion_breadth_m,
                omphalion_breadth_m, hip_breadth_m),
        ),
        BodyPart::Head => ("head", values!(i; mass_kg, head_length_m, head_circumference_m)),
        BodyPart::UpperArm => (
            "upper arm",
            values!(i; mass_kg, upper_arm_length_m, axillary_arm_circumference_m,
                elbow_circumference_m),
        ),
        BodyPart::Forearm => (
            "forearm",
            values!(i; forearm_length_m, forearm_circumference_m, elbow_circumference_m,
                wrist_circumference_m),
        ),
        BodyPart::Hand => (
            "hand",
            values!(i; wrist_to_knuckle_m, fist_circumference_m, wrist_circumference_m,
                wrist_breadth_m),
        ),
        BodyPart::Thigh => (
            "thigh",
            values!(i; mass_kg, thigh_length_m, upper_thigh_circumference_m, upper_thigh_depth_m,
                knee_circumference_m),
        ),
        BodyPart::Shank => (
            "shank",
            values!(i; shank_length_m, calf_circumference_m, knee_circumference_m,
                ankle_circumference_m),
        ),
        BodyPart::Foot => (
            "foot",
            values!(i; mass_kg, foot_length_m, heel_circumference_m, ball_circumference_m,
                toe_circumference_m, ankle_circumference_m, foot_breadth_m, toe_breadth_m),
        ),
    }
}
