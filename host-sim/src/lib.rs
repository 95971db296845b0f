//! The host side of Sinew: mocap in, simulated figure, the paper's tables out.

pub mod blend;
pub mod builtin;
pub mod character;
pub mod command;
pub mod evaluate;
pub mod figure;
pub mod find;
pub mod geodesic;
pub mod inspect;
pub mod measured;
pub mod output;
mod parse_message;
pub mod performance;
pub mod pipeline;
pub mod plant;
pub mod play;
pub mod random;
pub mod report;
pub mod rig;
pub mod spatial;
pub mod sweep;
pub mod teach;
pub mod verify;
pub mod weights;
