//! Writing to the terminal.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Write as _};

use indicatif::{ProgressBar, ProgressStyle};

/// Writes to standard output. Names out of files cannot command the terminal: their control characters are written out.
///
/// # Errors
/// What the system says, such as that the disk is full. That the reader has gone, as in `sinew | head`, is none: the
/// command ends with the exit code of its own result.
pub fn print(text: &str) -> io::Result<()> {
    print_raw(&harmless(text))
}

/// Writes to standard output what may move the cursor: nothing of it is out of a file.
///
/// # Errors
/// Those of [`print()`].
pub fn print_raw(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Writes a line to standard error, if there is one.
pub fn note(line: fmt::Arguments<'_>) {
    // There is no place left to tell about a failure here.
    let _ = writeln!(io::stderr(), "{}", harmless(&line.to_string()));
}

/// The text with U+FFFD for each character that a terminal would obey or that would turn the text round: controls but
/// for the end of a line and the tabulator, and the marks of direction.
fn harmless(text: &str) -> Cow<'_, str> {
    let commands = |c: char| {
        c.is_control() && c != '\n' && c != '\t'
            || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if text.contains(commands) { text.replace(commands, "\u{fffd}").into() } else { text.into() }
}

/// Shows a bar on standard error while `work` runs, if that is a terminal.
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
