//! World Space Error.

use super::StateError;
use crate::state::BodyState;

/// Error of each body's world state, in world axes: eq. (4) of Notman et al. (2011). O(n).
pub fn world(desired: &[BodyState], measured: &[BodyState], out: &mut [StateError]) {
    for ((desired, measured), error) in desired.iter().zip(measured).zip(out) {
        *error = StateError::between(desired, measured);
    }
}
