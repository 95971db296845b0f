//! Units of values, derived from the ending of their key.

use super::error::Step;

/// Endings of keys, the longer first, and how the unit is displayed.
const UNITS: [(&str, &str); 21] = [
    // Keys whose unit has both an angle and a length are not displayed with a unit.
    ("_deg_m", ""),
    ("_kg_m2", "kg m²"),
    ("_deg_s2", "deg/s²"),
    ("_deg_s", "deg/s"),
    ("_deg", "deg"),
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_nm_rad", "N m/rad"),
    ("_nm_s", "N m s"),
    ("_nm_a", "N m/A"),
    ("_rad_s", "rad/s"),
    ("_rad", "rad"),
    ("_us", "us"),
    ("_k_w", "K/W"),
    ("_kg", "kg"),
    ("_nm", "N m"),
    ("_v", "V"),
    ("_a", "A"),
    ("_s", "s"),
    ("_m", "m"),
    ("_c", "°C"),
];

/// Returns the unit of a key's values, if its ending is known.
fn unit(key: &str) -> Option<&'static str> {
    UNITS.iter().find(|(end, _)| key.ends_with(end)).map(|(_, unit)| *unit)
}

/// Returns the unit of a path: that of the innermost key with a unit, otherwise empty.
pub(super) fn unit_at(path: &[Step]) -> &'static str {
    let of_step = |step: &Step| match step {
        Step::Key(key) => unit(key),
        Step::Index(_) => None,
    };
    path.iter().rev().find_map(of_step).unwrap_or("")
}

/// Returns whether a key's values are degrees in the file and radians in memory.
pub(crate) fn is_angle(key: &str) -> bool {
    unit(key).is_some_and(|unit| unit.starts_with("deg"))
}
