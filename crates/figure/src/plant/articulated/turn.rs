//! Rotations of a time step, computed by the operations of glam with libm, without branches: loops over mechanisms
//! become vector instructions.

use glam::{DQuat, DVec3};

/// Half of the largest angle, rad, that [`small_turn`] accepts: just below π/4, up to which libm computes sine and
/// cosine by its polynomials alone.
const MOST_HALF_RAD: f64 = 0.785;

/// Returns the rotation about a vector by its length, and whether the result is that of `DQuat::from_scaled_axis` to
/// the last bit. It is for all angles up to [`MOST_HALF_RAD`] times two.
#[inline(always)]
pub(super) fn small_turn(v: DVec3) -> (DQuat, bool) {
    let length = v.dot(v).sqrt();
    let half = length * 0.5;
    let turned = v / length * sine(half);
    let turn = DQuat::from_xyzw(turned.x, turned.y, turned.z, cosine(half));
    // Without a rotation, there is no axis.
    (if length == 0.0 { DQuat::IDENTITY } else { turn }, half <= MOST_HALF_RAD)
}

/// Returns the unit quaternion in the direction of `q`, like `DQuat::normalize`.
#[inline(always)]
pub(super) fn unit(q: DQuat) -> DQuat {
    q * (1.0 / q.dot(q).sqrt())
}

/// Computes libm's polynomial of the sine.
#[inline(always)]
fn sine(x: f64) -> f64 {
    let z = x * x;
    let w = z * z;
    let r = 8.333_333_333_322_49e-3
        + z * (-1.984_126_982_985_795e-4 + z * 2.755_731_370_707_006_8e-6)
        + z * w * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10);
    let v = z * x;
    x + v * (-1.666_666_666_666_663_2e-1 + z * r)
}

/// Computes libm's polynomial of the cosine.
#[inline(always)]
fn cosine(x: f64) -> f64 {
    let z = x * x;
    let w = z * z;
    let r = z
        * (4.166_666_666_666_66e-2
            + z * (-1.388_888_888_887_411e-3 + z * 2.480_158_728_947_673e-5))
        + w * w
            * (-2.755_731_435_139_066_3e-7
                + z * (2.087_572_321_298_175e-9 + z * -1.135_964_755_778_819_5e-11));
    let half_z = 0.5 * z;
    let w = 1.0 - half_z;
    w + (((1.0 - w) - half_z) + z * r)
}
