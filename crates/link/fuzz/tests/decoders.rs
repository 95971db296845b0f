//! A target for each way in: it takes the corpus, then what bolero thinks of.

#[expect(dead_code, reason = "fuzzing uses a part")]
#[path = "../../tests/link/common/mod.rs"]
mod common;
#[path = "../../tests/link/corpus/mod.rs"]
mod corpus;
#[path = "../../tests/link/decoders/mod.rs"]
mod decoders;

macro_rules! targets {
    ($($name:ident),*) => {$(
        #[test]
        fn $name() {
            corpus::inputs(stringify!($name)).iter().for_each(|bytes| decoders::$name(bytes));
            #[cfg(feature = "bolero")]
            bolero::check!().for_each(|bytes: &[u8]| decoders::$name(bytes));
        }
    )*};
}

targets!(stream, body, controller);
