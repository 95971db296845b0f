//! Tests that the chip's watchdog resets a core that hangs.

use std::time::Duration;

use sinew_board_client::Board;
use sinew_firmware::supervisor::Fault;
use sinew_link::message::{Command, Feed, State};
use sinew_nucleo::MachineEvent;

use crate::test_rig::{
    Emulated, LOWER_S, Rig, SECOND, arm_it, load, ready, servos_on, set_lowering, until,
};

const MS: u64 = 1_000_000;

/// Hangs the core. Checks that the watchdog, which counts in steps of 2 ms, resets the core after `bites_ms`, and that
/// the board has restarted 50 ms later.
fn hang(board: &mut Emulated, tick_ns: u64, bites_ms: u64) {
    board.other.clear();
    let hung_ns = board.servos.at_ns();
    board.servos.machine.hang().unwrap();
    board.run_until(hung_ns + (bites_ms + 50) * MS).unwrap();
    let resets: Vec<_> =
        board.other.iter().filter(|heard| matches!(heard, MachineEvent::Reset(..))).collect();
    let [MachineEvent::Reset(at_ns, by)] = resets.as_slice() else { panic!("{resets:?}") };
    assert_eq!(by, "iwdg");
    // The last feed was at most a tick ago. A count had already begun then, and the reset comes one count late.
    let took_ns = at_ns - hung_ns;
    let allowed = bites_ms * MS - tick_ns..=(bites_ms + 4) * MS;
    assert!(allowed.contains(&took_ns), "{took_ns} ns, not {allowed:?}");
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_that_hangs_is_reset_and_comes_back_limp_with_all_that_it_kept() {
    let rig = Rig::new(3);
    let mut board = ready(&rig);
    set_lowering(&mut board, 2.0);
    load(&mut board, &rig);
    arm_it(&mut board);
    board.ask(Command::Play(Feed::Show)).unwrap();
    until(&mut board, State::Playing, 1);
    board.run(SECOND / 2).unwrap();

    // Now the core hangs with torque on.
    assert_eq!(servos_on(board.line_mut()), 3);
    hang(board.line_mut(), rig.tick_ns(), 100);
    assert_eq!(servos_on(board.line_mut()), 0);
    comes_back(&mut board, &rig);
    // Now with torque off, where the watchdog is longer: an erase of flash may take 2 s.
    hang(board.line_mut(), rig.tick_ns(), 4000);
    comes_back(&mut board, &rig);

    arm_it(&mut board);
    board.ask(Command::Play(Feed::Show)).unwrap();
    until(&mut board, State::Playing, 1);
}

/// Checks that the board reports the cause of its restart, moves nothing, and has kept all its data.
fn comes_back(board: &mut Board<Emulated>, rig: &Rig) {
    board.reconnect(5 * SECOND).unwrap();
    assert_eq!(board.about().rig, rig.parts.rig_crc());
    assert!((board.setting(LOWER_S).unwrap() - 2.0).abs() < 1e-6);
    load(board, rig);
    until(board, State::Faulted, 1);
    let summary = board.log.summary.unwrap();
    assert_eq!(summary.fault, Some(Fault::WatchdogReset.number()));
    board.run(Duration::from_millis(200)).unwrap();
    assert_eq!(servos_on(board.line_mut()), 0);
    board.ask(Command::ClearFaults).unwrap();
    until(board, State::Limp, 1);
}
