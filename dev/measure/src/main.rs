//! Reads images of boards. `cargo xtask firmware`, `budget` and `audit` build the images and run this program.
//!
//! # Files
//! - `elf/`: functions, instructions and calls of an image.
//! - `budget/`: instructions, stack, flash and RAM, compared with the committed file.
//! - `audit/`: the search for forbidden content in a board's program.

mod audit;
mod budget;
mod elf;

use std::process::ExitCode;

use anyhow::{Result, bail};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match run(&words) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(words: &[&str]) -> Result<()> {
    match words {
        ["sizes", names @ ..] => budget::sizes(names),
        ["budget"] => budget::run(false),
        ["budget", "--accept"] => budget::run(true),
        ["audit"] => audit::run(),
        ["audit", "--self-test"] => audit::self_test(),
        _ => bail!("{words:?}: it is started by `cargo xtask firmware`, `budget` or `audit`"),
    }
}
