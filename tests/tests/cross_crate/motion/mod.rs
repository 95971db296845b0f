//! Tests of the motion core: with oracles, with laws over random trees, and with extreme inputs.

mod all_children;
mod controller;
mod coordinates;
mod dynamics;
mod entrances;
mod finite;
mod forward_dynamics;
mod geno_weights;
mod importance;
mod mass_matrix;
mod observer;
mod oracles;
mod pose_space;
mod precision;
mod projection;
mod reflected;
mod resolved_acceleration;
mod rotors;
mod same_bits;
mod state_error;
mod supply;
mod tracker;
mod trajectory;
