//! Runs the corpus through the fuzz targets of `tests/fuzz`.

use std::collections::BTreeSet;

use sinew_firmware::supervisor::State;

use super::{decoders, inputs};

#[test]
fn settings() {
    let read = inputs::settings().map(|bytes| decoders::settings(&bytes));
    let read: Vec<bool> = read.collect();
    assert!(read.contains(&true) && read.contains(&false));
}

/// The corpus contains messages in every state, and every kind of message.
#[test]
fn node() {
    let mut said = BTreeSet::new();
    for bytes in inputs::node() {
        said.extend(decoders::node(&bytes));
    }
    let states: BTreeSet<u8> = said.iter().map(|(state, _)| *state).collect();
    let kinds: BTreeSet<&str> = said.iter().map(|(_, kind)| kind.as_str()).collect();
    println!("{} kinds of messages in {} states: {} pairs", kinds.len(), states.len(), said.len());
    assert_eq!(states.len(), State::COUNT, "{states:?}");
    // A greeting, the commands, and the streams.
    assert_eq!(kinds.len(), 1 + 25 + 4, "{kinds:?}");
}
