//! Every fault in every state, by planted conditions: the page `docs/fault-matrix.md`.
//!
//! The arm of XL330 in current mode, 400 ticks a second.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{
    Clears, Command, Fault, FaultSet, Feed, Operator, Reaction, State, TABLE,
};
use sinew_servo_sim::fault::{Fault as Damage, FaultKind};

use super::cell::{Tried, measure, must_be, table};
use super::play::show;
use super::stand::{Kind, Planted, Stand, figure};

const ANN: Operator = Operator(1);

/// Why a fault cannot come in a state.
fn excuse(fault: Fault, state: State) -> Option<&'static str> {
    use Fault::{
        BrownOut, FollowingError, LinkLost, Panic, ServoStopped, ShowBad, ShowForeign, TorqueStuck,
        WatchdogReset,
    };
    match fault {
        WatchdogReset | BrownOut | Panic if state != State::Off => Some("at the start alone"),
        ShowBad | ShowForeign if state != State::Playing => Some("no show plays"),
        ServoStopped if !state.is_on() => Some("its watchdog rests"),
        TorqueStuck if state.is_on() => Some("torque is to be on"),
        FollowingError if !state.is_on() => Some("nothing is followed"),
        FollowingError if state == State::Lowering => Some("it sinks on purpose"),
        LinkLost if state == State::Arming => Some("over after 1 s"),
        LinkLost if state == State::Playing => Some("link late holds it before"),
        _ => None,
    }
}

/// A stand in a state. In `Off` a servo was never read.
fn stand_in(state: State, fault: Fault) -> Stand {
    let causes = match fault {
        Fault::WatchdogReset | Fault::BrownOut | Fault::Panic => FaultSet::of(fault),
        _ => FaultSet::EMPTY,
    };
    let mut stand = Stand::new(Kind::Current, Start { causes, ..Start::default() });
    if state == State::Off {
        let for_s = f64::INFINITY;
        stand.bench.faults.push(Damage { servo: 5, at_s: 0.0, for_s, kind: FaultKind::Silent });
        if causes.is_empty() {
            stand.run(0.004);
        }
        return stand;
    }
    stand.controller.load_show(Some(show(Kind::Current, 0))).unwrap();
    stand.run(1.0);
    match state {
        State::Calibrating => stand.tick(Some(Command::Calibrate)),
        State::Teaching => stand.tick(Some(Command::Teach)),
        State::Faulted => {
            let other = if fault == Fault::EStop { Fault::NotFinite } else { Fault::EStop };
            stand.found = FaultSet::of(other);
            stand.tick(None);
            stand.found = FaultSet::EMPTY;
        }
        State::Limp | State::Off => {}
        _ => {
            assert_eq!(stand.ask_to_arm(), None);
            if state != State::Arming {
                stand.until(State::Holding, 2.0);
            }
            match state {
                State::Playing => stand.tick(Some(Command::Play(Feed::Show))),
                State::Maintenance => stand.tick(Some(Command::Maintain(ANN))),
                State::Stopping => {
                    // Away from home first.
                    stand.tick(Some(Command::Play(Feed::Show)));
                    stand.run(8.0);
                    // The way home takes less than the time-out: the link was cut before.
                    stand.heard = fault != Fault::LinkLost;
                    stand.run(1.0);
                    stand.tick(Some(Command::Stop));
                }
                State::Lowering => stand.tick(Some(Command::Disarm)),
                State::Floating => stand.tick(Some(Command::Float)),
                _ => {}
            }
        }
    }
    if stand.state() == State::Arming || stand.state() == State::Stopping {
        // Some way into it.
        stand.run(0.1);
    }
    assert_eq!(stand.state(), state, "for {fault}");
    stand
}

/// Makes a fault's condition, or ends it.
fn plant(stand: &mut Stand, fault: Fault, on: bool) {
    let is_led = stand.state() == State::Floating;
    let at_s = if on { stand.bench.time_s() } else { f64::INFINITY };
    let planted = match fault {
        Fault::ServoStopped => Planted { has_stopped: true, ..Planted::default() },
        Fault::ServoError => Planted { alert: true, ..Planted::default() },
        Fault::HotMeasured => Planted { celsius: Some(66.0), ..Planted::default() },
        // A hundred times the stall current heats a winding in a tick.
        Fault::HotWinding => Planted { current_a: Some(147.0), ..Planted::default() },
        Fault::SupplyLow => Planted { volts: Some(3.0), ..Planted::default() },
        Fault::SupplyHigh => Planted { volts: Some(8.0), ..Planted::default() },
        // A slip is taken for the hand's lead; an encoder that swings is ahead of what any hand leads.
        Fault::FollowingError if is_led => Planted { off_rad: [0.35, -0.35], ..Planted::default() },
        // A horn that has slipped by 20 deg.
        Fault::FollowingError => Planted { off_rad: [0.35; 2], ..Planted::default() },
        Fault::Range => {
            Planted { position_rad: Some(std::f32::consts::PI + 2.9), ..Planted::default() }
        }
        Fault::NotFinite => Planted { position_rad: Some(f32::NAN), ..Planted::default() },
        _ => Planted::default(),
    };
    stand.bus.planted = if on { planted } else { Planted::default() };
    match fault {
        Fault::LinkLate | Fault::LinkLost => stand.heard = !on,
        Fault::ServoSilent => {
            // What keeps a rig off stays until it is mended.
            if !on {
                stand.bench.faults.clear();
            }
            let kind = FaultKind::Silent;
            stand.bench.faults.push(Damage { servo: 0, at_s, for_s: f64::INFINITY, kind });
        }
        Fault::TorqueStuck if on => {
            let kind = FaultKind::TorqueStuck;
            stand.bench.faults.push(Damage { servo: 0, at_s, for_s: f64::INFINITY, kind });
        }
        Fault::TorqueStuck => {
            let now_s = stand.bench.time_s();
            let stuck = |fault: &&mut Damage| fault.kind == FaultKind::TorqueStuck;
            for fault in stand.bench.faults.iter_mut().filter(stuck) {
                fault.for_s = now_s - fault.at_s;
            }
        }
        Fault::Overrun => stand.is_late = on,
        Fault::SettingsBad | Fault::EStop => {
            stand.found = if on { FaultSet::of(fault) } else { FaultSet::EMPTY };
        }
        Fault::ShowBad if on => assert!(stand.controller.load_show(Some(&[0; 40])).is_err()),
        Fault::ShowForeign if on => {
            assert!(stand.controller.load_show(Some(show(Kind::Current, 7))).is_err());
        }
        Fault::ShowBad | Fault::ShowForeign => {
            stand.controller.load_show(Some(show(Kind::Current, 0))).unwrap();
        }
        _ => {}
    }
}

impl Tried for Stand {
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

/// What became of a fault in a state: a cell of the page. What must hold is asserted.
fn cell(fault: Fault, state: State) -> String {
    if let Some(why) = excuse(fault, state) {
        return why.to_owned();
    }
    let mut stand = stand_in(state, fault);
    plant(&mut stand, fault, true);
    let measured = measure(&mut stand, fault, state);
    let reaction = measured.reaction;
    if reaction == Reaction::Stop {
        comes_to_rest(&mut stand, fault);
    }
    let latches = stand.controller.report().latched.contains(fault);
    let row = &TABLE[usize::from(fault.number()) - 1];
    assert_eq!(latches, row.latches() && reaction > Reaction::Note, "{fault} in {state}");
    if latches {
        clear(&mut stand, fault);
    }
    measured.words(fault, state)
}

/// A rig that stops gets to its rest pose, with the fault still there.
fn comes_to_rest(stand: &mut Stand, fault: Fault) {
    let mut at_rest = vec![];
    for _ in 0..stand.ticks_of(15.0) {
        if stand.state() != State::Stopping {
            break;
        }
        at_rest = stand.controller.measured().to_vec();
        stand.tick(None);
    }
    assert_eq!(stand.state(), State::Lowering, "{fault}");
    // As near as the following error allows that is no fault.
    for (at, home) in at_rest.iter().zip(&figure(stand.kind).home) {
        assert!((f64::from(*at) - home).abs() < 15_f64.to_radians(), "{fault}: {at} of {home}");
    }
}

/// A latched fault is not cleared while its condition is there, and by what its row says when it is over.
fn clear(stand: &mut Stand, fault: Fault) {
    let row = &TABLE[usize::from(fault.number()) - 1];
    // Found at the start alone, or as long as torque is on.
    let was_found_once = matches!(
        fault,
        Fault::WatchdogReset | Fault::BrownOut | Fault::Panic | Fault::FollowingError
    );
    if row.clears == Clears::Command && !was_found_once {
        stand.tick(Some(Command::ClearFaults));
        let report = stand.controller.report();
        assert!(report.latched.contains(fault), "{fault}: {:?}", report.answer);
    }
    plant(stand, fault, false);
    // Filters follow, and servos answer again.
    if row.clears == Clears::Command {
        let mut seconds = 0;
        while stand.controller.report().latched.contains(fault) {
            stand.heard = true;
            stand.run(1.0);
            stand.tick(Some(Command::ClearFaults));
            seconds += 1;
            assert!(seconds < 400, "{fault} is not cleared: {:?}", stand.controller.report());
            // A winding takes minutes to cool, which is the detector's own test.
            if fault == Fault::HotWinding {
                return;
            }
        }
    } else if fault == Fault::SettingsBad {
        // By the start that an upload leads to: see `node/mismatch.rs`.
        stand.tick(Some(Command::ClearFaults));
        assert!(stand.controller.report().latched.contains(fault), "{fault}");
    } else {
        stand.tick(None);
        assert!(!stand.controller.report().latched.contains(fault), "{fault}");
    }
}

#[test]
fn the_page_is_what_happens() {
    let ends = |fault: Fault, _: &[String]| {
        let row = &TABLE[usize::from(fault.number()) - 1];
        let latches = if row.latches() { "yes" } else { "no" };
        vec![latches.to_owned(), row.clears.to_string()]
    };
    must_be(0, &table(&["latches", "cleared by"], cell, ends));
}
