//! The status light: it breathes while the control tick runs.

use micromath::F32Ext;

/// Duration of one breath, s: calm enough to be told from a fault's blinking.
pub const BREATH_S: f32 = 3.0;

/// Duty of the light's 8-bit PWM at a time in ms, 0 to 255.
///
/// The sine is micromath's, the one place where an approximation does no harm: its error is below half a
/// step of the duty (tested), nobody sees it, and no soft-float library is pulled in for a light.
///
/// ```
/// assert_eq!(sinew_firmware::indicator::breath(0), 0);
/// ```
pub fn breath(time_ms: u32) -> u8 {
    // In whole milliseconds first: a float of the time since boot would lose them within hours.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "3000 ms")]
    const PERIOD_MS: u32 = (BREATH_S * 1000.0) as u32;
    #[expect(clippy::cast_precision_loss, reason = "below 3000")]
    let phase = (time_ms % PERIOD_MS) as f32 / PERIOD_MS as f32;
    let level = 0.5 - 0.5 * F32Ext::cos(phase * core::f32::consts::TAU);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to 0..=255"
    )]
    let duty = (level * 255.0).clamp(0.0, 255.0) as u8;
    duty
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_approximation_is_within_one_step_of_the_duty() {
        for time_ms in 0..6000u16 {
            let phase = f64::from(time_ms) / 1000.0 / f64::from(BREATH_S);
            let exact = 255.0 * (0.5 - 0.5 * libm::cos(phase * core::f64::consts::TAU));
            let got = f64::from(breath(u32::from(time_ms)));
            // Cutting to a whole step loses up to one; micromath's cosine may add 0.002 * 127.5 = 0.26.
            assert!(got - exact < 0.26 && exact - got < 1.26, "{time_ms} ms: {got} {exact}");
        }
    }
}
