//! The command `sinew`: it reads the command line, calls the crates, and prints.
//!
//! # Files
//! - `cli/mod`: the commands at the top. Each has a file of its name in `cli/` (`bake`, `report`), or a folder:
//!   `board/`, `play/`, `record/`, `rig/`, `servo/` (`servo simulate` is in `cli/servos`).
//! - `cli/clip`: its commands are `cli/inspect`, `map`, `find`, `blend`, `export` and `weights`.
//! - `cli/evaluation`: the command `evaluate`. Alone it is `cli/evaluate` (the paper's tables, and their report in
//!   `page`); its other commands are `cli/robustness`, `latency`, `sweep`, `verify` and `figure`.
//! - `cli/clips`, `methods`, `setup`, `unit_args`, `performance`, `driven`, `target`: options that commands share.
//! - `cli/guide`, `stack`, `stop`, `renamed`: a scripted hand; a large stack; Ctrl-C; names of before.
//! - `cli/output`: files to write, compared with those that a command reads, and tried.
//! - `inspect/`: a file of motion, a character or a rig, recognized and described.

mod cli;
mod inspect;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
