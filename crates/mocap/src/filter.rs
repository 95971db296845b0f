//! The zero-phase low-pass that removes sensor noise from a recording.
//!
//! A second-order Butterworth filter is applied forwards and then backwards, so that the delays cancel (D. A. Winter,
//! Biomechanics and Motor Control of Human Movement, 4th ed., section 3.4.4). The cutoff applies to both passes
//! together: the gain there is `1/sqrt(2)`.
//!
//! Rotations are filtered as quaternions, component by component, and normalized. If a rotation changes by a few
//! tenths of a radian within the filter's memory (about 30 ms at 6 Hz), the weighted sum of its quaternions has the
//! direction of their mean rotation up to terms of third order in that angle; normalization restores the length,
//! which is reduced by a term of second order.

use std::f64::consts::{PI, SQRT_2};

use glam::{DQuat, DVec3};

use crate::{Clip, JointSample};

/// A joint that rotates too fast for its low-passed rotation to be defined.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "joint `{joint}` turns too fast near frame {frame} to be low-passed: its rotations cancel out"
)]
pub struct FilterError {
    /// Name of the joint.
    pub joint: String,
    /// Index of the frame in the filtered clip.
    pub frame: usize,
}

/// A zero-phase low-pass for one sample rate.
#[derive(Debug, Clone, Copy)]
pub struct LowPass {
    pass: Biquad,
    /// Number of samples by which the signal is extended at both ends.
    padding: usize,
}

/// A low-pass of second order: `y(k) = b (x(k) + 2 x(k-1) + x(k-2)) - a1 y(k-1) - a2 y(k-2)`.
#[derive(Debug, Clone, Copy)]
struct Biquad {
    b: f64,
    a1: f64,
    a2: f64,
}

impl LowPass {
    /// Creates a low-pass with gain `1/sqrt(2)` at `cutoff_hz`; `None` if the cutoff is not below half of
    /// `rate_hz`.
    pub fn new(rate_hz: f64, cutoff_hz: f64) -> Option<Self> {
        if !(cutoff_hz > 0.0 && cutoff_hz < 0.5 * rate_hz && rate_hz.is_finite()) {
            return None;
        }
        // Two passes with corner c have the gain 1/(1 + (f/c)^4), therefore c must exceed the cutoff by the factor
        // (sqrt(2) - 1)^(-1/4) = 1/0.8022. The factor applies to the analog filter's frequencies, tan(pi f / rate),
        // to which the bilinear transform maps the real ones.
        let per_pass = (SQRT_2 - 1.0).sqrt().sqrt();
        let k = libm::tan(PI * cutoff_hz / rate_hz) / per_pass;
        // The bilinear transform of 1/(s^2 + sqrt(2) s + 1), with s in units of the corner.
        let scale = (1.0 + SQRT_2 * k + k * k).recip();
        let pass = Biquad {
            b: k * k * scale,
            a1: 2.0 * (k * k - 1.0) * scale,
            a2: (1.0 - SQRT_2 * k + k * k) * scale,
        };
        // Three periods of the cutoff: by then, the transient of a pass is below 1e-5.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive, and saturates"
        )]
        let padding = (3.0 * rate_hz / cutoff_hz).ceil() as usize;
        Some(Self { pass, padding })
    }

    /// Low-passes a signal in place. A constant is unchanged, bit by bit.
    ///
    /// At both ends the signal is extended by its odd reflection, which keeps value and slope.
    pub fn apply(&self, signal: &mut [f64]) {
        let (lone, _) = signal.as_chunks_mut::<1>();
        self.apply_to_all(lone);
    }

    /// Low-passes `K` signals side by side. A sample depends only on earlier samples of its own signal, so the
    /// processor computes the signals at the same time.
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

    /// Performs one pass, as if the signals had always been at their first values before.
    fn run<const K: usize>(&self, signals: &mut [[f64; K]]) {
        let start = signals[0];
        let Biquad { b, a1, a2 } = self.pass;
        // Transposed direct form II of the difference from the start, so that it starts at rest.
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
    /// [`FilterError`] if a joint rotates by about 180 deg or more within the filter's memory.
    pub fn apply_to_clip(&self, clip: &mut Clip) -> Result<(), FilterError> {
        for (j, joint) in clip.skeleton.joints.iter().enumerate() {
            let mut previous = DQuat::IDENTITY;
            let components = |frame: &Vec<JointSample>| {
                let JointSample { rotation, position_m: DVec3 { x, y, z } } = frame[j];
                // Both signs of a quaternion are the same rotation; the one nearer to the last frame's is used.
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

    /// Returns the amplitudes of the cosine and the sine part of `signal` at `hz`, over its middle.
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
        // The middle of 40 s contains whole periods of 6 Hz and is 10 s from the ends, where the filter's transient
        // is far below rounding: only rounding over 2400 sums remains.
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
        // Only the transient of the pass's start remains, 1e-5 of a step of the padding.
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
        // A swing of 0.3 rad at 3 Hz rotates by 0.17 rad in 30 ms; a third of its cube is 1.6e-3.
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
