//! Storage on simulated flash: power cuts, damage, any content.

mod coarse;
mod common;
mod damage;
mod items;
mod page;
mod power_cut;
mod random;
mod sequential_storage;
