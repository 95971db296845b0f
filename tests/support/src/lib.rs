//! Rigs, shows and independent computations for the tests across Sinew's crates. They are a separate, optimized
//! crate; the tests that call them are not optimized, so they compile in a fraction of the time.
//!
//! - [`cylinders`]: surface integrals in f64, by another method than the core's;
//! - [`extreme`]: numbers at the ends of f32, and rigs and states made with them;
//! - [`figure`]: the human figure as boards use it, and a show for it;
//! - [`nearest_pose`]: the optimum of the projection, by dense least squares in f64;
//! - [`newton_euler`]: inverse dynamics of given states in f64;
//! - [`parity`]: runs of the evaluation for other machines, and the differences of their numbers;
//! - [`subtree_form`]: another algorithm for the projection, with which the core's is compared;
//! - [`rig`]: random trees of all joint kinds, and random states of them;
//! - [`rounded`]: rigs and motions with their rounding, for limits that follow from it;
//! - [`mod@reference`]: dynamics of rigs in f64, derived only from poses, independent of the core's recursions.

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

/// Returns the settings of a property test. The cases are the same in every run, unless `PROPTEST_RNG_SEED` asks for
/// others. Failing cases are stored beside the test and run first.
pub fn property(cases: u32) -> Config {
    // The default reads the seed from the environment.
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
