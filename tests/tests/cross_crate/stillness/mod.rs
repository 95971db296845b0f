//! Rigs that stand still.

mod classes;
mod creep;
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
