//! `defmt::Format` for the types that cannot derive it: types that contain glam's vectors, which have no `Format`,
//! and types of which only a part is useful in a log.
//!
//! No implementation uses `core::fmt`: the board sends numbers, and the host formats them.

use defmt::{Format, Formatter, write};

use crate::controller::{TorqueController, Workspace};
use crate::coordinates::UnderGravity;
use crate::dynamics::{ArticulatedBody, BodyMotion, CompositeBody, ResolvedAccelerationScratch};
use crate::importance::RestPose;
use crate::joint_controller::JointController;
use crate::observer::Observer;
use crate::pose_space::{JointCoordinates, LineWorkspace};
use crate::projection::ProjectionWorkspace;
use crate::state_error::{Aim, StateError};
use crate::tracker::{Tick, Tracker};
use crate::{
    BodySet, ForwardDifferences, Inertia, JointKind, JointTargets, Trajectory, Transform, Tree,
    Twist, Wrench,
};

impl Format for Transform {
    fn format(&self, f: Formatter<'_>) {
        let (rotation, translation_m) = (self.rotation.to_array(), self.translation_m.to_array());
        write!(f, "Transform {{ rotation: {}, translation_m: {} }}", rotation, translation_m);
    }
}

impl Format for Twist {
    fn format(&self, f: Formatter<'_>) {
        let (angular, linear) = (self.angular.to_array(), self.linear.to_array());
        write!(f, "Twist {{ angular: {}, linear: {} }}", angular, linear);
    }
}

impl Format for JointCoordinates {
    fn format(&self, f: Formatter<'_>) {
        let (angular_rad, linear_m) = (self.angular_rad.to_array(), self.linear_m.to_array());
        write!(f, "JointCoordinates {{ angular_rad: {}, linear_m: {} }}", angular_rad, linear_m);
    }
}

impl Format for Wrench {
    fn format(&self, f: Formatter<'_>) {
        let (moment_nm, force_n) = (self.moment_nm.to_array(), self.force_n.to_array());
        write!(f, "Wrench {{ moment_nm: {}, force_n: {} }}", moment_nm, force_n);
    }
}

impl Format for StateError {
    fn format(&self, f: Formatter<'_>) {
        write!(
            f,
            "StateError {{ angular_rad: {}, linear_m: {}, angular_rate_rad_s: {}, linear_rate_m_s: {} }}",
            self.angular_rad.to_array(),
            self.linear_m.to_array(),
            self.angular_rate_rad_s.to_array(),
            self.linear_rate_m_s.to_array(),
        );
    }
}

impl Format for JointKind {
    #[expect(
        clippy::match_same_arms,
        reason = "their texts differ: clippy does not see them in the macro"
    )]
    fn format(&self, f: Formatter<'_>) {
        match self {
            Self::Fixed => write!(f, "Fixed"),
            Self::Revolute { axis } => write!(f, "Revolute {{ axis: {} }}", axis.to_array()),
            Self::Prismatic { axis } => write!(f, "Prismatic {{ axis: {} }}", axis.to_array()),
            Self::Universal { first, second } => {
                let (first, second) = (first.to_array(), second.to_array());
                write!(f, "Universal {{ first: {}, second: {} }}", first, second);
            }
            Self::Spherical => write!(f, "Spherical"),
            Self::Free => write!(f, "Free"),
        }
    }
}

impl Format for Inertia {
    fn format(&self, f: Formatter<'_>) {
        write!(
            f,
            "Inertia {{ mass_kg: {}, center_of_mass_m: {}, rotational_kg_m2: {} }}",
            self.mass_kg,
            self.center_of_mass_m.to_array(),
            self.rotational_kg_m2,
        );
    }
}

impl Format for Aim {
    fn format(&self, f: Formatter<'_>) {
        match self {
            Self::None => write!(f, "None"),
            Self::Child(child) => write!(f, "Child({})", child),
            Self::Children(children) => write!(f, "Children({})", children),
            Self::Point(point_m) => write!(f, "Point({})", point_m.to_array()),
        }
    }
}

/// Logs the members.
impl Format for BodySet {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "{{");
        for (place, body) in self.iter().enumerate() {
            write!(f, "{}{}", if place == 0 { "" } else { ", " }, body);
        }
        write!(f, "}}");
    }
}

/// Logs the bodies. The tree's sets follow from the bodies.
impl<const N: usize> Format for Tree<N> {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "Tree {}", self.bodies());
    }
}

/// Logs the joints with their parents. The sets follow from the parents.
impl<const N: usize> Format for RestPose<N> {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "RestPose {{");
        for joint in 0..self.len() {
            let (parent, position_m) = (self.parent(joint), self.position_m(joint).to_array());
            write!(f, " {{ parent: {}, position_m: {} }}", parent, position_m);
        }
        write!(f, " }}");
    }
}

/// Logs the targets of the joints. The targets of the bodies follow from these.
impl<const N: usize> Format for JointTargets<N> {
    fn format(&self, f: Formatter<'_>) {
        let (states, accelerations) = (self.states(), self.accelerations());
        write!(f, "JointTargets {{ states: {}, accelerations: {} }}", states, accelerations);
    }
}

/// Logs the number of frames, not the frames: a performance is too long for a log.
impl Format for Trajectory<'_> {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "Trajectory {{ frames: {}, dt_s: {} }}", self.len(), self.dt_s());
    }
}

/// Logs the settings and the tree.
impl<const N: usize> Format for TorqueController<N> {
    fn format(&self, f: Formatter<'_>) {
        write!(
            f,
            "Controller {{ tree: {}, gains: {}, method: {}, law: {}, gravity_m_s2: {}, limits: {}, inertias: {} }}",
            self.tree(),
            self.gains(),
            self.method(),
            self.law(),
            self.gravity_m_s2().to_array(),
            self.limits(),
            self.inertias(),
        );
    }
}

/// Logs the values that have public getters.
impl<const N: usize, const R: usize> Format for Workspace<N, R> {
    fn format(&self, f: Formatter<'_>) {
        write!(
            f,
            "Workspace {{ aim_status: {}, commands: {}, torques: {} }}",
            self.aim_status(),
            self.commands(),
            self.torques(),
        );
    }
}

/// Logs the values that have public getters.
impl<const N: usize, const D: usize> Format for Observer<N, D> {
    fn format(&self, f: Formatter<'_>) {
        let (states, disturbances) = (self.states(), self.disturbances());
        write!(f, "Observer {{ states: {}, disturbances: {} }}", states, disturbances);
    }
}

/// Logs only the name of this scratch memory.
impl<const N: usize> Format for ProjectionWorkspace<N> {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "ProjectionWorkspace");
    }
}

/// Logs only the name of this scratch memory.
impl<const N: usize> Format for LineWorkspace<N> {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "LineWorkspace");
    }
}

/// Logs only the name: the stored steps are useless alone.
impl<const N: usize> Format for ForwardDifferences<N> {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "ForwardDifferences");
    }
}

/// Logs only the name of this scratch memory.
impl Format for BodyMotion {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "BodyMotion");
    }
}

/// Logs only the name of this scratch memory.
impl Format for CompositeBody {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "CompositeBody");
    }
}

/// Logs only the name of this scratch memory.
impl Format for ArticulatedBody {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "ArticulatedBody");
    }
}

/// Logs only the name of this scratch memory.
impl Format for ResolvedAccelerationScratch {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "Resolved");
    }
}

/// Logs targets and states. The settings are known to the code that created the tracker.
impl<const N: usize, const D: usize, const R: usize> Format for Tracker<N, D, R> {
    fn format(&self, f: Formatter<'_>) {
        let (targets, states) = (self.targets(), self.states());
        write!(f, "Tracker {{ targets: {}, states: {} }}", targets, states);
    }
}

/// Logs the name only.
impl<const N: usize> Format for UnderGravity<'_, N> {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "UnderGravity");
    }
}

/// Logs the inner torque controller.
impl<const N: usize> Format for JointController<N> {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "JointController {{ controller: {} }}", self.controller());
    }
}

/// Logs the torques.
impl<const N: usize, const D: usize, const R: usize> Format for Tick<'_, N, D, R> {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "Tick {{ torques: {} }}", self.torques());
    }
}
