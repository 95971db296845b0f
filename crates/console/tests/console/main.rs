//! Tests of the console with a simulated board: which connections it accepts, which page drives, and which commands the
//! board gets.

mod attacks;
mod client;
mod driving;
mod emulated;
mod load;
mod many;
mod other_side;
mod recording;
mod replay;
mod response;
