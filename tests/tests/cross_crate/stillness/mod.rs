//! Rigs that stand still.

mod creep;
mod follow;
mod held;
mod limits;
mod measure;
mod onset;
mod push;
mod run;
