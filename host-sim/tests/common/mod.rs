//! Runs the command `sinew` as a process.
#![expect(dead_code, reason = "each program of tests uses a part")]

use std::path::Path;
use std::process::{Child, Command, Output};
use std::time::{Duration, Instant};

/// Longest time until a program ends after a signal. It may first lower a board's rig, and a busy machine delays
/// boards.
const PATIENCE: Duration = Duration::from_mins(2);

/// Returns the command without arguments.
pub(crate) fn command() -> Command {
    Command::new(env!("CARGO_BIN_EXE_sinew"))
}

/// Runs the command.
pub(crate) fn sinew(arguments: &[&str]) -> Output {
    command().args(arguments).output().expect("the command starts")
}

/// Runs the command in a folder.
pub(crate) fn sinew_in(folder: &Path, arguments: &[&str]) -> Output {
    command().current_dir(folder).args(arguments).output().expect("the command starts")
}

/// Returns standard output of a run that succeeds.
#[track_caller]
pub(crate) fn printed(arguments: &[&str]) -> String {
    let output = sinew(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Returns the output of a process as text.
pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Returns the path of a file in a folder.
pub(crate) fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().expect("UTF-8").to_owned()
}

/// Sends a signal to a program, and waits until it ends.
#[track_caller]
pub(crate) fn end_by(child: &mut Child, signal: &str) {
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status();
    // The program may be over already.
    kill.expect("`kill` runs");
    let end = Instant::now() + PATIENCE;
    while child.try_wait().expect("its state").is_none() {
        if Instant::now() > end {
            child.kill().expect("it is killed");
            panic!("it does not end by {signal}");
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}
