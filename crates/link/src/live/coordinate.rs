//! Coordinates of a joint in a pose: checks, interpolation between two poses, and steps limited by the largest speed.

use sinew_core::glam::Quat;
use sinew_core::math;

use super::LiveRefusal;

/// Maximum absolute coordinate and speed, equal to the core's: later results cannot overflow.
pub(super) const LARGEST: f32 = 1e6;

/// A joint, or a part of a joint, with the maximum speed of its target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coordinate {
    /// A single number: an angle, or a displacement.
    Scalar {
        /// Maximum speed, rad/s or m/s.
        speed: f32,
    },
    /// Four numbers: a unit quaternion xyzw.
    Rotation {
        /// Maximum speed, rad/s.
        speed: f32,
    },
}

impl Coordinate {
    /// Returns the number of coordinates.
    pub const fn len(self) -> usize {
        match self {
            Self::Scalar { .. } => 1,
            Self::Rotation { .. } => 4,
        }
    }

    /// Returns `false`: every joint has a coordinate.
    pub const fn is_empty(self) -> bool {
        false
    }

    pub(super) const fn speed(self) -> f32 {
        match self {
            Self::Scalar { speed } | Self::Rotation { speed } => speed,
        }
    }

    /// Checks the numbers of a joint. `first` is the index of its first number in the pose.
    pub(super) fn check(self, numbers: &[f32], first: usize) -> Result<(), LiveRefusal> {
        if let Some(place) =
            numbers.iter().position(|number| number.is_nan() || number.abs() > LARGEST)
        {
            return Err(LiveRefusal::Number { coordinate: first.saturating_add(place) });
        }
        match (self, numbers) {
            (Self::Rotation { .. }, &[x, y, z, w]) => {
                let q = Quat::from_xyzw(x, y, z, w);
                // Tolerance for six digits, the usual precision of files.
                if (q.dot(q) - 1.0).abs() <= 2e-3 {
                    Ok(())
                } else {
                    Err(LiveRefusal::NotUnit { coordinate: first })
                }
            }
            _ => Ok(()),
        }
    }

    /// Moves `target` towards the pose at `part` between `a` (0) and `b` (1), by at most `speed` times `tick_s`.
    /// Returns `true` if the limit applied.
    pub(super) fn follow(
        self,
        target: &mut [f32],
        (a, b): (&[f32], &[f32]),
        part: f32,
        tick_s: f32,
    ) -> bool {
        let most = self.speed() * tick_s;
        match (target, a, b) {
            ([target], &[a], &[b]) => {
                let wanted = a + (b - a) * part;
                let limited = (wanted - *target).abs() > most;
                *target = if !limited {
                    wanted
                } else if wanted > *target {
                    *target + most
                } else {
                    *target - most
                };
                limited
            }
            ([x, y, z, w], &[ax, ay, az, aw], &[bx, by, bz, bw]) => {
                let target = Quat::from_xyzw(*x, *y, *z, *w);
                let a = math::unit(Quat::from_xyzw(ax, ay, az, aw));
                let b = math::unit(Quat::from_xyzw(bx, by, bz, bw));
                let wanted = math::slerp(a, b, part);
                let turn = math::log(target.conjugate() * wanted);
                let angle = math::length(turn);
                let limited = angle > most;
                let next = if limited { math::slerp(target, wanted, most / angle) } else { wanted };
                // The nearer sign: q and -q are the same rotation, but a change of sign would be a jump in the
                // numbers.
                let next = if target.dot(next) < 0.0 { -next } else { next };
                (*x, *y, *z, *w) = (next.x, next.y, next.z, next.w);
                limited
            }
            _ => false,
        }
    }
}
