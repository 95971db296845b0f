//! Vectors and rotations of [`Number`]s, with the core's operations.

use std::f64::consts::PI;
use std::ops::{Add, Mul, Neg, Sub};

use glam::{DQuat, DVec3, Quat, Vec3};

use super::number::Number;

/// A vector of three numbers.
#[derive(Debug, Clone, Copy)]
pub struct Vector {
    /// Component along x.
    pub x: Number,
    /// Component along y.
    pub y: Number,
    /// Component along z.
    pub z: Number,
}

impl Vector {
    /// The zero vector.
    pub const ZERO: Self = Self { x: Number::ZERO, y: Number::ZERO, z: Number::ZERO };

    /// Creates a vector that f32 represents exactly.
    pub fn known(v: Vec3) -> Self {
        Self::by(v.as_dvec3(), Number::known)
    }

    /// Creates an input, which f32 represents by the nearest vector.
    pub fn given(v: DVec3) -> Self {
        Self::by(v, Number::given)
    }

    /// Creates a vector along one axis.
    pub fn along(axis: usize, number: Number) -> Self {
        let o = Number::ZERO;
        match axis {
            0 => Self { x: number, y: o, z: o },
            1 => Self { x: o, y: number, z: o },
            _ => Self { x: o, y: o, z: number },
        }
    }

    fn by(v: DVec3, number: impl Fn(f64) -> Number) -> Self {
        Self { x: number(v.x), y: number(v.y), z: number(v.z) }
    }

    /// Returns the components.
    pub fn components(self) -> [Number; 3] {
        [self.x, self.y, self.z]
    }

    /// Returns the vector without rounding.
    pub fn exact(&self) -> DVec3 {
        DVec3::new(self.x.exact(), self.y.exact(), self.z.exact())
    }

    /// Returns the limit of the error of the whole vector.
    pub fn limit(&self) -> f64 {
        DVec3::new(self.x.limit(), self.y.limit(), self.z.limit()).length()
    }

    /// Returns the dot product.
    pub fn dot(self, other: Self) -> Number {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Returns the cross product.
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self::ZERO.plus_cross(self, other)
    }

    /// Returns `self + a × b`.
    #[must_use]
    pub fn plus_cross(self, a: Self, b: Self) -> Self {
        Self {
            x: self.x + a.y * b.z - a.z * b.y,
            y: self.y + a.z * b.x - a.x * b.z,
            z: self.z + a.x * b.y - a.y * b.x,
        }
    }

    /// Returns the length.
    pub fn length(self) -> Number {
        self.dot(self).sqrt()
    }

    /// Multiplies by a power of two, which does not round.
    #[must_use]
    pub fn doubled(self, times: f64) -> Self {
        let [x, y, z] = self.components().map(|component| component.doubled(times));
        Self { x, y, z }
    }
}

impl Add for Vector {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl Sub for Vector {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl Mul<Number> for Vector {
    type Output = Self;

    fn mul(self, factor: Number) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl Neg for Vector {
    type Output = Self;

    fn neg(self) -> Self {
        self.doubled(-1.0)
    }
}

/// A unit quaternion.
#[derive(Debug, Clone, Copy)]
pub struct Rotation {
    v: Vector,
    w: Number,
}

impl Rotation {
    /// Returns the identity.
    pub fn identity() -> Self {
        Self { v: Vector::ZERO, w: Number::known(1.0) }
    }

    /// Creates a rotation from its vector part and its scalar part.
    pub fn of(v: Vector, w: Number) -> Self {
        Self { v, w }
    }

    /// Creates an input, which f32 represents by the nearest numbers, normalized.
    pub fn given(q: DQuat) -> Self {
        let number = Number::given;
        Self { v: Vector::given(DVec3::new(q.x, q.y, q.z)), w: number(q.w) }.unit()
    }

    /// Creates a rotation from its f32 quaternion, which is unit up to rounding.
    pub fn known(q: Quat) -> Self {
        let unit = q.as_dquat().normalize();
        let [x, y, z, w] = [(unit.x, q.x), (unit.y, q.y), (unit.z, q.z), (unit.w, q.w)]
            .map(|(exact, in_f32)| Number::near(exact, in_f32));
        Self { v: Vector { x, y, z }, w }
    }

    /// Returns the rotation without rounding.
    pub fn exact(&self) -> DQuat {
        let v = self.v.exact();
        DQuat::from_xyzw(v.x, v.y, v.z, self.w.exact())
    }

    /// Returns the limit of the angle's error: twice that of the quaternion, because a small angle is twice the length
    /// of the vector part.
    pub fn limit(&self) -> f64 {
        2.0 * self.v.limit().hypot(self.w.limit())
    }

    /// Returns the inverse.
    #[must_use]
    pub fn inverse(self) -> Self {
        Self { v: -self.v, w: self.w }
    }

    /// Returns the product, `other` first. The order of the sums keeps terms that cancel each other apart; the core may
    /// use this order or another.
    #[must_use]
    pub fn after(self, other: Self) -> Self {
        let (a, b) = (self, other);
        Self { v: (b.v * a.w).plus_cross(a.v, b.v) + a.v * b.w, w: a.w * b.w - a.v.dot(b.v) }
    }

    /// Returns the rotation normalized.
    #[must_use]
    pub fn unit(self) -> Self {
        let number = Number::known;
        let excess = self.v.dot(self.v) + self.w * self.w - number(1.0);
        let share = excess * (number(0.375) * excess - number(0.5));
        Self { v: self.v + self.v * share, w: self.w + self.w * share }
    }

    /// Rotates a vector.
    #[must_use]
    pub fn turn(self, v: Vector) -> Vector {
        let t = self.v.cross(v.doubled(2.0));
        (v + t * self.w).plus_cross(self.v, t)
    }

    /// Returns the rotation vector, with an angle within [0, π].
    pub fn log(self) -> Vector {
        // All lanes use one of the two quaternions of the rotation.
        let Self { v, w } =
            if self.w.exact() < 0.0 { Self { v: -self.v, w: -self.w } } else { self };
        let scale = v.length().function_with(w, |sine, cosine| {
            if sine > 0.0 { 2.0 * sine.atan2(cosine) / sine } else { 2.0 / cosine }
        });
        v * scale
    }

    /// Returns the rotation of a rotation vector.
    pub fn exp(vector: Vector) -> Self {
        let half = vector.doubled(0.5);
        let angle = half.length();
        let share = angle.function(|angle| if angle > 0.0 { angle.sin() / angle } else { 1.0 });
        Self { v: half * share, w: angle.function(f64::cos) }
    }

    /// Returns the rotation matrix.
    pub fn matrix(self) -> Matrix {
        let Self { v: Vector { x, y, z }, w } = self;
        let [x2, y2, z2] = [x, y, z].map(|component| component.doubled(2.0));
        let (xx, xy, xz, yy, yz, zz) = (x * x2, x * y2, x * z2, y * y2, y * z2, z * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        let one = Number::known(1.0);
        Matrix {
            columns: [
                Vector { x: one - (yy + zz), y: xy + wz, z: xz - wy },
                Vector { x: xy - wz, y: one - (xx + zz), z: yz + wx },
                Vector { x: xz + wy, y: yz - wx, z: one - (xx + yy) },
            ],
        }
    }
}

/// A matrix of three columns.
#[derive(Debug, Clone, Copy)]
pub struct Matrix {
    columns: [Vector; 3],
}

impl Matrix {
    /// Creates a matrix from its columns.
    pub fn of_columns(columns: [Vector; 3]) -> Self {
        Self { columns }
    }

    /// Returns a column by its index.
    pub fn column(&self, k: usize) -> Vector {
        self.columns[k]
    }

    /// Returns the product, `other` first.
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        other.map_columns(|_, column| self.turn(column))
    }

    /// Applies a function to each column and its index.
    #[must_use]
    pub fn map_columns(&self, mut of: impl FnMut(usize, Vector) -> Vector) -> Self {
        let [x, y, z] = self.columns;
        Self { columns: [of(0, x), of(1, y), of(2, z)] }
    }

    /// Returns the transpose.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let [x, y, z] = self.columns.map(Vector::components);
        let column = |k: usize| Vector { x: x[k], y: y[k], z: z[k] };
        Self { columns: [column(0), column(1), column(2)] }
    }

    /// Returns the sum.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        self.map_columns(|k, column| column + other.columns[k])
    }

    /// Multiplies by a vector.
    #[must_use]
    pub fn turn(&self, v: Vector) -> Vector {
        let [x, y, z] = self.columns;
        x * v.x + y * v.y + z * v.z
    }

    /// Multiplies the transpose by a vector.
    #[must_use]
    pub fn turn_back(&self, v: Vector) -> Vector {
        let [x, y, z] = self.columns.map(|column| column.dot(v));
        Vector { x, y, z }
    }
}

/// Returns the length of the difference of two rotation vectors. Near π a rounding may invert the axis; the
/// rotation is equal up to that rounding, and therefore its second rotation vector is compared too.
pub fn turn_error(got: DVec3, expected: DVec3) -> f64 {
    if !got.is_finite() {
        return f64::INFINITY;
    }
    let angle = expected.length();
    let same = (got - expected).length();
    if angle < PI - 1e-3 {
        return same;
    }
    let other_way_round = expected * (1.0 - 2.0 * PI / angle);
    same.min((got - other_way_round).length())
}
