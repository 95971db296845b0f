//! Commands for a board, with a simulated board on a pseudo-terminal.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use sinew_board_client::{Line as _, SerialBoard};
use sinew_servo_sim::port::Port;

use crate::common::{command, path};

fn sinew(args: &[&str]) -> Command {
    let mut command = command();
    command.args(args);
    command
}

fn text(output: &Output) -> String {
    [&output.stdout, &output.stderr]
        .map(|bytes| String::from_utf8_lossy(bytes).into_owned())
        .concat()
}

/// Runs a command that must end with this exit code, and returns its output.
pub(super) fn says(args: &[&str], code: i32) -> String {
    let output = sinew(args).output().unwrap();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {}", text(&output));
    text(&output)
}

/// A process that serves a port. It is ended when this value is dropped.
struct Served(Child);

impl Served {
    fn start(args: &[&str]) -> Self {
        let mut child = sinew(args).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        assert_eq!(line, "ready\n");
        Self(child)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_board_is_looked_over_set_up_and_asked() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, port, flash, report] =
        ["arm.toml", "board", "flash.bin", "report.txt"].map(|name| path(folder.path(), name));
    says(&["rig", "new", "--arm", "3", "-o", &rig], 0);
    let simulate = ["board", "simulate", "--rig", &rig, "--pty", &port, "--flash", &flash];
    {
        let _blank = Served::start(&[&simulate[..], &["--blank"]].concat());
        let none = says(&["board", "monitor", "--port", &port, "--samples", "1"], 2);
        assert!(none.contains("the board has no rig"), "{none}");
        let stored = says(&["board", "upload", "rig", &rig, "--port", &port], 0);
        assert!(stored.contains("the board has rig"), "{stored}");
    }
    // The file still contains it.
    let _board = Served::start(&[&simulate[..], &["--blank"]].concat());
    let line =
        says(&["board", "monitor", "--port", &port, "--samples", "3", "--interval-ms", "200"], 0);
    assert_spreads(&line);
    let set = says(&["board", "settings", "--port", &port, "set", "stop_s", "3"], 0);
    assert!(set.contains("stop_s is 3 now"), "{set}");
    assert_eq!(says(&["board", "settings", "--port", &port, "get", "stop_s"], 0), "3\n");
    let wrong = says(&["board", "settings", "--port", &port, "get", "stop"], 2);
    assert!(wrong.contains("link_hold_s"), "{wrong}");
    let refused = says(&["board", "settings", "--port", &port, "set", "stop_s", "1e9"], 2);
    assert!(
        refused.contains("refused: stop_s is 1000000000; it must be a number from"),
        "{refused}"
    );
    let model = says(&["servo", "ping", "1", "--board", &port, "--baud", "3000000"], 0);
    assert!(model.contains("servo 1: XL330"), "{model}");
    let looked = sinew(&["board", "doctor", "--port", &port, "--rig", &rig, "-o", &report]);
    let looked = { looked }.output().unwrap();
    let looked = text(&looked);
    let kept = std::fs::read_to_string(&report).unwrap();
    for of in ["firmware", "link", "period of ticks", "(id 3)", "57600 baud", "supply under load"] {
        assert!(looked.contains(of) && kept.contains(of), "{of}: {looked}");
    }
    assert_spreads(&kept);
}

/// Makes the board wait longer for its host, because on a busy machine the test may send nothing for 0.2 s.
fn be_patient(port: &str) {
    says(&["board", "settings", "--port", port, "set", "link_hold_s", "1.9"], 0);
}

/// Checks that each task of a board has a row: its count, then minimum, mean, maximum and jitter, in us and in cycles.
/// A cycle of a simulated board is a microsecond of simulated time.
#[track_caller]
fn assert_spreads(text: &str) {
    for part in ["tick", "bus", "link", "period"] {
        let rows = text.lines().filter_map(|line| line.trim_start().strip_prefix(part));
        let numbers = |row: &str| -> Option<Vec<f64>> {
            row.split_whitespace().map(|number| number.parse().ok()).collect()
        };
        let row = rows.filter_map(numbers).find(|row| row.len() == 9);
        let row = row.unwrap_or_else(|| panic!("no row of {part}: {text}"));
        assert!(row[0] >= 10.0, "{part}: {text}");
        let [in_us, in_cycles] = [&row[1..5], &row[5..]];
        assert_eq!(in_us, in_cycles, "{part}: {text}");
        let [least, mean, most, jitter] = in_us else { panic!("{text}") };
        assert!(least <= mean && mean <= most, "{part}: {text}");
        // They are integers.
        assert!((jitter - (most - least)).abs() < 0.5, "{part}: {text}");
    }
}

#[test]
fn the_wrong_kind_of_port_is_refused_with_words_and_a_monitor_makes_room() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, board, bus] = ["arm.toml", "board", "bus"].map(|name| path(folder.path(), name));
    says(&["rig", "new", "--arm", "3", "-o", &rig], 0);
    let _servos = Served::start(&["servo", "simulate", "--rig", &rig, "--pty", &bus]);
    let _board = Served::start(&["board", "simulate", "--rig", &rig, "--pty", &board]);
    let no_board = says(&["board", "faults", "--port", &bus], 2);
    assert!(no_board.contains("servos answer here") && no_board.contains("--port"), "{no_board}");
    let no_bus = says(&["servo", "ping", "1", "--port", &board, "--baud", "1000000"], 2);
    assert!(no_bus.contains("a controller answers here") && no_bus.contains("--board"), "{no_bus}");
    let mut monitor = sinew(&["board", "monitor", "--port", &board])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(monitor.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let second = says(&["board", "faults", "--port", &board], 0);
    monitor.kill().unwrap();
    monitor.wait().unwrap();
    assert!(second.contains("no faults are kept"), "{second}");
}

/// Writes a rig, and a show of one second for it.
pub(super) fn baked(folder: &Path) -> [String; 2] {
    let [rig, map, show] = ["arm.toml", "map.toml", "a.show"].map(|name| path(folder, name));
    says(&["rig", "new", "--arm", "3", "-o", &rig], 0);
    let text = std::fs::read_to_string(&rig).unwrap();
    let joint = text.split("[[joint]]").nth(1).and_then(|joint| joint.split('"').nth(1)).unwrap();
    let curve = format!(
        "rig = \"arm\"\nclip = \"punches_01\"\n\n[[curve]]\nclip = \"forearm_l\"\naxis = [0, 0, 1]\nrig = \"{joint}\"\n\
         points_deg = [[-180, -20], [180, 20]]\n"
    );
    std::fs::write(&map, curve).unwrap();
    let bake = ["bake", "punches_01", "--rig", &rig, "--mapping", &map, "--fit", "--seconds", "1"];
    says(&[&bake[..], &["-o", &show]].concat(), 0);
    [rig, show]
}

#[test]
fn a_show_is_uploaded_once_played_and_unplugged() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = baked(folder.path());
    let port = path(folder.path(), "board");
    let board = Served::start(&["board", "simulate", "--rig", &rig, "--pty", &port]);
    be_patient(&port);
    let play = ["play", &show, "--rig", &rig, "--target", &port];
    let first = says(&play, 0);
    for state in ["arming", "playing", "lowering", "limp"] {
        assert!(first.contains(state), "{first}");
    }
    let mut again = sinew(&play).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(again.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.contains("on the board already")));
    assert!(lines.any(|line| line.contains("playing")));
    drop(board);
    let rest = lines.collect::<Vec<_>>().join("\n");
    assert!(rest.contains("unplugged") && rest.contains("after 2 s it is lowered"), "{rest}");
    assert_eq!(again.wait().unwrap().code(), Some(2));
}

/// A wire between a program and a board. The direction from the board to the program can be cut.
struct Wire {
    is_dead: Arc<AtomicBool>,
    is_over: Arc<AtomicBool>,
    carries: Option<JoinHandle<()>>,
}

impl Wire {
    fn to(board: &str, link: &str) -> Self {
        let [is_dead, is_over] = [(); 2].map(|()| Arc::new(AtomicBool::new(false)));
        let port = Port::open(link.as_ref(), 1_000_000).unwrap();
        let mut line = SerialBoard::open(board.as_ref(), 1_000_000).unwrap();
        let (dead, over) = (Arc::clone(&is_dead), Arc::clone(&is_over));
        let carry = move || {
            let mut bytes = [0; 4096];
            while !over.load(Ordering::Relaxed) {
                let count = port.read(&mut bytes).unwrap();
                line.send(&bytes[..count]).unwrap();
                let count = line.receive(&mut bytes, Duration::from_millis(1)).unwrap();
                if !dead.load(Ordering::Relaxed) {
                    port.write(&bytes[..count]).unwrap();
                }
            }
        };
        Self { is_dead, is_over, carries: Some(thread::spawn(carry)) }
    }
}

impl Drop for Wire {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        let _ = self.carries.take().map(JoinHandle::join);
    }
}

/// The wire from the board is cut while a program drives the rig: the program ends, and the board lowers the rig by
/// itself.
#[test]
fn a_program_that_hears_nothing_ends_and_its_rig_is_limp() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = baked(folder.path());
    let [port, link, led] = ["board", "link", "led.show"].map(|name| path(folder.path(), name));
    let _board = Served::start(&["board", "simulate", "--rig", &rig, "--pty", &port]);
    let silence = ["--rig", &rig, "--target", &link, "--silence-s", "0.8"];
    for (command, begins) in
        [(&["play", &show][..], "playing"), (&["record", "--float", "-o", &led], "lead it")]
    {
        let wire = Wire::to(&port, &link);
        let mut program = sinew(command).args(silence).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines =
            BufReader::new(program.stderr.take().unwrap()).lines().map_while(Result::ok);
        assert!(lines.any(|line| line.contains(begins)), "{command:?}");
        wire.is_dead.store(true, Ordering::Relaxed);
        let cut = Instant::now();
        let rest = lines.collect::<Vec<_>>().join("\n");
        assert_eq!(program.wait().unwrap().code(), Some(2), "{rest}");
        let ended_s = cut.elapsed().as_secs_f64();
        assert!(rest.contains("for 0.8 s") && rest.contains("wire"), "{rest}");
        assert!((0.7..3.0).contains(&ended_s), "{ended_s}");
        drop(wire);
        // While torque is on, no other program gets a session.
        let limp = || {
            let look = ["board", "monitor", "--port", &port, "--samples", "1"];
            let looked = sinew(&look).output().unwrap();
            looked.status.success().then(|| text(&looked))
        };
        let state = (0..20).find_map(|_| limp()).unwrap();
        assert!(state.contains("faulted") || state.contains("limp"), "{state}");
        says(&["board", "faults", "--port", &port, "--clear"], 0);
    }
}

#[test]
fn firmware_is_refused_with_what_would_be_right() {
    let folder = tempfile::tempdir().unwrap();
    let elf = path(folder.path(), "image");
    let chip = says(&["board", "flash", &elf], 2);
    assert!(chip.contains("nucleo_f446re"), "{chip}");
    let flash = ["board", "flash", &elf, "--chip", "STM32F446RETx"];
    std::fs::write(&elf, "no image").unwrap();
    assert!(says(&flash, 2).contains("not an ELF file"));
    std::fs::write(&elf, b"\x7fELF sinew-link:\x09\x04").unwrap();
    let other = says(&flash, 2);
    assert!(other.contains("9.4") && other.contains("nothing was written"), "{other}");
}

#[test]
fn a_rig_at_a_board_is_led_and_limp_again() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, port, csv, show] =
        ["arm.toml", "board", "led.csv", "led.show"].map(|name| path(folder.path(), name));
    says(&["rig", "new", "--arm", "3", "-o", &rig], 0);
    let _board = Served::start(&["board", "simulate", "--rig", &rig, "--pty", &port, "--guide"]);
    be_patient(&port);
    let record = |how: &str, seconds: &str, file: &str| {
        let of =
            ["record", "--target", &port, "--rig", &rig, how, "--seconds", seconds, "-o", file];
        says(&of, 0)
    };
    let limp = record("--limp", "8.5", &csv);
    assert!(limp.contains("teaching") && limp.contains("lead it"), "{limp}");
    // The hand of the simulated board takes the built-in path: 0.6 rad at most, from home and back.
    let led = std::fs::read_to_string(&csv).unwrap();
    let column = |line: &str| line.split(',').nth(1).and_then(|x| x.parse::<f64>().ok());
    let most = led.lines().filter_map(column).fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!((12.0..40.0).contains(&most), "{most} deg");
    let floating = record("--float", "4", &show);
    assert!(floating.contains("floating") && floating.contains("limp"), "{floating}");
    assert!(std::fs::metadata(&show).unwrap().len() > 100);
    let hand =
        sinew(&["record", "--target", &port, "--rig", &rig, "--mass-scale", "2", "-o", &csv]);
    let hand = text(&{ hand }.output().unwrap());
    assert!(hand.contains("it is for `--target sim`"), "{hand}");
}

#[test]
fn what_was_led_is_kept_if_the_board_is_gone() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, port, show, kept] =
        ["arm.toml", "board", "walk.show", "walk.led.csv"].map(|name| path(folder.path(), name));
    says(&["rig", "new", "--arm", "3", "-o", &rig], 0);
    let board = Served::start(&["board", "simulate", "--rig", &rig, "--pty", &port, "--guide"]);
    be_patient(&port);
    let mut record = sinew(&["record", "--target", &port, "--rig", &rig, "--limp", "-o", &show]);
    let mut record = record.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(record.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("lead it") {
        assert!(said.read_line(&mut line).unwrap() > 0, "{line}");
    }
    std::thread::sleep(std::time::Duration::from_secs(4));
    drop(board);
    assert_eq!(record.wait().unwrap().code(), Some(2));
    std::io::Read::read_to_string(&mut said, &mut line).unwrap();
    assert!(line.contains("walk.led.csv: the motion as measured"), "{line}");
    let rows = std::fs::read_to_string(&kept).unwrap().lines().count();
    // Four seconds at 100 Hz; a busy machine may lose some rows.
    assert!(rows > 200, "{rows}");
    assert!(!std::path::Path::new(&show).exists());
}
