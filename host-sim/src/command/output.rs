//! Writing to the terminal.

use std::fmt;
use std::io::{self, Write as _};

use indicatif::{ProgressBar, ProgressStyle};

/// Writes to standard output.
///
/// # Errors
/// What the system says: the reader has gone, the disk is full.
pub fn print(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    stdout.flush()
}

/// Writes a line to standard error, if there is one.
pub fn note(line: fmt::Arguments<'_>) {
    // There is no place left to tell about a failure here.
    let _ = writeln!(io::stderr(), "{line}");
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
