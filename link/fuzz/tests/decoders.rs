//! A target for each way in.

#[path = "../../tests/common/mod.rs"]
mod common;
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

targets!(stream, body, controller);
