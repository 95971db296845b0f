//! Tests the rows of the fault matrix that the emulated NUCLEO can show, and the contents of its flash.

use std::io;
use std::sync::OnceLock;
use std::time::Duration;

use sinew_board_client::{Board, Line};
use sinew_firmware::supervisor::Fault;
use sinew_link::message::{Command, Feed, State};

use crate::test_rig::{
    Emulated, LOWER_S, Rig, SECOND, arm_it, connected, has_told, load, ready, servos_on,
    set_lowering, until, with_rig,
};

/// Returns a board that plays the show of an arm with three servos, from its flash.
fn playing(rig: &Rig) -> Board<Emulated> {
    static FLASH: OnceLock<Vec<u8>> = OnceLock::new();
    let flash = FLASH.get_or_init(|| ready(rig).line_mut().servos.machine.flash().unwrap());
    let mut board = connected(rig.power_on(Some(flash)));
    assert_eq!(board.about().rig, rig.parts.rig_crc(), "flash keeps the rig");
    load(&mut board, rig);
    arm_it(&mut board);
    board.ask(Command::Play(Feed::Show)).unwrap();
    until(&mut board, State::Playing, 1);
    assert_eq!(servos_on(board.line_mut()), 3);
    board
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_lets_go_within_two_ticks_of_the_emergency_stop() {
    let rig = Rig::new(3);
    let mut board = playing(&rig);
    let line = board.line_mut();
    let pressed_ns = line.servos.at_ns();
    line.servos.machine.pin("PC8", false).unwrap();
    line.run_until(pressed_ns + 2 * rig.tick_ns()).unwrap();
    assert_eq!(servos_on(line), 0);
    until(&mut board, State::Faulted, 1);
    assert!(has_told(&board, Fault::EStop));
    // While the loop is open, nothing clears the fault. After closing and clearing, nothing moves.
    let _ = board.ask(Command::ClearFaults);
    board.run(SECOND / 5).unwrap();
    assert_eq!(board.fresh_state(SECOND).unwrap(), State::Faulted);
    board.line_mut().servos.machine.pin("PC8", true).unwrap();
    board.run(SECOND / 5).unwrap();
    board.ask(Command::ClearFaults).unwrap();
    until(&mut board, State::Limp, 1);
    assert_eq!(servos_on(board.line_mut()), 0);
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_lowers_a_rig_with_a_silent_servo() {
    let rig = Rig::new(3);
    let mut board = playing(&rig);
    let bench = &mut board.line_mut().servos.line.servos;
    bench.bench_mut().servos_mut()[1].set_baud(57_600).unwrap();
    until(&mut board, State::Lowering, 1);
    assert!(has_told(&board, Fault::ServoSilent));
    until(&mut board, State::Faulted, 4);
    // The silent servo receives nothing either: its own watchdog has stopped it.
    assert_eq!(servos_on(board.line_mut()), 1);
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_lowers_a_rig_whose_host_is_gone() {
    let rig = Rig::new(3);
    let mut board = playing(&rig);
    let line = board.line_mut();
    let gone_ns = line.servos.at_ns();
    // The link counts as lost 2 s after the last beat, which is some 50 ms old. Torque goes off when the joints have
    // rested for 1 s, at the latest after 18 s.
    line.run_until(gone_ns + 2_950_000_000).unwrap();
    assert_eq!(servos_on(line), 3);
    while servos_on(line) > 0 {
        let at_ns = line.servos.at_ns();
        assert!(at_ns < gone_ns + 20_100_000_000, "torque stays on");
        line.run_until(at_ns + 100_000_000).unwrap();
    }
    board.run(SECOND / 5).unwrap();
    until(&mut board, State::Faulted, 1);
    assert!(has_told(&board, Fault::LinkLost));
}

/// A board whose reset button is pressed at a given time.
struct ResetAt(Emulated, Option<Duration>);

impl Line for ResetAt {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let Self(board, at) = self;
        if let Some(at) = at.take_if(|at| *at <= board.now() + wait) {
            board.run_until(u64::try_from(at.as_nanos()).unwrap_or(u64::MAX))?;
            board.servos.machine.reset().map_err(io::Error::other)?;
        }
        board.receive(into, wait)
    }

    fn now(&self) -> Duration {
        self.0.now()
    }
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_takes_an_upload_again_after_a_reset_in_it() {
    let rig = Rig::new(3);
    let mut board = with_rig(&rig);
    let flash = board.line_mut().servos.machine.flash().unwrap();
    let begun = board.now();
    board.upload(&rig.show_item(), &rig.show, &mut |_| ()).unwrap();
    let took = board.now().saturating_sub(begun);
    // During the erase, at its end, between blocks, and at the end.
    for part in [0.1, 0.5, 0.9, 0.97] {
        let line = ResetAt(rig.power_on(Some(&flash)), None);
        let mut board = Board::connect(line, 1, 5 * SECOND).unwrap();
        board.line_mut().1 = Some(board.now() + took.mul_f32(part));
        let cut = board.upload(&rig.show_item(), &rig.show, &mut |_| ());
        assert!(board.line_mut().1.is_none(), "the button was pressed");
        assert!(cut.is_err(), "at {part} of {took:?}");
        board.reconnect(5 * SECOND).unwrap();
        assert_eq!(board.about().rig, rig.parts.rig_crc(), "the rig is still there");
        board.upload(&rig.show_item(), &rig.show, &mut |_| ()).unwrap();
        let slot = board.slot_of(&rig.show_item()).unwrap().expect("it is whole");
        board.ask(Command::LoadShow { slot }).unwrap();
    }
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_keeps_rig_show_and_settings_over_a_power_cut() {
    let rig = Rig::new(3);
    let mut board = ready(&rig);
    set_lowering(&mut board, 2.0);
    let flash = board.line_mut().servos.machine.flash().unwrap();
    let mut board = connected(rig.power_on(Some(&flash)));
    assert_eq!(board.about().rig, rig.parts.rig_crc());
    assert!((board.setting(LOWER_S).unwrap() - 2.0).abs() < 1e-6);
    load(&mut board, &rig);
}
