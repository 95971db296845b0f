//! Every fault in every state, with planted conditions: the page `docs/fault-matrix.md`.
//!
//! The test rig is the arm of XL330 in current mode, at 400 ticks per second.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{
    Clears, Command, Fault, FaultSet, Feed, Operator, Reaction, State,
};
use sinew_servo_bus::ServoBus;
use sinew_servo_sim::fault::{Fault as Damage, FaultKind};

use super::cell::{Tried, measure, must_be, row, table};
use super::play::show;
use super::test_rig::{Kind, Planted, TestRig, figure};

const ANN: Operator = Operator(1);

/// Returns the reason why a fault cannot occur in a state.
fn excuse(fault: Fault, state: State) -> Option<&'static str> {
    use Fault::{
        BrownOut, FollowingError, LinkLost, Panic, ServoStopped, ShowBad, ShowForeign, Swing,
        TorqueStuck, WatchdogReset,
    };
    match fault {
        WatchdogReset | BrownOut | Panic if state != State::Off => Some("at the start alone"),
        ShowBad | ShowForeign if state != State::Playing => Some("no show plays"),
        ServoStopped if !state.is_on() => Some("its watchdog rests"),
        TorqueStuck if state.is_on() => Some("torque is to be on"),
        FollowingError | Swing if !state.is_on() => Some("nothing is followed"),
        FollowingError | Swing if state == State::Lowering => Some("it sinks on purpose"),
        LinkLost if state == State::Arming => Some("over after 1 s"),
        LinkLost if state == State::Playing => Some("link late holds it before"),
        _ => None,
    }
}

/// Returns a test rig in a state. For `Off`, a servo is silent from the start.
pub(super) fn stand_in(state: State, fault: Fault) -> TestRig {
    let causes = match fault {
        Fault::WatchdogReset | Fault::BrownOut | Fault::Panic => FaultSet::of(fault),
        _ => FaultSet::EMPTY,
    };
    let mut test_rig = TestRig::new(Kind::Current, Start { causes, ..Start::default() });
    if state == State::Off {
        let for_s = f64::INFINITY;
        test_rig.bench.faults.push(Damage { servo: 5, at_s: 0.0, for_s, kind: FaultKind::Silent });
        if causes.is_empty() {
            test_rig.run(0.004);
        }
        return test_rig;
    }
    test_rig.controller.load_show(Some(show(Kind::Current, 0))).unwrap();
    test_rig.run(1.0);
    match state {
        State::Calibrating => test_rig.tick(Some(Command::Calibrate)),
        State::Teaching => test_rig.tick(Some(Command::Teach)),
        State::Faulted => {
            let other = if fault == Fault::EStop { Fault::NotFinite } else { Fault::EStop };
            test_rig.found = FaultSet::of(other);
            test_rig.tick(None);
            test_rig.found = FaultSet::EMPTY;
        }
        State::Limp | State::Off => {}
        _ => {
            assert_eq!(test_rig.ask_to_arm(), None);
            if state != State::Arming {
                test_rig.until(State::Holding, 2.0);
            }
            match state {
                State::Playing => test_rig.tick(Some(Command::Play(Feed::Show))),
                State::Maintenance => test_rig.tick(Some(Command::Maintain(ANN))),
                State::Stopping => {
                    // First the arm moves away from home.
                    test_rig.tick(Some(Command::Play(Feed::Show)));
                    test_rig.run(8.0);
                    // The rig moves home in less time than the link's time-out, so the link is cut before the stop.
                    test_rig.heard = fault != Fault::LinkLost;
                    test_rig.run(1.0);
                    test_rig.tick(Some(Command::Stop));
                }
                State::Lowering => test_rig.tick(Some(Command::Disarm)),
                State::Floating => test_rig.tick(Some(Command::Float)),
                _ => {}
            }
        }
    }
    if test_rig.state() == State::Arming || test_rig.state() == State::Stopping {
        // The state has begun some time ago.
        test_rig.run(0.1);
    }
    assert_eq!(test_rig.state(), state, "for {fault}");
    test_rig
}

/// Creates a fault's condition, or ends it.
fn plant(test_rig: &mut TestRig, fault: Fault, on: bool) {
    let is_led = test_rig.state() == State::Floating;
    let at_s = if on { test_rig.bench.time_s() } else { f64::INFINITY };
    let planted = match fault {
        Fault::ServoStopped => Planted { has_stopped: true, ..Planted::default() },
        Fault::ServoError => Planted { alert: true, ..Planted::default() },
        Fault::HotMeasured => Planted { celsius: Some(66.0), ..Planted::default() },
        // A hundred times the stall current heats a winding in a tick.
        Fault::HotWinding => Planted { current_a: Some(147.0), ..Planted::default() },
        Fault::SupplyLow => Planted { volts: Some(3.0), ..Planted::default() },
        Fault::SupplyHigh => Planted { volts: Some(8.0), ..Planted::default() },
        // The encoder's reading runs away by 30 deg and stops there. In the state floating it runs farther, faster
        // than a hand moves the joint.
        Fault::FollowingError => {
            let is_rad = test_rig.bus.feedback(0).unwrap().position_rad;
            let far_rad = if is_led { 2.0 } else { 0.52 };
            let to_rad = is_rad + if is_rad < std::f32::consts::PI { far_rad } else { -far_rad };
            Planted { runs_to_rad: Some(to_rad), ..Planted::default() }
        }
        Fault::Swing => {
            // After a move by hand only the excess over the permitted speed remains.
            let swing_rad = if is_led { 0.05 } else { 0.01 };
            Planted { swing_rad: Some(swing_rad), ..Planted::default() }
        }
        Fault::Range => {
            Planted { runs_to_rad: Some(std::f32::consts::PI + 2.9), ..Planted::default() }
        }
        Fault::NotFinite => Planted { position_rad: Some(f32::NAN), ..Planted::default() },
        _ => Planted::default(),
    };
    test_rig.bus.planted = if on { planted } else { Planted::default() };
    match fault {
        Fault::LinkLate | Fault::LinkLost => test_rig.heard = !on,
        Fault::ServoSilent => {
            // In the state off, servo 5 is silent too, until this fault is ended.
            if !on {
                test_rig.bench.faults.clear();
            }
            let kind = FaultKind::Silent;
            test_rig.bench.faults.push(Damage { servo: 0, at_s, for_s: f64::INFINITY, kind });
        }
        Fault::Jump => {
            if !on {
                test_rig.bench.faults.clear();
                // The jump is reported for this long.
                test_rig.run(1.0);
            }
            let kind = FaultKind::EncoderJump(5_f64.to_radians());
            test_rig.bench.faults.push(Damage { servo: 0, at_s, for_s: f64::INFINITY, kind });
        }
        Fault::TorqueStuck if on => {
            let kind = FaultKind::TorqueStuck;
            test_rig.bench.faults.push(Damage { servo: 0, at_s, for_s: f64::INFINITY, kind });
        }
        Fault::TorqueStuck => {
            let now_s = test_rig.bench.time_s();
            let stuck = |fault: &&mut Damage| fault.kind == FaultKind::TorqueStuck;
            for fault in test_rig.bench.faults.iter_mut().filter(stuck) {
                fault.for_s = now_s - fault.at_s;
            }
        }
        Fault::Overrun => test_rig.is_late = on,
        Fault::SettingsBad | Fault::EStop | Fault::HostDeaf => {
            test_rig.found = if on { FaultSet::of(fault) } else { FaultSet::EMPTY };
        }
        Fault::ShowBad if on => assert!(test_rig.controller.load_show(Some(&[0; 40])).is_err()),
        Fault::ShowForeign if on => {
            assert!(test_rig.controller.load_show(Some(show(Kind::Current, 7))).is_err());
        }
        Fault::ShowBad | Fault::ShowForeign => {
            test_rig.controller.load_show(Some(show(Kind::Current, 0))).unwrap();
        }
        _ => {}
    }
}

impl Tried for TestRig {
    fn tick(&mut self) {
        self.tick(None);
    }
    fn state(&self) -> State {
        self.state()
    }
    fn has(&self, fault: Fault) -> bool {
        self.controller.report().present.contains(fault)
    }
    fn servos_on(&self) -> usize {
        self.servos_on()
    }
    fn most_current_a(&self) -> f64 {
        self.most_current_a()
    }
    fn sent_off(&self) -> bool {
        self.sent_off()
    }
    fn ticks_of(&self, seconds: f64) -> u32 {
        self.ticks_of(seconds)
    }
}

/// Returns a cell of the page: the reaction to a fault in a state. Asserts everything that must be true.
fn cell(fault: Fault, state: State) -> String {
    if let Some(why) = excuse(fault, state) {
        return why.to_owned();
    }
    let mut test_rig = stand_in(state, fault);
    plant(&mut test_rig, fault, true);
    let measured = measure(&mut test_rig, fault, state);
    let reaction = measured.reaction;
    if reaction == Reaction::Stop {
        comes_to_rest(&mut test_rig, fault);
    }
    let latches = test_rig.controller.report().latched.contains(fault);
    let row = row(fault);
    assert_eq!(latches, row.latches() && reaction > Reaction::Note, "{fault} in {state}");
    if latches {
        clear(&mut test_rig, fault);
    }
    measured.words(fault, state)
}

/// Checks that a stopping rig reaches its rest pose while the fault is still present.
fn comes_to_rest(test_rig: &mut TestRig, fault: Fault) {
    let mut at_rest = vec![];
    for _ in 0..test_rig.ticks_of(15.0) {
        if test_rig.state() != State::Stopping {
            break;
        }
        at_rest = test_rig.controller.measured().to_vec();
        test_rig.tick(None);
    }
    assert_eq!(test_rig.state(), State::Lowering, "{fault}");
    // The tolerance is a following error that is not yet a fault.
    for (at, home) in at_rest.iter().zip(&figure(test_rig.kind).home) {
        assert!((f64::from(*at) - home).abs() < 15_f64.to_radians(), "{fault}: {at} of {home}");
    }
}

/// Checks that a latched fault cannot be cleared while its condition is present, and afterwards only as its row
/// requires.
fn clear(test_rig: &mut TestRig, fault: Fault) {
    let row = row(fault);
    // These faults are found only at the start, or only while torque is on.
    let was_found_once = matches!(
        fault,
        Fault::WatchdogReset | Fault::BrownOut | Fault::Panic | Fault::FollowingError | Fault::Jump
    );
    if row.clears == Clears::Command && !was_found_once {
        test_rig.tick(Some(Command::ClearFaults));
        let report = test_rig.controller.report();
        assert!(report.latched.contains(fault), "{fault}: {:?}", report.answer);
    }
    plant(test_rig, fault, false);
    // Time passes until filters have settled and servos answer again.
    if row.clears == Clears::Command {
        let mut seconds = 0;
        while test_rig.controller.report().latched.contains(fault) {
            test_rig.heard = true;
            test_rig.run(1.0);
            test_rig.tick(Some(Command::ClearFaults));
            seconds += 1;
            assert!(seconds < 400, "{fault} is not cleared: {:?}", test_rig.controller.report());
            // A winding takes minutes to cool; the detector's own test covers that.
            if fault == Fault::HotWinding {
                return;
            }
        }
    } else if fault == Fault::SettingsBad {
        // This fault is cleared by the restart after an upload: see `node/mismatch.rs`.
        test_rig.tick(Some(Command::ClearFaults));
        assert!(test_rig.controller.report().latched.contains(fault), "{fault}");
    } else {
        test_rig.tick(None);
        assert!(!test_rig.controller.report().latched.contains(fault), "{fault}");
    }
}

#[test]
fn the_page_is_what_happens() {
    let ends = |fault: Fault, _: &[String]| {
        let row = row(fault);
        let latches = if row.latches() { "yes" } else { "no" };
        vec![latches.to_owned(), row.clears.to_string()]
    };
    must_be(0, &table(&["latches", "cleared by"], cell, ends));
}
