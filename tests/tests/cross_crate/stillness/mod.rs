//! Tests of rigs that stand still.

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
mod robots;
mod robustness;
mod run;
