//! A rig as a board has it: of fixed capacity, without names, checked as a whole.
//!
//! # Format, version 1
//! All numbers little-endian; `f32` as IEEE 754. Infinity stands for no limit.
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
//! Where and how the base stands is the placement of body 0: gravity is along -y of the world.

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

/// One degree of freedom: rad, or m of a slide.
///
/// Of a ball joint, the first one's range is `[0, most]`, of the angle from the zero pose; the others have none. Its
/// three homes are the rotation vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardDof {
    /// Least and most position; infinite for no limit.
    pub range: [f32; 2],
    /// Position in the home pose.
    pub home: f32,
    /// The largest speed, rad/s or m/s; infinite for no limit.
    pub speed: f32,
    /// The largest acceleration, rad/s² or m/s²; infinite for no limit.
    pub acceleration: f32,
    /// The largest effort, N m or N; infinite for no limit.
    pub effort: f32,
}

/// `least <= factor · q[dof] + other_factor · q[other] <= most`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkedLimit {
    /// Index of a dof.
    pub dof: u16,
    /// Index of another one.
    pub other: u16,
    /// Factor of the first.
    pub factor: f32,
    /// Factor of the second.
    pub other_factor: f32,
    /// Least and most sum; infinite for no limit.
    pub range: [f32; 2],
}

/// A drive, and what it joins.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardDrive {
    /// The drive.
    pub drive: Drive,
    /// Indices of its dofs, in its order.
    pub dofs: Vec<u16, DRIVE_CAPACITY>,
    /// Indices of its servos, in its order.
    pub servos: Vec<u16, DRIVE_CAPACITY>,
}

/// A servo, and where it hangs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardServo {
    /// Number of the bus: which one that is, the board says.
    pub bus: u16,
    /// Where on the bus.
    pub address: Address,
    /// Its limits and numbers.
    pub servo: Servo,
}

impl<const BODIES: usize, const DOFS: usize, const SERVOS: usize> BoardRig<BODIES, DOFS, SERVOS> {
    /// Its bodies.
    pub fn tree(&self) -> &Tree<BODIES> {
        &self.tree
    }

    /// Its degrees of freedom, in the order of the tree's.
    pub fn dofs(&self) -> &[BoardDof] {
        &self.dofs
    }

    /// Limits that join two dofs.
    pub fn limits(&self) -> &[LinkedLimit] {
        &self.limits
    }

    /// Its drives.
    pub fn drives(&self) -> &[BoardDrive] {
        &self.drives
    }

    /// Its servos.
    pub fn servos(&self) -> &[BoardServo] {
        &self.servos
    }
}
