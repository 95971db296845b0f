//! Numbers and vectors of several instants, computed side by side.

use std::array::from_fn;
use std::ops::{Add, Mul, Neg, Sub};

use glam::{Quat, Vec3};
use sinew_core::math;

/// Number of instants that are computed side by side: a vector register of any 64-bit processor holds four f32.
pub const LANES: usize = 4;

/// A number for each instant. Each operation is applied to every instant alone and in the written order, so that
/// the bits of the results equal those of a scalar computation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lanes(pub(super) [f32; LANES]);

impl Lanes {
    pub(super) const ZERO: Self = Self([0.0; LANES]);

    /// Returns the same number for all instants.
    #[inline]
    pub(super) fn all(number: f32) -> Self {
        Self([number; LANES])
    }
}

impl Add for Lanes {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane] + other.0[lane]))
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane] - other.0[lane]))
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane] * other.0[lane]))
    }
}

impl Neg for Lanes {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(self.0.map(|number| -number))
    }
}

/// A vector for each instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vectors {
    pub(super) x: Lanes,
    pub(super) y: Lanes,
    pub(super) z: Lanes,
}

impl Vectors {
    pub(super) const ZERO: Self = Self { x: Lanes::ZERO, y: Lanes::ZERO, z: Lanes::ZERO };

    /// Returns the same vector for all instants.
    #[inline]
    pub(super) fn all(vector: Vec3) -> Self {
        Self { x: Lanes::all(vector.x), y: Lanes::all(vector.y), z: Lanes::all(vector.z) }
    }

    pub(super) fn of(vectors: [Vec3; LANES]) -> Self {
        let [x, y, z] = [0, 1, 2].map(|k| Lanes(vectors.map(|vector| vector[k])));
        Self { x, y, z }
    }

    #[inline]
    pub(super) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Returns `self + a × b`, adding one product after the other.
    #[inline]
    pub(super) fn plus_cross(self, a: Self, b: Self) -> Self {
        Self {
            x: self.x + a.y * b.z - a.z * b.y,
            y: self.y + a.z * b.x - a.x * b.z,
            z: self.z + a.x * b.y - a.y * b.x,
        }
    }

    #[inline]
    pub(super) fn dot(self, other: Self) -> Lanes {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
}

impl Add for Vectors {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl Mul<Lanes> for Vectors {
    type Output = Self;

    #[inline]
    fn mul(self, factor: Lanes) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

/// A rotation for each instant, as a quaternion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quaternions {
    pub(super) x: Lanes,
    pub(super) y: Lanes,
    pub(super) z: Lanes,
    pub(super) w: Lanes,
}

impl Quaternions {
    pub(super) fn of(rotations: [Quat; LANES]) -> Self {
        Self {
            x: Lanes(rotations.map(|rotation| rotation.x)),
            y: Lanes(rotations.map(|rotation| rotation.y)),
            z: Lanes(rotations.map(|rotation| rotation.z)),
            w: Lanes(rotations.map(|rotation| rotation.w)),
        }
    }

    /// Returns rotations about an axis by these angles. Equals `math::exp`, and uses its polynomials if all angles
    /// are at most 90 deg.
    #[inline]
    pub(super) fn about(axis: Vec3, angles: Lanes) -> Self {
        let v = Vectors::all(axis) * angles * Lanes::all(0.5);
        let squared = v.dot(v);
        // The comparison also excludes NaN.
        if !squared.0.iter().all(|squared| *squared <= EIGHTH * EIGHTH) {
            return Self::of(angles.0.map(|angle| math::exp(axis * angle)));
        }
        let [one, a, b, c] = [1.0, -0.166_666_55, 0.008_332_1, 1.950_396_4e-4].map(Lanes::all);
        let sine_over_angle = one + squared * (a + squared * (b - squared * c));
        let [a, b, c, d] = [0.5, 0.041_666_653, -0.001_388_765_4, 2.446_383_4e-5].map(Lanes::all);
        let cosine = one - squared * (a - squared * (b + squared * (c + squared * d)));
        let Vectors { x, y, z } = v * sine_over_angle;
        Self { x, y, z, w: cosine }
    }

    /// Applies one outer rotation to each rotation.
    #[inline]
    pub(super) fn behind(self, outer: Quat) -> Self {
        let [x0, y0, z0, w0] = outer.to_array().map(Lanes::all);
        let Self { x: x1, y: y1, z: z1, w: w1 } = self;
        Self {
            x: w0 * x1 + x0 * w1 + y0 * z1 - z0 * y1,
            y: w0 * y1 - x0 * z1 + y0 * w1 + z0 * x1,
            z: w0 * z1 + x0 * y1 - y0 * x1 + z0 * w1,
            w: w0 * w1 - x0 * x1 - y0 * y1 - z0 * z1,
        }
    }

    /// Normalizes each quaternion to length 1.
    #[inline]
    pub(super) fn unit(self) -> Self {
        let Self { x, y, z, w } = self;
        let squared = x * x + y * y + z * z + w * w;
        let excess = squared - Lanes::all(1.0);
        if excess.0.iter().any(|excess| excess.abs() >= NEAR || excess.is_nan()) {
            return Self::of(from_fn(|k| {
                math::unit(Quat::from_xyzw(x.0[k], y.0[k], z.0[k], w.0[k]))
            }));
        }
        let share = excess * (Lanes::all(0.375) * excess - Lanes::all(0.5));
        Self { x: x + x * share, y: y + y * share, z: z + z * share, w: w + w * share }
    }
}

/// An eighth of a turn, rad: half of the largest angle for which `math::exp` uses a polynomial.
const EIGHTH: f32 = 0.25 * math::PI;

/// Distance of a squared length from 1 up to which `math::unit` uses a series.
const NEAR: f32 = 2e-3;

/// A rotation for each instant, as a matrix of three columns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Matrices([Vectors; 3]);

impl Matrices {
    pub(super) const ZERO: Self = Self([Vectors::ZERO; 3]);

    #[inline]
    pub(super) fn of(rotation: Quaternions) -> Self {
        let Quaternions { x, y, z, w } = rotation;
        let [x2, y2, z2] = [x + x, y + y, z + z];
        let [xx, xy, xz] = [x * x2, x * y2, x * z2];
        let [yy, yz, zz] = [y * y2, y * z2, z * z2];
        let [wx, wy, wz] = [w * x2, w * y2, w * z2];
        let one = Lanes::all(1.0);
        Self([
            Vectors { x: one - (yy + zz), y: xy + wz, z: xz - wy },
            Vectors { x: xy - wz, y: one - (xx + zz), z: yz + wx },
            Vectors { x: xz + wy, y: yz - wx, z: one - (xx + yy) },
        ])
    }

    #[inline]
    pub(super) fn turn(&self, v: Vectors) -> Vectors {
        let [a, b, c] = self.0;
        a * v.x + b * v.y + c * v.z
    }

    /// Rotates by the inverse, which is the transposed matrix. It is bit by bit equal to the matrix of the
    /// conjugate quaternion.
    #[inline]
    pub(super) fn turn_back(&self, v: Vectors) -> Vectors {
        let [a, b, c] = self.0;
        Vectors {
            x: a.x * v.x + a.y * v.y + a.z * v.z,
            y: b.x * v.x + b.y * v.y + b.z * v.z,
            z: c.x * v.x + c.y * v.y + c.z * v.z,
        }
    }
}
