//! The host side of Sinew: mocap in, simulated figure, the paper's tables out.

pub mod blend;
pub mod builtin;
pub mod character;
pub mod evaluate;
pub mod figure;
pub mod find;
pub mod geodesic;
pub mod pipeline;
pub mod plant;
mod random;
pub mod report;
pub mod show;
pub mod spatial;
pub mod study;
pub mod sweep;
pub mod verify;
pub mod weights;
mod words;
