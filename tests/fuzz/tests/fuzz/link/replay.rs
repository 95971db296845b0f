//! Checks that the corpus covers all kinds of messages.

use std::collections::BTreeSet;

use sinew_fuzz::inputs;
use sinew_link::message::{ToController, ToHost};
use sinew_link::{Decoder, Message};

use super::{common, decoders};

/// Returns the kinds of the messages in a stream of bytes.
fn kinds<M: Message + std::fmt::Debug>(bytes: &[u8], name: fn(&M) -> String) -> BTreeSet<String> {
    let (mut decoder, mut kinds) = (Decoder::<M>::new(), BTreeSet::new());
    decoder.feed(bytes, |message| _ = kinds.insert(name(&message)));
    kinds
}

/// Returns the first word of a text.
fn first(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric()).collect()
}

fn of_controller(message: &ToController) -> String {
    match message {
        ToController::Hello(_) => "Hello".to_owned(),
        ToController::Command(command) => first(&format!("{:?}", command.item)),
        ToController::Stream(stream) => first(&format!("{:?}", stream.item)),
    }
}

fn of_host(message: &ToHost) -> String {
    first(&format!("{message:?}"))
}

/// The corpus has every kind of message, and streams that are cut, damaged and padded.
#[test]
fn streams() {
    let (mut said, mut answered) = (BTreeSet::new(), BTreeSet::new());
    for bytes in inputs("link/stream.hex") {
        decoders::stream(&bytes);
        said.extend(kinds(&bytes, of_controller));
        answered.extend(kinds(&bytes, of_host));
    }
    // Greeting, commands, streams.
    assert_eq!(said.len(), 1 + common::messages::COMMANDS + 4, "{said:?}");
    assert_eq!(answered.len(), 4, "{answered:?}");
}

#[test]
fn bodies() {
    for bytes in inputs("link/body.hex") {
        decoders::body(&bytes);
    }
}

#[test]
fn controllers() {
    for bytes in inputs("link/controller.hex") {
        decoders::controller(&bytes);
    }
}
