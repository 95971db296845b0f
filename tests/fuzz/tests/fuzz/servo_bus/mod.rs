//! A fuzz target for each decoder of the servo bus: it runs the corpus, then inputs that bolero generates.

mod decoders;
#[path = "../../../../../crates/servo-bus/tests/servo_bus/reference/mod.rs"]
mod reference;
mod replay;

/// Returns the streams of the corpus.
fn streams() -> Vec<Vec<u8>> {
    sinew_fuzz::inputs("servo_bus/streams.hex")
}

macro_rules! targets {
    ($($name:ident),*) => {
        $(
            #[test]
            fn $name() {
                for bytes in &streams() {
                    decoders::$name(bytes);
                }
                #[cfg(feature = "bolero")]
                bolero::check!().for_each(|bytes: &[u8]| decoders::$name(bytes));
            }
        )*

        #[test]
        fn every_decoder_has_a_target() {
            assert_eq!(decoders::DECODERS.map(|(name, _)| name), [$(stringify!($name)),*]);
        }
    };
}

targets!(
    dynamixel_stream,
    dynamixel_controller,
    dynamixel_servo,
    fast_answer,
    feetech_stream,
    feetech_controller,
    sts_servo,
    scs_servo,
    pca9685_chip
);
