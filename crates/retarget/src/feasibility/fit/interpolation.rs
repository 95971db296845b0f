//! Interpolation between rows.

/// Interpolates between evenly spaced values; beyond the ends, the first or last value is returned.
pub(super) fn interpolated(values: &[f64], place: f64) -> f64 {
    let last = values.len().saturating_sub(1);
    let place = place.clamp(0.0, last as f64);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "within the values"
    )]
    let index = place.floor() as usize;
    let [from, to] =
        [index, (index + 1).min(last)].map(|index| values.get(index).copied().unwrap_or(0.0));
    from + (place - index as f64) * (to - from)
}
