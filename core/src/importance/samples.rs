//! Importance from random points on bones with a thickness.

use core::num::NonZeroU16;

use glam::Vec3;

use super::cylinder::Cylinder;
use super::weights::Weights;
use super::{Importance, ImportanceError, RestPose};
use crate::math;

/// Estimates the weights of [`cylinder_surface`](super::cylinder_surface), in m³, from points on the surfaces, like
/// Holden's article (see the module). Each point represents the same part of its bone's surface.
///
/// `samples`: pairs `(u, v)` in [0, 1), `points` of them for each bone that has a length and a thickness, in the
/// order of the joints at the ends of the bones. A point is `[r cos 2πv, r sin 2πv, L (u - 1/2)]` from the middle of
/// a bone along +z, then rotated by the shortest rotation to the bone's direction (for -z: half a turn about x). With
/// 1,000 points from [`SurfaceSamples`] the error of the weights is about 1 %. O(points · n · depth).
///
/// # Errors
/// As in [`cylinder_surface`](super::cylinder_surface), and if a sample is not in [0, 1) or there are too few
/// samples.
///
/// ```
/// use core::num::NonZeroU16;
/// use sinew_core::importance::{RestPose, SurfaceSamples, cylinder_samples, cylinder_surface};
/// use sinew_core::glam::Vec3;
/// let arm = RestPose::<3>::new(&[None, Some(0), Some(1)], &[Vec3::ZERO, Vec3::X, Vec3::X * 1.5])?;
/// let radii_m = [0.0, 0.05, 0.04];
/// let points = NonZeroU16::new(1000).expect("some");
/// let estimated = cylinder_samples(&arm, &radii_m, 0.001, points, SurfaceSamples::new(7))?;
/// let exact = cylinder_surface(&arm, &radii_m, 0.001)?;
/// for (estimated, exact) in estimated.as_slice().iter().zip(exact.as_slice()) {
///     assert!((estimated / exact - 1.0).abs() < 0.05);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn cylinder_samples<const N: usize>(
    rest_pose: &RestPose<N>,
    radii_m: &[f32],
    base_m3: f32,
    points: NonZeroU16,
    samples: impl IntoIterator<Item = (f32, f32)>,
) -> Result<Importance<N>, ImportanceError> {
    let mut weights = Weights::new(rest_pose.len(), base_m3)?;
    let mut samples = (0..).zip(samples);
    for (joint, bone) in Cylinder::of_bones(rest_pose, radii_m)? {
        let part_m2 = bone.area_m2() / f32::from(points.get());
        let frame = Frame::new(&bone);
        for _ in 0..points.get() {
            let (index, (u, v)) = samples.next().ok_or(ImportanceError::TooFewSamples { joint })?;
            if !((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v)) {
                return Err(ImportanceError::Sample { index, value: [u, v] });
            }
            let point_m = frame.point_m(u, v);
            for ancestor in rest_pose.ancestors(joint) {
                let distance_m = math::length(point_m - rest_pose.position_m(ancestor));
                weights.add(ancestor, part_m2 * distance_m);
            }
        }
    }
    weights.importance()
}

/// The middle of a cylinder, and its axes scaled by radius, radius and length, m.
struct Frame {
    middle: Vec3,
    x: Vec3,
    y: Vec3,
    z: Vec3,
}

impl Frame {
    fn new(bone: &Cylinder) -> Self {
        let Vec3 { x, y, z } = bone.axis;
        let off_axis = x * x + y * y;
        // 1 / (1 + z) for a unit vector, without the difference of nearly equal numbers.
        let factor = if z >= 0.0 { 1.0 / (1.0 + z) } else { (1.0 - z) / off_axis };
        let (first, second) = if z < 0.0 && off_axis < f32::MIN_POSITIVE {
            (Vec3::X, -Vec3::Y)
        } else {
            let mixed = -x * y * factor;
            (Vec3::new(1.0 - x * x * factor, mixed, -x), Vec3::new(mixed, 1.0 - y * y * factor, -y))
        };
        Self {
            middle: bone.middle_m(),
            x: first * bone.radius_m,
            y: second * bone.radius_m,
            z: bone.axis * bone.length_m,
        }
    }

    fn point_m(&self, u: f32, v: f32) -> Vec3 {
        let (sine, cosine) = math::sin_cos(2.0 * math::PI * v);
        self.middle + self.x * cosine + self.y * sine + self.z * (u - 0.5)
    }
}

/// An endless iterator of pairs of independent random numbers in [0, 1): equal seeds give equal numbers on all
/// machines.
///
/// The generator is PCG XSH RR 64/32 (O'Neill 2014), stream 54 of its demonstration.
///
/// ```
/// use sinew_core::importance::SurfaceSamples;
/// let take = |seed| SurfaceSamples::new(seed).take(3).collect::<Vec<_>>();
/// assert_eq!(take(7), take(7));
/// assert_ne!(take(7), take(8));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SurfaceSamples {
    state: u64,
}

impl SurfaceSamples {
    /// Creates the generator for a seed.
    pub fn new(seed: u64) -> Self {
        let mut samples = Self { state: 0 };
        samples.next_u32();
        samples.state = samples.state.wrapping_add(seed);
        samples.next_u32();
        samples
    }

    #[expect(clippy::cast_possible_truncation, reason = "the generator takes the lower bits")]
    fn next_u32(&mut self) -> u32 {
        const INCREMENT: u64 = (54 << 1) | 1;
        let state = self.state;
        self.state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(INCREMENT);
        let mixed = (((state >> 18) ^ state) >> 27) as u32;
        mixed.rotate_right((state >> 59) as u32)
    }

    /// Returns a multiple of 2⁻²⁴, which f32 represents exactly.
    fn next_unit(&mut self) -> f32 {
        (self.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
    }
}

impl Iterator for SurfaceSamples {
    type Item = (f32, f32);

    fn next(&mut self) -> Option<(f32, f32)> {
        let u = self.next_unit();
        Some((u, self.next_unit()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generator_makes_the_numbers_of_its_demonstration() {
        // Output of pcg32-demo in the authors' C library, seed 42, stream 54.
        let mut samples = SurfaceSamples::new(42);
        let published = [0xa15c_02b7, 0x7b47_f409, 0xba1d_3330, 0x83d2_f293, 0xbfa4_784b];
        assert_eq!(published.map(|_| samples.next_u32()), published);
    }
}
