//! Tests the emulated chip with an image that uses its peripherals. `cargo xtask emulate` builds both, and sets the
//! paths; without them, these tests are ignored.

mod board;

use board::{Board, MS, PING, S};
use sinew_nucleo::MachineEvent;

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_chip_boots_at_180_mhz() {
    let mut board = Board::new("SINEW_CHIP_IMAGE");
    board.run(100 * MS);
    assert!(board.said.starts_with("boot 180000000 true ffffffff\n"), "{}", board.said);
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_ping_leaves_whole_and_is_answered() {
    let mut board = Board::new("SINEW_CHIP_IMAGE");
    board.run(S);
    let (own, servos): (Vec<_>, Vec<_>) = board.bus.iter().partition(|burst| burst.is_own);
    assert!(own.len() > 400, "{} pings in a second", own.len());
    assert!(
        own.iter().all(|burst| burst.bytes == PING),
        "{:?}",
        own.iter().find(|b| b.bytes != PING)
    );
    // The last answer may not be complete.
    assert!(servos.len() + 1 >= own.len(), "{} answers to {} pings", servos.len(), own.len());
    let last = board.said.lines().rfind(|line| line.starts_with("ticks")).unwrap();
    let numbers: Vec<u32> = last.split(' ').filter_map(|word| word.parse().ok()).collect();
    assert_eq!(
        numbers[0], numbers[1],
        "ticks, and pings that the board says were answered: {last}"
    );
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_ping_is_cut_off_without_what_mends_embassy() {
    let mut board = Board::new("SINEW_STALE_TC_IMAGE");
    board.run(S);
    let own: Vec<_> = board.bus.iter().filter(|burst| burst.is_own).collect();
    assert!(own.len() > 400, "{} pings in a second", own.len());
    // Eight bytes leave. The ninth is lost in the shift register, and the tenth is sent before the next write.
    let (first, later) = own.split_first().unwrap();
    assert_eq!(first.bytes, PING[..8]);
    let led = [&PING[9..], &PING[..8]].concat();
    assert!(later.iter().all(|burst| burst.bytes == led), "{:?}", later.first());
    assert_eq!(own.len(), board.bus.len(), "no servo understands it");
    assert!(board.said.contains(" answered 0 "), "{}", board.said);
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_watchdog_resets_what_hangs() {
    for order in ["h", "p"] {
        let mut board = Board::new("SINEW_CHIP_IMAGE");
        board.run(50 * MS);
        board.order(order);
        board.run(7 * S);
        let resets: Vec<_> =
            board.other.iter().filter(|heard| matches!(heard, MachineEvent::Reset(..))).collect();
        let [MachineEvent::Reset(at_ns, by)] = resets.as_slice() else {
            panic!("{order}: {resets:?}")
        };
        assert_eq!(by, "iwdg", "{order}");
        // 5 s of a nominal watchdog after its last feed; its own clock has steps of 8 ms.
        let (from, to) = (4_990 * MS, 5_110 * MS);
        assert!((from..to).contains(at_ns), "{order}: after {at_ns} ns");
        assert_eq!(board.said.matches("boot").count(), 2, "{order}: {}", board.said);
    }
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_flash_keeps_what_is_programmed_over_reset_and_power_cut() {
    let mut board = Board::new("SINEW_CHIP_IMAGE");
    board.run(50 * MS);
    board.order("w");
    board.run(50 * MS);
    assert!(board.said.contains("wrote true true\n"), "{}", board.said);
    board.servos.machine.reset().unwrap();
    board.run(50 * MS);
    // The text "kept" as a number.
    assert!(board.said.ends_with("boot 180000000 true 7470656b\n"), "{}", board.said);
    let flash = board.servos.machine.flash().unwrap();
    let mut board = Board::with_flash("SINEW_CHIP_IMAGE", &flash);
    board.run(50 * MS);
    assert!(board.said.starts_with("boot 180000000 true 7470656b\n"), "{}", board.said);
    board.order("e");
    board.run(3 * S);
    assert!(board.said.contains("erased true\n"), "{}", board.said);
    board.servos.machine.reset().unwrap();
    board.run(50 * MS);
    assert!(board.said.ends_with("boot 180000000 true ffffffff\n"), "{}", board.said);
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_erase_stops_the_core_and_a_reset_leaves_it_half_done() {
    let mut board = Board::new("SINEW_CHIP_IMAGE");
    board.run(50 * MS);
    board.order("w");
    board.run(50 * MS);
    board.order("e");
    board.run(200 * MS);
    let begun = board.other.iter().find_map(|heard| match heard {
        MachineEvent::Erase(at_ns, sector) => Some((*at_ns, *sector)),
        _ => None,
    });
    let Some((begun_ns, 7)) = begun else { panic!("{begun:?}") };
    let last_ns = board.bus.last().unwrap().end_ns;
    assert!(
        last_ns < begun_ns,
        "it talks on the bus at {last_ns} ns, and erases since {begun_ns} ns"
    );
    board.servos.machine.reset().unwrap();
    board.run(50 * MS);
    assert_eq!(board.said.matches("boot").count(), 2, "{}", board.said);
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_pins_are_read_within_a_tick() {
    let mut board = Board::new("SINEW_CHIP_IMAGE");
    board.run(100 * MS);
    board.servos.machine.pin("PC8", false).unwrap();
    let stopped_ns = board.servos.at_ns();
    board.run(100 * MS);
    let last_ns = board.bus.iter().rfind(|burst| burst.is_own).unwrap().end_ns;
    assert!(
        last_ns < stopped_ns + 2 * MS,
        "stopped at {stopped_ns} ns, the last ping left at {last_ns}"
    );
    assert!(matches!(board.other.last(), Some(MachineEvent::Light(_, false))), "{:?}", board.other);
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_runs_are_the_same() {
    let [first, second] = [(); 2].map(|()| {
        let mut board = Board::new("SINEW_CHIP_IMAGE");
        board.run(50 * MS);
        board.order("w");
        board.run(500 * MS);
        (board.bus, board.said, board.other)
    });
    assert!(first == second);
}
