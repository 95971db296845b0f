//! What a rig *is*: bodies, joints, ranges, drives, servos, its home pose and where it stands.
//!
//! - [`Description`] is what a person writes (`rig.toml`), with names; it is read from TOML, URDF or MJCF.
//! - [`Mechanism`] is its bodies and joints by index, f64, fixed joints merged: what simulators and checks take.
//! - [`drive`] and [`servo`] are the same maths on a board and at the desk; [`board`] is the rig's compact form there.
//!
//! Simulates nothing, and opens no files: readers take text.
//!
//! # Files
//! - `description/`: a rig with names; `check/` refuses what is invalid, `mechanism` numbers bodies and merges fixed
//!   joints.
//! - `toml_file/`: rig.toml. Reader, writer and the page of keys share one `schema`.
//! - `import/`: URDF and MJCF to a description, in metres and upright, with notes of what was changed or filled in.
//! - `mechanism/`: `kinematics`, and `inverse_dynamics`: the core's, for one instant or for four side by side.
//! - `drive/`, `servo`, `limited`: joints to servos and back, with equal power on both sides (`no_std`).
//! - `servo_model`, `actuation/`: kinds of servo (`models/`, each value with its source), and what joints get from
//!   them.
//! - `review/`: what `sinew rig check` reports; `flexible_joint/` is the linear model of a loop through a soft gear.
//! - `tracking`: bandwidth and rest zone of each joint, by its servos' gears; `stiffness`: how stiffly servos may hold
//!   by loops of their own.
//! - `board/`: the compact form that boards read.
//! - `new/`: an arm and a face to start from.

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
