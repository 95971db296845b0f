use std::array::from_fn;

use glam::{Quat, Vec3};
use sinew_core::dynamics::{BodyMotion, inverse_dynamics};
use sinew_core::{
    Body, GRAVITY_M_S2, Inertia, JointKind, JointTargets, RotationalInertia, Transform, Tree,
    Wrench, math,
};

use crate::joint::Numbers;
use crate::widest::Instructions;
use crate::{Batch, LANES};

const CAPACITY: usize = 128;

/// A generator of numbers from -1 to 1, equal in every run.
pub(crate) struct Random(pub(crate) u32);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1_u32 << 23) as f32 - 1.0
    }

    pub(crate) fn index(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as usize % count
    }

    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    pub(crate) fn rotation(&mut self) -> Quat {
        math::exp(3.0 * self.vector())
    }

    pub(crate) fn axis(&mut self) -> Vec3 {
        let axes = [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::new(0.48, -0.64, 0.6)];
        axes[self.index(axes.len())]
    }
}

/// Creates a tree with joints of all kinds, a third of them with rotors.
fn tree(random: &mut Random, count: usize) -> Box<Tree<CAPACITY>> {
    let body = |index: usize| {
        let joint = match (random.index(8), index) {
            (0..=2, 0) => JointKind::Free,
            (0, _) => JointKind::Fixed,
            (1, _) => JointKind::Prismatic { axis: random.axis() },
            (2, _) => JointKind::Universal { first: Vec3::X, second: Vec3::Z },
            (3 | 4, _) => JointKind::Spherical,
            _ => JointKind::Revolute { axis: random.axis() },
        };
        let has_drive = !matches!(joint, JointKind::Fixed | JointKind::Free);
        let lengths = random.vector().abs() + 0.1;
        let [xx, yy, zz] = (lengths + Vec3::new(lengths.y, lengths.z, lengths.x)).to_array();
        let rotational_kg_m2 = RotationalInertia { xx, yy, zz, ..RotationalInertia::default() };
        Body {
            parent: index.checked_sub(1).map(|most| most - random.index(3).min(most)),
            joint,
            placement: Transform::new(random.rotation(), random.vector()),
            inertia: Inertia {
                mass_kg: 1.1 + random.next(),
                center_of_mass_m: 0.2 * random.vector(),
                rotational_kg_m2,
            },
            rotor_inertia: if has_drive && random.index(3) == 0 { 0.02 } else { 0.0 },
        }
    };
    let bodies: Vec<Body> = (0..count).map(body).collect();
    Box::new(Tree::from_bodies(&bodies).unwrap())
}

/// Creates valid positions (angles up to `most`), speeds and accelerations, which include zeros of both signs.
fn motion(random: &mut Random, bodies: &[Body], most: f32) -> [Vec<f32>; 3] {
    let [mut q, mut qd, mut qdd] = [const { Vec::new() }; 3];
    for body in bodies {
        let count = body.joint.coordinate_count();
        if count >= 4 {
            q.extend(random.rotation().to_array());
        }
        q.extend((0..count % 4).map(|_| most * random.next()));
        for (of_all, most) in [(&mut qd, 10.0), (&mut qdd, 300.0)] {
            let number = |_| match random.index(20) {
                0 => 0.0,
                1 => -0.0,
                _ => most * random.next(),
            };
            of_all.extend((0..body.joint.dof_count()).map(number));
        }
    }
    [q, qd, qdd]
}

/// Computes efforts with the core.
fn by_the_core(tree: &Tree<CAPACITY>, [q, qd, qdd]: &[Vec<f32>; 3]) -> Vec<f32> {
    let mut motion = Box::new(JointTargets::rest(tree));
    motion.set_coordinates(tree, q, qd, qdd).unwrap();
    let mut scratch = vec![BodyMotion::default(); tree.len()];
    let mut wrenches = vec![Wrench::ZERO; tree.len()];
    let (states, accelerations) = (motion.states(), motion.accelerations());
    let gravity = GRAVITY_M_S2;
    let bodies = tree.bodies();
    inverse_dynamics(bodies, states, accelerations, gravity, &[], &mut scratch, &mut wrenches);
    let mut efforts = vec![0.0; tree.dof_count()];
    tree.efforts(states, &wrenches, &mut efforts).unwrap();
    efforts
}

#[test]
fn all_instructions_have_the_bits_of_the_core() {
    let mut random = Random(1);
    let mut tried = 0;
    for round in 0_usize..150 {
        // Polynomials without and with a reduction of the angle, then a remainder of a division.
        let most = [1.57, 9.0, 1e5][round % 3];
        let count = if round % 10 == 0 { CAPACITY } else { 1 + random.index(40) };
        let tree = tree(&mut random, count);
        let motions: [[Vec<f32>; 3]; LANES] = from_fn(|_| motion(&mut random, tree.bodies(), most));
        let lanes: [Vec<Numbers>; 3] = from_fn(|kind| {
            let places = 0..motions[0][kind].len();
            places.map(|k| motions.each_ref().map(|motion| motion[kind][k])).collect()
        });
        let lanes = lanes.each_ref().map(Vec::as_slice);
        let expected = motions.each_ref().map(|motion| by_the_core(&tree, motion));
        let mut batch = Batch::new(tree.bodies());
        assert!(batch.takes(lanes));
        for instructions in Instructions::available() {
            let efforts = batch.efforts_with(instructions, lanes);
            for (lane, expected) in expected.iter().enumerate() {
                let found: Vec<u32> = efforts.iter().map(|of| of[lane].to_bits()).collect();
                let expected: Vec<u32> = expected.iter().map(|x| x.to_bits()).collect();
                assert_eq!(found, expected, "round {round}, lane {lane}, {instructions:?}");
                tried += found.len();
            }
        }
    }
    assert!(tried > 100_000, "{tried}");
}

#[test]
fn takes_what_the_core_takes() {
    let hinge = JointKind::Revolute { axis: Vec3::X };
    let body = |parent, joint| Body {
        parent,
        joint,
        placement: Transform::IDENTITY,
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    };
    let bodies = [body(None, JointKind::Spherical), body(Some(0), hinge)];
    let tree = Tree::<2>::from_bodies(&bodies).unwrap();
    let batch = Batch::new(&bodies);
    let still = [[0.0; LANES]; 4];
    let q = [[0.0; LANES], [0.0; LANES], [0.0; LANES], [1.0; LANES], [0.0; LANES]];
    assert!(batch.takes([&q, &still, &still]));
    assert!(!batch.takes([&q[1..], &still, &still]));
    for (place, number) in [(4, f32::NAN), (4, 1e6), (4, 1.1e6), (4, f32::INFINITY)]
        .into_iter()
        .chain([0.9, 0.998, 0.999, 0.9995, 1.0005, 1.001, 1.002].map(|w| (3, w)))
    {
        for lane in [0, 7, LANES - 1] {
            let mut q = q;
            q[place][lane] = number;
            let alone: Vec<f32> = q.iter().map(|of| of[lane]).collect();
            let taken =
                JointTargets::rest(&tree).set_coordinates(&tree, &alone, &[0.0; 4], &[0.0; 4]);
            assert_eq!(batch.takes([&q, &still, &still]), taken.is_ok(), "{place} {number}");
        }
    }
    for wrong in [f32::NAN, -2e6] {
        let mut qd = still;
        qd[2][5] = wrong;
        assert!(!batch.takes([&q, &qd, &still]) && !batch.takes([&q, &still, &qd]));
    }
}
