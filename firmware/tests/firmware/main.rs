//! Tests of the firmware in process: its parts, the controller and the node with simulated servos, and a model of the
//! supervisor.

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
