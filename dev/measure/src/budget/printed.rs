//! Parses lines that images print, such as `kernel=rnea bodies=18`.

use anyhow::{Context, Result};

/// Returns the value of a name in a line.
pub(super) fn field<'a>(line: &'a str, name: &str) -> Result<&'a str> {
    line.split_whitespace()
        .filter_map(|word| word.split_once('='))
        .find(|(key, _)| *key == name)
        .map(|(_, value)| value)
        .with_context(|| format!("QEMU printed no `{name}` in: {line}"))
}

/// Returns the integer value of a name in a line.
pub(super) fn number(line: &str, name: &str) -> Result<u64> {
    let number = field(line, name)?.parse();
    number.with_context(|| format!("QEMU printed no whole number for `{name}` in: {line}"))
}
