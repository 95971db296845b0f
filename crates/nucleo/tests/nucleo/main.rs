//! Tests the emulated NUCLEO with its own image, from the host's side. `cargo xtask emulate` builds both.

mod chip;
mod faults;
mod hang;
mod in_process;
mod servos;
mod test_rig;
mod walk;

use sinew_link::message::Command;
use sinew_nucleo::MachineEvent;

use test_rig::{Rig, SECOND, TORQUE_OFF, connected};

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_boots_says_torque_off_and_greets() {
    let mut board = connected(Rig::new(1).power_on(None));
    assert_eq!(board.about().rig, 0, "its flash is blank");
    let line = board.line_mut();
    let stray = line.other.iter().find(|heard| matches!(heard, MachineEvent::Stray(..)));
    assert_eq!(stray, None, "its stack has run over, or an address is none");
    // Torque off is sent twice, completely, and before anything else.
    let said: Vec<&[u8]> = line.bus.iter().map(|burst| burst.bytes.as_slice()).collect();
    assert_eq!(said, [TORQUE_OFF, TORQUE_OFF].concat());
}

/// Tests a basic property of the host link: the time of an answer.
#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_answers_while_its_servos_are_silent() {
    let rig = Rig::new(5);
    let mut board = connected(rig.power_on(None));
    let bench = &mut board.line_mut().servos.line.servos;
    bench.bench_mut().servos_mut().iter_mut().for_each(|servo| servo.set_baud(57_600).unwrap());
    board.upload(&rig.item(), &rig.bytes, &mut |_| ()).unwrap();
    for _ in 0..10 {
        let asked = board.now();
        board.ask(Command::ReadFault { index: 0 }).unwrap();
        let took = board.now().saturating_sub(asked);
        assert!(took < SECOND / 20, "an answer took {took:?}");
    }
}
