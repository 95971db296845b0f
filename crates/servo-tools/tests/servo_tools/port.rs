//! Tests a serial port as a line: a pseudo-terminal with a simulated servo.
#![expect(clippy::unwrap_used, reason = "a test may fail by panicking")]

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::path::PathBuf;

use nix::pty::openpty;
use nix::unistd::ttyname;
use sinew_servo_bus::Line;
use sinew_servo_bus::dynamixel::Device;
use sinew_servo_bus::dynamixel::table::Table;
use sinew_servo_tools::registers::{self, Number};
use sinew_servo_tools::{
    Client, Exchange as _, Protocol, SerialLine, ServiceError, Settings, find,
};

/// Returns an open terminal with XL330 number 3 behind it: registers without a motor, at any baud rate.
fn servo() -> (OwnedFd, PathBuf) {
    let pty = openpty(None, None).unwrap();
    let path = ttyname(&pty.slave).unwrap();
    let mut master = File::from(pty.master);
    std::thread::spawn(move || {
        let table = Table::of(1200, 52).unwrap();
        let mut memory = vec![0; table.size()];
        let mut devices = [Device::<512>::new(table, 3, &mut memory)];
        let (mut bytes, mut scratch) = ([0; 512], [0; 512]);
        while let Ok(count) = master.read(&mut bytes) {
            let mut answers = Vec::new();
            Line::new(&mut devices)
                .exchange(&bytes[..count], &mut scratch, |said, _| answers.extend_from_slice(said));
            if master.write_all(&answers).is_err() {
                break;
            }
        }
    });
    (pty.slave, path)
}

#[test]
fn a_servo_answers_over_a_port() {
    let (_kept, path) = servo();
    let line = SerialLine::open(&path).unwrap();
    let mut client = Client::new(line, Protocol::Feetech, 1_000_000, Settings::default()).unwrap();
    let servo = find(&mut client, 3, &[Protocol::Dynamixel], None, None).unwrap();
    assert_eq!(servo.table.model(), "XL330-M288");
    for count in 0..200 {
        registers::write(&mut client, &servo, "Profile Velocity", Number::Raw(count)).unwrap();
        let read = registers::read(&mut client, &servo, &["Profile Velocity".to_owned()]).unwrap();
        assert_eq!(read[0].quantity.raw, count);
    }
    assert!(matches!(client.open(4, None), Err(ServiceError::Silent { id: 4, .. })));
}

#[test]
fn a_port_has_one_master() {
    let (_kept, path) = servo();
    let first = SerialLine::open(&path).unwrap();
    let second = SerialLine::open(&path).unwrap_err().to_string();
    assert!(second.contains("another program has it"), "{second}");
    drop(first);
    SerialLine::open(&path).unwrap();
}

#[test]
fn odd_rates_are_set_as_they_are() {
    let (_kept, path) = servo();
    let mut line = SerialLine::open(&path).unwrap();
    for baud in Protocol::ALL.into_iter().flat_map(Protocol::bauds) {
        line.set_baud(baud).unwrap();
        // Opens the same terminal again, despite the lock.
        let keep = |settings: serial2::Settings| Ok(settings);
        let other = serial2::SerialPort::open(&path, keep).unwrap();
        assert_eq!(other.get_configuration().unwrap().get_baud_rate().unwrap(), baud);
    }
}
