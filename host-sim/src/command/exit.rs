//! How a command ends.
//!
//! Exit codes: 0 done; 1 done, and the result is bad; 2 could not be done (bad input, bad usage).

use std::io;
use std::process::ExitCode;

use super::output::note;

/// The exit code of a command. An error is written to standard error.
pub fn exit_code(result: anyhow::Result<ExitCode>) -> ExitCode {
    result.unwrap_or_else(|error| {
        // The reader has gone, as in `sinew | head`: nothing is wrong.
        if error.downcast_ref::<io::Error>().is_some_and(is_broken_pipe) {
            return ExitCode::SUCCESS;
        }
        note(format_args!("error: {}", chain(&error)));
        ExitCode::from(2)
    })
}

/// The error and its causes in one line, without what an error already says of its cause.
fn chain(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if line.is_empty() {
            line = cause;
        } else if !line.contains(&cause) {
            line = format!("{line}: {cause}");
        }
    }
    line
}

fn is_broken_pipe(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::BrokenPipe
}
