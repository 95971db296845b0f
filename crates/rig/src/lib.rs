//! Description of a rig: bodies, joints, ranges, drives, servos, home pose and mount.
//!
//! - [`Description`] is the rig in the form that a person writes (`rig.toml`), with names. It is read from TOML,
//!   URDF or MJCF.
//! - [`Mechanism`] has bodies and joints by index, in f64, with fixed joints merged. Simulators and checks use it.
//! - [`drive`] and [`servo`] run the same code on a board and on a desktop; [`board`] is the compact form of a rig
//!   on a board.
//!
//! This crate simulates nothing and opens no files: its readers get the text of a file.
//!
//! # Files
//! - `description/`: a rig with names; `check/` refuses what is invalid, `mechanism` numbers bodies and merges fixed
//!   joints.
//! - `toml_file/`: rig.toml. Reader, writer and the reference of keys share one `schema`.
//! - `import/`: reads URDF and MJCF as a description in metres and upright, with notes on changed and filled-in
//!   values.
//! - `mechanism/`: `kinematics` and `inverse_dynamics`, which computes as the core does, for one instant or for
//!   many side by side.
//! - `drive/`, `servo`, `limited`: convert joints to servos and back, and conserve power (`no_std`).
//! - `servo_model`, `actuation/`: kinds of servo (`models/`, each value with its source), and the values that
//!   joints get from them.
//! - `review/`: the report of `sinew rig check`; `flexible_joint/` is the linear model of a control loop through an
//!   elastic gear.
//! - `tracking`: bandwidth and rest zone of each joint, limited by its servos' gears; `stiffness`: permitted
//!   stiffness of the servos' own position loops.
//! - `board/`: the compact form that boards read.
//! - `new/`: an arm and a face as starting points for a new rig.

#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]

pub mod board;
pub mod drive;
pub mod limited;
pub mod servo;

#[cfg(feature = "std")]
pub mod actuation;
#[cfg(feature = "std")]
pub mod description;
#[cfg(feature = "std")]
pub mod import;
#[cfg(feature = "std")]
pub mod mechanism;
#[cfg(feature = "std")]
mod nearest;
#[cfg(feature = "std")]
pub mod new;
#[cfg(feature = "std")]
mod number;
#[cfg(feature = "std")]
pub mod review;
#[cfg(feature = "std")]
mod servo_model;
#[cfg(feature = "std")]
pub mod stiffness;
#[cfg(feature = "std")]
pub mod toml_file;
#[cfg(feature = "std")]
pub mod tracking;

#[cfg(feature = "std")]
pub use description::Description;
#[cfg(feature = "std")]
pub use mechanism::Mechanism;
