//! Tests of rig files, imports of robot descriptions, and boards' rigs.

mod actuators;
mod board;
mod common;
mod drives;
mod golden;
mod import_data;
mod mjcf;
mod mutations;
mod new_arm;
mod servo_models;
mod urdf;
