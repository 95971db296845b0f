//! What commands on a host share, whatever they are about.

pub mod command;
pub mod output;
mod parse_message;
pub mod random;

pub use parse_message::parse_message;
