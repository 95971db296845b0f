//! Symmetric 3 x 3 matrices in six numbers, and the inverses of matrices that inertias consist of.

use core::ops::{Add, AddAssign, Mul, Sub};

use glam::{Mat3, Vec3};

use crate::inertia::RotationalInertia;

/// Relative rounding error of an inertia after a few subtractions.
pub(crate) const ROUNDING: f32 = 1e-6;

/// A symmetric matrix, by the elements of its upper triangle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Symmetric {
    pub(crate) xx: f32,
    pub(crate) xy: f32,
    pub(crate) xz: f32,
    pub(crate) yy: f32,
    pub(crate) yz: f32,
    pub(crate) zz: f32,
}

/// The inverse of a positive semidefinite matrix. Its form depends on whether the matrix is definite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Inverse {
    /// Definite matrix: its factors `L D Lᵀ`, L with a diagonal of ones.
    Factored {
        /// Elements of 1 / D.
        reciprocals: Vec3,
        /// Elements yx, zx, zy of L.
        lower: Vec3,
    },
    /// Matrix that is singular, or nearly singular.
    Pseudo {
        /// Moore-Penrose inverse: zero along the null directions of the matrix.
        inverse: Symmetric,
        /// Projector on the null directions.
        null: Symmetric,
    },
}

impl Symmetric {
    pub(crate) const ZERO: Self = Self::diagonal(0.0);

    /// Returns a multiple of the identity.
    pub(crate) const fn diagonal(x: f32) -> Self {
        Self { xx: x, xy: 0.0, xz: 0.0, yy: x, yz: 0.0, zz: x }
    }

    /// Returns `a bᵀ + b aᵀ`.
    pub(crate) fn from_outer(a: Vec3, b: Vec3) -> Self {
        Self {
            xx: 2.0 * a.x * b.x,
            xy: a.x * b.y + a.y * b.x,
            xz: a.x * b.z + a.z * b.x,
            yy: 2.0 * a.y * b.y,
            yz: a.y * b.z + a.z * b.y,
            zz: 2.0 * a.z * b.z,
        }
    }

    /// Returns `A B` for a symmetric product: only the upper triangle is computed.
    pub(crate) fn from_product(a: &Mat3, b: &Mat3) -> Self {
        let rows = a.transpose();
        Self {
            xx: rows.x_axis.dot(b.x_axis),
            xy: rows.x_axis.dot(b.y_axis),
            xz: rows.x_axis.dot(b.z_axis),
            yy: rows.y_axis.dot(b.y_axis),
            yz: rows.y_axis.dot(b.z_axis),
            zz: rows.z_axis.dot(b.z_axis),
        }
    }

    /// Adds a multiple of the identity.
    #[inline]
    pub(crate) fn add_diagonal(&mut self, x: f32) {
        self.xx += x;
        self.yy += x;
        self.zz += x;
    }

    pub(crate) fn x_axis(&self) -> Vec3 {
        Vec3::new(self.xx, self.xy, self.xz)
    }

    pub(crate) fn y_axis(&self) -> Vec3 {
        Vec3::new(self.xy, self.yy, self.yz)
    }

    pub(crate) fn z_axis(&self) -> Vec3 {
        Vec3::new(self.xz, self.yz, self.zz)
    }

    pub(crate) fn to_mat3(self) -> Mat3 {
        Mat3::from_cols(self.x_axis(), self.y_axis(), self.z_axis())
    }

    pub(crate) fn trace(&self) -> f32 {
        self.xx + self.yy + self.zz
    }

    /// Returns `R S Rᵀ`: the matrix in rotated axes.
    #[inline]
    pub(crate) fn turned(&self, rotation: &Mat3) -> Self {
        let half = Mat3::from_cols(
            *rotation * self.x_axis(),
            *rotation * self.y_axis(),
            *rotation * self.z_axis(),
        );
        Self::from_product(&half, &rotation.transpose())
    }

    /// Returns the inverse. The matrix must be positive semidefinite within rounding.
    #[inline]
    pub(crate) fn inverse(&self) -> Inverse {
        let trace = self.trace();
        let first = 1.0 / self.xx;
        let (yx, zx) = (self.xy * first, self.xz * first);
        let y_pivot = self.yy - yx * self.xy;
        let below = self.yz - yx * self.xz;
        let second = 1.0 / y_pivot;
        let zy = below * second;
        let z_pivot = self.zz - zx * self.xz - zy * below;
        let third = 1.0 / z_pivot;
        // The traces of a matrix and of its inverse bound the ratio of its eigenvalues.
        let aslant = yx * zy - zx;
        let trace_of_inverse =
            first * (1.0 + yx * yx + aslant * aslant) + second * (1.0 + zy * zy) + third;
        let definite = self.xx > 0.0 && y_pivot > 0.0 && z_pivot > 0.0;
        if definite && trace * trace_of_inverse < 1.0 / ROUNDING {
            Inverse::Factored {
                reciprocals: Vec3::new(first, second, third),
                lower: Vec3::new(yx, zx, zy),
            }
        } else {
            self.pseudo_inverse()
        }
    }

    #[cold]
    fn pseudo_inverse(&self) -> Inverse {
        let trace = self.trace();
        let identity = Self::diagonal(1.0);
        if !(trace > f32::MIN_POSITIVE && trace.is_finite()) {
            return Inverse::Pseudo { inverse: Self::ZERO, null: identity };
        }
        let scale = 1.0 / trace;
        let unit = *self * scale;
        // With eigenvalues a, b, 0, the adjugate is a b times the projector on the null direction. In the plane of
        // the other two, where a + b = 1, (1 - A) A = a b.
        let adjugate = unit.adjugate();
        let product = adjugate.trace();
        let (inverse, null) = if product > ROUNDING {
            let share = 1.0 / product;
            let null = adjugate * share;
            ((identity - null - unit) * share, null)
        } else {
            (unit, identity - unit)
        };
        Inverse::Pseudo { inverse: inverse * scale, null }
    }

    /// Returns the inverse by its cofactors; zero if the matrix is not definite. If the determinant overflows f32,
    /// the elements are NaN: a zero inverse would look like a body that no force can move.
    #[inline]
    pub(crate) fn inverse_if_definite(&self) -> Self {
        let adjugate = self.adjugate();
        let determinant = self.xx * adjugate.xx + self.xy * adjugate.xy + self.xz * adjugate.xz;
        let share = if determinant > f32::MAX {
            f32::NAN
        } else if determinant > 0.0 {
            1.0 / determinant
        } else {
            0.0
        };
        adjugate * share
    }

    #[inline]
    fn adjugate(&self) -> Self {
        let Self { xx, xy, xz, yy, yz, zz } = *self;
        Self {
            xx: yy * zz - yz * yz,
            xy: xz * yz - xy * zz,
            xz: xy * yz - xz * yy,
            yy: xx * zz - xz * xz,
            yz: xy * xz - xx * yz,
            zz: xx * yy - xy * xy,
        }
    }
}

impl Inverse {
    #[inline]
    pub(crate) fn mul_vec3(&self, v: Vec3) -> Vec3 {
        match self {
            Self::Factored { reciprocals, lower } => {
                let y = v.y - lower.x * v.x;
                let z = (v.z - lower.y * v.x - lower.z * y) * reciprocals.z;
                let y = y * reciprocals.y - lower.z * z;
                Vec3::new(v.x * reciprocals.x - lower.x * y - lower.y * z, y, z)
            }
            Self::Pseudo { inverse, .. } => *inverse * v,
        }
    }

    #[inline]
    pub(crate) fn mul_mat3(&self, m: &Mat3) -> Mat3 {
        Mat3::from_cols(self.mul_vec3(m.x_axis), self.mul_vec3(m.y_axis), self.mul_vec3(m.z_axis))
    }

    /// Returns the inverse as a matrix.
    pub(crate) fn matrix(&self) -> Symmetric {
        match self {
            Self::Factored { .. } => {
                let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| self.mul_vec3(axis));
                Symmetric { xx: x.x, xy: y.x, xz: z.x, yy: y.y, yz: z.y, zz: z.z }
            }
            Self::Pseudo { inverse, .. } => *inverse,
        }
    }

    /// Returns the projector on the null directions of the matrix, if there are any.
    #[inline]
    pub(crate) fn null(&self) -> Option<Symmetric> {
        match self {
            Self::Factored { .. } => None,
            Self::Pseudo { null, .. } => Some(*null),
        }
    }
}

impl From<&RotationalInertia> for Symmetric {
    fn from(i: &RotationalInertia) -> Self {
        Self { xx: i.xx, xy: i.xy, xz: i.xz, yy: i.yy, yz: i.yz, zz: i.zz }
    }
}

impl From<&Symmetric> for RotationalInertia {
    fn from(s: &Symmetric) -> Self {
        Self { xx: s.xx, xy: s.xy, xz: s.xz, yy: s.yy, yz: s.yz, zz: s.zz }
    }
}

impl Add for Symmetric {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            xx: self.xx + other.xx,
            xy: self.xy + other.xy,
            xz: self.xz + other.xz,
            yy: self.yy + other.yy,
            yz: self.yz + other.yz,
            zz: self.zz + other.zz,
        }
    }
}

impl AddAssign for Symmetric {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Symmetric {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl Mul<f32> for Symmetric {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f32) -> Self {
        Self {
            xx: self.xx * factor,
            xy: self.xy * factor,
            xz: self.xz * factor,
            yy: self.yy * factor,
            yz: self.yz * factor,
            zz: self.zz * factor,
        }
    }
}

impl Mul<Vec3> for Symmetric {
    type Output = Vec3;

    #[inline]
    fn mul(self, v: Vec3) -> Vec3 {
        Vec3::new(self.x_axis().dot(v), self.y_axis().dot(v), self.z_axis().dot(v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    fn largest(v: Vec3) -> f32 {
        v.abs().max_element()
    }

    /// Returns a matrix with the given eigenvalues along the axes of a frame, and the frame.
    fn with_eigenvalues(values: Vec3) -> (Mat3, Symmetric) {
        let frame = Mat3::from_quat(math::exp(Vec3::new(0.4, -1.2, 0.7)));
        let Vec3 { x, y, z } = values;
        (frame, Symmetric { xx: x, yy: y, zz: z, ..Symmetric::ZERO }.turned(&frame))
    }

    #[test]
    fn a_definite_matrix_is_divided_by() {
        let v = Vec3::new(0.3, -2.0, 0.8);
        for values in [Vec3::ONE, Vec3::new(2.0, 0.02, 0.5), Vec3::new(3e-9, 1e-8, 2e-9)] {
            let (_, matrix) = with_eigenvalues(values);
            let inverse = matrix.inverse();
            assert!(inverse.null().is_none());
            // Tolerance: a few roundings in each of two products of three terms.
            assert!(largest(matrix * inverse.mul_vec3(v) - v) < 4e-6, "{values}");
        }
    }

    #[test]
    fn directions_that_a_singular_matrix_does_not_reach_stay_zero() {
        let v = Vec3::new(0.3, -2.0, 0.8);
        for values in [
            Vec3::new(1.0, 2.0, 0.0),
            Vec3::new(0.0, 1e-8, 2e-9),
            Vec3::new(0.0, 5.0, 0.0),
            Vec3::new(0.0, 0.0, 2e-12),
            Vec3::ZERO,
        ] {
            let (frame, matrix) = with_eigenvalues(values);
            let inverse = matrix.inverse();
            let null = inverse.null().expect("it is singular");
            let in_frame = |v: Vec3| frame.transpose() * v;
            let along = in_frame(v);
            let expected = |of: fn(f32, f32) -> f32| {
                Vec3::new(of(values.x, along.x), of(values.y, along.y), of(values.z, along.z))
            };
            let divided = expected(|value, along| if value > 0.0 { along / value } else { 0.0 });
            let left = expected(|value, along| if value > 0.0 { 0.0 } else { along });
            // Tolerance: rounding of the matrix, amplified by the ratio of its eigenvalues.
            let size = largest(divided).max(f32::MIN_POSITIVE);
            assert!(largest(in_frame(inverse.mul_vec3(v)) - divided) < 4e-6 * size, "{values}");
            assert!(largest(in_frame(null * v) - left) < 4e-6, "{values}");
        }
    }

    #[test]
    fn the_range_of_f32_gives_no_nan() {
        let sizes = [0.0, 1e-45, 1e-38, 1e-30, 1.0, 1e30, 1e38, f32::MAX];
        let pairs = || sizes.iter().flat_map(|a| sizes.iter().map(move |b| (*a, *b)));
        for ((x, y), z) in pairs().flat_map(|pair| sizes.iter().map(move |z| (pair, *z))) {
            let v = Vec3::new(0.6, -0.48, 0.64) * math::sqrt(z);
            let line = Symmetric::from_outer(v, v * 0.5);
            for matrix in [Symmetric { xx: x, yy: y, zz: z, ..Symmetric::ZERO }, line] {
                let inverse = matrix.inverse();
                assert!(inverse.mul_vec3(Vec3::ZERO).is_finite(), "{matrix:?}");
                if let Some(null) = inverse.null() {
                    assert!((null * Vec3::ONE).is_finite(), "{matrix:?}");
                }
            }
        }
    }
}
