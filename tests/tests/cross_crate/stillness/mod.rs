//! Tests of rigs that stand still, that follow clips or slow motions, and that are lowered.

mod classes;
mod creep;
mod follow;
mod held;
mod limits;
mod long;
mod lowered;
mod measure;
mod onset;
mod position;
mod push;
pub(super) mod robots;
mod robustness;
pub(super) mod run;
