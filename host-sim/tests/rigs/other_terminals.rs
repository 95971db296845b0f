//! Tests of commands that drive a board, while commands in other terminals stop, watch or replace them. The results are
//! checked at the simulated servos.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

use sinew_firmware::supervisor::State;

use super::board::baked;
use super::watched::Watched;
use crate::common::{command, end_by, path, text};

/// Longest wait for a state. A busy machine delays boards.
const PATIENCE: Duration = Duration::from_mins(1);
const BAUD: u32 = 1_000_000;

/// A simulated board with its files, and its own folder of sockets.
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
        let [rig, _] = baked(folder.path());
        let [link, map, show] =
            ["board", "map.toml", "loop.show"].map(|name| path(folder.path(), name));
        let board = Watched::start(&link, BAUD);
        let desk = Self { folder, rig, show, link, board };
        let bake = ["bake", "punches_01", "--rig", &desk.rig, "--mapping", &map, "--fit", "--loop"];
        desk.says(&[&bake[..], &["--seconds", "1", "-o", &desk.show]].concat(), 0);
        // On a busy machine, the host may be silent for 0.2 s, so the board must wait longer.
        desk.says(&["board", "settings", "--port", &desk.link, "set", "link_hold_s", "1.9"], 0);
        desk
    }

    fn command(&self, args: &[&str]) -> Command {
        own_command(self.folder.path(), args)
    }

    fn says(&self, args: &[&str], code: i32) -> String {
        let output = self.command(args).output().unwrap();
        let said = both(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {said}");
        said
    }

    /// Starts `sinew play` with a loop.
    fn play(&self, rounds: &str) -> Child {
        let play = ["play", &self.show, "--rig", &self.rig, "--target", &self.link];
        self.command(&[&play[..], &["--rounds", rounds]].concat())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    }

    /// Starts `sinew play`, and waits until its rig is in a state.
    fn play_until(&self, state: State) -> Child {
        let play = self.play("1000");
        assert!(self.board.until(|now| now == state, PATIENCE), "{state} does not come");
        self.board.begin();
        play
    }

    fn is_off(&self) -> bool {
        self.board.until(|state| !state.is_on(), PATIENCE)
    }
}

fn own_command(folder: &Path, args: &[&str]) -> Command {
    let mut command = command();
    command.env("SINEW_SOCKETS", folder.join("sinew")).args(args);
    command
}

fn both(output: &Output) -> String {
    text(&output.stdout) + &text(&output.stderr)
}

#[track_caller]
fn ends(program: Child, code: i32) -> String {
    let output = program.wait_with_output().unwrap();
    let said = both(&output);
    assert_eq!(output.status.code(), Some(code), "{said}");
    said
}

/// Returns the paths of all sockets.
fn sockets(folder: &Path) -> Vec<std::path::PathBuf> {
    let files = fs::read_dir(folder.join("sinew")).into_iter().flatten().flatten();
    files.map(|file| file.path()).collect()
}

#[test]
fn a_play_is_watched_and_stopped_from_other_terminals() {
    let desk = Desk::new();
    let play = desk.play_until(State::Playing);
    let modes = sockets(desk.folder.path());
    let modes = modes.iter().map(|socket| fs::metadata(socket).unwrap().permissions().mode());
    assert_eq!(modes.map(|mode| mode & 0o777).collect::<Vec<_>>(), [0o600]);
    // The first view may be older than the state.
    let watched = desk.says(&["board", "monitor", "--port", &desk.link, "--samples", "3"], 0);
    assert!(watched.contains("playing, supply"), "{watched}");
    let refused = desk.says(&["board", "jog", "turn1", "5", "--port", &desk.link], 1);
    assert!(refused.contains("`sinew play` has the board"), "{refused}");
    let refused = desk.says(&["board", "faults", "--port", &desk.link], 2);
    assert!(refused.contains("`sinew play` has the board; `sinew board monitor`"), "{refused}");
    let stopped = desk.says(&["stop"], 0);
    assert!(stopped.contains("goes to its rest pose"), "{stopped}");
    assert!(desk.is_off());
    ends(play, 0);
    let seen = desk.board.begin();
    let states: Vec<State> = seen.states.iter().map(|(_, state)| *state).collect();
    assert_eq!(states, [State::Playing, State::Stopping, State::Lowering, State::Limp]);
    assert_eq!(seen.torque_in_off, 0);
    assert!(sockets(desk.folder.path()).is_empty());
}

#[test]
fn an_emergency_stop_reaches_a_play() {
    let desk = Desk::new();
    let play = desk.play_until(State::Playing);
    let stopped = desk.says(&["estop", "--target", &desk.link], 0);
    assert!(stopped.contains("torque is off"), "{stopped}");
    assert!(ends(play, 1).contains("emergency stop"));
    let states: Vec<State> = desk.board.begin().states.iter().map(|(_, state)| *state).collect();
    assert_eq!(states, [State::Playing, State::Faulted]);
}

#[test]
fn a_killed_play_leaves_its_port_to_the_next_one() {
    let desk = Desk::new();
    let mut killed = desk.play_until(State::Playing);
    end_by(&mut killed, "-KILL");
    // The socket of the ended program is removed when the next command looks for it.
    assert_eq!(sockets(desk.folder.path()).len(), 1);
    let said = ends(desk.play("2"), 0);
    assert!(
        said.contains("has ended: this command waits") && said.contains("is cleared"),
        "{said}"
    );
    assert!(said.contains("playing") && !said.contains("another program"), "{said}");
    let none = desk.says(&["stop"], 2);
    assert!(none.contains("no command of this user drives a rig"), "{none}");
    // If torque is off, the next command does not wait.
    let mut killed = desk.command(&["record", "--limp", "--rig", &desk.rig, "-o"]);
    let mut killed = killed.arg(path(desk.folder.path(), "led.csv"));
    killed = killed.args(["--target", &desk.link]).stdout(Stdio::null()).stderr(Stdio::null());
    let mut killed = killed.spawn().unwrap();
    assert!(desk.board.until(|state| state == State::Teaching, PATIENCE));
    end_by(&mut killed, "-KILL");
    let said = ends(desk.play("2"), 0);
    assert!(said.contains("playing") && !said.contains("this command waits"), "{said}");
}

#[test]
fn the_rig_of_a_killed_play_is_stopped_at_once() {
    let desk = Desk::new();
    let mut killed = desk.play_until(State::Playing);
    end_by(&mut killed, "-KILL");
    desk.says(&["estop", "--target", &desk.link], 0);
    assert!(desk.board.until(|state| state == State::Faulted, PATIENCE));
    let seen = desk.board.begin();
    let off_s = seen.states.last().unwrap().0 - seen.states[0].0;
    // Without the e-stop, the board would lower the rig after 2 s, and torque would be off later.
    assert!(off_s < 3.0, "torque was off {off_s:.2} s after the play was watched");
}

#[test]
fn a_program_that_stood_still_for_3_s_moves_nothing_afterwards() {
    let desk = Desk::new();
    let mut play = desk.play_until(State::Playing);
    let signal = |signal: &str| {
        let pid = play.id().to_string();
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
    };
    signal("-STOP");
    sleep(Duration::from_secs(3));
    // The board has lost its link, and lowers the rig.
    assert!(desk.board.until(|state| state != State::Playing && state != State::Holding, PATIENCE));
    desk.board.begin();
    signal("-CONT");
    let code = play.wait().unwrap().code();
    assert!(matches!(code, Some(1 | 2)), "{code:?}");
    sleep(Duration::from_secs(1));
    assert!(desk.is_off());
    let seen = desk.board.begin();
    let states: Vec<State> = seen.states.iter().map(|(_, state)| *state).collect();
    let is_way_down = |state: &State| {
        matches!(state, State::Stopping | State::Lowering | State::Limp | State::Faulted)
    };
    assert!(states.iter().all(is_way_down), "{states:?}");
    assert!(seen.torque_in_off == 0 && seen.beyond_rad < 0.05, "{seen:?}");
}

#[test]
fn a_monitor_leaves_the_port_to_a_play_and_watches_it() {
    let desk = Desk::new();
    let monitor = ["board", "monitor", "--port", &desk.link, "--interval-ms", "200"];
    let mut monitor = desk.command(&monitor);
    let mut monitor = monitor.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let lines = BufReader::new(monitor.stdout.take().unwrap()).lines().map_while(Result::ok);
    let mut lines = lines.skip_while(|line| line.starts_with("off")).peekable();
    assert!(lines.peek().unwrap().starts_with("limp"), "{:?}", lines.peek());
    let reader = spawn(move || lines.collect::<Vec<String>>());
    // A command for another board leaves it alone.
    let refused = desk.says(&["board", "jog", "turn1", "5"], 2);
    assert!(refused.contains("no console has this board"), "{refused}");
    sleep(Duration::from_millis(300));
    assert_eq!(sockets(desk.folder.path()).len(), 1);
    ends(desk.play("2"), 0);
    sleep(Duration::from_secs(6));
    end_by(&mut monitor, "-INT");
    let lines = reader.join().unwrap();
    let place = |state: &str| lines.iter().position(|line| line.starts_with(state));
    let playing = place("playing").unwrap();
    // The command has opened the port again, and therefore prints the durations at its end.
    let limp = lines.iter().skip(playing).filter(|line| line.starts_with("limp")).count();
    assert!(limp > 2 && lines.iter().any(|line| line.contains("period")), "{lines:#?}");
}

#[test]
fn two_simulated_boards_do_not_share_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, link] = ["arm.toml", "board"].map(|name| path(folder.path(), name));
    let run = |args: &[&str]| own_command(folder.path(), args).output().unwrap();
    assert!(run(&["rig", "new", "--arm", "3", "-o", &rig]).status.success());
    let simulate = ["board", "simulate", "--rig", &rig, "--pty", &link];
    let start = || {
        let mut first = own_command(folder.path(), &simulate);
        let mut first = first.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(first.stdout.take().unwrap()).read_line(&mut line).unwrap();
        assert_eq!(line, "ready\n");
        first
    };
    let mut first = start();
    let second = run(&simulate);
    assert_eq!(second.status.code(), Some(2));
    assert!(both(&second).contains("another simulation serves it"), "{}", both(&second));
    let servos = run(&["servo", "simulate", "--rig", &rig, "--pty", &link]);
    assert!(both(&servos).contains("another simulation serves it"), "{}", both(&servos));
    end_by(&mut first, "-KILL");
    let mut third = start();
    end_by(&mut third, "-HUP");
    // The ended simulation leaves no file.
    let left: Vec<_> =
        fs::read_dir(folder.path()).unwrap().flatten().map(|f| f.file_name()).collect();
    assert_eq!(left, ["arm.toml"]);
}

#[test]
fn a_simulated_play_is_stopped_from_another_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = baked(folder.path());
    for (request, code, word) in [("stop", 0, "lowering"), ("estop", 1, "emergency stop")] {
        let mut play = own_command(folder.path(), &["play", &show, "--rig", &rig, "--real-time"]);
        let play = play.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let end = Instant::now() + PATIENCE;
        while !own_command(folder.path(), &[request]).output().unwrap().status.success() {
            assert!(Instant::now() < end);
            sleep(Duration::from_millis(100));
        }
        let said = ends(play, code);
        assert!(said.contains(word), "{said}");
        // If nothing was measured, no error is printed.
        assert!(!said.contains("error mean"), "{said}");
    }
}
