//! Rigs, shows and other ways to their numbers, for the tests across Sinew's crates. They are a crate of their own so
//! that they are optimized: the tests that call them are not, and compile in a fraction of the time.
//!
//! - [`cylinders`]: surface integrals in f64, another way than the core's;
//! - [`extreme`]: numbers at the ends of f32, and rigs and states made with them;
//! - [`figure`]: the human figure as boards have a rig, and a show of it;
//! - [`nearest_pose`]: what the projection looks for, by dense least squares in f64;
//! - [`newton_euler`]: inverse dynamics of given states in f64;
//! - [`parity`]: runs of the evaluation for other machines, and where their numbers differ;
//! - [`subtree_form`]: the other way to look for it, which the core's is compared with;
//! - [`rig`]: random trees of all joint kinds, and random states of them;
//! - [`rounded`]: rigs and motions with their rounding, for limits that follow from it;
//! - [`mod@reference`]: their dynamics in f64 from nothing but poses, independent of the core's recursions.

pub mod cylinders;
pub mod extreme;
pub mod figure;
pub mod nearest_pose;
pub mod newton_euler;
pub mod parity;
pub mod reference;
pub mod rig;
pub mod rounded;
pub mod subtree_form;

use proptest::test_runner::{Config, FileFailurePersistence, RngSeed};

/// Settings of a property: its cases are the same on every run, unless `PROPTEST_RNG_SEED` asks for others, and
/// failures that were found once are kept beside the test and run first.
pub fn property(cases: u32) -> Config {
    // The default has the seed of the environment.
    let rng_seed = match Config::default().rng_seed {
        RngSeed::Random => RngSeed::Fixed(20_261_121),
        asked_for @ RngSeed::Fixed(_) => asked_for,
    };
    Config {
        cases,
        rng_seed,
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..Config::default()
    }
}
