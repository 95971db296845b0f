//! Rigs that stand still.

mod creep;
mod debug;
mod follow;
mod held;
mod limits;
mod long;
mod measure;
mod onset;
mod push;
mod robots;
mod robustness;
mod run;
