//! A fuzz target for flash contents that a host may write, and a target for all messages that a host may send in every
//! state. Each runs the corpus, then inputs that bolero generates.

#![expect(dead_code, reason = "tests of the node use the rest")]
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the controller's side is f32, the servos' f64"
)]

#[path = "../../../../firmware/tests/firmware/node/decoders.rs"]
mod decoders;
#[path = "../../../../firmware/tests/firmware/node/emulated.rs"]
mod emulated;
#[path = "../../../../crates/storage/tests/storage/common/flash.rs"]
mod flash;
#[path = "../../../../firmware/tests/firmware/node/hardware.rs"]
mod hardware;
#[path = "../../../../firmware/tests/firmware/node/host.rs"]
mod host;
#[path = "../../../../firmware/tests/firmware/node/hostile.rs"]
mod hostile;
#[path = "../../../../firmware/tests/firmware/node/ideal.rs"]
mod ideal;
#[path = "../../../../firmware/tests/firmware/node/inputs.rs"]
mod inputs;
#[path = "../../../../firmware/tests/firmware/node/line.rs"]
mod line;
#[path = "../../../../firmware/tests/firmware/node/stored.rs"]
mod stored;
#[path = "../../../../firmware/tests/firmware/controller/swing.rs"]
mod swing;
#[path = "../../../../firmware/tests/firmware/controller/test_rig.rs"]
mod test_rig;
#[path = "../../../../firmware/tests/firmware/node/told.rs"]
mod told;
#[path = "../../../../firmware/tests/firmware/node/world.rs"]
mod world;

#[test]
fn settings() {
    inputs::settings().for_each(|bytes| {
        decoders::settings(&bytes);
    });
    bolero::check!().for_each(|bytes: &[u8]| {
        decoders::settings(bytes);
    });
}

/// One input takes seconds of simulated time, so allow minutes for a run.
#[test]
fn node() {
    inputs::node().for_each(|bytes| {
        decoders::node(&bytes);
    });
    bolero::check!().for_each(|bytes: &[u8]| {
        decoders::node(bytes);
    });
}
