//! Tests of the console with a simulated board: which connections it accepts, which page drives, and which commands the
//! board gets.

mod attacks;
mod client;
mod driving;
mod load;
mod other_side;
mod replay;
