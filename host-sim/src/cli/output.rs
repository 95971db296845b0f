//! Writing to the terminal.

use std::fmt;
use std::io::{self, Write as _};

/// Writes to standard output.
///
/// # Errors
/// What the system says: the reader has gone, the disk is full.
pub(super) fn print(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    stdout.flush()
}

/// Writes a line to standard error, if there is one.
pub(super) fn note(line: fmt::Arguments<'_>) {
    // There is no place left to tell about a failure here.
    let _ = writeln!(io::stderr(), "{line}");
}
