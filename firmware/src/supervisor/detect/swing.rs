//! Detector of a joint that swings because its own control loop excites it.

/// Frequency below which a motion does not count as a swing, Hz. The filter consists of three high-passes of one pole
/// each. A show moves at less than 4 Hz. A following error of 14 deg in a fast show is 0.14 deg rms after the
/// high-passes; half of a swing at 16 Hz remains.
const CORNER_HZ: f32 = 12.0;
/// Corner frequency while the target stands still, Hz: the error then contains no show, and a poor gear swings at 7
/// to 10 Hz.
const STANDING_CORNER_HZ: f32 = 4.0;
/// Time constant of the mean squares, and of the reduction of the gain, s.
const WINDOW_S: f32 = 0.5;
/// Minimum error of a swing, rms after the high-passes, rad or m: a sine of 0.8 deg peak to peak at 16 Hz. An
/// encoder of 4,096 steps that wavers by a step causes a third of this error.
const LEAST_ERROR: f32 = 2.6e-3;
/// Factor of the error while the target stands still: with the lower corner, 0.9 of a swing at 16 Hz remains.
const STANDING_SHARE: f32 = 0.6;
/// Minimum effort of a swing, rms, as a part of the joint's maximum: its servos must cause the swing.
const LEAST_SHARE: f32 = 0.03;
/// Maximum of a value, as a multiple of the minimum for a swing, so that a single jerk does not count as a swing.
const MOST: f32 = 2.0;
/// The swing has ended when the mean square was below this part of its minimum for `CALM_S`.
const CALM: f32 = 0.25;
/// Time below `CALM` after which the swing has ended, s.
const CALM_S: f32 = 5.0;
/// Part of the minimum mean square below which only the error is computed.
const FAINT: f32 = 0.05;

/// Settings that the detectors of all joints of a rig share.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SwingSettings {
    dt_s: f32,
    /// Weights of a tick in a mean of the high-pass filter: the first is used while the target moves, the second
    /// while the target stands still.
    corners: [f32; 2],
    /// Weight of a tick in a mean over the window.
    window: f32,
    low_gain: f32,
}

impl SwingSettings {
    /// Returns the settings for ticks of `dt_s`. `low_gain` is the factor to which a swinging joint's feedback is
    /// reduced.
    pub fn new(dt_s: f32, low_gain: f32) -> Self {
        let part = |time_s: f32| dt_s / (dt_s + time_s);
        let corners = [CORNER_HZ, STANDING_CORNER_HZ]
            .map(|corner_hz| part(1.0 / (core::f32::consts::TAU * corner_hz)));
        Self { dt_s, corners, window: part(WINDOW_S), low_gain }
    }
}

/// Detects that a joint swings at about 15 to 40 Hz, or from 7 Hz on while its target stands still: its error
/// alternates, and so does its effort if its servos report it. The error does not contain a show's motion, and a show
/// does not contain a swing. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swing {
    error: Alternating,
    effort: Alternating,
    /// Remaining time for which the joint counts as swinging, s.
    left_s: f32,
    gain: f32,
}

/// A detector without a swing until now.
impl Default for Swing {
    fn default() -> Self {
        let still = Alternating::default();
        Self { error: still, effort: still, left_s: 0.0, gain: 1.0 }
    }
}

impl Swing {
    /// Checks a tick in which torque is on. `error` is the commanded minus the measured position, rad or m. `stands`
    /// is whether its target stands still. `effort` is the measured effort, N m or N, and `most` the joint's maximum
    /// effort, infinite for no limit. A number that is not finite resets the measurement.
    pub fn step(
        &mut self,
        settings: &SwingSettings,
        (error, stands): (f32, bool),
        effort: Option<f32>,
        most: f32,
    ) {
        let SwingSettings { corners: [moving, standing], window, .. } = *settings;
        let (corner, share) = if stands { (standing, STANDING_SHARE) } else { (moving, 1.0) };
        let mut square = self.error.step([corner, window], share * error / LEAST_ERROR);
        // If the size of an effort is not known, only the error counts. If the error is small, the effort is not
        // computed: this is the usual case.
        if square <= FAINT {
            self.effort = Alternating::default();
        } else if let Some(effort) = effort
            && most < f32::INFINITY
        {
            square = square.min(self.effort.step([corner, window], effort / (LEAST_SHARE * most)));
        }
        let (least, wanted) = if self.is_found() { (CALM, settings.low_gain) } else { (1.0, 1.0) };
        self.left_s = if square > least { CALM_S } else { self.left_s - settings.dt_s };
        self.gain += settings.window * (wanted - self.gain);
    }

    /// Returns whether the joint swings, or did within the last 5 s.
    pub fn is_found(&self) -> bool {
        self.left_s > 0.0
    }

    /// Returns the factor of the joint's feedback.
    pub fn gain(&self) -> f32 {
        self.gain
    }
}

/// Mean square of the alternating part of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Alternating {
    slow: [f32; 3],
    mean_square: f32,
}

impl Alternating {
    // Not inlined: it is used twice in each step, and a single copy of the code is enough.
    #[inline(never)]
    fn step(&mut self, [corner, window]: [f32; 2], value: f32) -> f32 {
        if value.is_finite() {
            let mut rest = value;
            for slow in &mut self.slow {
                let before = *slow;
                *slow += corner * (rest - before);
                // The mean in the middle of the tick: else the result would depend on the tick's length.
                rest -= 0.5 * (before + *slow);
            }
            let square = (rest * rest).min(MOST * MOST);
            self.mean_square += window * (square - self.mean_square);
        } else {
            *self = Self::default();
        }
        self.mean_square
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATES_HZ: [f32; 3] = [200.0, 400.0, 1000.0];
    const DEG: f32 = core::f32::consts::PI / 180.0;
    /// Maximum effort of an XL330, N m, and torque per current, N m/A.
    const MOST_NM: f32 = 0.42;
    const NM_PER_A: f32 = 0.3;

    /// Returns the time at which a swing is detected within 20 s, for signals of error, rad, and current, A.
    fn found_s(
        (rate_hz, stands): (f32, bool),
        error: impl Fn(f32) -> f32,
        current: impl Fn(f32) -> f32,
    ) -> Option<f32> {
        let (mut swing, settings) = (Swing::default(), SwingSettings::new(1.0 / rate_hz, 1.0));
        let mut times_s = (0_u16..).map(|tick| f32::from(tick) / rate_hz).take_while(|t| *t < 20.0);
        times_s.find(|t| {
            let effort_nm = NM_PER_A * current(*t);
            swing.step(&settings, (error(*t), stands), Some(effort_nm), MOST_NM);
            swing.is_found()
        })
    }

    /// Returns all rates, while the target moves and while it stands still.
    fn cases() -> impl Iterator<Item = (f32, bool)> {
        RATES_HZ.into_iter().flat_map(|rate_hz| [(rate_hz, false), (rate_hz, true)])
    }

    fn sine(hz: f32, amplitude: f32) -> impl Fn(f32) -> f32 {
        move |t| amplitude * sinew_core::math::sin_cos(core::f32::consts::TAU * (hz * t % 1.0)).0
    }

    #[test]
    fn a_swing_is_found_within_a_second() {
        for (rate_hz, stands) in cases() {
            // 1 deg peak to peak, with 0.3 A.
            for hz in [16.0, 25.0, 40.0] {
                let found = found_s((rate_hz, stands), sine(hz, 0.5 * DEG), sine(hz, 0.3));
                assert!(found.is_some_and(|s| s < 1.0), "{hz} Hz at {rate_hz} Hz: {found:?}");
            }
            // A third of that does not count as a swing.
            assert_eq!(found_s((rate_hz, stands), sine(16.0, 0.16 * DEG), sine(16.0, 0.3)), None);
            // A person shakes the rig, and the servo does not.
            assert_eq!(found_s((rate_hz, stands), sine(16.0, 0.5 * DEG), |_| 0.0), None);
        }
    }

    #[test]
    fn a_slow_swing_is_found_while_the_target_stands() {
        for rate_hz in RATES_HZ {
            for hz in [7.0, 8.0, 10.0] {
                let found = found_s((rate_hz, true), sine(hz, 0.75 * DEG), sine(hz, 0.3));
                assert!(found.is_some_and(|s| s < 1.0), "{hz} Hz at {rate_hz} Hz: {found:?}");
            }
            // The maximum motion of a standing joint, with all friction on its rotor.
            assert_eq!(found_s((rate_hz, true), sine(16.0, 0.3 * DEG), sine(16.0, 0.3)), None);
        }
    }

    #[test]
    fn what_is_no_swing_is_not_found() {
        for rate_hz in RATES_HZ {
            // A fast show: 3 deg behind its commands, with a large current, and friction that reverses.
            let friction = |t: f32| sine(2.0, 0.6)(t) + 0.1 * sine(2.0, 1.0)(t).signum();
            assert_eq!(found_s((rate_hz, false), sine(2.0, 3.0 * DEG), friction), None);
            assert_eq!(found_s((rate_hz, false), sine(3.0, 1.5 * DEG), sine(3.0, 0.6)), None);
        }
        for case in cases() {
            let (rate_hz, _) = case;
            // The joint sticks and slips once per second, by a degree.
            let slips = |t: f32| DEG * ((t + 0.5) % 1.0 - 0.5);
            assert_eq!(found_s(case, slips, |t| 0.5 * slips(t) / DEG), None);
            // An encoder wavers by a step of 4,096, in each tick or every 15th, and the loop responds.
            let step = DEG * 360.0 / 4096.0;
            for hz in [0.5 * rate_hz, rate_hz / 30.0] {
                let wavers = |t: f32| 0.5 * step * sine(hz, 1.0)(t + 0.25 / rate_hz).signum();
                assert_eq!(found_s(case, wavers, |t| wavers(t) / step), None, "{hz}");
            }
            // A jerk of 5 deg with the maximum effort.
            let jerk = |t: f32| if t < 1.0 { 0.0 } else { 5.0 * DEG };
            assert_eq!(found_s(case, jerk, |t| jerk(t) / DEG), None);
        }
    }

    #[test]
    fn it_calms_down_after_5_s_and_the_gain_follows() {
        let (mut swing, settings) = (Swing::default(), SwingSettings::new(0.0025, 0.5));
        let mut run = |seconds: u16, hz: f32, amplitude: f32| {
            for tick in 0..seconds * 400 {
                let error = sine(hz, amplitude)(f32::from(tick) * 0.0025);
                // The servo reports no effort.
                swing.step(&settings, (error, false), None, MOST_NM);
            }
            swing
        };
        assert!((run(3, 16.0, DEG).gain() - 0.5).abs() < 0.01);
        // A swing that is smaller than the threshold for its start continues.
        assert!(run(10, 16.0, 0.25 * DEG).is_found());
        assert!(run(5, 16.0, 0.0).is_found());
        let calm = run(5, 16.0, 0.0);
        assert!(!calm.is_found() && (calm.gain() - 1.0).abs() < 0.01, "{calm:?}");
    }

    #[test]
    fn what_is_no_number_leaves_nothing_behind() {
        let (mut swing, settings) = (Swing::default(), SwingSettings::new(0.0025, 0.5));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
            swing.step(&settings, (bad, false), Some(bad), MOST_NM);
            swing.step(&settings, (bad, false), None, bad);
            swing.step(&settings, (f32::NAN, true), Some(f32::NAN), MOST_NM);
            let Swing { error, effort, gain, .. } = swing;
            assert_eq!((error, effort), (Alternating::default(), Alternating::default()), "{bad}");
            assert!((0.5..=1.0).contains(&gain));
        }
        // For a joint without a limit only the error counts.
        let mut free = Swing::default();
        for tick in 0_u16..400 {
            let error = sine(16.0, DEG)(f32::from(tick) * 0.0025);
            free.step(&settings, (error, false), Some(0.0), f32::INFINITY);
        }
        assert!(free.is_found());
    }
}
