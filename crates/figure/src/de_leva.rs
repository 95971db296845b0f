//! The mean man of a published segment table: P. de Leva, "Adjustments to Zatsiorsky-Seluyanov's segment
//! inertia parameters", J. Biomech. 29 (1996) 1223-1230, table 4, males (73.0 kg, 1.741 m).
//!
//! A limb has its length in the clip, since its ends are joint centres in the table too. The lengths of the other
//! segments are the table's shares of the stature. The stature is derived from the length of the clip's legs.

use glam::DVec3;

use super::cut::{self, CutDisc};
use super::error::BodyModelError;
use super::placement::{self, BodyPart, Placement};
use crate::plant::MassProperties;

/// Returns the mass properties of the table's man in the dimensions of a skeleton.
pub(super) fn bodies(placement: &Placement<'_>) -> Result<Vec<MassProperties>, BodyModelError> {
    let stature_m = placement.leg_m / (THIGH.length + SHANK.length);
    let upper_trunk = UpperTrunkParts::new();
    placement::each_body(|body| {
        let (part, place) = (BodyPart::new(body), placement.place(body)?);
        let segment = upper_trunk.segment(part);
        let length =
            if part.is_limb() { place.bone_m.length() } else { segment.length * stature_m };
        let center_of_mass_m = match part {
            // The bone is half the breadth of the trunk.
            BodyPart::Shoulder => place.bone_m * segment.center,
            _ => place.along(segment.center * length),
        };
        let mass_kg = segment.mass * MASS_KG;
        let moments = segment.gyration.map(|k| mass_kg * (k * length) * (k * length));
        Ok(MassProperties {
            mass_kg,
            center_of_mass_m,
            rotational_kg_m2: place.in_body_frame(DVec3::from_array(moments)),
        })
    })
}

/// Returns the mass of a body of the figure by the table, as a share of the whole mass.
///
/// # Panics
/// If `body` is not below [`BODY_COUNT`](super::BODY_COUNT).
pub fn mass_fraction(body: usize) -> f64 {
    UpperTrunkParts::new().segment(BodyPart::new(body)).mass
}

/// Mass to which the fractions apply, in kg: the mean of the sample.
const MASS_KG: f64 = 73.0;

/// One row of the table. Lengths, centre and radii are converted from percent to fractions.
#[derive(Debug, Clone, Copy)]
struct Segment {
    /// Mass, as a fraction of the whole body's mass.
    mass: f64,
    /// Length of the segment, as a fraction of stature.
    length: f64,
    /// Distance of the centre of mass from the end at the figure's joint, as a fraction of the length.
    center: f64,
    /// Radii of gyration about the centre of mass as fractions of the length: about the sagittal
    /// (front to back), the transverse (left to right) and the longitudinal axis.
    gyration: [f64; 3],
}

const STATURE_M: f64 = 1.741;

const fn row(mass: f64, length_m: f64, center: f64, gyration: [f64; 3]) -> Segment {
    let [s, t, l] = gyration;
    Segment {
        mass: mass / 100.0,
        length: length_m / STATURE_M,
        center: center / 100.0,
        gyration: [s / 100.0, t / 100.0, l / 100.0],
    }
}

// The table measures the centres of the head and the trunk's parts from the top, but the figure's joints are at
// the bottom: these centres are 100 minus the table's.

/// Row of the head, from vertex to cervicale: the table's alternative end points, since the figure's head turns at
/// the neck.
const HEAD: Segment = row(6.94, 0.2429, 100.0 - 50.02, [30.3, 31.5, 26.1]);
/// Row of the upper trunk, from suprasternale to xyphion.
const UPPER_TRUNK: Segment = row(15.96, 0.1707, 100.0 - 29.99, [71.6, 45.4, 65.9]);
/// Row of the middle trunk, from xyphion to omphalion.
const MID_TRUNK: Segment = row(16.33, 0.2155, 100.0 - 45.02, [48.2, 38.3, 46.8]);
/// Row of the lower trunk, from omphalion to the middle of the hips.
const LOWER_TRUNK: Segment = row(11.17, 0.1457, 100.0 - 61.15, [61.5, 55.1, 58.7]);
/// Row of the upper arm, from shoulder to elbow.
const UPPER_ARM: Segment = row(2.71, 0.2817, 57.72, [28.5, 26.9, 15.8]);
/// Row of the forearm, from elbow to wrist.
const FOREARM: Segment = row(1.62, 0.2689, 45.74, [27.6, 26.5, 12.1]);
/// Row of the hand, from wrist to third metacarpal.
const HAND: Segment = row(0.61, 0.0862, 79.00, [62.8, 51.3, 40.1]);
/// Row of the thigh, from hip to knee.
const THIGH: Segment = row(14.16, 0.4222, 40.95, [32.9, 32.9, 14.9]);
/// Row of the shank, from knee to lateral malleolus.
const SHANK: Segment = row(4.33, 0.4340, 44.59, [25.5, 24.9, 10.3]);
/// Row of the foot, from heel to toe tip.
const FOOT: Segment =
    row(1.37, 0.2581, 44.15 - 100.0 * placement::HEEL_TO_ANKLE, [25.7, 24.5, 12.4]);

/// The upper trunk cut in three (see `cut.rs`). It is modelled as a solid elliptical column with the published
/// radii of gyration.
#[derive(Debug, Clone, Copy)]
struct UpperTrunkParts {
    /// The middle part. Its centre of mass is that of the whole upper trunk.
    thorax: Segment,
    /// The left or the right part. Its `center` is measured from the middle of the trunk, as a fraction of the
    /// distance to its side.
    shoulder: Segment,
}

impl UpperTrunkParts {
    fn new() -> Self {
        let whole = UPPER_TRUNK;
        let [depth, breadth, height] = second_moments(whole.gyration);
        let disc = CutDisc::new();
        let scale = |moment: f64, mean_square: f64| moment * mean_square / cut::WHOLE;
        let [across, along] = disc.outer;
        let shoulder =
            [scale(depth, along), scale(breadth, across - disc.center * disc.center), height];
        let [across, along] = disc.middle;
        let thorax = [scale(depth, along), scale(breadth, across), height];
        Self {
            thorax: Segment {
                mass: whole.mass * disc.middle_share(),
                gyration: gyration(thorax),
                ..whole
            },
            shoulder: Segment {
                mass: whole.mass * disc.share,
                center: disc.center,
                gyration: gyration(shoulder),
                ..whole
            },
        }
    }

    fn segment(&self, part: BodyPart) -> Segment {
        match part {
            BodyPart::LowerTrunk => LOWER_TRUNK,
            BodyPart::MidTrunk => MID_TRUNK,
            BodyPart::Thorax => self.thorax,
            BodyPart::Head => HEAD,
            BodyPart::Shoulder => self.shoulder,
            BodyPart::UpperArm => UPPER_ARM,
            BodyPart::Forearm => FOREARM,
            BodyPart::Hand => HAND,
            BodyPart::Thigh => THIGH,
            BodyPart::Shank => SHANK,
            BodyPart::Foot => FOOT,
        }
    }
}

/// Returns the mean squares of the mass's distances along the sagittal, transverse and longitudinal axes, from the
/// radii of gyration about them.
fn second_moments([s, t, l]: [f64; 3]) -> [f64; 3] {
    let half_trace = 0.5 * (s * s + t * t + l * l);
    [half_trace - s * s, half_trace - t * t, half_trace - l * l]
}

/// Inverts [`second_moments`].
fn gyration([s, t, l]: [f64; 3]) -> [f64; 3] {
    [libm::sqrt(t + l), libm::sqrt(s + l), libm::sqrt(s + t)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_sum_to_the_whole_body() {
        let limbs = [UPPER_ARM, FOREARM, HAND, THIGH, SHANK, FOOT];
        let middle = [HEAD, UPPER_TRUNK, MID_TRUNK, LOWER_TRUNK];
        let sum: f64 = middle.iter().map(|row| row.mass).sum::<f64>()
            + 2.0 * limbs.iter().map(|row| row.mass).sum::<f64>();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn the_figures_bodies_are_the_whole_body() {
        let sum: f64 = (0..crate::BODY_COUNT).map(mass_fraction).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn the_three_parts_of_the_upper_trunk_are_the_whole() {
        let parts = UpperTrunkParts::new();
        let (thorax, shoulder) = (parts.thorax, parts.shoulder);
        assert!((thorax.mass + 2.0 * shoulder.mass - UPPER_TRUNK.mass).abs() < 1e-15);
        let whole = second_moments(UPPER_TRUNK.gyration);
        let half_breadth = 2.0 * whole[1].sqrt();
        for (axis, whole) in whole.into_iter().enumerate() {
            // Parallel axes: the shoulder parts' centres are away from the middle along the breadth only.
            let away = if axis == 1 { (shoulder.center * half_breadth).powi(2) } else { 0.0 };
            let sum = thorax.mass * second_moments(thorax.gyration)[axis]
                + 2.0 * shoulder.mass * (second_moments(shoulder.gyration)[axis] + away);
            let expected = UPPER_TRUNK.mass * whole;
            assert!((sum / expected - 1.0).abs() < 1e-12, "axis {axis}: {sum} {expected}");
        }
    }
}
