//! Every fault in every state, by planted conditions: the page `docs/fault-matrix.md`.
//!
//! The arm of XL330 in current mode, 400 ticks a second.

use std::fmt::Write;

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{
    Clears, Command, Fault, FaultSet, Feed, Operator, Reaction, State, TABLE,
};
use sinew_servo_sim::fault::{Fault as Damage, FaultKind};

use crate::play::show;
use crate::stand::{Kind, Planted, SERVOS, Stand, figure};

const PAGE: &str = include_str!("../../../docs/fault-matrix.md");
const ANN: Operator = Operator(1);
/// A motor that draws less is without torque, A: a thousandth of an XL330's stall.
const NOTHING_A: f64 = 1.5e-3;

/// Why a fault cannot come in a state.
fn excuse(fault: Fault, state: State) -> Option<&'static str> {
    use Fault::{BrownOut, FollowingError, LinkLost, Panic, ShowBad, ShowForeign, WatchdogReset};
    match fault {
        WatchdogReset | BrownOut | Panic if state != State::Off => Some("at the start alone"),
        ShowBad | ShowForeign if state != State::Playing => Some("no show plays"),
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
    let at_s = if on { stand.bench.time_s() } else { f64::INFINITY };
    let planted = match fault {
        Fault::ServoError => Planted { alert: true, ..Planted::default() },
        Fault::HotMeasured => Planted { celsius: Some(66.0), ..Planted::default() },
        // A hundred times the stall current heats a winding in a tick.
        Fault::HotWinding => Planted { current_a: Some(147.0), ..Planted::default() },
        Fault::SupplyLow => Planted { volts: Some(3.0), ..Planted::default() },
        Fault::SupplyHigh => Planted { volts: Some(8.0), ..Planted::default() },
        // A horn that has slipped by 20 deg.
        Fault::FollowingError => Planted { off_rad: 0.35, ..Planted::default() },
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

/// What became of a fault in a state: a cell of the page. What must hold is asserted.
fn cell(fault: Fault, state: State) -> String {
    if let Some(why) = excuse(fault, state) {
        return why.to_owned();
    }
    let mut stand = stand_in(state, fault);
    let reaction = TABLE[usize::from(fault.number()) - 1].reaction(state);
    let carried_a = stand.most_current_a();
    plant(&mut stand, fault, true);
    let mut noticed = 0_u32;
    loop {
        stand.tick(None);
        noticed += 1;
        if stand.controller.report().present.contains(fault) {
            break;
        }
        assert!(noticed < 4_000, "{fault} is not noticed in {state}");
        assert_eq!(stand.state(), state, "{state} ended before {fault}");
    }
    // From here on: ticks until bytes and torque are as the reaction says. 0: those of this very tick.
    let (mut bytes, mut torque) = (None, None);
    for tick in 0..stand.ticks_of(4.0) {
        let is_off = stand.servos_on() == 0 && stand.most_current_a() < NOTHING_A;
        bytes = bytes.or_else(|| stand.sent_off().then_some(tick));
        torque = torque.or_else(|| is_off.then_some(tick));
        let stays = matches!(reaction, Reaction::Note | Reaction::Hold | Reaction::Stop);
        if tick == 0 {
            let expected: &[State] = match reaction {
                Reaction::Limp => &[State::Faulted],
                Reaction::Lower => &[State::Lowering],
                Reaction::Stop => &[State::Stopping],
                Reaction::Hold => &[State::Holding, State::Maintenance],
                Reaction::Note => &[state],
            };
            let now = stand.state();
            assert!(expected.contains(&now), "{fault} in {state}: {now}, {reaction}");
        }
        if (bytes.is_some() && torque.is_some()) || (stays && tick == 2) {
            break;
        }
        // What is lowered is carried on the way down: half a second from here some of the torque is there. The least
        // share of effort is 0.3, and the least that lowering has left of it, after 2.5 s of 3, a sixth.
        if reaction == Reaction::Lower && tick == stand.ticks_of(0.5) {
            assert_eq!(stand.servos_on(), SERVOS, "{fault} in {state}");
            let later_a = stand.most_current_a();
            assert!(later_a > 0.05 * carried_a, "{fault} in {state}: {carried_a} to {later_a}");
        }
        stand.tick(None);
    }
    if reaction == Reaction::Stop {
        comes_to_rest(&mut stand, fault);
    }
    let latches = stand.controller.report().latched.contains(fault);
    let row = &TABLE[usize::from(fault.number()) - 1];
    assert_eq!(latches, row.latches() && reaction > Reaction::Note, "{fault} in {state}");
    if latches {
        clear(&mut stand, fault);
    }
    match (reaction, bytes, torque) {
        (Reaction::Limp, Some(bytes), Some(torque)) => {
            assert!(bytes <= 2 && torque <= 2, "{fault} in {state}: {bytes}, {torque}");
            format!("{noticed}; off {bytes}, {torque}")
        }
        (Reaction::Lower, Some(bytes), Some(torque)) => {
            assert!(bytes.abs_diff(torque) <= 2, "{fault} in {state}");
            let seconds = f64::from(bytes) / f64::from(stand.kind.rate_hz());
            format!("{noticed}; lowers 0, off {seconds:.1} s")
        }
        (Reaction::Note, Some(0), Some(0)) => format!("{noticed}; is off"),
        (Reaction::Note, ..) => format!("{noticed}; told"),
        (Reaction::Hold, None, None) => format!("{noticed}; holds 0"),
        (Reaction::Stop, None, None) => format!("{noticed}; stops 0"),
        found => panic!("{fault} in {state}: {found:?}"),
    }
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
    let mut table = "| | fault |".to_owned();
    for state in State::ALL {
        write!(table, " {state} |").unwrap();
    }
    writeln!(table, " latches | cleared by |\n| ---: | --- |{}", " --- |".repeat(State::COUNT + 2))
        .unwrap();
    for row in TABLE {
        let (number, name) = (row.fault.number(), row.fault.name());
        write!(table, "| {number} | {name} |").unwrap();
        for state in State::ALL {
            write!(table, " {} |", cell(row.fault, state)).unwrap();
        }
        let latches = if row.latches() { "yes" } else { "no" };
        writeln!(table, " {latches} | {} |", row.clears).unwrap();
    }
    let of_page: Vec<&str> = PAGE.lines().filter(|line| line.starts_with('|')).collect();
    let printed: Vec<&str> = table.lines().collect();
    assert!(of_page == printed, "the table of docs/fault-matrix.md must be:\n{table}");
}
