//! The emulated NUCLEO with its own image, as a host meets it first. `cargo xtask emulate` builds both.

#[expect(dead_code, reason = "another program of tests uses the rest")]
mod common;

use std::time::Duration;

use common::{Board as Emulated, S};
use sinew_client::Board;
use sinew_emulation::{EmulatedBoard, Heard};

/// Torque off to all, as servos of two makers know it.
const TORQUE_OFF: [&[u8]; 2] = [
    &[0xFF, 0xFF, 0xFD, 0, 0xFE, 6, 0, 3, 0x40, 0, 0, 0x2E, 0x16],
    &[0xFF, 0xFF, 0xFE, 4, 3, 0x28, 0, 0xD2],
];

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_boots_says_torque_off_and_greets() {
    let emulated = Emulated::new("SINEW_NUCLEO_IMAGE");
    let board = EmulatedBoard::new(emulated.servos);
    let mut board = Board::connect(board, 1, Duration::from_nanos(5 * S)).unwrap();
    assert_eq!(board.about().rig, 0, "its flash is blank");
    let line = board.line_mut();
    let stray = line.other.iter().find(|heard| matches!(heard, Heard::Stray(..)));
    assert_eq!(stray, None, "its stack has run over, or an address is none");
    // Twice, whole, and before anything else.
    let said: Vec<&[u8]> = line.bus.iter().map(|burst| burst.bytes.as_slice()).collect();
    assert_eq!(said, [TORQUE_OFF, TORQUE_OFF].concat());
}
