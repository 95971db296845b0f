//! Random rigs by number: the same in every run.

use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use sinew_test_support::rig::{Joints, Rig, figures, rigs_with_rotors};

/// Largest number of bodies in a rig.
const BODIES: usize = 64;

/// Sizes of the difference between two states of a figure, rad.
const SIZES: [f32; 4] = [1e-4, 1e-2, 0.3, 2.0];

/// A case, identified by its number.
pub(crate) struct Case {
    number: u64,
}

impl Case {
    pub(crate) fn new(number: u64) -> Self {
        Self { number }
    }

    /// Returns a rig with joints of all kinds, and a motion of it.
    pub(crate) fn rig(&self) -> Rig {
        self.drawn(0, &rigs_with_rotors(BODIES, Joints::Mixed))
    }

    /// Returns two states of a mocap figure, desired and measured.
    pub(crate) fn figures(&self) -> (Rig, Rig) {
        let size = SIZES[usize::try_from(self.number % 4).expect("below 4")];
        self.drawn(1, &figures(BODIES, size))
    }

    fn drawn<S: Strategy>(&self, salt: u8, strategy: &S) -> S::Value {
        let mut seed = [salt; 32];
        seed[..8].copy_from_slice(&self.number.to_le_bytes());
        let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
        let mut runner = TestRunner::new_with_rng(Config::default(), rng);
        strategy.new_tree(&mut runner).expect("no rig is rejected").current()
    }
}
