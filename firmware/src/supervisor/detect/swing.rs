//! A joint that swings: its own loop shakes it.

/// Below this a motion is no swing, Hz: three high-passes of one pole each. A show moves at less than 4 Hz, and what
/// lags behind a fast one by 14 deg has 0.14 deg rms behind them, of 16 Hz a half is left.
const CORNER_HZ: f32 = 12.0;
/// The corner while the target stands, Hz: no show is in the error then, and a worse gear swings at 7 to 10 Hz.
const STANDING_CORNER_HZ: f32 = 4.0;
/// Time constant of the mean squares, and of the gain that is lowered, s.
const WINDOW_S: f32 = 0.5;
/// Least error of a swing, rms behind the high-passes, rad or m: a sine of 0.8 deg peak to peak at
/// 16 Hz. An encoder of 4,096 steps that wavers by one has a third of it.
const LEAST_ERROR: f32 = 2.6e-3;
/// Part of an error that counts while the target stands: behind the lower corner, of 16 Hz 0.9 are left.
const STANDING_SHARE: f32 = 0.6;
/// Least effort of a swing, rms, as a part of the joint's most: its servos swing it.
const LEAST_SHARE: f32 = 0.03;
/// Squares count up to so many times the least, so that a single jerk is no swing.
const MOST: f32 = 2.0;
/// It swings no more below this part of the least mean square ...
const CALM: f32 = 0.25;
/// ... for so long, s.
const CALM_S: f32 = 5.0;
/// Below this part of it nothing but the error is looked at.
const FAINT: f32 = 0.05;

/// Settings that the detectors of all joints of a rig share.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SwingSettings {
    dt_s: f32,
    /// Part by which a tick changes a mean behind the corner: while the target moves, and while it stands.
    corners: [f32; 2],
    /// Part by which a tick changes a mean over the window.
    window: f32,
    low_gain: f32,
}

impl SwingSettings {
    /// For ticks of `dt_s`. `low_gain`: to what part the feedback of a joint that swings is lowered.
    pub fn new(dt_s: f32, low_gain: f32) -> Self {
        let part = |time_s: f32| dt_s / (dt_s + time_s);
        let corners = [CORNER_HZ, STANDING_CORNER_HZ]
            .map(|corner_hz| part(1.0 / (core::f32::consts::TAU * corner_hz)));
        Self { dt_s, corners, window: part(WINDOW_S), low_gain }
    }
}

/// Finds that a joint swings at about 15 to 40 Hz, or from 7 Hz while its target stands: its error alternates, and so
/// does its effort, if its servos tell that. What a show commands is in no error, and a swing in no show. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swing {
    error: Alternating,
    effort: Alternating,
    /// For so long it counts as one that swings, s.
    left_s: f32,
    gain: f32,
}

/// Nothing has swung until now.
impl Default for Swing {
    fn default() -> Self {
        let still = Alternating::default();
        Self { error: still, effort: still, left_s: 0.0, gain: 1.0 }
    }
}

impl Swing {
    /// Takes a tick in which torque is on. `error`: commanded less measured position, rad or m; `stands`: its target
    /// does not move; `effort`: as measured, N m or N; `most`: the joint's most effort, infinite for no limit. A number
    /// that is not finite is as if nothing was.
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
        // Where nothing tells what effort is much, the error alone counts. Where the error is small, its effort is not
        // looked at: that is most of the time.
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

    /// Whether it swings, or did within the last 5 s.
    pub fn is_found(&self) -> bool {
        self.left_s > 0.0
    }

    /// The factor of its feedback.
    pub fn gain(&self) -> f32 {
        self.gain
    }
}

/// The alternating part of a course, as a mean square.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Alternating {
    slow: [f32; 3],
    mean_square: f32,
}

impl Alternating {
    // Twice in each step: once is enough of it.
    #[inline(never)]
    fn step(&mut self, [corner, window]: [f32; 2], value: f32) -> f32 {
        if value.is_finite() {
            let mut rest = value;
            for slow in &mut self.slow {
                let before = *slow;
                *slow += corner * (rest - before);
                // In the middle of the tick: else its length would count.
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
    /// An XL330's, N m, and per A.
    const MOST_NM: f32 = 0.42;
    const NM_PER_A: f32 = 0.3;

    /// When a joint with such courses of error, rad, and current, A, is found to swing within 20 s.
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

    /// Rates, while the target moves and while it stands.
    fn cases() -> impl Iterator<Item = (f32, bool)> {
        RATES_HZ.into_iter().flat_map(|rate_hz| [(rate_hz, false), (rate_hz, true)])
    }

    fn sine(hz: f32, amplitude: f32) -> impl Fn(f32) -> f32 {
        move |t| amplitude * sinew_core::math::sin_cos(core::f32::consts::TAU * (hz * t % 1.0)).0
    }

    #[test]
    fn a_swing_is_found_within_a_second() {
        for (rate_hz, stands) in cases() {
            // 1 deg from peak to peak, with 0.3 A.
            for hz in [16.0, 25.0, 40.0] {
                let found = found_s((rate_hz, stands), sine(hz, 0.5 * DEG), sine(hz, 0.3));
                assert!(found.is_some_and(|s| s < 1.0), "{hz} Hz at {rate_hz} Hz: {found:?}");
            }
            // A third of that is none.
            assert_eq!(found_s((rate_hz, stands), sine(16.0, 0.16 * DEG), sine(16.0, 0.3)), None);
            // Somebody shakes the rig, and the servo does not.
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
            // As much as a joint may move that stands, with all friction on its rotor.
            assert_eq!(found_s((rate_hz, true), sine(16.0, 0.3 * DEG), sine(16.0, 0.3)), None);
        }
    }

    #[test]
    fn what_is_no_swing_is_not_found() {
        for rate_hz in RATES_HZ {
            // A fast show: 3 deg behind its commands, with much current, and friction that turns about.
            let friction = |t: f32| sine(2.0, 0.6)(t) + 0.1 * sine(2.0, 1.0)(t).signum();
            assert_eq!(found_s((rate_hz, false), sine(2.0, 3.0 * DEG), friction), None);
            assert_eq!(found_s((rate_hz, false), sine(3.0, 1.5 * DEG), sine(3.0, 0.6)), None);
        }
        for case in cases() {
            let (rate_hz, _) = case;
            // It sticks and slips once a second, by a degree.
            let slips = |t: f32| DEG * ((t + 0.5) % 1.0 - 0.5);
            assert_eq!(found_s(case, slips, |t| 0.5 * slips(t) / DEG), None);
            // An encoder wavers by a step of 4,096, in each tick or every 15th, and the loop answers.
            let step = DEG * 360.0 / 4096.0;
            for hz in [0.5 * rate_hz, rate_hz / 30.0] {
                let wavers = |t: f32| 0.5 * step * sine(hz, 1.0)(t + 0.25 / rate_hz).signum();
                assert_eq!(found_s(case, wavers, |t| wavers(t) / step), None, "{hz}");
            }
            // A jerk of 5 deg, with all that it has.
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
                // A servo that tells no effort.
                swing.step(&settings, (error, false), None, MOST_NM);
            }
            swing
        };
        assert!((run(3, 16.0, DEG).gain() - 0.5).abs() < 0.01);
        // Smaller than what begins it, it goes on.
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
        // Of a joint without a limit the error alone counts.
        let mut free = Swing::default();
        for tick in 0_u16..400 {
            let error = sine(16.0, DEG)(f32::from(tick) * 0.0025);
            free.step(&settings, (error, false), Some(0.0), f32::INFINITY);
        }
        assert!(free.is_found());
    }
}
