//! Motions of the figure: evaluated, searched, blended and weighted, by the library and by commands.

mod better;
#[path = "../common/mod.rs"]
mod common;
mod evaluate;
mod figure;
mod find;
mod report;
mod robustness;
mod study;
mod sweep;
mod verify;
mod weights;
