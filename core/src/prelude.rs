//! The names that a first program needs, in one line.
//!
//! ```
//! use sinew_core::prelude::*;
//! let link = Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04));
//! let arm = Tree::<2>::serial_chain(&[Body::revolute(None, Vec3::X, Vec3::Y * 0.1, link); 2])?;
//! let mut controller = JointController::new(arm, 200.0, &[2.0; 2])?;
//! let mut torques_nm = [0.0; 2];
//! controller.tick(&[0.1; 2], &[0.0; 2], &[0.0; 2], &mut torques_nm)?;
//! assert!(torques_nm[1] > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use glam::{Quat, Vec3};

pub use crate::control::{Gains, LimitReason, TorqueLimit};
pub use crate::coordinates::DofCommand;
pub use crate::inertia::{Inertia, RotationalInertia};
pub use crate::joint::JointKind;
pub use crate::joint_controller::JointController;
pub use crate::joint_states::JointStates;
pub use crate::joint_targets::JointTargets;
pub use crate::tracker::{Frame, FrameSource, Measured, RigTracker, Settings, Timing};
pub use crate::transform::{Transform, Twist, Wrench};
pub use crate::tree::{Body, Tree};
