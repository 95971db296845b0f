//! Numbers, vectors, matrices, rotations and states of several instants or rigs, which loops over them read and write.
//! The compiler turns these loops into vector instructions.

use glam::{Mat3, Quat, Vec3};
use sinew_core::{BodyState, Inertia, RotationalInertia, Transform, Twist};

/// A number in each lane.
pub(crate) type Numbers<const L: usize> = [f32; L];

/// A vector in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vectors<const L: usize> {
    x: Numbers<L>,
    y: Numbers<L>,
    z: Numbers<L>,
}

impl<const L: usize> Vectors<L> {
    pub(crate) const ZERO: Self = Self::all(Vec3::ZERO);

    /// Returns the same vector for all lanes.
    pub(crate) const fn all(v: Vec3) -> Self {
        Self { x: [v.x; L], y: [v.y; L], z: [v.z; L] }
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

/// A matrix in each lane, by columns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Matrices<const L: usize>([Vectors<L>; 3]);

impl<const L: usize> Matrices<L> {
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

/// A rotation in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rotations<const L: usize> {
    vectors: Vectors<L>,
    w: Numbers<L>,
}

impl<const L: usize> Rotations<L> {
    pub(crate) const IDENTITY: Self = Self { vectors: Vectors::ZERO, w: [1.0; L] };

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> Quat {
        let v = self.vectors.at(lane);
        Quat::from_xyzw(v.x, v.y, v.z, self.w[lane])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, q: Quat) {
        self.vectors.set(lane, Vec3::new(q.x, q.y, q.z));
        self.w[lane] = q.w;
    }
}

/// A pose in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Poses<const L: usize> {
    pub(crate) rotation: Rotations<L>,
    translation_m: Vectors<L>,
}

impl<const L: usize> Poses<L> {
    pub(crate) const IDENTITY: Self =
        Self { rotation: Rotations::IDENTITY, translation_m: Vectors::ZERO };

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> Transform {
        Transform::new(self.rotation.at(lane), self.translation_m.at(lane))
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, pose: Transform) {
        self.rotation.set(lane, pose.rotation);
        self.translation_m.set(lane, pose.translation_m);
    }
}

/// A velocity or an acceleration in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Twists<const L: usize> {
    pub(crate) angular: Vectors<L>,
    pub(crate) linear: Vectors<L>,
}

impl<const L: usize> Twists<L> {
    pub(crate) const ZERO: Self = Self { angular: Vectors::ZERO, linear: Vectors::ZERO };

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> Twist {
        Twist::new(self.angular.at(lane), self.linear.at(lane))
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, twist: Twist) {
        self.angular.set(lane, twist.angular);
        self.linear.set(lane, twist.linear);
    }
}

/// Pose and velocity of a body or a joint in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct States<const L: usize> {
    pub(crate) pose: Poses<L>,
    pub(crate) velocity: Twists<L>,
}

impl<const L: usize> States<L> {
    pub(crate) const REST: Self = Self { pose: Poses::IDENTITY, velocity: Twists::ZERO };

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> BodyState {
        BodyState { pose: self.pose.at(lane), velocity: self.velocity.at(lane) }
    }
}

/// Inertias of one body of a rig, in each lane.
pub(crate) trait Inertias {
    fn of_lane(&self, lane: usize) -> Inertia;
}

/// All lanes have the same rig.
impl Inertias for Inertia {
    #[inline(always)]
    fn of_lane(&self, _: usize) -> Inertia {
        *self
    }
}

/// Each lane has its own rig.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OwnInertias<const L: usize> {
    mass_kg: Numbers<L>,
    center_of_mass_m: Vectors<L>,
    /// Moments of inertia, then products of inertia: xx, yy, zz, xy, xz, yz.
    moments_kg_m2: Vectors<L>,
    products_kg_m2: Vectors<L>,
}

impl<const L: usize> OwnInertias<L> {
    pub(crate) fn new(inertias: [&Inertia; L]) -> Self {
        let mut own = Self {
            mass_kg: [0.0; L],
            center_of_mass_m: Vectors::ZERO,
            moments_kg_m2: Vectors::ZERO,
            products_kg_m2: Vectors::ZERO,
        };
        for (lane, inertia) in inertias.into_iter().enumerate() {
            let RotationalInertia { xx, xy, xz, yy, yz, zz } = inertia.rotational_kg_m2;
            own.mass_kg[lane] = inertia.mass_kg;
            own.center_of_mass_m.set(lane, inertia.center_of_mass_m);
            own.moments_kg_m2.set(lane, Vec3::new(xx, yy, zz));
            own.products_kg_m2.set(lane, Vec3::new(xy, xz, yz));
        }
        own
    }
}

impl<const L: usize> Inertias for OwnInertias<L> {
    #[inline(always)]
    fn of_lane(&self, lane: usize) -> Inertia {
        let ([xx, yy, zz], [xy, xz, yz]) =
            (self.moments_kg_m2.at(lane).to_array(), self.products_kg_m2.at(lane).to_array());
        Inertia {
            mass_kg: self.mass_kg[lane],
            center_of_mass_m: self.center_of_mass_m.at(lane),
            rotational_kg_m2: RotationalInertia { xx, xy, xz, yy, yz, zz },
        }
    }
}
