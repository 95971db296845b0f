//! A motion core for animatronic servo rigs: it makes a tree of joints follow a performance with natural, low-gain
//! motion.
//!
//! `no_std`, fixed capacity, no allocation, no `unsafe`, no panic. Controller and simulator run the same code, and
//! their results are equal to the last bit.
//!
//! # The first torque
//! An arm of six revolute joints: build the tree, name a target, get six torques.
//! ```
#![doc = include_str!("../examples/first_torque.rs")]
//! ```
//! [`prelude`] has all names that a first program needs. [`Tree::inverse_dynamics`], [`Tree::forward_dynamics`],
//! [`Tree::mass_matrix`] and [`Tree::gravity`] use the coordinates of [`JointController`].
//!
//! Gains: the controller turns the error of a joint into an acceleration, `kp` times the error plus `kd` times its
//! rate. Inverse dynamics turns this acceleration into the torque. `kp` is therefore a stiffness per unit of inertia,
//! in 1/s²: the same value suits a finger and a shoulder. 200 is firm, 20 is soft. `kd`, in 1/s, is damping;
//! [`Gains::critically_damped`](control::Gains::critically_damped) chooses `kd = 2 √kp`.
//!
//! Gravity is a vector in the axes of the base, whose frame is the world frame. For a rig on a tilted base, tilt the
//! vector.
//!
//! # From a performance to torques
//! 1. [`Tree`]: the rig, validated once.
//! 2. [`Trajectory`], [`finite_difference`]: desired poses and velocities of the rig. [`coordinates`] converts
//!    between poses and the numbers of servos and encoders.
//! 3. [`kinematics`]: world states of all bodies.
//! 4. [`state_error`]: the difference between the rig and the performance, by one of several methods.
//! 5. [`control`] and [`dynamics`]: error to torque, with inverse dynamics and limits.
//!
//! [`TorqueController::tick`] does steps 3 to 5 in one call. [`tracker::RigTracker`] does all steps, with an observer,
//! from a source of frames. For rigs whose joints cannot all follow exactly, [`importance`] weighs the joints.
//!
//! ```
//! use sinew_core::{Body, TorqueController, Inertia, JointKind, JointStates, JointTargets, Trajectory, Tree};
//! use sinew_core::{Transform, Workspace, control::Gains, glam::Vec3, math, state_error::Method};
//!
//! // 1. An arm of two links of 0.3 m and 0.5 kg, on ball joints.
//! let link = |parent, x| Body {
//!     parent,
//!     joint: JointKind::Spherical,
//!     placement: Transform::from_translation(Vec3::X * x),
//!     inertia: Inertia::of_box(0.5, Vec3::X * 0.15, Vec3::new(0.3, 0.05, 0.05)),
//!     rotor_inertia: 0.0,
//! };
//! let arm = Tree::<2>::from_bodies(&[link(None, 0.0), link(Some(0), 0.3)])?;
//!
//! // 2. A performance of 100 frames per second, in which both joints swing.
//! let frame = |k: u8| {
//!     let swing = math::exp(Vec3::Z * 0.5 * (0.1 * f32::from(k)).sin());
//!     [Transform::new(swing, Vec3::ZERO), Transform::new(swing, Vec3::X * 0.3)]
//! };
//! let frames: Vec<Transform> = (0..100).flat_map(frame).collect();
//! let performance = Trajectory::new(&frames, 2, 0.01)?;
//!
//! // 3. to 5. Track the performance.
//! let controller = TorqueController::new(arm, Gains::critically_damped(200.0)?, Method::World)?;
//! let mut targets = JointTargets::rest(controller.tree());
//! let mut measured = JointStates::rest(controller.tree());
//! let mut workspace = Workspace::new();
//! for frame in 0..performance.len() {
//!     performance.targets(frame, &mut targets)?;
//!     // A real rig stores the readings of its sensors at this point. This rig has no error.
//!     for (joint, state) in targets.states().iter().enumerate() {
//!         measured.set(joint, *state)?;
//!     }
//!     let torques = controller.tick(&mut targets, &measured, &[], &mut workspace);
//!     assert!(torques.iter().all(|torque| torque.reason.is_none()));
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//! - SI units (m, kg, s, N, N m) and radians; right-handed frames; quaternions `[x, y, z, w]`, unit.
//! - Rotations are active: `v_parent = R v_child`. A rotation vector is axis times angle.
//! - **Regular numbering**: body 0 is the root, and a parent's index is smaller than its children's. Joint `i` moves
//!   body `i`, whose frame has its origin at the joint. The root's parent is the world.
//! - The pose of joint `i` is the pose of body `i` in its parent's frame. The velocity and acceleration of a joint
//!   are those of body `i` relative to its parent, in **body axes**.
//! - A world velocity is the velocity of the frame's origin, in **world axes**.
//! - **Numbers**: types with a constructor or a setter hold finite numbers. Functions of plain slices and vectors
//!   (kinematics, state errors, dynamics) accept any numbers. If a number is not finite, or too large for f32, the
//!   result is not finite either; there is no panic. [`TorqueController::tick`] then gives a torque of zero and the
//!   reason.
//! - Every elementary function goes through [`math`], and glam is used without SIMD, which makes the results of all
//!   machines identical to the bit.
//!
//! # Features
//! Both are off by default. Neither needs `std` or an allocator.
//! - `defmt`: `defmt::Format` for all public types, for a board's log.
//! - `serde`: `Serialize` and `Deserialize` for settings and states. Reading checks the same rules as the
//!   constructors and refuses NaN and infinity. An error names the wrong value and its place.
//!
//! `serde` writes vectors as `[x, y, z]`, quaternions as `[x, y, z, w]`, a [`Tree`] as a list of its bodies, sets and
//! values by body or joint as lists, and the bound of a torque limit as a number or `null` (no bound). Reading
//! normalises rotations and axes, which may change their last bits. A value that belongs to a tree but is read
//! without it, such as [`Aims`](state_error::Aims), must fit *some* tree; [`TorqueController::new`] checks whether it
//! fits the controller's. `serde` does not cover
//! - scratch memory, and estimates that are updated from tick to tick: [`Workspace`],
//!   [`Observer`](observer::Observer), ...;
//! - types that only a constructor can make: [`ObserverSettings`](observer::ObserverSettings), whose gains depend on
//!   each other; [`ManifoldProjection`](projection::ManifoldProjection) (write its weights and ranges instead);
//!   [`TorqueSupply`](supply::TorqueSupply) (write its number and weights);
//! - [`RestPose`](importance::RestPose) and the values measured on it, which follow from a rig or a character;
//! - [`Trajectory`], which borrows its frames;
//! - errors, which have a `Display` for people.
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
//!
//! # Files
//! In this list, a module uses only modules of its own line and of earlier lines:
//! - `math`: elementary functions, most of them short polynomials. No other code computes such functions.
//! - `bandwidth`: the bandwidth that a soft gear allows.
//! - `read`: numbers that the feature `serde` reads, refused if they are not finite or not unit.
//! - `transform`, `inertia`, `joint`: rigid transforms, motion and force vectors; mass properties; joint kinds.
//! - `body_set`, `tree`, `fixed`, `matrix`, `symmetric`: the rig in regular numbering (λ parent, κ supporters, ν
//!   subtree, µ children, leaves); vectors filled without a panic; small matrices.
//! - `state`, `kinematics`, `pose_step`, `finite_difference`: states of joints and bodies, and the conversion between
//!   them (eq. 5); steps between poses; eq. 13.
//! - `joint_states`, `joint_targets`: checked containers of measured states and of targets.
//! - `trajectory`, `forward_differences`, `aligned_differences`: performances as a list of frames, and frame by
//!   frame.
//! - `importance/`, `body_weight`: weights of joints, from a skeleton at rest; weights of bodies.
//! - `dynamics/`: inverse dynamics (`rnea`), forward dynamics (`aba`), mass matrix (`crba`), the inertia at a drive
//!   (`reflected`), and Gauss's principle (`least_constraint`), which the projection and `resolved_acceleration` use.
//! - `projection/`, `pose_space/`: the pose of the rig that is nearest to the desired pose; distances between poses,
//!   and curves.
//! - `state_error/`: a file for each method.
//! - `control`, `controller`: gains, laws and limits; the tick from targets and measurements to torques.
//! - `chain`: constructors of bodies by the kind of their joint, and of trees that are one chain.
//! - `coordinates/`, `joint_controller`: states, efforts and dynamics as slices of numbers; a tick that uses such
//!   slices.
//! - `supply`, `observer`: the limit of the sum of all torques; filtered sensors, learned disturbances, and a
//!   prediction over the delay.
//! - `tracker/`: the whole tick in one call: frames (`frames`) to targets (`desired`), readings to states
//!   (`estimate`).
//! - `prelude`: the names that a first program needs.
//! - `serial`, `format`: the implementations for the features `serde` and `defmt`.

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

mod aligned_differences;
pub mod bandwidth;
mod body_set;
mod body_weight;
mod chain;
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
mod joint_controller;
mod joint_states;
mod joint_targets;
pub mod kinematics;
pub mod math;
mod matrix;
pub mod observer;
pub mod pose_space;
mod pose_step;
pub mod prelude;
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
pub use controller::{ControllerError, GRAVITY_M_S2, TorqueController, Workspace};
pub use coordinates::JointCoordinatesError;
pub use forward_differences::ForwardDifferences;
pub use inertia::{Inertia, InertiaError, RotationalInertia};
pub use joint::{JointError, JointKind};
pub use joint_controller::{JointController, JointControllerError, JointTickError};
pub use joint_states::JointStates;
pub use joint_targets::JointTargets;
pub use state::{BodyState, JointState, StateInputError};
pub use trajectory::{Trajectory, TrajectoryError};
pub use transform::{Transform, Twist, Wrench};
pub use tree::{Body, Tree, TreeError};

/// The vector algebra of the public types. Using this re-export avoids a mismatch of versions.
pub use glam;
