//! How a command ends.
//!
//! Exit codes: 0 done; 1 done, and the result is bad; 2 could not be done (bad input, bad usage).

use std::borrow::Cow;
use std::process::ExitCode;

use super::output::note;

/// The exit code of a command. An error is written to standard error.
pub fn exit_code(result: anyhow::Result<ExitCode>) -> ExitCode {
    result.unwrap_or_else(|error| {
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
    line.lines().map(shortened).collect::<Vec<_>>().join("\n")
}

/// A line of a message: what a file has in its place may be of any length.
fn shortened(line: &str) -> Cow<'_, str> {
    const LENGTH_MAX: usize = 1500;
    match line.char_indices().nth(LENGTH_MAX) {
        None => line.into(),
        Some((end, _)) => {
            format!("{}… and {} characters more", &line[..end], line[end..].chars().count()).into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_has_no_line_without_end() {
        let error = anyhow::anyhow!("a.{}\nkey", "ä".repeat(15_000)).context("--set");
        let told = chain(&error);
        assert!(told.starts_with("--set: a.ä") && told.ends_with("characters more\nkey"), "{told}");
        assert!(told.chars().count() < 1600);
    }
}
