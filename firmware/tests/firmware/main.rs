//! The firmware in process: its parts, the controller and the node with simulated servos, the supervisor's model.

mod classes;
mod common;
mod controller;
mod drives;
mod faults;
mod gravity;
mod guard;
mod link_states;
mod node;
mod slow_motion;
mod supervisor;
mod supervisor_model;
