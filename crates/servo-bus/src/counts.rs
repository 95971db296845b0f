//! Converts SI units into whole counts of a servo.

/// Returns the maximum change of a position between two ticks, in counts.
///
/// The result contains a factor of two, because one reading may be late in its tick and the next early, and two
/// counts of noise for each reading.
pub(crate) fn step_counts(speed_rad_s: f32, tick_us: u32, rad_per_count: f32) -> u32 {
    let counts = speed_rad_s * (tick_us as f32 * 1e-6) / rad_per_count;
    round(2.0 * counts + 4.0, [0, i32::MAX]).unsigned_abs()
}

/// Rounds to the nearest whole number within the bounds. The callers exclude NaN.
#[expect(
    clippy::cast_possible_truncation,
    reason = "`as` holds at the ends of i32, which is what is wanted"
)]
pub(crate) fn round(value: f32, [least, most]: [i32; 2]) -> i32 {
    let half = if value < 0.0 { -0.5 } else { 0.5 };
    ((value + half) as i32).max(least).min(most)
}

/// Converts a limit to counts, rounded down so that the limit is never exceeded. Tolerates a millionth, for the
/// rounding of f32.
pub(crate) fn most_counts(limit: f32, scale: f32, ceiling: i32) -> i32 {
    round(limit / scale * (1.0 + 1e-6) - 0.5, [0, ceiling])
}

/// Converts a speed to the goal of a profile. Rounds up, so that the profile keeps up, and never returns 0, which means
/// "no limit".
pub(crate) fn profile_counts(speed_rad_s: f32, scale: f32, most: i32) -> i32 {
    // Slightly less than half a count, so that a speed that is already a whole count stays unchanged despite f32
    // rounding.
    round(speed_rad_s / scale + 0.499, [1, most])
}
