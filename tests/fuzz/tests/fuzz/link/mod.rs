//! A fuzz target for each decoder of the host link: it runs the corpus, then inputs that bolero generates.

#[expect(dead_code, reason = "fuzzing uses a part")]
#[path = "../../../../../crates/link/tests/link/common/mod.rs"]
mod common;
#[path = "../../../../../crates/link/tests/link/decoders.rs"]
mod decoders;
mod replay;

use sinew_fuzz::inputs;

macro_rules! targets {
    ($($name:ident),*) => {$(
        #[test]
        fn $name() {
            let file = concat!("link/", stringify!($name), ".hex");
            for bytes in &inputs(file) {
                decoders::$name(bytes);
            }
            #[cfg(feature = "bolero")]
            bolero::check!().for_each(|bytes: &[u8]| decoders::$name(bytes));
        }
    )*};
}

targets!(stream, body, controller);
