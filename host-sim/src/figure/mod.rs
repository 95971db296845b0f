//! The 18-body figure of the paper: its bodies, and what they weigh.

pub mod body;

pub use body::{BODIES, BODY_COUNT, Body};
