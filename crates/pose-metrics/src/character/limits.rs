//! Limits of characters. Larger files and coordinates indicate damage.

use glam::DVec3;

/// Maximum number of joints, far above any character's. It limits the memory that a small file can request.
pub(super) const JOINT_COUNT_MAX: usize = 1024;

/// Maximum coordinate, m. Larger coordinates indicate damage: no character is a hundred kilometres large.
pub(crate) const COORDINATE_MAX_M: f64 = 1e5;

/// Returns whether a position is plausible for a character; false for NaN.
pub(super) fn is_place(position_m: DVec3) -> bool {
    position_m.abs().max_element() <= COORDINATE_MAX_M && position_m.is_finite()
}

pub(super) const A_PLACE: &str = "finite coordinates of at most 100000 m";
