//! The console with a simulated board: what gets in, who drives, and what the board was told.

mod attacks;
mod client;
mod driving;
mod load;
mod other_side;
