//! Tests of the console with a simulated board: which connections it accepts, which page drives, and which commands the
//! board gets.

mod alike;
mod attacks;
mod client;
mod driving;
mod emulated;
mod idle;
mod idle_hour;
mod load;
mod many;
mod other_side;
mod program;
mod pulsed_servos;
mod recording;
mod replay;
mod response;
