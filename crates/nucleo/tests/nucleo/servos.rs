//! Tests packets from a host to servos, passed on by the board.

use std::time::Duration;

use sinew_board_client::BoardServos;
use sinew_link::message::{State, TelemetryParts};
use sinew_servo_tools::registers::{Number, write};
use sinew_servo_tools::{Client, Exchange as _, Protocol, ServiceError, Settings};

use crate::test_rig::{Emulated, Rig, arm_it, servos_on, until, with_rig};

/// Address of the light of an XL330.
const LED: u16 = 65;
/// A packet that switches the light of servo 2 off. No other part of the test sends it.
const DARK: [u8; 13] = [0xFF, 0xFF, 0xFD, 0, 2, 6, 0, 3, 0x41, 0, 0, 0xF9, 0x65];

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_passes_packets_on_to_servos_while_it_is_limp() {
    let rig = Rig::new(3);
    let mut board = with_rig(&rig);
    board.telemetry(20.0, TelemetryParts::SUMMARY).unwrap();
    until(&mut board, State::Limp, 2);

    // The settings of `sinew servo --board`.
    let settings = Settings { patience: Duration::from_millis(5), tries: 3 };
    let line = BoardServos::new(board, 0).unwrap();
    let mut client = Client::new(line, Protocol::Dynamixel, rig.baud(), settings).unwrap();
    for id in 1..=3 {
        let servo = client.open(id, None).unwrap();
        assert_eq!(servo.table.model(), "XL330-M288");
        // More bytes than one answer of the host link can carry.
        assert_eq!(client.read_bytes(id, 0, 147).unwrap().0.len(), 147);
        // Time from the first byte sent to the last byte received, by the board's clock: 14 and 158 bytes.
        let wire = Duration::from_secs_f64(10.0 * f64::from(14 + 158) / f64::from(rig.baud()));
        let took = client.line_mut().took();
        assert!(took > wire && took < wire + Duration::from_millis(1), "{took:?}, {wire:?}");
    }
    let servo = client.open(2, None).unwrap();
    write(&mut client, &servo, "LED", Number::Raw(1)).unwrap();
    let lit = |client: &mut Client<BoardServos<_>>| {
        let emulated: &mut Emulated = client.line_mut().board_mut().line_mut();
        let bench = emulated.servos.line.servos.bench();
        bench.servos().iter().map(|servo| servo.get(LED)).collect::<Vec<_>>()
    };
    assert_eq!(lit(&mut client), [0, 1, 0]);
    assert!(matches!(client.open(77, None), Err(ServiceError::Silent { id: 77, .. })));
    // No servo understands another rate; afterwards the line has its own rate again.
    client.set_baud(57_600).unwrap();
    assert!(client.open(1, None).is_err());
    let mut line = client.into_line();
    line.own_rate();

    arm_it(line.board_mut());
    assert_eq!(servos_on(line.board_mut().line_mut()), 3);
    line.board_mut().line_mut().bus.clear();
    let refused = line.exchange(&DARK, Duration::from_millis(5), &mut |_| true).unwrap_err();
    assert!(refused.to_string().contains("the rig is holding"), "{refused}");
    let emulated = line.board_mut().line_mut();
    assert!(emulated.bus.iter().all(|burst| !burst.bytes.windows(13).any(|it| it == DARK)));
    assert_eq!(emulated.servos.line.servos.bench().servos()[1].get(LED), 1);
    assert_eq!(servos_on(emulated), 3);
}
