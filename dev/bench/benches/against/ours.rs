//! The core's kernels on one rig, with the interface of [`Peer`](crate::peer::Peer).

use std::hint::black_box;
use std::time::Instant;

use sinew_core::dynamics::{
    ArticulatedBody, CompositeBody, dof_count, forward_dynamics, mass_matrix,
};
use sinew_core::{BodyState, JointKind, Tree, Twist, Wrench, kinematics};

use crate::motion::RigMotion;
use crate::peer::Kernel;
use crate::sinew::Sinew;
use crate::{BODIES, Contender as _, GRAVITY_M_S2};

pub(crate) struct Ours {
    inverse: Sinew,
    articulated: Vec<ArticulatedBody>,
    accelerations: Vec<Twist>,
    composites: Vec<CompositeBody>,
    matrix: Vec<f32>,
    world: Vec<BodyState>,
}

impl Ours {
    pub(crate) fn new(tree: &Tree<BODIES>) -> Self {
        let count = tree.len();
        Self {
            inverse: Sinew::new(tree),
            articulated: vec![ArticulatedBody::default(); count],
            accelerations: vec![Twist::ZERO; count],
            composites: vec![CompositeBody::default(); count],
            matrix: vec![0.0; dof_count(tree.bodies()).pow(2)],
            world: vec![BodyState::WORLD; count],
        }
    }

    /// Sets a motion. Forward dynamics gets the wrenches that the motion needs.
    pub(crate) fn set(&mut self, motion: &RigMotion) {
        self.inverse.set(motion);
        self.inverse.run();
    }

    fn run(&mut self, kernel: Kernel) {
        let (tree, joints) = (black_box(&self.inverse.tree), black_box(&self.inverse.joints));
        match kernel {
            Kernel::Rnea => self.inverse.run(),
            Kernel::Aba => forward_dynamics(
                tree.bodies(),
                joints,
                black_box(&self.inverse.wrenches),
                GRAVITY_M_S2,
                &[],
                &mut self.articulated,
                &mut self.accelerations,
            ),
            Kernel::Crba => {
                mass_matrix(tree.bodies(), joints, &mut self.composites, &mut self.matrix);
            }
            Kernel::Kinematics => kinematics::body_states(tree.bodies(), joints, &mut self.world),
        }
        black_box(self);
    }

    /// Returns the time of a call, ns.
    pub(crate) fn time_ns(&mut self, kernel: Kernel, calls: u32) -> f64 {
        let start = Instant::now();
        for _ in 0..calls {
            self.run(kernel);
        }
        start.elapsed().as_secs_f64() * 1e9 / f64::from(calls)
    }

    /// Returns the result of a kernel in the form of a peer: `dev/bench/peers/peer.hpp`.
    pub(crate) fn found(&mut self, kernel: Kernel) -> Vec<f64> {
        self.run(kernel);
        match kernel {
            Kernel::Rnea => {
                let wrench = |wrench: &Wrench| Twist::new(wrench.moment_nm, wrench.force_n);
                self.by_joint(&self.inverse.wrenches.iter().map(wrench).collect::<Vec<_>>())
            }
            Kernel::Aba => self.by_joint(&self.accelerations),
            Kernel::Crba => vec![self.energy()],
            Kernel::Kinematics => {
                let last = self.world.last().map(|state| state.pose.translation_m.as_dvec3());
                last.map_or_else(Vec::new, |position_m| position_m.to_array().to_vec())
            }
        }
    }

    /// Returns all six numbers of the root, and the numbers of other joints along their dofs.
    fn by_joint(&self, motions: &[Twist]) -> Vec<f64> {
        let mut all = Vec::new();
        for (body, motion) in self.inverse.tree.bodies().iter().zip(motions) {
            let angular = motion.angular.as_dvec3();
            match body.joint {
                JointKind::Revolute { axis } => all.push(axis.as_dvec3().dot(angular)),
                _ => all.extend(angular.to_array()),
            }
            if body.joint == JointKind::Free {
                all.extend(motion.linear.as_dvec3().to_array());
            }
        }
        all
    }

    /// Returns the kinetic energy, computed with the mass matrix.
    fn energy(&self) -> f64 {
        let speeds =
            self.by_joint(&self.inverse.joints.iter().map(|j| j.velocity).collect::<Vec<_>>());
        let of_row = |(row, speed): (&[f32], &f64)| {
            let sum: f64 = row.iter().zip(&speeds).map(|(h, v)| f64::from(*h) * v).sum();
            0.5 * sum * speed
        };
        self.matrix.chunks_exact(speeds.len()).zip(&speeds).map(of_row).sum()
    }
}
