//! Joint coordinates: the numbers of servos and encoders, for all joints of a tree.
//!
//! The core works with transforms ([`JointState`](crate::JointState)). A rig works with numbers: positions `q`,
//! speeds `qd`, accelerations `qdd`, and efforts. Each of these quantities is one slice, body after body in regular
//! numbering.
//!
//! | joint | `q` | `qd`, `qdd` and efforts |
//! | --- | --- | --- |
//! | fixed | | |
//! | revolute | angle, rad | rad/s, rad/s², N m |
//! | prismatic | displacement, m | m/s, m/s², N |
//! | universal | both angles, rad | rad/s, rad/s², N m, about both axes |
//! | spherical | unit quaternion x y z w of the body in the joint frame | rad/s, rad/s², N m, about x, y, z of the body |
//! | free | quaternion as above, then x y z in the joint frame, m | three about, then three along x, y, z of the body |
//!
//! `q` has [`Tree::coordinate_count`](crate::Tree::coordinate_count) numbers (nq). The other slices have
//! [`Tree::dof_count`](crate::Tree::dof_count) numbers (nv). [`Tree::coordinates`](crate::Tree::coordinates) and
//! [`Tree::dofs`](crate::Tree::dofs) return the ranges of a body's numbers.
//!
//! - **Numbers in**: [`JointStates::set_coordinates`](crate::JointStates::set_coordinates) for measured states (for
//!   encoders without speeds, [`JointStates::update_coordinates`](crate::JointStates::update_coordinates));
//!   [`JointTargets::set_coordinates`](crate::JointTargets::set_coordinates) for targets.
//! - **Numbers out**: [`Tree::efforts`](crate::Tree::efforts) for the torques of a tick, or
//!   [`TorqueController::dof_commands`](crate::TorqueController::dof_commands) for target, feed-forward and feedback
//!   of each dof.
//! - **Inverses**: `coordinates` for states and targets, [`Tree::accelerations`](crate::Tree::accelerations) for
//!   commands, [`Tree::wrenches`](crate::Tree::wrenches) for efforts.
//!
//! All are O(n) and allocate nothing. An error ([`CoordinatesError`]) names the slice that is refused.
//!
//! The speeds of a spherical or free joint are components in body axes, not derivatives of its quaternion. The linear
//! accelerations of a free joint are the second derivative of its position, in body axes. They exceed the derivative
//! of its linear speeds by `ω × v`.
//!
//! ```
//! use sinew_core::{Body, Inertia, JointKind, JointStates, Transform, Tree, glam::Vec3};
//! let body = |parent, joint| {
//!     Body { parent, joint, placement: Transform::IDENTITY, inertia: Inertia::default(), rotor_inertia: 0.0 }
//! };
//! let knee = JointKind::Revolute { axis: Vec3::X };
//! let leg = Tree::<2>::from_bodies(&[body(None, JointKind::Spherical), body(Some(0), knee)])?;
//! assert_eq!((leg.coordinate_count(), leg.dof_count()), (5, 4));
//! assert_eq!((leg.coordinates(1), leg.dofs(1)), (4..5, 3..4));
//!
//! let mut measured = JointStates::rest(&leg);
//! measured.set_coordinates(&leg, &[0.0, 0.0, 0.0, 1.0, 0.5], &[0.0, 0.0, 0.0, 2.0])?;
//! assert_eq!(measured.as_slice()[1].velocity.angular, Vec3::X * 2.0);
//! let refused = measured.set_coordinates(&leg, &[0.0, 0.0, 0.0, 1.0, f32::NAN], &[0.0; 4]);
//! let message = refused.expect_err("the knee has no such angle").to_string();
//! assert_eq!(message, "q[4], of joint 1, is NaN; it must be a number from -1e6 to 1e6");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod dof_command;
mod dynamics;
mod error;
mod joint;
mod tree;

pub use dof_command::{DofCommand, nearest_turn};
pub use dynamics::UnderGravity;
pub use error::CoordinatesError;
pub use joint::JointCoordinatesError;
