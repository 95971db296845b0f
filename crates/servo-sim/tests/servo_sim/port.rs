//! Tests a pseudo-terminal as programs use it.
#![cfg(unix)]

use std::fs::{File, OpenOptions};
use std::io::{Read as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use sinew_servo_bus::dynamixel::Instruction;
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::line::Line;
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::port::{Port, PortError};
use sinew_servo_sim::supply::Supply;

const BAUD: u32 = 4_000_000;
const PATIENCE: Timespec = Timespec { tv_sec: 0, tv_nsec: 300_000_000 };

/// Pings servo 7 and returns the reply.
fn ping(port: &mut File) -> Vec<u8> {
    let mut packet = [0; 16];
    let len = Instruction::Ping.encode(7, &mut packet).unwrap();
    port.write_all(&packet[..len]).unwrap();
    let mut said = Vec::new();
    while poll(&mut [PollFd::new(port, PollFlags::IN)], Some(&PATIENCE)).unwrap() > 0 {
        let mut bytes = [0; 64];
        let count = port.read(&mut bytes).unwrap();
        said.extend_from_slice(&bytes[..count]);
        if said.len() >= 14 {
            break;
        }
    }
    said
}

fn set_rate(port: &File, baud: u32) {
    let mut settings = tcgetattr(port).unwrap();
    settings.set_speed(baud).unwrap();
    tcsetattr(port, OptionalActions::Now, &settings).unwrap();
}

#[test]
fn programs_open_it_talk_and_open_it_again() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("bus");
    // A program that was killed leaves a link without a target.
    std::os::unix::fs::symlink("/dev/pts/none", &link).unwrap();
    let port = Port::open(&link, BAUD).unwrap();
    let kind = Parameters::built_in("XL330-M288-T").unwrap();
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let server = scope.spawn(|| {
            let mut memory = [0; MEMORY_LEN];
            let mut servo = Servo::new(&kind, 7, &mut memory).unwrap();
            servo.set_baud(BAUD).unwrap();
            let bench = Bench::new(vec![servo], vec![Arm::default()], Supply::stiff(5.0));
            let mut line = Line::new(bench);
            let start = Instant::now();
            port.serve(&mut line, &stop).unwrap();
            let real_s = start.elapsed().as_secs_f64();
            // Its time is that of the clock, within the delays of a busy machine.
            assert!((line.servos.time_s() - real_s).abs() < 0.5, "{real_s}");
        });
        let open = || OpenOptions::new().read(true).write(true).open(&link).unwrap();
        for _ in 0..3 {
            let mut client = open();
            assert_eq!(ping(&mut client)[..5], [0xFF, 0xFF, 0xFD, 0, 7]);
            assert_eq!(ping(&mut client).len(), 14);
        }
        let mut client = open();
        set_rate(&client, 57_600);
        assert!(ping(&mut client).is_empty());
        set_rate(&client, BAUD);
        assert_eq!(ping(&mut client).len(), 14);
        std::thread::sleep(Duration::from_millis(20));
        stop.store(true, Ordering::Relaxed);
        server.join().unwrap();
    });
    drop(port);
    assert!(link.symlink_metadata().is_err());
}

#[test]
fn a_file_is_not_replaced() {
    let file = tempfile::NamedTempFile::new().unwrap();
    assert!(matches!(Port::open(file.path(), BAUD), Err(PortError::Occupied(_))));
    let nowhere = file.path().with_extension("d").join("bus");
    let error = Port::open(&nowhere, BAUD).unwrap_err().to_string();
    assert!(error.starts_with(&nowhere.display().to_string()), "{error}");
    assert!(file.path().exists());
}
