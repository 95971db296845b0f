//! Byte streams that are or were interesting: `streams.hex`, one in a line.

/// All of them.
pub(crate) fn streams() -> Vec<Vec<u8>> {
    let lines = include_str!("streams.hex").lines().filter(|line| !line.starts_with('#'));
    let byte = |text| u8::from_str_radix(text, 16).unwrap();
    lines.map(|line| line.split_whitespace().map(byte).collect()).collect()
}
