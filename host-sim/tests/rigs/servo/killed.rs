//! Every command of `sinew servo` at a port, ended as a process: the servo is as before or as commanded, or the next
//! command reports what is left. Prints a table; `docs/hostile.md` has its sums.

use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::process::{Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::on_bus::Bus;
use crate::common::{command, end_by};

/// Environment variable with the number of runs that each signal ends, for each command.
const KILLS: &str = "SINEW_KILLS";
const SIGNALS: [&str; 4] = ["-KILL", "-INT", "-TERM", "-HUP"];

/// Commands, and whether they run until a signal ends them.
const COMMANDS: [(&str, bool); 13] = [
    ("scan --max-id 4", false),
    ("ping 2", false),
    ("read 2", false),
    ("watch 2", true),
    ("write 2 return-delay-time 100 --raw", false),
    ("set-id 2 7", false),
    ("set-baud 2 57600", false),
    ("identify 2", false),
    ("reboot 2", false),
    ("diff --rig RIG", false),
    ("apply --rig RIG", false),
    ("calibrate --rig RIG", true),
    ("tap bend2 --rig RIG --taps 10", false),
];

type Registers = BTreeMap<String, i64>;

fn start(bus: &Bus, args: &str) -> Child {
    let (rig, port) = (bus.rig().display().to_string(), bus.port());
    let mut command = command();
    command.arg("servo").args(args.split(' ').map(|word| if word == "RIG" { &rig } else { word }));
    if !args.starts_with("scan") {
        command.args(["--baud", "1000000"]);
    }
    command.args(["--port", &port, "--timeout-ms", "300"]).stdin(Stdio::piped());
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // The answer to a question; the pipe stays open, so that no command ends by its input.
    let _ = child.stdin.as_mut().unwrap().write_all(b"\n");
    child
}

/// Returns the id and the rate at which servo 2 now answers, and the output of `ping`.
fn found(bus: &Bus) -> (&'static str, &'static str, String) {
    for (id, baud) in [("2", "1000000"), ("7", "1000000"), ("2", "57600")].repeat(3) {
        let (code, _, said) = bus.servo(&["ping", id, "--baud", baud, "--timeout-ms", "300"]);
        if code == 0 {
            return (id, baud, said);
        }
    }
    panic!("the servo is lost");
}

/// Returns the registers that are not measurements. Reads until two readings are equal, because a busy machine may
/// delay an answer until the program expects another one.
fn registers(bus: &Bus, id: &str, baud: &str) -> Registers {
    let mut last = None;
    for _ in 0..9 {
        let read = once(bus, id, baud);
        if read.is_some() && read == last {
            break;
        }
        last = read;
    }
    last.expect("two equal readings")
}

fn once(bus: &Bus, id: &str, baud: &str) -> Option<Registers> {
    let read = ["read", id, "--baud", baud, "--timeout-ms", "300", "--format", "json"];
    let (_, said, _) = bus.servo(&read);
    let read: Value = serde_json::from_str(&said).ok()?;
    let measured = ["Present", "Tick", "Moving", "Trajectory", "Goal Position", "Status"];
    let all = read["registers"].as_array()?.iter();
    let registers = all.filter_map(|register| {
        let name = register["name"].as_str()?;
        let is_measured = measured.iter().any(|word| name.contains(word));
        (!is_measured).then_some((name.to_owned(), register["raw"].as_i64()?))
    });
    Some(registers.collect())
}

/// Starts a command several times, each time with new servos, and ends each run by a signal. Returns a row of the
/// table.
fn row((args, is_endless): (&str, bool), times: u32) -> String {
    let new_bus = || Bus::of_new_arm("3", &[]);
    let bus = new_bus();
    let before = registers(&bus, "2", "1000000");
    let begin = Instant::now();
    let mut whole = start(&bus, args);
    let (took, asked) = if is_endless {
        thread::sleep(Duration::from_millis(600));
        whole.kill().unwrap();
        whole.wait().unwrap();
        (Duration::from_millis(1500), before.clone())
    } else {
        whole.wait().unwrap();
        let took = begin.elapsed();
        let (id, baud, _) = found(&bus);
        (took, registers(&bus, id, baud))
    };
    let [mut on, mut left, mut told, mut by_signal] = [0; 4];
    for signal in SIGNALS {
        for time in 0..times {
            let bus = new_bus();
            let mut child = start(&bus, args);
            thread::sleep(took * (2 * time + 1) / (2 * times));
            end_by(&mut child, signal);
            // Waits for the watchdog of a servo.
            thread::sleep(Duration::from_millis(500));
            let (id, baud, said) = found(&bus);
            let now = registers(&bus, id, baud);
            let has_torque = now["Torque Enable"] != 0;
            let others = now.iter().filter(|(name, raw)| {
                ![&before, &asked].into_iter().any(|known| known.get(*name) == Some(*raw))
            });
            let others: Vec<_> = others.collect();
            let is_told = said.contains("sinew servo reboot");
            let mut ended = String::new();
            child.stderr.take().unwrap().read_to_string(&mut ended).unwrap();
            assert!(
                is_told || !has_torque && others.is_empty(),
                "{args} {signal}: {others:?}: {ended}"
            );
            if signal != "-KILL" {
                by_signal += i32::from(has_torque || !others.is_empty());
            }
            on += i32::from(has_torque);
            left += i32::from(!others.is_empty());
            told += i32::from(is_told);
        }
    }
    assert_eq!(by_signal, 0, "{args}: a signal left something");
    let name = args.split(' ').next().unwrap_or_default();
    let runs = SIGNALS.len() * times as usize;
    format!("| `servo {name}` | {runs} | {on} | {left} | {told} |")
}

/// Ends runs of all commands by all signals, which takes minutes.
#[test]
fn each_ended_command_leaves_a_servo_as_it_was_or_is_told_by_the_next() {
    let times = std::env::var(KILLS).map_or(1, |times| times.parse().unwrap());
    println!("| command | ended | torque on | other registers left | told by the next command |");
    for commands in COMMANDS.chunks(4) {
        let rows: Vec<String> = thread::scope(|scope| {
            let run = |case: &(&'static str, bool)| {
                let case = *case;
                scope.spawn(move || row(case, times))
            };
            let running: Vec<_> = commands.iter().map(run).collect();
            running.into_iter().map(|running| running.join().unwrap()).collect()
        });
        println!("{}", rows.join("\n"));
    }
}
