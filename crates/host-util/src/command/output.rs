//! Writes to the terminal.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Write as _};

use indicatif::{ProgressBar, ProgressStyle};

/// Writes to standard output. Control characters, for example in names from files, are replaced, so that they cannot
/// control the terminal.
///
/// # Errors
/// An error of the operating system, such as a full disk. A closed pipe, as in `sinew | head`, is not an error: the
/// command ends with the exit code of its own result.
pub fn print(text: &str) -> io::Result<()> {
    print_raw(&harmless(text))
}

/// Writes text to standard output that may move the cursor. The text must not contain data from a file.
///
/// # Errors
/// The errors of [`print()`].
pub fn print_raw(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Writes a line to standard error, if it is open.
pub fn note(line: fmt::Arguments<'_>) {
    // A failure cannot be reported anywhere.
    let _ = writeln!(io::stderr(), "{}", harmless(&line.to_string()));
}

/// Replaces with U+FFFD each character that could control a terminal or reverse the text: control characters except
/// newline and tabulator, and direction marks.
fn harmless(text: &str) -> Cow<'_, str> {
    let commands = |c: char| {
        c.is_control() && c != '\n' && c != '\t'
            || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if text.contains(commands) { text.replace(commands, "\u{fffd}").into() } else { text.into() }
}

/// Runs `work` and shows a progress bar on standard error, if that is a terminal. `work` calls the function that it
/// receives with the number of steps just completed.
pub fn with_progress<T>(steps: usize, work: impl FnOnce(&(dyn Fn(usize) + Sync)) -> T) -> T {
    let style = ProgressStyle::with_template(
        "{bar:40} {percent:>3} %  {human_pos} of {human_len} steps, {eta} left",
    )
    .expect("the template is sound");
    let bar = ProgressBar::new(steps as u64).with_style(style);
    let result = work(&|done| bar.inc(done as u64));
    bar.finish_and_clear();
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_command_a_terminal() {
        assert_eq!(harmless("knee\t1\nLeft Ärm"), "knee\t1\nLeft Ärm");
        assert_eq!(
            harmless("\u{1b}]0;a\u{7}\r\u{9b}2J\u{202e}b"),
            "\u{fffd}]0;a\u{fffd}\u{fffd}\u{fffd}2J\u{fffd}b"
        );
    }
}
