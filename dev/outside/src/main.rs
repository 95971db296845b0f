//! The core's first example, as a program of somebody else.

include!("../../../core/examples/first_torque.rs");
