//! `sinew servo simulate` as a process.

use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Child, Command, ExitStatus, Stdio};

use crate::common::command;

/// Returns the command `sinew servo simulate`, with piped output.
pub(crate) fn simulate(args: &[&str]) -> Command {
    let mut command = command();
    command.args(["servo", "simulate"]).args(args).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Starts the process, and waits for `ready`.
pub(crate) fn start(args: &[&str]) -> Child {
    let mut child = simulate(args).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    if line != "ready\n" {
        let mut said = String::new();
        child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        panic!("{line}{said}");
    }
    child
}

/// Ends the process by a signal, and returns its exit status.
pub(crate) fn end(mut child: Child, signal: &str) -> ExitStatus {
    let killed = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    child.wait().unwrap()
}
