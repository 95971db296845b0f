//! Bytes that are or were interesting, one input of a target in a line: `stream.hex`, `body.hex`, `controller.hex`.

/// Those of a target.
pub(crate) fn inputs(target: &str) -> Vec<Vec<u8>> {
    let text = match target {
        "stream" => include_str!("stream.hex"),
        "body" => include_str!("body.hex"),
        "controller" => include_str!("controller.hex"),
        other => panic!("no target {other}"),
    };
    let byte = |at: &[u8]| u8::from_str_radix(std::str::from_utf8(at).unwrap(), 16).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.as_bytes().chunks(2).map(byte).collect()).collect()
}
