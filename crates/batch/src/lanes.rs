//! Vectors and matrices of several instants, which loops over the instants read and write. The compiler turns these
//! loops into vector instructions.

use glam::{Mat3, Vec3};

/// Number of instants that are computed at once: the widest vector registers hold this number of f32.
pub const LANES: usize = 16;

/// A number for each instant.
pub(crate) type Numbers = [f32; LANES];

/// A vector for each instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vectors {
    x: Numbers,
    y: Numbers,
    z: Numbers,
}

impl Vectors {
    pub(crate) const ZERO: Self = Self::all(Vec3::ZERO);

    /// Returns the same vector for all instants.
    pub(crate) const fn all(v: Vec3) -> Self {
        Self { x: [v.x; LANES], y: [v.y; LANES], z: [v.z; LANES] }
    }

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, v: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (v.x, v.y, v.z);
    }
}

/// A matrix for each instant, by columns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Matrices([Vectors; 3]);

impl Matrices {
    pub(crate) const ZERO: Self = Self([Vectors::ZERO; 3]);

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> Mat3 {
        let [x, y, z] = &self.0;
        Mat3::from_cols(x.at(lane), y.at(lane), z.at(lane))
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, m: Mat3) {
        let [x, y, z] = &mut self.0;
        x.set(lane, m.x_axis);
        y.set(lane, m.y_axis);
        z.set(lane, m.z_axis);
    }
}
