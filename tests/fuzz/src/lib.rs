//! Inputs of the fuzz targets. The targets themselves are tests.

use std::fs;
use std::path::{Path, PathBuf};

/// Returns the path of a file or a folder in `corpus/`.
pub fn corpus(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name)
}

/// Reads the inputs of a file in `corpus/`: hexadecimal bytes, one input per line.
pub fn inputs(name: &str) -> Vec<Vec<u8>> {
    let path = corpus(name);
    let text = fs::read_to_string(&path).unwrap_or_else(|_| panic!("{}", path.display()));
    let byte = |pair: &[u8]| u8::from_str_radix(str::from_utf8(pair).unwrap(), 16).unwrap();
    let input = |line: &str| {
        let digits: String = line.split_whitespace().collect();
        digits.as_bytes().chunks(2).map(byte).collect()
    };
    text.lines().filter(|line| !line.starts_with('#')).map(input).collect()
}
