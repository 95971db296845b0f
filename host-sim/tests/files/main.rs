//! Tests with foreign files: from many makers, recorded and hostile.

mod arms;
mod attack;
#[path = "../common/mod.rs"]
mod common;
mod driven_ties;
mod field;
mod foreign;
mod kills;
mod mocap_data;
mod outputs;
mod ties;
