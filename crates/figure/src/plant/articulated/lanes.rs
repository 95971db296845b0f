//! Numbers, vectors, matrices and rotations of several mechanisms, which loops over the mechanisms read and write. The
//! compiler turns these loops into vector instructions.

use glam::{DMat3, DQuat, DVec3};

/// A vector of each mechanism.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vectors<const L: usize> {
    x: [f64; L],
    y: [f64; L],
    z: [f64; L],
}

/// A matrix of each mechanism, by columns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Matrices<const L: usize>([Vectors<L>; 3]);

/// A rotation of each mechanism.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rotations<const L: usize> {
    vectors: Vectors<L>,
    w: [f64; L],
}

impl<const L: usize> Vectors<L> {
    pub(super) const ZERO: Self = Self { x: [0.0; L], y: [0.0; L], z: [0.0; L] };

    #[inline(always)]
    pub(super) fn at(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, v: DVec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (v.x, v.y, v.z);
    }
}

impl<const L: usize> Matrices<L> {
    pub(super) const ZERO: Self = Self([Vectors::ZERO; 3]);

    #[inline(always)]
    pub(super) fn at(&self, lane: usize) -> DMat3 {
        let [x, y, z] = &self.0;
        DMat3::from_cols(x.at(lane), y.at(lane), z.at(lane))
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, m: DMat3) {
        let [x, y, z] = &mut self.0;
        x.set(lane, m.x_axis);
        y.set(lane, m.y_axis);
        z.set(lane, m.z_axis);
    }
}

impl<const L: usize> Rotations<L> {
    pub(super) const IDENTITY: Self = Self { vectors: Vectors::ZERO, w: [1.0; L] };

    #[inline(always)]
    pub(super) fn at(&self, lane: usize) -> DQuat {
        let v = self.vectors.at(lane);
        DQuat::from_xyzw(v.x, v.y, v.z, self.w[lane])
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, q: DQuat) {
        self.vectors.set(lane, DVec3::new(q.x, q.y, q.z));
        self.w[lane] = q.w;
    }
}
