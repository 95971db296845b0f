//! The status light: it breathes while there is no fault, and blinks the number of a fault.

use micromath::F32Ext;

/// Duration of a breath, s: slow enough to be distinguished from a fault's blinking.
pub const BREATH_S: f32 = 3.0;

/// Returns the duty of the light's 8-bit PWM at a time in ms, 0 to 255.
///
/// The cosine is an approximation by micromath, so that no soft-float library is linked for a light. Its error is below
/// half a step of the duty (tested), which nobody sees. Nothing but the light may use such an approximation.
///
/// ```
/// assert_eq!(sinew_firmware::indicator::breath(0), 0);
/// ```
pub fn breath(time_ms: u32) -> u8 {
    // The remainder is computed in whole milliseconds first: a float of the time since boot would lose milliseconds
    // within hours.
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

/// Duration of a long blink, which counts ten, ms: on, then dark.
const LONG_MS: [u32; 2] = [900, 300];
/// Duration of a short blink, which counts one, ms: on, then dark.
const SHORT_MS: [u32; 2] = [250, 300];
/// Dark time between two numbers, ms.
const PAUSE_MS: u32 = 1800;

/// Returns the duty of the light at a time in ms, 0 to 255: it blinks the number of the first latched fault, or
/// breathes.
///
/// ```
/// use sinew_firmware::indicator::{breath, duty};
/// assert_eq!(duty(None, 700), breath(700));
/// // Twelve: a long blink, and two short ones.
/// let lit = |ms| duty(Some(12), ms) > 0;
/// assert!(lit(0) && lit(899) && !lit(900) && lit(1200) && !lit(1450) && lit(1750) && !lit(2000));
/// ```
pub fn duty(fault: Option<u8>, time_ms: u32) -> u8 {
    let Some(number) = fault else { return breath(time_ms) };
    let (tens, ones) = (u32::from(number / 10), u32::from(number % 10));
    let (long_ms, short_ms) = (LONG_MS[0] + LONG_MS[1], SHORT_MS[0] + SHORT_MS[1]);
    let of_tens_ms = tens * long_ms;
    let at_ms = time_ms % (of_tens_ms + ones * short_ms + PAUSE_MS);
    let is_lit = if at_ms < of_tens_ms {
        at_ms % long_ms < LONG_MS[0]
    } else {
        let of_ones_ms = at_ms - of_tens_ms;
        of_ones_ms < ones * short_ms && of_ones_ms % short_ms < SHORT_MS[0]
    };
    if is_lit { u8::MAX } else { 0 }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;

    #[test]
    fn the_approximation_is_within_one_step_of_the_duty() {
        for time_ms in 0..6000u16 {
            let phase = f64::from(time_ms) / 1000.0 / f64::from(BREATH_S);
            let exact = 255.0 * (0.5 - 0.5 * libm::cos(phase * core::f64::consts::TAU));
            let got = f64::from(breath(u32::from(time_ms)));
            // Truncation to a whole step loses up to one; micromath's cosine may add 0.002 * 127.5 = 0.26.
            assert!(got - exact < 0.26 && exact - got < 1.26, "{time_ms} ms: {got} {exact}");
        }
    }

    #[test]
    fn a_number_is_counted_in_blinks() {
        for number in 1..=99 {
            // Durations of the blinks of a number, ms.
            let mut lit = Vec::new();
            let mut dark = 0;
            for time_ms in 0.. {
                if duty(Some(number), time_ms) > 0 {
                    if dark > 0 || lit.is_empty() {
                        lit.push(0);
                    }
                    *lit.last_mut().expect("one was put") += 1;
                    dark = 0;
                } else {
                    dark += 1;
                    if dark == 1500 {
                        break;
                    }
                }
            }
            let long = lit.iter().filter(|ms| **ms == LONG_MS[0]).count();
            let short = lit.iter().filter(|ms| **ms == SHORT_MS[0]).count();
            assert_eq!((long + short, 10 * long + short), (lit.len(), number.into()));
        }
    }
}
