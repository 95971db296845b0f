//! Bounds of characters: larger files and coordinates are damage.

use glam::DVec3;

/// Far above any character's: what bounds the memory that a small file can ask for.
pub(super) const JOINT_COUNT_MAX: usize = 1024;

/// Larger coordinates are damage: no character is a hundred kilometres large.
pub(crate) const COORDINATE_MAX_M: f64 = 1e5;

/// Whether a place can be one of a character's; NaN cannot.
pub(super) fn is_place(position_m: DVec3) -> bool {
    position_m.abs().max_element() <= COORDINATE_MAX_M && position_m.is_finite()
}

pub(super) const A_PLACE: &str = "finite coordinates of at most 100000 m";
