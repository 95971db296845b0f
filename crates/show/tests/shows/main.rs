//! Shows as they are written, played, blended, damaged and read by another program.

mod attack;
mod blend;
mod examples;
mod nearer;
mod round_trip;
mod run_in;
mod second_reader;
