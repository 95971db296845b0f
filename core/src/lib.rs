//! Twist core for animatronic servo rigs: makes a figure of many joints follow a performance with
//! natural, low-gain motion.
//!
//! `no_std`, fixed capacity, no allocation, no `unsafe`, no panic: what is flashed on the controller is
//! what the host simulates, bit for bit.
//!
//! # From a performance to torques
//! 1. [`Tree`]: the rig, validated once.
//! 2. [`Trajectory`], [`finite_difference`]: where the rig should be, and how fast.
//! 3. [`kinematics`]: world states of all bodies.
//! 4. [`state_error`]: how far the rig is from the performance, by one of several methods.
//! 5. [`control`] and [`dynamics`]: error to torque, with inverse dynamics and limits.
//!
//! [`Controller::tick`] does steps 3 to 5 in one call. Where not all joints can have what they want, [`importance`] says how
//! much each matters.
//!
//! ```
//! use sinew_core::{Body, Controller, Inertia, JointKind, JointStates, JointTargets, Trajectory, Tree};
//! use sinew_core::{RotationalInertia, Transform, Workspace, control::Gains, glam::Vec3, math};
//! use sinew_core::state_error::Method;
//!
//! // 1. An arm of two links of 0.3 m and 0.5 kg, on ball joints.
//! let link = |parent, x| Body {
//!     parent,
//!     joint: JointKind::Spherical,
//!     placement: Transform::from_translation(Vec3::X * x),
//!     inertia: Inertia {
//!         mass_kg: 0.5,
//!         center_of_mass_m: Vec3::X * 0.15,
//!         rotational_kg_m2: RotationalInertia::diagonal(1e-4, 4e-3, 4e-3),
//!     },
//! };
//! let arm = Tree::<2>::from_bodies(&[link(None, 0.0), link(Some(0), 0.3)])?;
//!
//! // 2. A performance of 100 frames a second, in which both joints swing.
//! let frame = |k: u8| {
//!     let swing = math::exp(Vec3::Z * 0.5 * (0.1 * f32::from(k)).sin());
//!     [Transform::new(swing, Vec3::ZERO), Transform::new(swing, Vec3::X * 0.3)]
//! };
//! let frames: Vec<Transform> = (0..100).flat_map(frame).collect();
//! let performance = Trajectory::new(&frames, 2, 0.01)?;
//!
//! // 3 to 5.
//! let controller = Controller::new(arm, Gains::critically_damped(200.0)?, Method::World)?;
//! let mut targets = JointTargets::rest(controller.tree());
//! let mut measured = JointStates::rest(controller.tree());
//! let mut workspace = Workspace::new();
//! for frame in 0..performance.len() {
//!     performance.targets(frame, &mut targets)?;
//!     // A rig tells here how its joints stand; this one is where it should be.
//!     for (joint, state) in targets.states().iter().enumerate() {
//!         measured.set(joint, *state)?;
//!     }
//!     let torques = controller.tick(&mut targets, &measured, &[], &mut workspace);
//!     assert!(torques.iter().all(|torque| torque.reason.is_none()));
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions, once
//! - SI units (m, kg, s, N, N m) and radians; right-handed frames; quaternions `[x, y, z, w]`, unit.
//! - Rotations are active: `v_parent = R v_child`. A rotation vector is axis times angle.
//! - **Regular numbering**: body 0 is the root, a parent's index is smaller than its children's. Body
//!   `i` is moved by joint `i`, and its frame has its origin there. The root's parent is the world.
//! - The pose of joint `i` is the pose of body `i` in its parent's frame; velocities and accelerations
//!   of a joint are those of body `i` relative to its parent, in **body axes**.
//! - World velocities are those of the frame's origin, in **world axes**.
//! - **Numbers**: what has a constructor or a setter holds finite numbers. Functions of plain slices and vectors
//!   (kinematics, state errors, dynamics) take any: what is not finite, or too large for f32, comes out as not finite,
//!   and never as a panic. [`Controller::tick`] makes nothing of that but a torque of zero with its reason.
//! - Every elementary function goes through [`math`], and glam is used without SIMD, so that all
//!   machines compute the same bits.
//!
//! # Features
//! Both are off unless asked for, and need neither `std` nor an allocator.
//! - `defmt`: `defmt::Format` for all public types, for the log of a board.
//! - `serde`: `Serialize` and `Deserialize` for settings and states. To read is an entrance like any other: rules
//!   are checked, and NaN and infinities refused, with errors that say what and where.
//!
//! What `serde` writes: vectors as `[x, y, z]`, quaternions as `[x, y, z, w]`, a [`Tree`] as its bodies, sets and what
//! goes by body or joint as a list, a torque limit's bound as a number or none (`null`). To read makes rotations and
//! axes unit, so their last bits may change. What belongs to a tree but comes without one, as
//! [`Aims`](state_error::Aims), must fit *some* tree; [`Controller::new`] checks whether it fits its own. Left out are
//! - scratch, and what is learnt from tick to tick: [`Workspace`], [`Observer`](observer::Observer), ...;
//! - what only its constructor can make: [`ObserverSettings`](observer::ObserverSettings), whose gains must go together,
//!   and [`ManifoldProjection`](projection::ManifoldProjection), made of weights and ranges, which are written, and
//!   [`TorqueSupply`](supply::TorqueSupply), of a number and weights;
//! - [`RestPose`](importance::RestPose) and what is measured on it, which follow from a rig or a character;
//! - [`Trajectory`], which borrows its frames;
//! - errors, which are for people: they have `Display`.
//!
//! ```
//! # #[cfg(feature = "serde")] {
//! use sinew_core::{JointKind, control::{Gains, TorqueLimit}, glam::Vec3};
//! let knee: JointKind = serde_json::from_str(r#"{ "revolute": { "axis": [1, 0, 0] } }"#)?;
//! assert_eq!(knee, JointKind::Revolute { axis: Vec3::X });
//! let servo = TorqueLimit::new(3.0, f32::INFINITY)?;
//! assert_eq!(serde_json::to_string(&servo)?, r#"{"moment_nm":3.0,"force_n":null}"#);
//!
//! let refused = r#"{ "kp": 200, "kd": -28, "linear_kp": 0, "linear_kd": 0 }"#;
//! let error = serde_json::from_str::<Gains>(refused).expect_err("it would push away from the goal");
//! assert_eq!(error.to_string(), "the gain kd is negative; it must be zero or more");
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]
#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::arithmetic_side_effects,
        reason = "a test may fail by panicking"
    )
)]

mod body_set;
mod body_weight;
pub mod control;
mod controller;
pub mod coordinates;
pub mod dynamics;
pub mod finite_difference;
mod fixed;
#[cfg(feature = "defmt")]
mod format;
mod forward_differences;
pub mod importance;
mod inertia;
mod joint;
mod joint_states;
mod joint_targets;
pub mod kinematics;
pub mod math;
mod matrix;
pub mod observer;
pub mod pose_space;
mod pose_step;
pub mod projection;
#[cfg(feature = "serde")]
mod read;
#[cfg(feature = "serde")]
mod serial;
mod state;
pub mod state_error;
pub mod supply;
mod symmetric;
pub mod tracker;
pub mod trajectory;
mod transform;
mod tree;

pub use body_set::BodySet;
pub use controller::{Controller, ControllerError, Workspace};
pub use coordinates::JointCoordinatesError;
pub use forward_differences::ForwardDifferences;
pub use inertia::{Inertia, InertiaError, RotationalInertia};
pub use joint::{JointError, JointKind};
pub use joint_states::JointStates;
pub use joint_targets::JointTargets;
pub use state::{BodyState, JointState, StateInputError};
pub use trajectory::{Trajectory, TrajectoryError};
pub use transform::{Transform, Twist, Wrench};
pub use tree::{Body, Tree, TreeError};

/// The vector algebra that the public types are made of, so that users need not match its version.
pub use glam;
