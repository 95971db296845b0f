//! Developer commands of Sinew: `cargo xtask COMMAND`.

mod clients;
mod deny;
mod docs;
mod emulate;
mod firmware;
mod limits;
mod lints;
mod measure;
mod nextest;
mod node;
mod package;
mod parity;
mod peers;
mod python;
mod retargeting;
mod scope;
mod semver;
mod setup;
mod studies;
mod targets;
mod task;
mod test;
mod wheel;

use std::env;
use std::process::ExitCode;

use anyhow::Result;

use scope::Scope;
use task::{HELP, Task};

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let Some(task) = Task::parse(&words) else {
        eprint!("error: unknown command `{}`\n\n{HELP}", words.join(" "));
        return ExitCode::from(2);
    };
    match run(task) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(task: Task<'_>) -> Result<()> {
    match task {
        Task::Help => {
            print!("{HELP}");
            Ok(())
        }
        Task::Setup => setup::run(),
        Task::Test { all: false } => test::run(Scope::Gate),
        Task::Test { all: true } => test::run(Scope::All),
        Task::Soak => test::soak(),
        Task::Firmware { board } => firmware::run(board),
        Task::Budget { accept } => {
            firmware::all()?;
            measure::run(if accept { &["budget", "--accept"] } else { &["budget"] })
        }
        Task::Parity => parity::run(),
        Task::Node => node::run(),
        Task::Emulate => emulate::run(),
        Task::Limits => limits::run(),
        Task::Clients => clients::run(),
        Task::Retargeting { accept } => retargeting::run(accept),
        Task::Peers => peers::run(),
        Task::Python { bench: false } => wheel::run(),
        Task::Python { bench: true } => wheel::bench(),
        Task::Deny => deny::run(),
        Task::Semver { revision } => semver::run(revision),
        Task::Audit { self_test: true } => measure::run(&["audit", "--self-test"]),
        Task::Audit { self_test: false } => measure::run(&["audit"]),
        Task::Docs => docs::run(),
    }
}
