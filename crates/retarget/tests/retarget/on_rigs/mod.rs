//! Performers on rigs: rigs matched, mappings, poses solved.

mod examples;
mod mapping;
mod rigs;
mod solve;
