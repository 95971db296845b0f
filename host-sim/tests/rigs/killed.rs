//! Programs that are ended while they use a board's rig. Prints the last table of the page `docs/fault-matrix.md`, and
//! the number of ended runs for the page `docs/hostile.md`. The tests check the servos in each tick.

use std::os::unix::fs::PermissionsExt as _;
use std::process::{Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use sinew_firmware::supervisor::State;

use super::board::{baked, says};
use super::watched::Watched;
use crate::common::{command, end_by, path};

/// Environment variable with the number of runs that each signal ends, for each program and state.
const KILLS: &str = "SINEW_KILLS";
const SIGNALS: [&str; 4] = ["-KILL", "-INT", "-TERM", "-HUP"];
/// Longest time until torque is off, by the board's clock, s: 2 s until the link counts as lost, and 18 s of lowering.
const OFF_S: f64 = 20.5;
/// Longest wait of the test. A busy machine delays boards.
const PATIENCE: Duration = Duration::from_mins(2);
const BAUD: u32 = 1_000_000;

const MATRIX: &str = include_str!("../../../docs/fault-matrix.md");

/// A program, its arguments, and the states of the rig that it uses.
type Tool = (&'static str, &'static str, &'static [State]);

const TOOLS: [Tool; 13] = [
    (
        "play",
        "play SHOW --rig RIG --target PORT",
        &[State::Arming, State::Playing, State::Stopping, State::Lowering],
    ),
    (
        "record --float",
        "record --float --rig RIG --target PORT --seconds 2 -o OUT.csv",
        &[State::Arming, State::Floating, State::Lowering],
    ),
    ("record --limp", "record --limp --rig RIG --target PORT -o OUT.csv", &[State::Teaching]),
    ("board upload rig", "board upload rig RIG --port PORT", &[State::Limp]),
    ("board upload show", "board upload show SHOW --port PORT --replace 0", &[State::Limp]),
    ("board settings", "board settings --port PORT set stop_s 3", &[State::Limp]),
    ("board faults", "board faults --port PORT --clear", &[State::Limp]),
    ("board monitor", "board monitor --port PORT", &[State::Limp]),
    ("board doctor", "board doctor --port PORT --rig RIG -o OUT.txt", &[State::Limp]),
    ("board flash", "board flash IMAGE --chip any --port PORT", &[State::Limp]),
    ("servo apply", "servo apply --rig RIG --board PORT", &[State::Limp]),
    ("servo write", "servo write 2 return-delay-time 100 --raw --board PORT", &[State::Limp]),
    ("servo reboot", "servo reboot 2 --board PORT", &[State::Limp]),
];

/// A board with a show, and the files for its programs.
struct Desk {
    folder: tempfile::TempDir,
    rig: String,
    show: String,
    link: String,
    board: Watched,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let [rig, show] = baked(folder.path());
        let link = path(folder.path(), "board");
        let board = Watched::start(&link, BAUD);
        says(&["board", "upload", "show", &show, "--port", &link], 0);
        // A stand-in for the program that writes an image into a board.
        let probe = folder.path().join("probe-rs");
        std::fs::write(&probe, "#!/bin/sh\nsleep 0.3\n").unwrap();
        std::fs::set_permissions(&probe, std::fs::Permissions::from_mode(0o755)).unwrap();
        std::fs::write(folder.path().join("image"), b"\x7fELF sinew-link:\x01\x02").unwrap();
        Self { folder, rig, show, link, board }
    }

    fn start(&self, args: &str) -> Child {
        let [out, image] = ["out", "image"].map(|name| path(self.folder.path(), name));
        let word = |word: &str| {
            let names = [
                ("SHOW", &self.show),
                ("RIG", &self.rig),
                ("PORT", &self.link),
                ("OUT", &out),
                ("IMAGE", &image),
            ];
            names.into_iter().fold(word.to_owned(), |word, (name, path)| word.replace(name, path))
        };
        let mut command = command();
        command.args(args.split(' ').map(word)).stdout(Stdio::null()).stderr(Stdio::null());
        let programs = std::env::var_os("PATH").unwrap_or_default();
        let programs =
            [self.folder.path().to_owned()].into_iter().chain(std::env::split_paths(&programs));
        command.env("PATH", std::env::join_paths(programs).unwrap());
        command.spawn().unwrap()
    }

    /// Starts a program, waits until the rig is in a state, and then for the time `after`. From then on the board's
    /// states are recorded.
    fn until(&self, args: &str, state: State, after: Duration) -> Child {
        for _ in 0..5 {
            let mut program = self.start(args);
            let is_there = self.board.until(|now| now == state, Duration::from_secs(30));
            thread::sleep(after);
            self.board.begin();
            let now = self.board.seen().state();
            // A board whose settings change restarts: its rig is off, then limp.
            if is_there && (now == state || !now.is_on() && !state.is_on()) {
                return program;
            }
            // A busy machine kept the program from the link, and the rig is held.
            let _ = program.kill();
            program.wait().unwrap();
            self.clear();
        }
        panic!("{args}: {state} does not come");
    }

    /// Waits until torque is off. Returns whether torque is off in time.
    fn is_off(&self) -> bool {
        self.board.until(|state| !state.is_on(), PATIENCE)
    }

    /// Makes the rig limp, without a latched fault.
    fn clear(&self) {
        assert!(self.is_off());
        if self.board.seen().state() == State::Teaching {
            // The next program that moves the rig ends it.
            assert!(self.start(TOOLS[0].1).wait().unwrap().success(), "a rig that is led");
        }
        let faults = ["board", "faults", "--port", &self.link, "--clear"];
        let _ = command().args(faults).output().unwrap();
        assert!(self.board.until(|state| state == State::Limp, PATIENCE));
    }

    /// Ends a program by a signal while the rig is in a state. Returns the states from then until torque is off.
    fn end(&self, (name, args, _): Tool, state: State, signal: &str, after: Duration) -> String {
        let mut program = self.until(args, state, after);
        end_by(&mut program, signal);
        assert!(self.is_off(), "{name}, {state}, {signal}: torque is on");
        // Servos are without torque, and stay so.
        thread::sleep(Duration::from_millis(500));
        let seen = self.board.begin();
        assert_eq!(seen.torque_in_off, 0, "{name}, {state}, {signal}");
        if !state.is_on() {
            assert_eq!(seen.ticks_on, 0, "{name}, {state}, {signal}");
            return "torque stays off".to_owned();
        }
        let states: Vec<String> =
            seen.states.iter().skip(1).map(|(_, state)| state.to_string()).collect();
        let off_s = seen.states.last().map_or(0.0, |(at_s, _)| at_s - seen.states[0].0);
        println!("{name}, {state}, {signal}: {states:?}, {off_s:.1} s");
        assert!(off_s < OFF_S, "{name}, {state}, {signal}");
        states.join(", ")
    }
}

/// Returns a row of the table on the page.
fn row(name: &str, state: State, killed: &str, ended: &str) -> String {
    format!("| {name} | {state} | {killed} | {ended} |")
}

/// Ends a program by each signal in each of its states. Returns the rows of its states, and the number of runs.
fn all_of(tool: Tool, times: u32) -> (Vec<String>, usize) {
    let (name, args, states) = tool;
    let desk = Desk::new();
    let (mut rows, mut runs) = (Vec::new(), 0);
    for state in states {
        // A program that uses no torque is ended at moments that are spread over its run.
        let is_short = *state == State::Limp && name != "board monitor";
        let begin = Instant::now();
        let took = if is_short {
            desk.start(args).wait().unwrap();
            begin.elapsed()
        } else {
            Duration::from_millis(100)
        };
        let mut cells = Vec::new();
        for signal in SIGNALS {
            for time in 0..times {
                let after = took * (2 * time + 1) / (2 * times);
                cells.push(desk.end(tool, *state, signal, after));
                runs += 1;
                // The next program finds a board that answers, and that has its rig.
                desk.clear();
                let stop_s = says(&["board", "settings", "--port", &desk.link, "get", "stop_s"], 0);
                assert!(["10\n", "3\n"].contains(&stop_s.as_str()), "{name}: {stop_s}");
            }
        }
        let (killed, ended) = cells.split_at(times as usize);
        for cells in [killed, ended] {
            assert!(cells.iter().all(|cell| *cell == cells[0]), "{name}, {state}: {cells:?}");
        }
        rows.push(row(name, *state, &killed[0], &ended[0]));
        // Without a latched fault, `faults --clear` has nothing to do. 1 is a doubtful result of the doctor.
        if is_short && name != "board faults" {
            let code = desk.start(args).wait().unwrap().code();
            assert!(code < Some(2), "{name}: the next run: {code:?}");
        }
    }
    (rows, runs)
}

/// A quick sample of the whole test: a show, a rig that is led by hand, and a setting.
#[test]
fn a_rig_whose_program_is_killed_is_lowered() {
    let sample = [(0, State::Playing), (1, State::Floating), (5, State::Limp)];
    thread::scope(|scope| {
        for (index, state) in sample {
            scope.spawn(move || {
                let cell = Desk::new().end(TOOLS[index], state, "-KILL", Duration::from_millis(50));
                let row = row(TOOLS[index].0, state, &cell, "");
                assert!(MATRIX.contains(row.trim_end_matches(" |")), "docs/fault-matrix.md: {row}");
            });
        }
    });
}

/// Ends all programs by all signals in all of their states, which takes minutes.
#[test]
fn each_ended_program_leaves_a_limp_rig() {
    let times = std::env::var(KILLS).map_or(1, |times| times.parse().unwrap());
    let of_tools: Vec<_> = thread::scope(|scope| {
        let running = TOOLS.map(|tool| scope.spawn(move || all_of(tool, times)));
        running.into_iter().map(|running| running.join().unwrap()).collect()
    });
    let heads = "| program | its rig is | after SIGKILL | after Ctrl-C, SIGTERM, SIGHUP |";
    let mut rows = vec![heads.to_owned(), "| --- | --- | --- | --- |".to_owned()];
    for ((name, ..), (of_tool, runs)) in TOOLS.iter().zip(of_tools) {
        rows.extend(of_tool);
        println!("{name}: {runs} runs");
    }
    let table = rows.join("\n");
    assert!(MATRIX.contains(&table), "docs/fault-matrix.md must have:\n{table}");
}
