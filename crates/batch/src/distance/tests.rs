use sinew_core::pose_space::{PoseCoordinates, PoseSpace};
use sinew_core::{Body, Inertia, JointKind, Transform, Tree, math};

use super::{Distances, PoseSequence};
use crate::LANES;
use crate::tests::Random;
use crate::widest::Instructions;

const CAPACITY: usize = 24;

/// Creates poses from a walk with steps of all sizes: equal poses, half turns, turns of nearly 180 degrees.
fn poses(
    random: &mut Random,
    space: &PoseSpace<'_, CAPACITY>,
    count: usize,
) -> Vec<PoseCoordinates<CAPACITY>> {
    let bodies = space.tree().bodies();
    let mut now: Vec<Transform> = bodies.iter().map(|body| body.placement).collect();
    let mut walk = |random: &mut Random| {
        for (body, pose) in bodies.iter().zip(&mut now) {
            if body.joint == JointKind::Spherical {
                let size = [0.0, 0.01, 0.3, 3.0, 3.2][random.index(5)];
                let turn = math::exp(size * random.axis());
                pose.rotation = math::unit(pose.rotation * turn);
            }
        }
        space.coordinates(&now).unwrap()
    };
    (0..count).map(|_| walk(random)).collect()
}

#[test]
fn distances_have_the_bits_of_the_core() {
    let mut random = Random(11);
    let mut tried = 0;
    for round in 0..20 {
        let body = |index: usize| Body {
            parent: index.checked_sub(1).map(|most| most - random.index(2).min(most)),
            joint: if index.is_multiple_of(7) { JointKind::Fixed } else { JointKind::Spherical },
            placement: Transform::new(
                if index == 0 { glam::Quat::IDENTITY } else { random.rotation() },
                random.vector(),
            ),
            inertia: Inertia::default(),
            rotor_inertia: 0.0,
        };
        let bodies: Vec<Body> = (0..=round).map(body).collect();
        let tree = Tree::<CAPACITY>::from_bodies(&bodies).unwrap();
        let weights: Vec<f32> = bodies.iter().map(|_| 1.0 + random.next()).collect();
        let space = PoseSpace::new(&tree).with_weights(&weights).unwrap();
        let [a, b] = [5, LANES + 9].map(|count| poses(&mut random, &space, count));
        let sequences = |poses: &[PoseCoordinates<CAPACITY>]| {
            let places: Vec<_> = poses.iter().map(|at| space.body_poses(at)).collect();
            let rotations: Vec<_> = poses.iter().map(|at| space.joint_rotations(at)).collect();
            let sequences = [
                PoseSequence::of_angles(&tree, poses.iter()).unwrap(),
                PoseSequence::of_rotations(rotations.iter()),
                PoseSequence::of_positions(places.iter()),
            ];
            (places, rotations, sequences)
        };
        let (a_places, a_rotations, a_sequences) = sequences(&a);
        let (b_places, b_rotations, b_sequences) = sequences(&b);
        for pose in 0..a.len() {
            for first in 0..b.len() {
                let expected = |to: usize| {
                    [
                        space.angle_distance(&a[pose], &b[to]),
                        space.rotation_distance(&a_rotations[pose], &b_rotations[to]),
                        space.position_distance(&a_places[pose], &b_places[to]),
                    ]
                };
                for (quantity, (one, many)) in a_sequences.iter().zip(&b_sequences).enumerate() {
                    for instructions in Instructions::available() {
                        let work = Distances::new(many, first, (one, pose), &weights);
                        for (to, found) in (first..b.len()).zip(instructions.run(work)) {
                            let expected = expected(to)[quantity];
                            let (expected_bits, bits) = (expected.to_bits(), found.to_bits());
                            let place = format!("quantity {quantity}, {pose} to {to}");
                            assert_eq!(
                                expected_bits, bits,
                                "{place}, {instructions:?}: {expected} {found}"
                            );
                            tried += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(tried > 50_000, "{tried}");
}
