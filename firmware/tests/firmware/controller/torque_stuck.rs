//! A servo that keeps its torque in spite of commands: its register reports it, and the rig cannot be armed.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{Command, Fault, Refused, State};
use sinew_servo_sim::fault::{Fault as Damage, FaultKind};

use super::test_rig::{Kind, SERVOS, TestRig};

const WHO: usize = 2;
const KINDS: [Kind; 3] = [Kind::Current, Kind::Voltage, Kind::Position];

fn stick(test_rig: &mut TestRig) {
    let (at_s, for_s) = (test_rig.bench.time_s(), f64::INFINITY);
    test_rig.bench.faults.push(Damage { servo: WHO, at_s, for_s, kind: FaultKind::TorqueStuck });
}

fn mend(test_rig: &mut TestRig) {
    test_rig.bench.faults.clear();
    test_rig.bench.servos_mut()[WHO].stick_torque(false);
}

/// Checks that the fault is reported for this servo and prevents arming, and that a command clears the fault after its
/// condition has ended.
fn is_refused_until_mended(mut test_rig: TestRig) {
    let kind = test_rig.kind;
    test_rig.until(State::Faulted, 1.0);
    let report = test_rig.controller.report();
    assert!(report.latched.contains(Fault::TorqueStuck), "{kind:?}: {report:?}");
    let first = test_rig.controller.supervisor().log().first().unwrap();
    assert_eq!((first.fault, first.servo), (Fault::TorqueStuck, Some(WHO as u16)), "{kind:?}");
    let refused = Some(Refused::Fault(Fault::TorqueStuck));
    assert_eq!((test_rig.ask_to_arm(), test_rig.servos_on()), (refused, 1), "{kind:?}");
    test_rig.tick(Some(Command::ClearFaults));
    let answer = test_rig.controller.report().answer;
    assert_eq!(answer, Some(Err(Refused::StillThere(Fault::TorqueStuck))), "{kind:?}");

    mend(&mut test_rig);
    test_rig.run(1.0);
    assert_eq!(test_rig.servos_on(), 0, "{kind:?}");
    test_rig.tick(Some(Command::ClearFaults));
    test_rig.run(0.5);
    assert_eq!((test_rig.ask_to_arm(), test_rig.state()), (None, State::Arming), "{kind:?}");
    test_rig.run(0.1);
    assert_eq!(test_rig.servos_on(), SERVOS, "{kind:?}");
}

#[test]
fn a_servo_that_keeps_its_torque_from_the_start_is_never_armed() {
    for kind in KINDS {
        let mut test_rig = TestRig::new(kind, Start::default());
        stick(&mut test_rig);
        is_refused_until_mended(test_rig);
    }
}

#[test]
fn a_servo_that_keeps_its_torque_after_a_stop_is_not_armed_again() {
    for kind in KINDS {
        let mut test_rig = TestRig::new(kind, Start::default());
        test_rig.arm();
        test_rig.until(State::Holding, 2.0);
        stick(&mut test_rig);
        test_rig.tick(Some(Command::Disarm));
        test_rig.until(State::Limp, 20.0);
        is_refused_until_mended(test_rig);
    }
}
