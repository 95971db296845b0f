//! A servo that keeps its torque, whatever it is told: its register says so, and nobody is armed.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{Command, Fault, Refused, State};
use sinew_servo_sim::fault::{Fault as Damage, FaultKind};

use super::stand::{Kind, SERVOS, Stand};

const WHO: usize = 2;
const KINDS: [Kind; 2] = [Kind::Current, Kind::Position];

fn stick(stand: &mut Stand) {
    let (at_s, for_s) = (stand.bench.time_s(), f64::INFINITY);
    stand.bench.faults.push(Damage { servo: WHO, at_s, for_s, kind: FaultKind::TorqueStuck });
}

fn mend(stand: &mut Stand) {
    stand.bench.faults.clear();
    stand.bench.servos_mut()[WHO].stick_torque(false);
}

/// The fault is told, of this servo, and refuses to arm. When it is over, a command clears it.
fn is_refused_until_mended(mut stand: Stand) {
    let kind = stand.kind;
    stand.until(State::Faulted, 1.0);
    let report = stand.controller.report();
    assert!(report.latched.contains(Fault::TorqueStuck), "{kind:?}: {report:?}");
    let first = stand.controller.supervisor().log().first().unwrap();
    assert_eq!((first.fault, first.servo), (Fault::TorqueStuck, Some(WHO as u16)), "{kind:?}");
    let refused = Some(Refused::Fault(Fault::TorqueStuck));
    assert_eq!((stand.ask_to_arm(), stand.servos_on()), (refused, 1), "{kind:?}");
    stand.tick(Some(Command::ClearFaults));
    let answer = stand.controller.report().answer;
    assert_eq!(answer, Some(Err(Refused::StillThere(Fault::TorqueStuck))), "{kind:?}");

    mend(&mut stand);
    stand.run(1.0);
    assert_eq!(stand.servos_on(), 0, "{kind:?}");
    stand.tick(Some(Command::ClearFaults));
    stand.run(0.5);
    assert_eq!((stand.ask_to_arm(), stand.state()), (None, State::Arming), "{kind:?}");
    stand.run(0.1);
    assert_eq!(stand.servos_on(), SERVOS, "{kind:?}");
}

#[test]
fn a_servo_that_keeps_its_torque_from_the_start_is_never_armed() {
    for kind in KINDS {
        let mut stand = Stand::new(kind, Start::default());
        stick(&mut stand);
        is_refused_until_mended(stand);
    }
}

#[test]
fn a_servo_that_keeps_its_torque_after_a_stop_is_not_armed_again() {
    for kind in KINDS {
        let mut stand = Stand::new(kind, Start::default());
        stand.arm();
        stand.until(State::Holding, 2.0);
        stick(&mut stand);
        stand.tick(Some(Command::Disarm));
        stand.until(State::Limp, 5.0);
        is_refused_until_mended(stand);
    }
}
