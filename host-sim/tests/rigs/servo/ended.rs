//! `sinew servo`, ended in the middle of its work, as a process: the servo is restored, or the next command reports the
//! registers that were left.

use std::io::Read as _;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::on_bus::Bus;
use crate::common::command;

/// Registers that `identify` changes, for each kind of servo.
const CHANGED: [(&str, &str, &[&str]); 2] = [
    (
        "xl330",
        "dynamixel",
        &["torque-enable", "bus-watchdog", "goal-current", "goal-pwm", "profile-velocity"],
    ),
    ("sts3215", "feetech", &["torque-enable", "torque-limit", "acceleration", "goal-velocity"]),
];

/// Starts `sinew servo identify 2`.
fn identify(bus: &Bus, protocol: &str) -> Child {
    let mut identify = command();
    identify.args(["servo", "identify", "2", "--baud", "1000000", "--timeout-ms", "100"]);
    identify.args(["--protocol", protocol]);
    identify.args(["--port", &bus.port()]).stdout(Stdio::piped()).stderr(Stdio::piped());
    identify.spawn().unwrap()
}

/// Ends a program by a signal after the servo's torque was switched on. Returns its exit code and its output.
fn end(mut child: Child, signal: &str) -> (Option<i32>, String) {
    // The program checks the other servos for a second, and then moves the servo for 4 s.
    std::thread::sleep(Duration::from_millis(2200));
    let killed = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let code = child.wait().unwrap().code();
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    (code, said)
}

#[test]
fn a_signal_leaves_nothing_and_a_kill_is_told_by_the_next_command() {
    for (kind, protocol, registers) in CHANGED {
        let bus = Bus::of_kind(kind, "2,3");
        let held = || {
            let read = ["read", "2", "--protocol", protocol];
            bus.done(&[&read, registers].concat())
        };
        let before = held();
        for signal in ["-INT", "-TERM", "-HUP"] {
            let (code, said) = end(identify(&bus, protocol), signal);
            assert_eq!(code, Some(2), "{kind} {signal}: {said}");
            assert!(said.contains("ended by a signal"), "{kind} {signal}: {said}");
            assert_eq!(held(), before, "{kind} {signal}");
        }
        assert_eq!(end(identify(&bus, protocol), "-KILL").0, None);
        // Waits for the watchdog.
        std::thread::sleep(Duration::from_millis(500));
        let (code, _, said) =
            bus.servo(&["ping", "2", "--baud", "1000000", "--protocol", protocol]);
        assert!(code == 0 && said.contains("`sinew servo reboot 2`"), "{kind}: {said}");
        let left = held();
        let row = |name: &str| left.lines().find(|line| line.contains(name)).unwrap_or_default();
        assert!(row("Torque Enable").contains(" 1 "), "{left}");
        if kind == "xl330" {
            assert!(row("Bus Watchdog").contains("-1"), "it stopped by itself: {left}");
        }
        assert!(
            bus.not_done(&["identify", "2", "--protocol", protocol], 2)
                .contains("a program that was ended")
        );
        // A command for another servo reports it, too.
        let (code, _, said) =
            bus.servo(&["set-id", "3", "4", "--baud", "1000000", "--protocol", protocol]);
        assert!(code == 0 && said.contains("`sinew servo reboot 2`"), "{kind}: {said}");
        bus.done(&["reboot", "2", "--protocol", protocol]);
        assert_eq!(held(), before, "{kind}");
        assert!(bus.done(&["identify", "2", "--protocol", protocol]).contains("it moved by"));
    }
}

#[test]
fn a_servo_in_trouble_is_no_servo_that_moved() {
    for (fault, words) in [
        ("2:stuck@3s", "hardly moves"),
        ("2:hot=90@3s", "too hot"),
        ("2:torque-lost@3s", "torque went off by itself"),
        ("2:encoder-jump=90@3s", "jumps"),
        ("2:torque-stuck@3s", "Torque Enable"),
    ] {
        let bus = Bus::of_kind_with("xl330", "2", &["--fault", fault]);
        let said = bus.not_done(&["identify", "2"], 2);
        assert!(said.contains(words), "{fault}: {said}");
        if !fault.contains("torque-stuck") {
            assert_eq!(bus.raw("2", "torque-enable"), 0, "{fault}");
        }
        assert_eq!((bus.raw("2", "bus-watchdog"), bus.raw("2", "led")), (0, 0), "{fault}");
    }
}
