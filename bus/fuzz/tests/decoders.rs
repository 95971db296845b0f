//! A target for each decoder.

#[path = "../../tests/decoders/mod.rs"]
mod decoders;

macro_rules! targets {
    ($($name:ident),*) => {$(
        #[test]
        fn $name() {
            bolero::check!().for_each(|bytes: &[u8]| decoders::$name(bytes));
        }
    )*};
}

targets!(dynamixel_controller, dynamixel_servo, feetech_controller, feetech_servo, pca9685_chip);
