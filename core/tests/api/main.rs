//! The crate as its users meet it: the README's example, and settings and states that are stored.

mod readme;
#[cfg(feature = "serde")]
mod serde;
