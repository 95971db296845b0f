//! The command `sinew-studies`.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
