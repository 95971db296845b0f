//! Tests of shows: writing, playing, blending, damage, and reading by another program.

mod attack;
mod blend;
mod examples;
mod nearer;
mod round_trip;
mod run_in;
mod second_reader;
mod sound;
mod tied;
