//! Functions that all commands on a host share.
//!
//! - [`output`] writes files completely or not at all, locks a folder of results, and never overwrites an input.
//! - [`command`] contains the options and the terminal output that `sinew` and `sinew-studies` share.
//! - [`random`] generates seeded random numbers.
//! - [`parse_message()`] converts messages of serde and toml to sentences.

pub mod command;
pub mod output;
mod parse_message;
pub mod random;

pub use parse_message::parse_message;
