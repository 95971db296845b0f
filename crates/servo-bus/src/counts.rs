//! Numbers in counts of a servo, from SI units.

/// How many counts a servo can turn from one tick to the next, with a margin of two and two counts of noise either way.
///
/// The margin: what is read late in one tick may be read early in the next.
pub(crate) fn step_counts(speed_rad_s: f32, tick_us: u32, rad_per_count: f32) -> u32 {
    let counts = speed_rad_s * (tick_us as f32 * 1e-6) / rad_per_count;
    round(2.0 * counts + 4.0, [0, i32::MAX]).unsigned_abs()
}

/// The nearest whole number within bounds; NaN does not come here.
#[expect(
    clippy::cast_possible_truncation,
    reason = "`as` holds at the ends of i32, which is what is wanted"
)]
pub(crate) fn round(value: f32, [least, most]: [i32; 2]) -> i32 {
    let half = if value < 0.0 { -0.5 } else { 0.5 };
    ((value + half) as i32).max(least).min(most)
}

/// A limit in counts, rounded down: what is allowed is never exceeded. A millionth is left to the rounding of f32.
pub(crate) fn most_counts(limit: f32, scale: f32, ceiling: i32) -> i32 {
    round(limit / scale * (1.0 + 1e-6) - 0.5, [0, ceiling])
}

/// A speed as a goal of a profile: rounded up, so that the profile keeps up, and never 0, which would be no limit.
pub(crate) fn profile_counts(speed_rad_s: f32, scale: f32, most: i32) -> i32 {
    // Half a count up, but for the rounding of f32 of a speed that is a count already.
    round(speed_rad_s / scale + 0.499, [1, most])
}
