//! The effect of rounding on the core's results: the core's formulas, evaluated with numbers that carry their
//! rounding.
//!
//! An error limit is not taken from a run of the program: it follows from the additions and multiplications that lead
//! to a result, in each case. The order of operations is mainly the core's. Another order of equal sums has errors of
//! equal size, up to a factor for which the limits have room.

mod dynamics;
mod forward;
mod kinematics;
mod link;
mod motion;
mod number;
mod space;
mod states;

pub use dynamics::{inverse_dynamics, mass_matrix, mass_matrix_by_torques};
pub use forward::forward_dynamics;
pub use kinematics::body_states;
pub use link::{Link, symmetric};
pub use motion::Motion;
pub use number::{DOUBLE, LAMBDA, Number};
pub use space::{Matrix, Rotation, Vector, turn_error};
pub use states::{Compensated, Difference, Joint, State};
