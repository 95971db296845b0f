//! Our inverse dynamics, f32.

use std::hint::black_box;

use sinew_core::dynamics::{BodyMotion, inverse_dynamics};
use sinew_core::{JointState, JointStates, Transform, Tree, Twist, Wrench};

use crate::motion::{RigMotion, Turn, single, together, torques};
use crate::{BODIES, Contender, GRAVITY_M_S2};

/// `inverse_dynamics` with existing states, as in a tick.
pub(crate) struct Sinew {
    pub(crate) tree: Tree<BODIES>,
    pub(crate) joints: Vec<JointState>,
    accelerations: Vec<Twist>,
    scratch: Vec<BodyMotion>,
    pub(crate) wrenches: Vec<Wrench>,
}

impl Sinew {
    pub(crate) fn new(tree: &Tree<BODIES>) -> Self {
        let count = tree.len();
        Self {
            tree: tree.clone(),
            joints: vec![JointState::default(); count],
            accelerations: vec![Twist::ZERO; count],
            scratch: vec![BodyMotion::default(); count],
            wrenches: vec![Wrench::ZERO; count],
        }
    }
}

impl Contender for Sinew {
    fn name(&self) -> &'static str {
        "sinew"
    }

    fn set(&mut self, motion: &RigMotion) {
        let root = &motion.root;
        let to_body = root.rotation.conjugate();
        self.joints[0] = JointState {
            pose: Transform::new(root.rotation.as_quat(), root.translation_m.as_vec3()),
            velocity: Twist::new(
                (to_body * root.angular_velocity).as_vec3(),
                (to_body * root.linear_velocity).as_vec3(),
            ),
        };
        self.accelerations[0] = Twist::new(
            (to_body * root.angular_acceleration).as_vec3(),
            (to_body * root.linear_acceleration).as_vec3(),
        );
        for (index, turns) in (1..).zip(&motion.turns) {
            let turned = together(turns);
            let placement = self.tree.bodies()[index].placement;
            let rotation = placement.rotation.as_dquat() * turned.rotation;
            self.joints[index] = JointState {
                pose: Transform::new(rotation.as_quat(), placement.translation_m),
                velocity: Twist { angular: turned.velocity.as_vec3(), ..Twist::ZERO },
            };
            self.accelerations[index] =
                Twist { angular: turned.acceleration.as_vec3(), ..Twist::ZERO };
        }
    }

    fn run(&mut self) {
        inverse_dynamics(
            black_box(self.tree.bodies()),
            black_box(&self.joints),
            black_box(&self.accelerations),
            GRAVITY_M_S2,
            &[],
            &mut self.scratch,
            &mut self.wrenches,
        );
        black_box(&self.wrenches);
    }

    fn torques(&self, motion: &RigMotion) -> Vec<f64> {
        let root = self.wrenches[0];
        let to_world = motion.root.rotation;
        let mut all = Vec::new();
        all.extend((to_world * root.moment_nm.as_dvec3()).to_array());
        all.extend((to_world * root.force_n.as_dvec3()).to_array());
        for (wrench, turns) in self.wrenches.iter().skip(1).zip(&motion.turns) {
            all.extend(torques(turns, wrench.moment_nm.as_dvec3()));
        }
        all
    }
}

/// `inverse_dynamics` from the coordinates of the joints, with their check and conversion, which each call of the
/// other crates includes.
pub(crate) struct FromCoordinates {
    inner: Sinew,
    states: JointStates<BODIES>,
    /// Position and speed of each joint except the root, as for `JointKind::state`.
    coordinates: Vec<(Vec<f32>, Vec<f32>)>,
}

impl FromCoordinates {
    pub(crate) fn new(tree: &Tree<BODIES>) -> Self {
        Self { inner: Sinew::new(tree), states: JointStates::rest(tree), coordinates: Vec::new() }
    }
}

impl Contender for FromCoordinates {
    fn name(&self) -> &'static str {
        "sinew, from coordinates"
    }

    fn set(&mut self, motion: &RigMotion) {
        self.inner.set(motion);
        let of_joint = |turns: &Vec<Turn>| match turns.as_slice() {
            [turn] => (vec![single(turn.angle_rad)], vec![single(turn.velocity_rad_s)]),
            turns => {
                let turned = together(turns);
                let rotation = turned.rotation.as_quat();
                (rotation.to_array().to_vec(), turned.velocity.as_vec3().to_array().to_vec())
            }
        };
        self.coordinates = motion.turns.iter().map(of_joint).collect();
    }

    fn run(&mut self) {
        let Self { inner, states, coordinates } = self;
        let bodies = black_box(inner.tree.bodies());
        states.set(0, black_box(inner.joints[0])).expect("the root's state is usable");
        for (index, (position, speed)) in (1..).zip(black_box(&*coordinates)) {
            let body = &bodies[index];
            let state =
                body.joint.state(body.placement, position, speed).expect("usable coordinates");
            states.set(index, state).expect("a usable state");
        }
        inverse_dynamics(
            bodies,
            states.as_slice(),
            black_box(&inner.accelerations),
            GRAVITY_M_S2,
            &[],
            &mut inner.scratch,
            &mut inner.wrenches,
        );
        black_box(&inner.wrenches);
    }

    fn torques(&self, motion: &RigMotion) -> Vec<f64> {
        self.inner.torques(motion)
    }
}
