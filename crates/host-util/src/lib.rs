//! What commands on a host share, whatever they are about.
//!
//! - [`output`] writes files: each as a whole, a folder of results as a whole and locked, never over an input.
//! - [`command`] holds the options and the output to a terminal that `sinew` and `sinew-studies` share.
//! - [`random`] makes seeded random numbers.
//! - [`parse_message()`] turns messages of serde and toml into sentences.

pub mod command;
pub mod output;
mod parse_message;
pub mod random;

pub use parse_message::parse_message;
