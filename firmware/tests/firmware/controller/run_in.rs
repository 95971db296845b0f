//! A show that begins in the middle of a movement is entered from standstill.

use std::f64::consts::TAU;

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{Command, Feed, State};
use sinew_show::write::{Motion, Settings, write};
use sinew_show::{Joint, Rate};

use super::play::show;
use super::test_rig::{Kind, TestRig, figure};

const KIND: Kind = Kind::Current;
/// Amplitude of the moving joint: 1.9 rad/s in its middle, where the show begins.
const SWING_RAD: f64 = 0.3;
const HZ: f64 = 1.0;
/// Default duration of a blend.
const RUN_IN_S: f64 = 1.0;

/// Returns a show in which the last joint swings around home without end, and the others stand still.
fn at_speed() -> &'static [u8] {
    let figure = figure(KIND);
    let mut q = Vec::new();
    for sample in 0..200 {
        let mut pose = figure.home.clone();
        *pose.last_mut().unwrap() += SWING_RAD * (TAU * HZ * f64::from(sample) / 100.0).sin();
        q.extend(pose);
    }
    let joints: Vec<Joint> =
        figure.board.tree().bodies().iter().map(|body| body.joint.into()).collect();
    let rate = Rate { samples: 100, seconds: 1 };
    let (cues, course) = (&[], &[]);
    let (is_loop, rig, time_code) = (true, 0, None);
    let motion = Motion { joints: &joints, q: &q, rate, is_loop, rig, cues, time_code, course };
    // Close enough that its speeds are those of the sine within 1 %.
    let settings = Settings { angle_rad: 1e-4, ..Settings::default() };
    Vec::leak(write(&motion, &settings).unwrap().bytes)
}

/// Returns a test rig whose show begins to run in the next tick.
fn at_first_pose(show: &'static [u8]) -> TestRig {
    let mut test_rig = TestRig::new(KIND, Start::default());
    test_rig.controller.load_show(Some(show)).unwrap();
    test_rig.arm();
    test_rig.until(State::Holding, 2.0);
    test_rig.tick(Some(Command::Play(Feed::Show)));
    while !test_rig.controller.permission().runs {
        assert_eq!(test_rig.state(), State::Playing);
        test_rig.tick(None);
    }
    test_rig
}

#[test]
fn a_show_that_starts_at_speed_is_entered_within_its_own_limits() {
    let mut test_rig = at_first_pose(at_speed());
    let dt_s = 1.0 / f64::from(KIND.rate_hz());
    let speed = SWING_RAD * TAU * HZ;
    // The sine's acceleration, plus the acceleration of the pace, which rises from 0 to 1 as 3 s² - 2 s³. A tenth
    // allows for the rounding of the show.
    let most = 1.1 * (speed * TAU * HZ + 1.5 * speed / RUN_IN_S);
    let mut before = 0.0;
    for tick in 0..test_rig.ticks_of(3.0) {
        let (_, qd) = test_rig.controller.commanded();
        let now = f64::from(*qd.last().unwrap());
        assert!((now - before).abs() <= most * dt_s, "{before} to {now} rad/s in tick {tick}");
        assert!(now.abs() <= 1.01 * speed, "{now} rad/s in tick {tick}");
        before = now;
        test_rig.tick(None);
        assert_eq!(test_rig.state(), State::Playing, "{:?}", test_rig.controller.report());
    }
    // Half of the blend's duration is lost, and the show is in time from then on: 100 samples per second.
    let samples = test_rig.controller.report().show.unwrap().sample();
    let expected = 100.0 * (3.0 - 0.5 * RUN_IN_S);
    assert!((f64::from(samples) - expected).abs() <= 1.0, "{samples} of {expected}");
}

#[test]
fn a_show_that_starts_from_rest_is_in_time_at_once() {
    let mut test_rig = at_first_pose(show(KIND, 0));
    test_rig.run(1.0);
    let samples = test_rig.controller.report().show.unwrap().sample();
    assert!((99..=100).contains(&samples), "{samples}");
}
