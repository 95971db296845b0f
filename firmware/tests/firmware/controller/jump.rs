//! An encoder that jumps by several sizes in all states: the last tables of the page `docs/fault-matrix.md`.
//! The rig is compared with a twin whose encoder does not jump, and which is disarmed in the tick of the fault: the
//! distance between both is the movement that the jump causes.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{Command, Fault, Feed, State};
use sinew_servo_sim::fault::{Fault as Damage, FaultKind};

use super::cell::must_be;
use super::matrix::stand_in;
use super::play::show;
use super::test_rig::{Kind, TestRig};

const JUMPS_DEG: [f64; 4] = [2.0, 5.0, 10.0, 20.0];

/// Measured effect of a jump.
#[derive(Debug, Default, Clone, Copy)]
struct Seen {
    /// Number of ticks until the fault, if it occurs.
    fault: Option<usize>,
    /// Maximum distance of the joint from its twin, deg, and maximum difference of their speeds, deg/s.
    off_deg: f64,
    fast_deg_s: f64,
    not_believed: u32,
}

/// Lets the encoder of servo 0 jump by an angle for a time, in equal rigs that `make` creates.
fn jump(make: impl Fn() -> TestRig, jump_deg: f64, for_s: f64) -> Seen {
    let run = |jumps: bool, disarmed_in: Option<usize>| {
        let mut test_rig = make();
        let state = test_rig.state();
        let counted = test_rig.controller.report().servos[0].not_believed;
        // The jump is between two readings.
        let at_s = test_rig.bench.time_s() + 0.0004;
        let kind = FaultKind::EncoderJump(jump_deg.to_radians());
        if jumps {
            test_rig.bench.faults.push(Damage { servo: 0, at_s, for_s, kind });
        }
        let (mut shafts, mut fault) = (vec![], None);
        for tick in 0..test_rig.ticks_of(0.5) as usize {
            let command = (Some(tick) == disarmed_in).then_some(Command::Disarm);
            test_rig.tick(command);
            shafts.push(test_rig.bench.servos()[0].shaft());
            if fault.is_none() && test_rig.controller.report().present.contains(Fault::Jump) {
                fault = Some(tick);
                let expected = if state.is_on() { State::Lowering } else { state };
                assert_eq!(test_rig.state(), expected);
                let mut records = test_rig.controller.supervisor().log().last();
                let record = records.find(|record| record.fault == Fault::Jump);
                let servo = record.and_then(|record| record.servo);
                assert_eq!(servo, state.is_on().then_some(0), "{state}");
            }
        }
        (shafts, fault, test_rig.controller.report().servos[0].not_believed - counted)
    };
    let (jumped, fault, not_believed) = run(true, None);
    let (twin, ..) = run(false, fault);
    let mut seen = Seen { fault, not_believed, ..Seen::default() };
    for (own, twin) in jumped.iter().zip(&twin) {
        let off_deg = (own.position_rad - twin.position_rad).abs().to_degrees();
        let fast_deg_s = (own.velocity_rad_s - twin.velocity_rad_s).abs().to_degrees();
        seen.off_deg = seen.off_deg.max(off_deg);
        seen.fast_deg_s = seen.fast_deg_s.max(fast_deg_s);
    }
    seen
}

/// Returns the larger effect of a jump in either direction.
fn either_way(make: impl Fn() -> TestRig, jump_deg: f64, for_s: f64) -> Seen {
    let [up, down] = [jump_deg, -jump_deg].map(|jump_deg| jump(&make, jump_deg, for_s));
    Seen {
        fault: up.fault.max(down.fault).filter(|_| up.fault.is_some() == down.fault.is_some()),
        off_deg: up.off_deg.max(down.off_deg),
        fast_deg_s: up.fast_deg_s.max(down.fast_deg_s),
        not_believed: up.not_believed.max(down.not_believed),
    }
}

/// In current mode the joint stays where it was, or continues its movement.
#[test]
fn a_joint_does_not_move_for_an_encoder_that_jumps() {
    let cell = |jump_deg: f64, state: State| {
        let seen = either_way(|| stand_in(state, Fault::Jump), jump_deg, f64::INFINITY);
        let words = seen.fault.map_or_else(|| panic!("in {state}"), |tick| tick + 1);
        assert!(seen.off_deg <= 1.0, "{jump_deg} deg in {state}: {seen:?}");
        if state.is_on() {
            format!("{words}; {:.1} deg", seen.off_deg)
        } else {
            format!("{words}; is off")
        }
    };
    let states = State::ALL.map(|state| state.to_string()).join(" | ");
    let mut lines = vec![
        format!("| a jump that stays | {states} |"),
        format!("| --- |{}", " --- |".repeat(State::COUNT)),
    ];
    for jump_deg in JUMPS_DEG {
        let cells = State::ALL.map(|state| cell(jump_deg, state)).join(" | ");
        lines.push(format!("| {jump_deg} deg | {cells} |"));
    }
    must_be(3, &lines);
}

/// Returns a rig that holds, or that plays.
fn held(kind: Kind, plays: bool) -> TestRig {
    let mut test_rig = TestRig::new(kind, Start::default());
    test_rig.controller.load_show(Some(show(kind, 0))).unwrap();
    test_rig.arm();
    test_rig.until(State::Holding, 2.0);
    if plays {
        test_rig.tick(Some(Command::Play(Feed::Show)));
        test_rig.run(if kind == Kind::Voltage { 4.0 } else { 8.0 });
        assert_eq!(test_rig.state(), State::Playing);
    }
    test_rig
}

/// For each class, a jump that stays, and a jump of a single reading.
#[test]
fn a_servo_by_position_follows_its_encoder_for_a_moment() {
    let mut lines = vec![];
    let mut heads = vec!["a jump".to_owned()];
    let classes = [
        ("current, 400 Hz", Kind::Current),
        ("voltage, 400 Hz", Kind::Voltage),
        ("position, 100 Hz", Kind::Position),
    ];
    for (name, _) in classes {
        heads.extend(["holding", "playing"].map(|state| format!("{name}: {state}")));
    }
    lines.push(format!("| {} |", heads.join(" | ")));
    lines.push(format!("|{}", " --- |".repeat(heads.len())));
    for stays in [true, false] {
        for jump_deg in JUMPS_DEG {
            let mut line = vec![format!("{jump_deg} deg{}", if stays { "" } else { " once" })];
            for (name, kind) in classes {
                for plays in [false, true] {
                    let once_s = 0.9 / f64::from(kind.rate_hz());
                    let for_s = if stays { f64::INFINITY } else { once_s };
                    let seen = either_way(|| held(kind, plays), jump_deg, for_s);
                    assert!(stays || seen.fault.is_none(), "{name} {jump_deg}: {seen:?}");
                    let fault = match seen.fault {
                        Some(tick) => format!("{}; ", tick + 1),
                        None if stays => "not seen; ".to_owned(),
                        None => String::new(),
                    };
                    let Seen { off_deg, fast_deg_s, .. } = seen;
                    line.push(format!("{fault}{off_deg:.1} deg, {fast_deg_s:.0} deg/s"));
                }
            }
            lines.push(format!("| {} |", line.join(" | ")));
        }
    }
    must_be(4, &lines);
}
