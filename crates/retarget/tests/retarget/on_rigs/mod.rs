//! Tests of performers on rigs: matched rigs, mappings, solved poses.

mod examples;
mod mapping;
mod rigs;
mod solve;
