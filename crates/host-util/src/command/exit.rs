//! Exit codes and error messages of commands.
//!
//! Exit codes: 0 success; 1 success with a bad result; 2 failure (bad input, bad usage).

use std::borrow::Cow;
use std::process::ExitCode;

use super::output::note;

/// Returns the exit code of a command. Writes an error to standard error; the code is then 2.
pub fn exit_code(result: anyhow::Result<ExitCode>) -> ExitCode {
    result.unwrap_or_else(|error| {
        note(format_args!("error: {}", chain(&error)));
        ExitCode::from(2)
    })
}

/// Formats an error with its causes in one line. Skips a cause whose text the line already contains.
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

/// Shortens a line of a message: content that is quoted from a file may have any length.
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
