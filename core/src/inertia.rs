//! Mass, centre of mass and rotational inertia of a body, and their validation.

use core::fmt;

use glam::Vec3;

/// Rotational inertia about the centre of mass, in body axes, in kg m².
///
/// `xy`, `xz`, `yz` are the elements of the matrix (the negated products of inertia).
///
/// ```
/// use sinew_core::{RotationalInertia, glam::Vec3};
/// let drum = RotationalInertia::diagonal(0.1, 0.2, 0.1);
/// // The moment for an angular acceleration of 3 rad/s² about y.
/// assert_eq!(drum.mul_vec3(Vec3::Y * 3.0), Vec3::Y * 0.6);
/// let tilted = RotationalInertia { xy: 0.02, ..drum };
/// assert_eq!(tilted.mul_vec3(Vec3::X), Vec3::new(0.1, 0.02, 0.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[expect(missing_docs, reason = "the fields are the elements that the type's line names")]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct RotationalInertia {
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub xx: f32,
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub xy: f32,
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub xz: f32,
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub yy: f32,
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub yz: f32,
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub zz: f32,
}

impl RotationalInertia {
    /// Creates an inertia whose principal axes are the body axes, kg m².
    pub const fn diagonal(xx: f32, yy: f32, zz: f32) -> Self {
        Self { xx, xy: 0.0, xz: 0.0, yy, yz: 0.0, zz }
    }

    /// Returns the matrix times a vector in body axes.
    pub fn mul_vec3(&self, v: Vec3) -> Vec3 {
        Vec3::new(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }

    /// Returns `true` if every element is finite.
    pub fn is_finite(&self) -> bool {
        self.elements().iter().all(|element| element.is_finite())
    }

    fn elements(&self) -> [f32; 6] {
        [self.xx, self.xy, self.xz, self.yy, self.yz, self.zz]
    }
}

/// Mass of a body, and the distribution of the mass.
///
/// ```
/// use sinew_core::{Inertia, InertiaError, RotationalInertia, glam::Vec3};
/// let rod = Inertia {
///     mass_kg: 1.2,
///     center_of_mass_m: Vec3::new(0.0, -0.15, 0.0),
///     rotational_kg_m2: RotationalInertia::diagonal(0.009, 0.0, 0.009),
/// };
/// assert!(rod.validate().is_ok());
/// let flat = Inertia { rotational_kg_m2: RotationalInertia::diagonal(1.0, 1.0, 3.0), ..rod };
/// assert_eq!(flat.validate(), Err(InertiaError::TriangleInequality));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Inertia {
    /// Mass, kg; zero for a frame without a body.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub mass_kg: f32,
    /// Centre of mass in the body frame, m.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub center_of_mass_m: Vec3,
    /// Rotational inertia about the centre of mass, in body axes, kg m².
    pub rotational_kg_m2: RotationalInertia,
}

/// Tolerance for f32 rounding of the inputs, as a fraction of the trace. A thin rod or a flat plate, whose second
/// moment is zero along an axis, must still pass after a rotation in f32.
const ROUNDING: f32 = 1e-5;

impl Inertia {
    /// Returns the inertia of a solid box of this mass, with edges along the body axes: a first guess for a link of a
    /// rig.
    ///
    /// ```
    /// use sinew_core::{Inertia, glam::Vec3};
    /// let link = Inertia::of_box(1.2, Vec3::Y * 0.5, Vec3::new(0.0, 1.0, 0.1));
    /// // About x: m (height² + depth²) / 12.
    /// assert!((link.rotational_kg_m2.xx - 0.101).abs() < 1e-6);
    /// assert!(link.validate().is_ok());
    /// ```
    pub fn of_box(mass_kg: f32, center_m: Vec3, size_m: Vec3) -> Self {
        let Vec3 { x, y, z } = size_m * size_m * (mass_kg / 12.0);
        let rotational_kg_m2 = RotationalInertia::diagonal(y + z, z + x, x + y);
        Self { mass_kg, center_of_mass_m: center_m, rotational_kg_m2 }
    }

    /// Refuses an inertia that no real body can have.
    ///
    /// The second moments of mass `Σ = tr(I)/2 - I` of any real body are positive semidefinite. This single condition
    /// includes both the positive moments and the triangle inequality (Wensing, Kim & Slotine 2018, "Linear matrix
    /// inequalities for physically consistent inertial parameter identification").
    ///
    /// # Errors
    /// [`InertiaError`] with the first broken rule.
    pub fn validate(&self) -> Result<(), InertiaError> {
        let i = &self.rotational_kg_m2;
        if !self.mass_kg.is_finite() {
            return Err(InertiaError::NonFinite("mass"));
        }
        if !self.center_of_mass_m.is_finite() {
            return Err(InertiaError::NonFinite("center of mass"));
        }
        if !i.is_finite() {
            return Err(InertiaError::NonFinite("rotational inertia"));
        }
        if self.mass_kg < 0.0 {
            return Err(InertiaError::NegativeMass);
        }
        if i.xx < 0.0 || i.yy < 0.0 || i.zz < 0.0 {
            return Err(InertiaError::NegativeMoment);
        }
        let largest = i.xx.max(i.yy).max(i.zz);
        if self.mass_kg <= 0.0 && largest > 0.0 {
            return Err(InertiaError::InertiaWithoutMass);
        }
        if largest <= 0.0 {
            return if i.elements().iter().all(|element| element.abs() <= 0.0) {
                Ok(())
            } else {
                Err(InertiaError::TriangleInequality)
            };
        }
        // Scaled by the trace, which makes the tolerance relative. Before that, scaled by the largest moment:
        // otherwise the trace of a huge body could overflow, and that of a tiny one could have too few digits.
        let [xx, xy, xz, yy, yz, zz] = i.elements().map(|element| element / largest);
        let trace = xx + yy + zz;
        let (xx, yy, zz) = (0.5 - xx / trace, 0.5 - yy / trace, 0.5 - zz / trace);
        let (xy, xz, yz) = (-xy / trace, -xz / trace, -yz / trace);
        let minors = [
            xx,
            yy,
            zz,
            xx * yy - xy * xy,
            xx * zz - xz * xz,
            yy * zz - yz * yz,
            xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz),
        ];
        if minors.iter().all(|minor| *minor >= -ROUNDING) {
            Ok(())
        } else {
            Err(InertiaError::TriangleInequality)
        }
    }
}

/// An error in an inertia.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum InertiaError {
    /// The named quantity is NaN or infinite.
    NonFinite(&'static str),
    /// The mass is negative.
    NegativeMass,
    /// A diagonal element is negative.
    NegativeMoment,
    /// The mass is zero, but the rotational inertia is not.
    InertiaWithoutMass,
    /// A principal moment exceeds the sum of the other two, or is negative: no distribution of mass has these
    /// moments.
    TriangleInequality,
}

impl fmt::Display for InertiaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinite(what) => write!(f, "the {what} is not a finite number"),
            Self::NegativeMass => f.write_str("the mass is negative; it must be zero or more"),
            Self::NegativeMoment => f.write_str("a moment of inertia is negative; it must be zero or more"),
            Self::InertiaWithoutMass => {
                f.write_str("there is rotational inertia but no mass; give a mass above zero")
            }
            Self::TriangleInequality => f.write_str(
                "no body has this inertia: each principal moment must lie between zero and the sum of the other two",
            ),
        }
    }
}

impl core::error::Error for InertiaError {}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(rotational_kg_m2: RotationalInertia) -> Inertia {
        Inertia { mass_kg: 1.0, center_of_mass_m: Vec3::ZERO, rotational_kg_m2 }
    }

    #[test]
    fn impossible_inertia_is_refused_each_by_its_name() {
        use InertiaError as E;
        let good = body(RotationalInertia::diagonal(1.0, 1.0, 1.0));
        assert_eq!(good.validate(), Ok(()));
        assert_eq!(Inertia { mass_kg: -1.0, ..good }.validate(), Err(E::NegativeMass));
        assert_eq!(Inertia { mass_kg: 0.0, ..good }.validate(), Err(E::InertiaWithoutMass));
        assert_eq!(Inertia { mass_kg: f32::NAN, ..good }.validate(), Err(E::NonFinite("mass")));
        assert_eq!(
            Inertia { center_of_mass_m: Vec3::new(0.0, f32::INFINITY, 0.0), ..good }.validate(),
            Err(E::NonFinite("center of mass"))
        );
        let nan = RotationalInertia { yz: f32::NAN, ..RotationalInertia::diagonal(1.0, 1.0, 1.0) };
        assert_eq!(body(nan).validate(), Err(E::NonFinite("rotational inertia")));
        assert_eq!(
            body(RotationalInertia::diagonal(-1.0, 1.0, 1.0)).validate(),
            Err(E::NegativeMoment)
        );
        let sheared = RotationalInertia { xy: 1.5, ..RotationalInertia::diagonal(1.0, 1.0, 1.0) };
        assert_eq!(body(sheared).validate(), Err(E::TriangleInequality));
        assert_eq!(Inertia::default().validate(), Ok(()), "a massless frame");
    }
}
