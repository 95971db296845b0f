//! The command `sinew`.

mod cli;
mod inspect;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
