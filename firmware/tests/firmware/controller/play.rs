//! A desk arm from power-on through a small show to its rest pose.

use sinew_firmware::controller::{Jog, Start};
use sinew_firmware::supervisor::{
    Command, Fault, FaultSet, Feed, SOFT_MOST_RAD_S, Settings, Source, State,
};

use super::swing::swing;
use super::test_rig::{Kind, SERVOS, TestRig, figure};

/// Returns a show of four seconds for a rig.
pub(crate) fn show(kind: Kind, rig: u32) -> &'static [u8] {
    Vec::leak(swing(kind, 4, false, rig))
}

/// Measurements of a performance.
pub(crate) struct Seen {
    pub(crate) hash: u64,
    mean_deg: f64,
    most_deg: f64,
}

/// Runs a performance from power-on until torque is off, and checks it on the way.
pub(crate) fn perform(kind: Kind) -> Seen {
    let mut test_rig = TestRig::new(kind, Start::default());
    test_rig.controller.load_show(Some(show(kind, 0))).unwrap();
    let dt_s = 1.0 / kind.rate_hz() as f32;
    let (mut before, mut was_on) = (vec![], false);
    let (mut sum, mut count, mut most) = (0.0_f64, 0.0, 0.0_f64);
    let mut goals: Option<Vec<i32>> = None;
    // Runs a tick, and checks what must be true in each tick.
    let mut look = |test_rig: &mut TestRig, command| {
        test_rig.tick(command);
        assert!(test_rig.ended.is_ok(), "{:?}", test_rig.ended);
        let report = test_rig.controller.report();
        assert!(report.raised.minus(FaultSet::WARNINGS).is_empty(), "{report:?}");
        let (q, _) = test_rig.controller.commanded();
        for ((now, before), dof) in q.iter().zip(&before).zip(figure(kind).board.dofs()) {
            let now: f32 = *now;
            let most = match report.state {
                State::Arming => SOFT_MOST_RAD_S,
                State::Lowering => Settings::default().lower_rad_s,
                _ => dof.speed,
            };
            let moved = (now - before) / dt_s;
            let is_on = was_on && test_rig.controller.permission().torque;
            assert!(!is_on || f32::abs(moved) <= most + 1e-3, "{moved} rad/s in {}", report.state);
        }
        // Until torque is on, the commanded pose is the measured pose.
        (before, was_on) = (q.to_vec(), test_rig.controller.permission().torque);
        if kind == Kind::Position && test_rig.servos_on() == SERVOS {
            // Goal position (42) of an STS, 4096 steps per turn: the maximum change is that of its speed and its
            // offset, plus a step.
            let now: Vec<i32> = test_rig.bench.servos().iter().map(|servo| servo.get(42)).collect();
            for ((now, before), servo) in
                now.iter().zip(goals.iter().flatten()).zip(figure(kind).board.servos())
            {
                let most = (servo.servo.settings().speed_rad_s + 1.0) * dt_s * 4096.0
                    / std::f32::consts::TAU
                    + 1.0;
                assert!(((now - before).abs() as f32) <= most, "{before} to {now} of {most}");
            }
            goals = Some(now);
        } else {
            goals = None;
        }
    };
    // After power-on only torque off is sent.
    for _ in 0..test_rig.ticks_of(1.0) {
        look(&mut test_rig, None);
        assert!(test_rig.servos_on() == 0 && test_rig.sent_off());
    }
    assert_eq!(test_rig.state(), State::Limp);
    // The arm has fallen, and still swings.
    while test_rig.controller.report().answer != Some(Ok(State::Arming)) {
        look(&mut test_rig, Some(Command::Arm));
    }
    assert_eq!((test_rig.state(), test_rig.servos_on()), (State::Arming, SERVOS));
    for _ in 0..test_rig.ticks_of(1.1) {
        look(&mut test_rig, None);
    }
    assert_eq!(test_rig.state(), State::Holding);
    look(&mut test_rig, Some(Command::Play(Feed::Show)));
    let mut soft_ticks = 0;
    for _ in 0..test_rig.ticks_of(20.0) {
        look(&mut test_rig, None);
        let report = test_rig.controller.report();
        if report.state == State::Holding {
            break;
        }
        if test_rig.controller.permission().runs {
            let following = report.following.unwrap();
            let mean_deg = f64::from(following.mean_rad).to_degrees();
            (sum, count) = (sum + mean_deg, count + 1.0);
            most = most.max(f64::from(following.most_rad).to_degrees());
        } else {
            soft_ticks += 1;
            let (_, qd) = test_rig.controller.commanded();
            assert!(qd.iter().all(|v| v.abs() <= SOFT_MOST_RAD_S * 1.001), "{qd:?}");
        }
    }
    // 0.6 rad at 20 deg/s take 1.7 s, and the show starts only after them.
    assert!(f64::from(soft_ticks) * f64::from(dt_s) > 1.7, "{soft_ticks}");
    assert_eq!(test_rig.state(), State::Holding, "the show is over");
    assert!(count * f64::from(dt_s) > 3.9, "{count}");
    look(&mut test_rig, Some(Command::Stop));
    assert_eq!(test_rig.controller.report().source, Source::Rest);
    let mut at_rest = vec![];
    for _ in 0..test_rig.ticks_of(30.0) {
        look(&mut test_rig, None);
        match test_rig.state() {
            State::Stopping => at_rest = test_rig.controller.commanded().0.to_vec(),
            State::Limp => break,
            _ => {}
        }
    }
    for (at, home) in at_rest.iter().zip(&figure(kind).home) {
        assert!((f64::from(*at) - home).abs() < 2e-3, "{at} {home}");
    }
    assert_eq!((test_rig.state(), test_rig.servos_on()), (State::Limp, 0));
    Seen { hash: test_rig.hash, mean_deg: sum / count, most_deg: most }
}

#[test]
fn a_desk_arm_plays_a_show() {
    // Bound of the mean: the controller's requirement for a show within the rig's limits. Bound of the maximum: below
    // the fault's 15 deg.
    for (kind, bound_deg) in [(Kind::Current, 3.0), (Kind::Voltage, 3.0), (Kind::Position, 5.0)] {
        let Seen { hash, mean_deg, most_deg } = perform(kind);
        println!("{kind:?}: mean {mean_deg:.2} deg, largest {most_deg:.2} deg, hash {hash:016x}");
        assert!(mean_deg <= bound_deg && most_deg < 15.0);
    }
}

#[test]
fn the_same_bytes_twice() {
    for kind in [Kind::Current, Kind::Voltage, Kind::Position] {
        assert_eq!(perform(kind).hash, perform(kind).hash);
    }
}

/// Returns a desk arm that holds the pose in which it was armed.
fn holding() -> TestRig {
    let mut test_rig = TestRig::new(Kind::Current, Start::default());
    test_rig.controller.load_show(Some(show(Kind::Current, 0))).unwrap();
    test_rig.arm();
    test_rig.until(State::Holding, 2.0);
    test_rig
}

#[test]
fn another_show_while_one_plays_holds_the_rig() {
    let mut test_rig = holding();
    test_rig.tick(Some(Command::Play(Feed::Show)));
    while !test_rig.controller.permission().runs {
        test_rig.tick(None);
    }
    test_rig.run(1.0);
    assert_eq!(test_rig.controller.report().source, Source::Feed(Feed::Show));
    test_rig.controller.load_show(Some(show(Kind::Current, 0))).unwrap();
    test_rig.tick(None);
    assert_eq!(
        (test_rig.state(), test_rig.controller.report().source),
        (State::Holding, Source::Hold)
    );
    test_rig.run(1.0);
    assert_eq!(test_rig.state(), State::Holding);
    assert!(test_rig.controller.commanded().1.iter().all(|speed| speed.abs() < 1e-3));
}

#[test]
fn a_jog_moves_at_once_within_speed_and_acceleration() {
    for kind in [Kind::Current, Kind::Voltage, Kind::Position] {
        let mut test_rig = TestRig::new(kind, Start::default());
        test_rig.arm();
        test_rig.until(State::Holding, 2.0);
        let (dt_s, dof) = (1.0 / kind.rate_hz() as f32, figure(kind).board.dofs()[0]);
        let from = test_rig.controller.commanded().0[0];
        // The joint moves forth and back; without the input it brakes.
        let (mut before, mut way) = (0.0_f32, 0.0_f32);
        for speed in [Some(9.0), Some(-9.0), None] {
            test_rig.jog = speed.map(|speed| Jog { dof: 0, speed });
            for tick in 0..test_rig.ticks_of(0.2) {
                let begins = tick == 0 && speed == Some(9.0);
                test_rig.tick(begins.then_some(Command::Play(Feed::Jog)));
                let (q, qd) = test_rig.controller.commanded();
                let step = (qd[0] - before).abs();
                assert!(step <= dof.acceleration * dt_s * 1.01, "{kind:?}: {before} to {}", qd[0]);
                assert!(qd[0].abs() <= SOFT_MOST_RAD_S * 1.001);
                (before, way) = (qd[0], way.max(q[0] - from));
            }
        }
        // In 0.2 s at 20 deg/s a joint moves by 0.07 rad.
        assert!(way > 0.05, "{kind:?}: {way} rad");
        assert!(before.abs() < 1e-3, "{kind:?}: stands");
    }
}

#[test]
fn a_jog_that_is_no_number_is_a_fault() {
    for speed in [f32::NAN, f32::INFINITY] {
        let mut test_rig = holding();
        test_rig.jog = Some(Jog { dof: 0, speed });
        test_rig.tick(Some(Command::Play(Feed::Jog)));
        assert!(test_rig.controller.report().raised.contains(Fault::NotFinite));
        assert_eq!((test_rig.state(), test_rig.servos_on()), (State::Faulted, 0));
    }
}
