//! A rig in the form that a board stores: fixed capacity, no names, checked as a whole.
//!
//! # Format, version 1
//! All numbers are little-endian; `f32` is IEEE 754. Infinity means no limit.
//!
//! - 4 bytes: magic `SNWR`
//! - `u16`: version, 1
//! - 5 x `u16`: bodies b, at least 1; dofs v; linked limits; drives; servos s
//! - b x 100 bytes, body: parent `i16` (-1: the world), joint kind `u16` (0 fixed, 1 revolute, 2 prismatic, 3
//!   universal, 4 spherical, 5 free), two axes 6 x `f32` (unused ones zero), placement quaternion xyzw and translation
//!   7 x `f32` (m), mass `f32` (kg), centre of mass 3 x `f32` (m), inertia xx xy xz yy yz zz 6 x `f32` (kg m²), rotor
//!   inertia `f32` (kg m², kg)
//! - v x 24 bytes, dof: least, most, home, largest speed, acceleration and effort, 6 x `f32` (rad, m, N m, N)
//! - 20 bytes each, linked limit: dof and other `u16`, factors 2 x `f32`, least and most 2 x `f32`
//! - drive: its dofs and its servos, each a count `u16` and as many indices `u16`; kind `u16` and numbers:
//!   0 matrix, 1 matrix of a ball joint: rows, then offsets, `f32`; 2 curve: count of points `u16`, points 2 x `f32`;
//!   3 four-bar: ground, crank, coupler, rocker, crank's zero, rocker's zero, range 8 x `f32`, crossed `u16`
//! - s x 56 bytes, servo: bus `u16`, address `u16` (channels from 256), gear, offset, range, torque, speed,
//!   acceleration, torque constant, position gain, friction, damping, rotor inertia 12 x `f32`, on signal loss `u16`
//!   (0 limp, 1 hold, 2 home), zero `u16`
//! - `u32`: CRC-32 (ISO-HDLC) of all bytes before it
//!
//! Position and orientation of the base are the placement of body 0; gravity points along -y of the world.

#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

#[cfg(feature = "std")]
mod bake;
mod bytes;
mod check;
mod codec;
mod error;

use heapless::Vec;
use sinew_core::Tree;

use crate::drive::{DRIVE_CAPACITY, Drive};
use crate::servo::{Address, Servo};

#[cfg(feature = "std")]
pub use bake::BakeError;
pub use error::BoardRigError;

/// A rig of at most `BODIES` bodies, `DOFS` degrees of freedom (and linked limits), and `SERVOS` servos (and drives).
#[derive(Debug, Clone, PartialEq)]
pub struct BoardRig<const BODIES: usize, const DOFS: usize, const SERVOS: usize> {
    tree: Tree<BODIES>,
    dofs: Vec<BoardDof, DOFS>,
    limits: Vec<LinkedLimit, DOFS>,
    drives: Vec<BoardDrive, SERVOS>,
    servos: Vec<BoardServo, SERVOS>,
}

/// One dof, in rad, or m for a slide.
///
/// For a ball joint, the range of the first dof is `[0, most]` and limits the angle from the zero pose; the other
/// two have no range. The three homes together are the rotation vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardDof {
    /// Minimum and maximum position; infinite without limit.
    pub range: [f32; 2],
    /// Position in the home pose.
    pub home: f32,
    /// Maximum speed, rad/s or m/s; infinite without limit.
    pub speed: f32,
    /// Maximum acceleration, rad/s² or m/s²; infinite without limit.
    pub acceleration: f32,
    /// Maximum effort, N m or N; infinite without limit.
    pub effort: f32,
}

/// A limit on a sum of two dofs: `least <= factor · q[dof] + other_factor · q[other] <= most`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkedLimit {
    /// Index of the first dof.
    pub dof: u16,
    /// Index of the second dof.
    pub other: u16,
    /// Factor of the first dof.
    pub factor: f32,
    /// Factor of the second dof.
    pub other_factor: f32,
    /// Minimum and maximum sum; infinite without limit.
    pub range: [f32; 2],
}

/// A drive with the dofs and servos that it connects.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardDrive {
    /// Relation between dofs and servos.
    pub drive: Drive,
    /// Indices of the dofs, in the order of the drive.
    pub dofs: Vec<u16, DRIVE_CAPACITY>,
    /// Indices of the servos, in the order of the drive.
    pub servos: Vec<u16, DRIVE_CAPACITY>,
}

/// A servo and its place on a bus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardServo {
    /// Number of the bus; the board maps it to a bus line.
    pub bus: u16,
    /// Address on the bus.
    pub address: Address,
    /// Limits and constants of the servo.
    pub servo: Servo,
}

impl<const BODIES: usize, const DOFS: usize, const SERVOS: usize> BoardRig<BODIES, DOFS, SERVOS> {
    /// Returns the tree of bodies.
    pub fn tree(&self) -> &Tree<BODIES> {
        &self.tree
    }

    /// Returns the dofs, in the order of the tree.
    pub fn dofs(&self) -> &[BoardDof] {
        &self.dofs
    }

    /// Returns the limits that join two dofs.
    pub fn limits(&self) -> &[LinkedLimit] {
        &self.limits
    }

    /// Returns the drives.
    pub fn drives(&self) -> &[BoardDrive] {
        &self.drives
    }

    /// Returns the servos.
    pub fn servos(&self) -> &[BoardServo] {
        &self.servos
    }
}
