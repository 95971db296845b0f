//! What rounding does to the core's results: its formulas once more, in numbers that carry their rounding.
//!
//! A limit of an error is no number that was read off a run: it follows from what is added and multiplied on the way to
//! a result, for the very case. The order of operations is the core's in the main; another order of the same sums is
//! off by as much, to a factor that the limits have room for.

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
