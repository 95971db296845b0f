//! Predicts, before a show is played, how far the servos that close their own loop stay behind it, and whether the
//! supervisor would end the show with a following error.
//!
//! - [`ServoLag`] is a linear model of a dof with such servos: from torque and speed it gives a bound of the error, and
//!   the speed that the dof cannot follow. [`servo_lags`] derives it from the parts of a rig.
//! - [`FollowedSpeed`] is the largest speed of a joint by this model, for `sinew rig check`.
//! - [`FollowingCheck`] plays a show on simulated servos, unless the bounds show that no servo can be that far behind.
//!
//! `docs/drives.md` derives both.

mod check;
mod lag;
mod prediction;
mod speeds;
#[cfg(test)]
mod tests;

pub use check::{Allowance, FollowingCheck};
pub use lag::{ServoLag, servo_lags};
pub use prediction::{LargestError, Prediction};
pub use speeds::FollowedSpeed;
