//! Studies of articles that Sinew takes ideas from: what they claim, tried again on other data.

pub mod autoencoder;
pub mod pictures;
pub mod recordings;
pub mod spatial;
mod tables;
