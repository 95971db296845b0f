//! An encoder that jumps: beside a twin whose encoder does not.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{Command, Fault, Feed, State};
use sinew_servo_sim::fault::{Fault as Damage, FaultKind};

use super::play::show;
use super::test_rig::{Kind, TestRig};

/// Holding, or performing.
fn stand_in(kind: Kind, state: State) -> TestRig {
    let mut test_rig = TestRig::new(kind, Start::default());
    test_rig.controller.load_show(Some(show(kind, 0))).unwrap();
    test_rig.arm();
    test_rig.until(State::Holding, 2.0);
    if state == State::Playing {
        test_rig.tick(Some(Command::Play(Feed::Show)));
        test_rig.run(if kind == Kind::Voltage { 4.0 } else { 8.0 });
    }
    assert_eq!(test_rig.state(), state);
    test_rig
}

/// What a jump does.
#[derive(Debug, Default)]
struct Seen {
    /// Ticks until the fault, if it comes.
    fault: Option<usize>,
    /// How far the joint is from its twin, deg, and how much faster, deg/s.
    off_deg: f64,
    fast_deg_s: f64,
    not_believed: u32,
}

/// Lets servo 0 jump by so much, for so long.
fn jump(kind: Kind, state: State, jump_deg: f64, for_s: f64) -> Seen {
    let run = |damaged: bool, disarmed_in: Option<usize>| {
        let mut test_rig = stand_in(kind, state);
        // Between two readings.
        let at_s = test_rig.bench.time_s() + 0.0004;
        let damage = FaultKind::EncoderJump(jump_deg.to_radians());
        if damaged {
            test_rig.bench.faults.push(Damage { servo: 0, at_s, for_s, kind: damage });
        }
        let mut shafts = vec![];
        let mut fault = None;
        for tick in 0..test_rig.ticks_of(1.0) as usize {
            let command = (Some(tick) == disarmed_in).then_some(Command::Disarm);
            test_rig.tick(command);
            shafts.push(test_rig.bench.servos()[0].shaft());
            let report = test_rig.controller.report();
            if fault.is_none() && report.raised.contains(Fault::Jump) {
                fault = Some(tick);
                assert_eq!(test_rig.state(), State::Lowering);
                let log = test_rig.controller.supervisor().log();
                let record = log.last().find(|record| record.fault == Fault::Jump);
                assert_eq!(record.and_then(|record| record.servo), Some(0));
            }
        }
        let not_believed = test_rig.controller.report().servos[0].not_believed;
        (shafts, fault, not_believed)
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

#[test]
fn a_joint_does_not_move_for_an_encoder_that_jumps() {
    for kind in [Kind::Current, Kind::Voltage, Kind::Position] {
        for state in [State::Holding, State::Playing] {
            for for_s in [f64::INFINITY, 0.9 / f64::from(kind.rate_hz())] {
                for jump_deg in [1.0, 2.0, -2.0, 5.0, 10.0, -15.0, 20.0] {
                    let seen = jump(kind, state, jump_deg, for_s);
                    let Seen { fault, off_deg, fast_deg_s, not_believed } = seen;
                    println!(
                        "{kind:?} {state} {jump_deg} for {for_s:.4}: fault {fault:?}, off {off_deg:.2} deg, \
                         {fast_deg_s:.0} deg/s, {not_believed} not believed"
                    );
                }
            }
        }
    }
}
