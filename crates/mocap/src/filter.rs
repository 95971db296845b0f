//! The zero-phase low-pass that takes sensor noise out of a recording.
//!
//! A second-order Butterworth filter runs over the signal forward and then backward, so that its
//! delays cancel (D. A. Winter, Biomechanics and Motor Control of Human Movement, 4th ed., section
//! 3.4.4). The cutoff is that of both passes together: the gain there is `1/sqrt(2)`.
//!
//! Rotations are filtered as quaternions, component by component, and made unit again. Where a
//! rotation turns by a few tenths of a radian within the filter's memory (about 30 ms at 6 Hz), the
//! weighted sum of its quaternions points along their mean rotation up to terms of third order in
//! that angle; what is lost in length, a term of second order, is restored.

use std::f64::consts::{PI, SQRT_2};

use glam::{DQuat, DVec3};

use crate::{Clip, JointSample};

/// A joint that turns so fast that its low-passed rotation is not defined.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "joint `{joint}` turns too fast near frame {frame} to be low-passed: its rotations cancel out"
)]
pub struct FilterError {
    /// Name of the joint.
    pub joint: String,
    /// The frame, in the clip as filtered.
    pub frame: usize,
}

/// A zero-phase low-pass for one sample rate.
#[derive(Debug, Clone, Copy)]
pub struct LowPass {
    pass: Biquad,
    /// Samples to go on for at both ends.
    padding: usize,
}

/// `y(k) = b (x(k) + 2 x(k-1) + x(k-2)) - a1 y(k-1) - a2 y(k-2)`: a low-pass of second order.
#[derive(Debug, Clone, Copy)]
struct Biquad {
    b: f64,
    a1: f64,
    a2: f64,
}

impl LowPass {
    /// A low-pass with gain `1/sqrt(2)` at `cutoff_hz`; `None` where the rate cannot hold it, at or
    /// above half of `rate_hz`.
    pub fn new(rate_hz: f64, cutoff_hz: f64) -> Option<Self> {
        if !(cutoff_hz > 0.0 && cutoff_hz < 0.5 * rate_hz && rate_hz.is_finite()) {
            return None;
        }
        // Two passes of corner c have the gain 1/(1 + (f/c)^4), so that c must lie above the cutoff
        // by the factor (sqrt(2) - 1)^(-1/4), 1/0.8022. The factor holds for the analog filter's
        // frequencies, tan(pi f / rate), to which the bilinear transform bends the real ones.
        let per_pass = (SQRT_2 - 1.0).sqrt().sqrt();
        let k = libm::tan(PI * cutoff_hz / rate_hz) / per_pass;
        // The bilinear transform of 1/(s^2 + sqrt(2) s + 1), s in units of the corner.
        let scale = (1.0 + SQRT_2 * k + k * k).recip();
        let pass = Biquad {
            b: k * k * scale,
            a1: 2.0 * (k * k - 1.0) * scale,
            a2: (1.0 - SQRT_2 * k + k * k) * scale,
        };
        // Three periods of the cutoff: the start of a pass has faded to below 1e-5 by then.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive, and saturates"
        )]
        let padding = (3.0 * rate_hz / cutoff_hz).ceil() as usize;
        Some(Self { pass, padding })
    }

    /// Low-passes a signal, in place. A constant stays as it is, to the bit.
    ///
    /// At both ends the signal goes on as its own odd reflection, which keeps value and slope.
    pub fn apply(&self, signal: &mut [f64]) {
        let (lone, _) = signal.as_chunks_mut::<1>();
        self.apply_to_all(lone);
    }

    /// Low-passes `K` signals side by side: a sample of one waits for the sample before, not for the other signals.
    fn apply_to_all<const K: usize>(&self, signals: &mut [[f64; K]]) {
        let n = signals.len();
        let (Some(&first), Some(&last)) = (signals.first(), signals.last()) else { return };
        let padding = self.padding.min(n - 1);
        let reflected = |end: [f64; K], inner: [f64; K]| {
            std::array::from_fn(|signal| 2.0 * end[signal] - inner[signal])
        };
        let before = (1..=padding).rev().map(|k| reflected(first, signals[k]));
        let after = (1..=padding).map(|k| reflected(last, signals[n - 1 - k]));
        let mut padded: Vec<[f64; K]> =
            before.chain(signals.iter().copied()).chain(after).collect();
        self.run(&mut padded);
        padded.reverse();
        self.run(&mut padded);
        padded.reverse();
        signals.copy_from_slice(&padded[padding..padding + n]);
    }

    /// One pass, as if the signals had always been at their first values before.
    fn run<const K: usize>(&self, signals: &mut [[f64; K]]) {
        let start = signals[0];
        let Biquad { b, a1, a2 } = self.pass;
        // Transposed direct form II of the difference to the start, so that it starts at rest.
        let (mut s1, mut s2) = ([0.0; K], [0.0; K]);
        for values in signals {
            let states = s1.iter_mut().zip(&mut s2);
            for ((value, start), (s1, s2)) in values.iter_mut().zip(start).zip(states) {
                let x = *value - start;
                let y = b * x + *s1;
                *s1 = 2.0 * b * x - a1 * y + *s2;
                *s2 = b * x - a2 * y;
                *value = start + y;
            }
        }
    }

    /// Low-passes the position and the rotation of every joint.
    ///
    /// # Errors
    /// [`FilterError`] if a joint turns by about half a turn or more within the filter's memory.
    pub fn apply_to_clip(&self, clip: &mut Clip) -> Result<(), FilterError> {
        for (j, joint) in clip.skeleton.joints.iter().enumerate() {
            let mut previous = DQuat::IDENTITY;
            let components = |frame: &Vec<JointSample>| {
                let JointSample { rotation, position_m: DVec3 { x, y, z } } = frame[j];
                // Of the two quaternions of a rotation, the one near the last frame's.
                previous = if rotation.dot(previous) < 0.0 { -rotation } else { rotation };
                let [qx, qy, qz, qw] = previous.to_array();
                [qx, qy, qz, qw, x, y, z]
            };
            let mut signals: Vec<[f64; 7]> = clip.frames.iter().map(components).collect();
            self.apply_to_all(&mut signals);
            for (f, (frame, signals)) in clip.frames.iter_mut().zip(signals).enumerate() {
                let [qx, qy, qz, qw, x, y, z] = signals;
                let sum = DQuat::from_xyzw(qx, qy, qz, qw);
                if sum.length() < 0.1 {
                    return Err(FilterError { joint: joint.name.clone(), frame: f });
                }
                frame[j] =
                    JointSample { rotation: sum.normalize(), position_m: DVec3::new(x, y, z) };
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, TAU};

    use super::*;
    use crate::{Skeleton, SkeletonJoint};

    /// Amplitudes of the cosine and the sine part of `signal` at `hz`, over its middle.
    fn spectrum(signal: &[f64], rate_hz: f64, hz: f64) -> (f64, f64) {
        let n = signal.len();
        let (mut re, mut im) = (0.0, 0.0);
        for (k, value) in signal.iter().enumerate().take(3 * n / 4).skip(n / 4) {
            let phase = TAU * hz * k as f64 / rate_hz;
            re += value * phase.cos();
            im += value * phase.sin();
        }
        (4.0 * re / n as f64, 4.0 * im / n as f64)
    }

    fn cosine(rate_hz: f64, hz: f64, n: usize) -> Vec<f64> {
        (0..n).map(|k| (TAU * hz * k as f64 / rate_hz).cos()).collect()
    }

    #[test]
    fn halves_the_power_at_the_cutoff_without_delay() {
        // The middle of 40 s holds whole periods of 6 Hz and lies 10 s from the ends, where the
        // filter's transient is far below rounding: what is left is rounding over 2400 sums.
        for rate in [30_u16, 60, 120, 240] {
            let rate_hz = f64::from(rate);
            let filter = LowPass::new(rate_hz, 6.0).unwrap();
            let mut signal = cosine(rate_hz, 6.0, 40 * usize::from(rate));
            filter.apply(&mut signal);
            let (re, im) = spectrum(&signal, rate_hz, 6.0);
            assert!((re - FRAC_1_SQRT_2).abs() < 1e-9, "{rate_hz} Hz: gain {re}");
            assert!(im.abs() < 1e-9, "{rate_hz} Hz: sine part {im}");
        }
    }

    #[test]
    fn has_the_gain_of_two_butterworth_passes() {
        let filter = LowPass::new(120.0, 6.0).unwrap();
        let bent = |hz: f64| (TAU * hz / 240.0).tan();
        for hz in [1.0, 3.0, 10.0, 30.0] {
            let mut signal = cosine(120.0, hz, 4800);
            filter.apply(&mut signal);
            let (re, im) = spectrum(&signal, 120.0, hz);
            let gain = 1.0 / (1.0 + (2.0_f64.sqrt() - 1.0) * (bent(hz) / bent(6.0)).powi(4));
            assert!((re - gain).abs() < 1e-9 && im.abs() < 1e-9, "{hz} Hz: gain {re}, {im}");
        }
    }

    #[test]
    fn keeps_a_constant_to_the_bit_and_a_ramp_closely() {
        let filter = LowPass::new(120.0, 6.0).unwrap();
        let mut constant = vec![0.1; 50];
        filter.apply(&mut constant);
        assert_eq!(constant, vec![0.1; 50]);
        // Only the lag of the pass's start, 1e-5 of a step of padding, is seen.
        let mut ramp: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
        let before = ramp.clone();
        filter.apply(&mut ramp);
        for (a, b) in ramp.iter().zip(&before) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
    }

    #[test]
    fn takes_any_length() {
        let filter = LowPass::new(120.0, 6.0).unwrap();
        for n in 0..5 {
            let mut signal = vec![1.0; n];
            filter.apply(&mut signal);
            assert_eq!(signal, vec![1.0; n]);
        }
    }

    #[test]
    fn needs_a_cutoff_below_half_the_rate() {
        assert!(LowPass::new(12.0, 6.0).is_none());
        assert!(LowPass::new(120.0, f64::NAN).is_none());
        assert!(LowPass::new(12.5, 6.0).is_some());
    }

    fn clip(rotations: impl Iterator<Item = DQuat>) -> Clip {
        let joint = SkeletonJoint {
            name: "hip".to_owned(),
            parent: None,
            offset_m: DVec3::ZERO,
            end_sites_m: Vec::new(),
        };
        Clip {
            name: "test".to_owned(),
            skeleton: Skeleton { joints: vec![joint] },
            frame_time_s: 1.0 / 120.0,
            frames: rotations
                .map(|rotation| vec![JointSample { rotation, position_m: DVec3::ZERO }])
                .collect(),
        }
    }

    #[test]
    fn keeps_a_constant_rotation_and_sees_no_sign() {
        let rotation = DQuat::from_xyzw(0.5, -0.5, 0.5, 0.5);
        let filter = LowPass::new(120.0, 6.0).unwrap();
        let mut flipping = clip((0..60).map(|k| if k % 2 == 0 { rotation } else { -rotation }));
        filter.apply_to_clip(&mut flipping).unwrap();
        for frame in &flipping.frames {
            assert_eq!(frame[0].rotation, rotation);
        }
    }

    #[test]
    fn refuses_a_spin_that_cancels_out() {
        let filter = LowPass::new(120.0, 6.0).unwrap();
        let mut spin = clip((0..60).map(|k| DQuat::from_rotation_x(3.0 * f64::from(k))));
        let error = filter.apply_to_clip(&mut spin).unwrap_err();
        assert_eq!(error.joint, "hip");
    }

    #[test]
    fn filters_a_swing_as_its_angle() {
        // A swing of 0.3 rad at 3 Hz turns by 0.17 rad in 30 ms; a third of its cube is 1.6e-3.
        let angles: Vec<f64> = cosine(120.0, 3.0, 600).iter().map(|cosine| 0.3 * cosine).collect();
        let filter = LowPass::new(120.0, 6.0).unwrap();
        let mut swing = clip(angles.iter().map(|&angle| DQuat::from_rotation_x(angle)));
        filter.apply_to_clip(&mut swing).unwrap();
        let mut filtered = angles;
        filter.apply(&mut filtered);
        for (frame, angle) in swing.frames.iter().zip(filtered) {
            let (axis, found) = frame[0].rotation.to_axis_angle();
            assert!((axis.x * found - angle).abs() < 1.6e-3);
        }
    }
}
