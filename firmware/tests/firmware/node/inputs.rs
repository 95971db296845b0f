//! Input bytes of the fuzz targets, from `tests/fuzz/corpus/firmware/*.hex`: one input per line.

/// Returns the inputs of `decoders::settings`.
pub(crate) fn settings() -> impl Iterator<Item = Vec<u8>> {
    inputs(include_str!("../../../../tests/fuzz/corpus/firmware/settings.hex"))
}

/// Returns the inputs of `decoders::node`.
pub(crate) fn node() -> impl Iterator<Item = Vec<u8>> {
    inputs(include_str!("../../../../tests/fuzz/corpus/firmware/node.hex"))
}

fn inputs(text: &'static str) -> impl Iterator<Item = Vec<u8>> {
    let byte = |at: &[u8]| u8::from_str_radix(std::str::from_utf8(at).unwrap(), 16).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(move |line| line.as_bytes().chunks(2).map(byte).collect())
}
