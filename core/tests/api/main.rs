//! Tests of the crate's public interface: the README's example, and stored settings and states.

mod readme;
#[cfg(feature = "serde")]
mod serde;
