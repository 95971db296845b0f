//! The command `sinew`: it reads the command line, calls the crates, and prints.
//!
//! # Files
//! - `cli/mod`: the top-level commands. Each has a file of its name in `cli/` (`bake`, `report`), or a folder:
//!   `board/`, `console/`, `play/`, `record/`, `rig/`, `servo/` (`servo simulate` is in `cli/servos`). `stop` and
//!   `estop` are in `cli/halt`.
//! - `cli/clip`: its commands are in `cli/inspect`, `map`, `find`, `blend`, `export`, `weights`, `jaw` and `idle`.
//! - `cli/evaluation`: the command `evaluate`. Without a sub-command it runs `cli/evaluate` (the paper's tables, and
//!   their report in `page`); its sub-commands are in `cli/robustness`, `latency`, `sweep`, `verify` and `figure`.
//! - `cli/clips`, `methods`, `setup`, `unit_args`, `performance`, `driven`, `target`: options that commands share.
//! - `cli/guide`: a scripted hand. `stack`: a thread with a large stack. `stop`: Ctrl-C. `renamed`: old names of
//!   commands.
//! - `cli/output`: checks that an output file differs from all input files and can be written.
//! - `inspect/`: recognizes and describes a file of motion, a character or a rig.

mod cli;
mod inspect;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
