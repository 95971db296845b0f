//! Bytes that are or were interesting, `corpus/*.hex`, one input in a line: through the fuzz targets of `../../fuzz`.

use std::collections::BTreeSet;

use sinew_firmware::supervisor::State;

use crate::decoders;

fn inputs(text: &str) -> impl Iterator<Item = Vec<u8>> {
    let byte = |at: &[u8]| u8::from_str_radix(std::str::from_utf8(at).unwrap(), 16).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(move |line| line.as_bytes().chunks(2).map(byte).collect())
}

#[test]
fn settings() {
    let read = inputs(include_str!("corpus/settings.hex")).map(|bytes| decoders::settings(&bytes));
    let read: Vec<bool> = read.collect();
    assert!(read.contains(&true) && read.contains(&false));
}

/// Something in every state, and every kind of message.
#[test]
fn node() {
    let mut said = BTreeSet::new();
    for bytes in inputs(include_str!("corpus/node.hex")) {
        said.extend(decoders::node(&bytes));
    }
    let states: BTreeSet<u8> = said.iter().map(|(state, _)| *state).collect();
    let kinds: BTreeSet<&str> = said.iter().map(|(_, kind)| kind.as_str()).collect();
    println!("{} kinds of messages in {} states: {} pairs", kinds.len(), states.len(), said.len());
    assert_eq!(states.len(), State::COUNT, "{states:?}");
    // Greeting, commands, streams.
    assert_eq!(kinds.len(), 1 + 21 + 4, "{kinds:?}");
}
