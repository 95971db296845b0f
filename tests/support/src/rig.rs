//! Random rigs and random states of them.

use proptest::collection::vec;
use proptest::prelude::*;
use sinew_core::dynamics::{BodyMotion, inverse_dynamics};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::{
    Body, BodyState, Inertia, JointKind, JointState, JointStates, RotationalInertia, Transform,
    Tree, Twist, Wrench, kinematics, math,
};

/// The core's largest capacity.
pub const CAPACITY: usize = 128;

/// A rig, and one motion of it.
#[derive(Debug, Clone)]
pub struct Rig {
    /// Bodies of the rig.
    pub tree: Tree<CAPACITY>,
    /// Coordinates of each joint and their first two derivatives.
    pub motions: Vec<Coordinates>,
}

/// Coordinates of a joint along the columns of its motion subspace, with its start.
#[derive(Debug, Clone, Copy)]
pub struct Coordinates {
    /// Orientation of a spherical or free joint.
    pub rotation: Quat,
    /// Position in m of a free joint in its joint frame.
    pub position_m: Vec3,
    /// Angle in rad or displacement in m of the joints with one or two axes.
    pub along: [f32; 2],
    /// Speeds, rad/s or m/s; first the angular ones, in body axes.
    pub speed: [f32; 6],
    /// Derivatives of the speeds. For angular speeds in body axes, the derivatives of their components.
    pub acceleration: [f32; 6],
}

/// How the bodies of a rig are connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Each body on the previous one.
    Chain,
    /// All bodies on the root.
    Star,
    /// Each body on any previous body.
    Random,
}

/// The joints of a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joints {
    /// Every kind of joint, anywhere.
    Mixed,
    /// The joints of a mocap figure: a free root and spherical joints.
    Figure,
}

/// Two states of a figure of up to `most` bodies, desired and measured. In each axis, poses differ by up to `size`
/// rad (for the root also by up to `size` m), and speeds by up to 1 rad/s or m/s.
pub fn figures(most: usize, size: f32) -> impl Strategy<Value = (Rig, Rig)> {
    (rigs(most, Joints::Figure), vec(unit(), 12 * most)).prop_map(move |(desired, numbers)| {
        let mut measured = desired.clone();
        for (motion, numbers) in measured.motions.iter_mut().zip(numbers.chunks_exact(12)) {
            let mut numbers = Numbers(numbers.iter());
            motion.rotation = math::unit(motion.rotation * math::exp(numbers.vector() * size));
            motion.position_m += numbers.vector() * size;
            for speed in &mut motion.speed {
                *speed += numbers.next();
            }
        }
        (desired, measured)
    })
}

/// A number below 1 in size.
fn unit() -> impl Strategy<Value = f32> {
    -1.0f32..1.0
}

/// Rigs of 1 to `most` bodies. About three of four drives have rotors, with much less to much more inertia than a link.
pub fn rigs_with_rotors(most: usize, joints: Joints) -> impl Strategy<Value = Rig> {
    let rotor =
        prop_oneof![1 => Just(0.0), 3 => (-4.0f32..0.5).prop_map(|power| 10f32.powf(power))];
    (rigs(most, joints), vec(rotor, most)).prop_map(|(rig, rotors)| rig.with_rotors(&rotors))
}

/// Rigs of 1 to `most` bodies, without rotors.
pub fn rigs(most: usize, joints: Joints) -> impl Strategy<Value = Rig> {
    let shape = prop_oneof![Just(Shape::Chain), Just(Shape::Star), Just(Shape::Random)];
    // Each body and its motion use this many numbers.
    let body = (any::<u16>(), 0usize..6, vec(unit(), 48));
    (shape, vec(body, 1..=most)).prop_map(move |(shape, bodies)| build(shape, joints, &bodies))
}

/// Builds a rig. Each body is given by a number that selects its parent, one of six kinds of joint, and 48 numbers
/// below 1 in size.
pub fn build(shape: Shape, joints: Joints, bodies: &[(u16, usize, Vec<f32>)]) -> Rig {
    let mut tree = Tree::new();
    let mut motions = Vec::new();
    for (index, (pick, kind, numbers)) in bodies.iter().enumerate() {
        let mut numbers = Numbers(numbers.iter());
        let parent = index.checked_sub(1).map(|last| match shape {
            Shape::Chain => last,
            Shape::Star => 0,
            Shape::Random => usize::from(*pick) % index,
        });
        let joint = match joints {
            Joints::Mixed => numbers.joint(*kind),
            Joints::Figure if index == 0 => JointKind::Free,
            Joints::Figure => JointKind::Spherical,
        };
        let body = Body {
            parent,
            joint,
            placement: Transform::new(numbers.rotation(), numbers.vector() * 0.3),
            inertia: numbers.inertia(),
            rotor_inertia: 0.0,
        };
        tree.push(body).expect("the numbers are chosen so that every body is possible");
        motions.push(numbers.coordinates());
    }
    Rig { tree, motions }
}

/// Numbers below 1 in size, used one after the other.
struct Numbers<'a>(std::slice::Iter<'a, f32>);

impl Numbers<'_> {
    fn next(&mut self) -> f32 {
        *self.0.next().expect("enough numbers are drawn for a body")
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    fn rotation(&mut self) -> Quat {
        math::exp(self.vector() * 2.0)
    }

    /// Returns a unit vector; X if the numbers are too small.
    fn axis(&mut self) -> Vec3 {
        let v = self.vector();
        let length = math::length(v);
        if length > 1e-2 { v / length } else { Vec3::X }
    }

    fn joint(&mut self, kind: usize) -> JointKind {
        let (axis, other) = (self.axis(), self.axis());
        match kind {
            0 => JointKind::Fixed,
            1 => JointKind::Revolute { axis },
            2 => JointKind::Prismatic { axis },
            3 => {
                let across = axis.cross(other);
                let length = math::length(across);
                let helper = if axis.x.abs() < 0.7 { Vec3::X } else { Vec3::Y };
                let second = if length > 1e-2 { across } else { axis.cross(helper) };
                JointKind::Universal { first: axis, second: second / math::length(second) }
            }
            4 => JointKind::Spherical,
            _ => JointKind::Free,
        }
    }

    /// Returns an inertia made from three non-negative second moments of mass, rotated. Any body has such moments.
    fn inertia(&mut self) -> Inertia {
        let mass_kg = 0.1 + 5.0 * self.next().abs();
        let moments = self.vector().abs() * 0.02 * mass_kg;
        let rotation = self.rotation();
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| {
            let in_principal = rotation.conjugate() * axis;
            let second = rotation * (moments * in_principal);
            axis * moments.element_sum() - second
        });
        let rotational_kg_m2 =
            RotationalInertia { xx: x.x, xy: y.x, xz: z.x, yy: y.y, yz: z.y, zz: z.z };
        Inertia { mass_kg, center_of_mass_m: self.vector() * 0.2, rotational_kg_m2 }
    }

    fn coordinates(&mut self) -> Coordinates {
        Coordinates {
            rotation: self.rotation(),
            position_m: self.vector(),
            along: [self.next() * 2.0, self.next() * 2.0],
            speed: std::array::from_fn(|_| self.next() * 3.0),
            acceleration: std::array::from_fn(|_| self.next() * 20.0),
        }
    }
}

impl Coordinates {
    /// Returns the position coordinates of a joint.
    fn position(&self, joint: JointKind) -> Vec<f32> {
        let numbers = match joint {
            JointKind::Spherical | JointKind::Free => {
                [&self.rotation.to_array()[..], &self.position_m.to_array()].concat()
            }
            _ => self.along.to_vec(),
        };
        numbers[..joint.coordinate_count()].to_vec()
    }

    /// Returns the state of a joint with these coordinates.
    pub fn state(&self, body: &Body) -> JointState {
        let position = self.position(body.joint);
        let speed = &self.speed[..body.joint.dof_count()];
        body.joint.state(body.placement, &position, speed).expect("coordinates are valid")
    }

    /// Returns the acceleration of the joint in the form that inverse dynamics uses.
    pub fn joint_acceleration(&self, body: &Body) -> Twist {
        let state = self.state(body);
        let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
        let columns = body.joint.motion_subspace(in_joint);
        columns.iter().zip(self.acceleration).fold(
            body.joint.bias_acceleration(in_joint, state.velocity),
            |sum, (column, along)| {
                Twist::new(sum.angular + column.angular * along, sum.linear + column.linear * along)
            },
        )
    }
}

impl Rig {
    /// Adds rotors to the drives of the joints that have a drive.
    #[must_use]
    fn with_rotors(self, rotors: &[f32]) -> Self {
        let mut tree = Tree::new();
        for (body, rotor) in self.tree.bodies().iter().zip(rotors) {
            let has_drive = !matches!(body.joint, JointKind::Fixed | JointKind::Free);
            let rotor_inertia = if has_drive { *rotor } else { 0.0 };
            tree.push(Body { rotor_inertia, ..*body }).expect("a rotor on a drive");
        }
        Self { tree, ..self }
    }

    /// Returns positions, speeds and accelerations of all joints in order: `q`, `qd` and `qdd`.
    pub fn coordinates(&self) -> [Vec<f32>; 3] {
        let mut all = [vec![], vec![], vec![]];
        for (body, motion) in self.tree.bodies().iter().zip(&self.motions) {
            let count = body.joint.dof_count();
            all[0].extend(motion.position(body.joint));
            all[1].extend(&motion.speed[..count]);
            all[2].extend(&motion.acceleration[..count]);
        }
        all
    }

    /// Returns the states of the joints.
    pub fn states(&self) -> JointStates<CAPACITY> {
        let mut states = JointStates::rest(&self.tree);
        for (joint, (body, motion)) in self.tree.bodies().iter().zip(&self.motions).enumerate() {
            states.set(joint, motion.state(body)).expect("coordinates are valid");
        }
        states
    }

    /// Returns the states of the bodies in the world.
    pub fn world(&self) -> Vec<BodyState> {
        let mut world = vec![BodyState::WORLD; self.tree.len()];
        kinematics::body_states(self.tree.bodies(), self.states().as_slice(), &mut world);
        world
    }

    /// Returns the states of a figure that is larger by a factor. The tree and the root's pose are unchanged.
    pub fn scaled_states(&self, factor: f32) -> JointStates<CAPACITY> {
        let mut states = self.states();
        for (joint, (state, body)) in
            self.states().as_slice().iter().zip(self.tree.bodies()).enumerate().skip(1)
        {
            let translation_m = body.placement.translation_m * factor;
            let pose = Transform { translation_m, ..state.pose };
            states.set(joint, JointState { pose, ..*state }).expect("as valid as it was");
        }
        states
    }

    /// Returns the wrenches of the joints, computed by the core.
    pub fn wrenches(
        &self,
        joints: &[JointState],
        accelerations: &[Twist],
        gravity_m_s2: Vec3,
        external: &[Wrench],
    ) -> Vec<Wrench> {
        let bodies = self.tree.bodies();
        let mut scratch = vec![BodyMotion::default(); bodies.len()];
        let mut out = vec![Wrench::ZERO; bodies.len()];
        inverse_dynamics(
            bodies,
            joints,
            accelerations,
            gravity_m_s2,
            external,
            &mut scratch,
            &mut out,
        );
        out
    }

    /// Returns the mass matrix. Each column has the efforts of all dofs for a unit acceleration of one dof, at rest
    /// and without gravity.
    pub fn mass_matrix_by_torques(&self) -> Vec<Vec<f64>> {
        let (bodies, states) = (self.tree.bodies(), self.states());
        let still: Vec<_> =
            states.as_slice().iter().map(|s| JointState { velocity: Twist::ZERO, ..*s }).collect();
        let of_body = |(index, (body, state)): (usize, (&Body, &JointState))| {
            let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
            body.joint.motion_subspace(in_joint).into_iter().map(move |column| (index, column))
        };
        let dofs: Vec<(usize, Twist)> =
            bodies.iter().zip(&still).enumerate().flat_map(of_body).collect();
        let column = |(moved, unit): &(usize, Twist)| {
            let mut accelerations = vec![Twist::ZERO; bodies.len()];
            accelerations[*moved] = *unit;
            let wrenches = self.wrenches(&still, &accelerations, Vec3::ZERO, &[]);
            let along = |(body, along): &(usize, Twist)| f64::from(wrenches[*body].power_w(*along));
            dofs.iter().map(along).collect()
        };
        dofs.iter().map(column).collect()
    }

    /// Returns the accelerations of the joints in the form that inverse dynamics uses.
    pub fn accelerations(&self) -> Vec<Twist> {
        let bodies = self.tree.bodies().iter();
        bodies.zip(&self.motions).map(|(body, motion)| motion.joint_acceleration(body)).collect()
    }
}
