use glam::{DQuat, DVec3};
use sinew_core::JointKind;
use sinew_core::glam::Vec3;
use sinew_core::projection::JointRange;

use super::curve::Curve;
use super::model::{Model, Order};
use super::*;

/// Returns a joint 0.3 m along x from its parent.
fn joint(parent: Option<usize>, kind: JointKind) -> RigJoint {
    RigJoint {
        parent,
        kind,
        rotation: DQuat::IDENTITY,
        offset_m: DVec3::X * 0.3,
        range: JointRange::Any,
        weight: 1.0,
    }
}

const HINGE: JointKind = JointKind::Revolute { axis: Vec3::Z };
const CROSS: JointKind = JointKind::Universal { first: Vec3::Y, second: Vec3::Z };

/// Returns a bending trunk with two arms: one with a ball, a hinge and a slide, one with a universal joint and a
/// hinge.
fn rig_of_all_kinds() -> Vec<RigJoint> {
    let skewed = |joint: RigJoint| RigJoint {
        rotation: DQuat::from_scaled_axis(DVec3::new(0.3, -0.6, 0.2)),
        offset_m: DVec3::new(0.1, 0.25, -0.05),
        ..joint
    };
    vec![
        joint(None, JointKind::Free),
        joint(Some(0), CROSS),
        skewed(joint(Some(1), JointKind::Spherical)),
        joint(Some(2), HINGE),
        joint(Some(3), JointKind::Prismatic { axis: Vec3::X }),
        joint(Some(4), JointKind::Fixed),
        skewed(joint(Some(1), CROSS)),
        joint(Some(6), HINGE),
        RigJoint { weight: 2.5, ..joint(Some(7), JointKind::Fixed) },
    ]
}

fn pose(sign: f64) -> Vec<JointPosition> {
    let turn = |x: f64, y: f64, z: f64| DQuat::from_scaled_axis(DVec3::new(x, y, z) * sign);
    vec![
        JointPosition::Free(DQuat::IDENTITY, DVec3::ZERO),
        JointPosition::Along([0.3 * sign, -0.2 * sign]),
        JointPosition::Turn(turn(0.4, 0.7, -0.3)),
        JointPosition::Along([0.5 + 0.6 * sign, 0.0]),
        JointPosition::Along([0.05 * sign, 0.0]),
        JointPosition::Fixed,
        JointPosition::Along([0.6 * sign, 0.9 * sign]),
        JointPosition::Along([-0.8 * sign, 0.0]),
        JointPosition::Fixed,
    ]
}

#[test]
fn derivatives_are_those_of_positions() {
    let rig = Rig::new(&rig_of_all_kinds()).unwrap();
    let at = pose(0.8);
    let (placed, step) = (rig.place(&at), 1e-4);
    let moved = |changes: &[(usize, f64)]| {
        let mut along = vec![0.0; rig.columns];
        for (column, change) in changes {
            along[*column] += change;
        }
        rig.place(&rig.stepped(&at, &placed, &along))
    };
    let jacobian = rig.jacobian(&placed);
    let force = placed.f.map(|x| libm::sin(17.0 * x) + 0.3);
    let pull = rig.pull(&placed, &force);
    let bend = rig.bend(&placed, &pull);
    let along = jacobian.tr_mul(&force);
    // The sums have few products of numbers below 1.
    assert!((&pull.along - along).amax() < 1e-13);
    let squares = jacobian.column_iter().map(|column| column.norm_squared());
    let squares = nalgebra::DVector::from_iterator(rig.columns, squares);
    assert!((rig.squares(&placed) - squares).amax() < 1e-13);
    for column in 0..rig.columns {
        let (after, before) = (moved(&[(column, step)]), moved(&[(column, -step)]));
        let difference = (&after.f - &before.f) / (2.0 * step);
        assert!((difference - jacobian.column(column)).amax() < 1e-8, "column {column}");
        for other in 0..rig.columns {
            let at = |a: f64, b: f64| moved(&[(column, a * step), (other, b * step)]).f.dot(&force);
            let second = (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0))
                / (4.0 * step * step);
            // Central differences of second order: third derivatives times h², and rounding divided by h².
            assert!(
                (second - bend[(column, other)]).abs() < 1e-6,
                "{column} {other}: {second} {}",
                bend[(column, other)]
            );
        }
    }
}

/// Checks that both orders of elimination solve one system of equations: with joints at ends of their ranges, with
/// and without second derivatives.
#[test]
fn steps_are_the_same_in_every_order() {
    let mut joints = rig_of_all_kinds();
    joints[2].range = JointRange::Turn(0.7);
    joints[3].range = JointRange::Axis([0.0, 1.0]);
    let rig = Rig::new(&joints).unwrap();
    let (from, mut to) = (pose(1.0), pose(-1.0));
    to[2] = JointPosition::Turn(DQuat::from_scaled_axis(DVec3::new(0.8, -0.2, 0.5)));
    let steps = 6;
    let poses = (0..=steps).map(|k| rig.between(&from, &to, f64::from(k) / f64::from(steps)));
    let mut curve = Curve::new(&rig, poses.collect()).within(&rig, 1e-2);
    curve.push(1e-3);
    for has_second_derivatives in [true, false] {
        let step = |order| {
            let model = Model::in_order(&rig, &curve, has_second_derivatives, 1e-4, order);
            model.direction(&rig, &curve, 1e-3).expect("positive definite").step
        };
        let by_pose = step(Order::Poses);
        for (one, other) in by_pose.iter().zip(step(Order::Joints)) {
            // The damping adds at least 1e-6 of the largest element, and the sum of all 50 eigenvalues is at most
            // 50 times that element: the condition is at most 5e7. Times the rounding of f64, that is 6e-9.
            let difference = (one - &other).amax() / one.amax();
            assert!(difference < 1e-8, "{has_second_derivatives}: {difference:e}");
        }
    }
}

/// Tests a chain of the maximum number of joints, all ball joints. Elimination pose by pose would cost the cube of
/// its 765 columns per iteration.
#[test]
fn a_long_chain_gets_shorter() {
    let joints: Vec<_> = (0..256)
        .map(|index| RigJoint {
            offset_m: DVec3::new(0.01, 0.0, 0.0),
            ..joint(usize::checked_sub(index, 1), JointKind::Spherical)
        })
        .collect();
    let rig = Rig::new(&joints).unwrap();
    let pose = |phase: f64| -> Vec<_> {
        let turn = |index: usize| {
            let angle = 0.1 * libm::sin(0.11 * index as f64 + phase);
            DQuat::from_scaled_axis(DVec3::new(0.3 * angle, angle, -0.5 * angle))
        };
        (0..256).map(|index| JointPosition::Turn(turn(index))).collect()
    };
    let options = Options { iterations: 20, ..Options::default() };
    let found = solve(&rig, &pose(0.0), &pose(1.0), &options).unwrap();
    assert!(found.length_m < found.line_length_m);
    assert!(found.course.windows(2).all(|pair| pair[1].energy_m2 <= pair[0].energy_m2));
    assert!(found.gradient < found.course[0].gradient, "{:?}", found.course);
}

#[test]
fn no_other_curve_has_less_energy() {
    let rig = Rig::new(&rig_of_all_kinds()).unwrap();
    let geodesic = solve(&rig, &pose(1.0), &pose(-1.0), &Options::default()).unwrap();
    assert!(geodesic.converged && geodesic.course.len() < 60, "{:?}", geodesic.course.last());
    assert!(geodesic.length_m < geodesic.line_length_m);
    // The steps are of one size: the energy is at least the squared length divided by their number.
    let steps = (geodesic.poses.len() - 1) as f64;
    assert!((geodesic.energy_m2 * steps / geodesic.length_m.powi(2) - 1.0).abs() < 1e-3);
    let energy = |poses: &[Vec<JointPosition>]| -> f64 {
        let placed: Vec<_> = poses.iter().map(|pose| rig.place(pose)).collect();
        placed.windows(2).map(|pair| (&pair[1].f - &pair[0].f).norm_squared()).sum()
    };
    assert!((energy(&geodesic.poses) - geodesic.energy_m2).abs() < 1e-15);
    for k in 1..geodesic.poses.len() - 1 {
        for column in 0..rig.columns {
            for change in [-1e-3, 1e-3] {
                let mut along = vec![0.0; rig.columns];
                along[column] = change;
                let mut poses = geodesic.poses.clone();
                poses[k] = rig.stepped(&poses[k], &rig.place(&poses[k]), &along);
                assert!(energy(&poses) > geodesic.energy_m2 - 1e-12, "{k} {column}");
            }
        }
    }
}

#[test]
fn both_methods_find_the_same_near_by() {
    // A small motion, since large motions have several minima.
    let rig = Rig::new(&rig_of_all_kinds()).unwrap();
    let of = |second_derivatives| {
        let options = Options { second_derivatives, ..Options::default() };
        solve(&rig, &pose(0.5), &pose(-0.3), &options).unwrap()
    };
    let (newton, gauss_newton) = (of(true), of(false));
    assert!(newton.converged && gauss_newton.converged);
    println!("{} {}", newton.course.len(), gauss_newton.course.len());
    assert!((gauss_newton.energy_m2 / newton.energy_m2 - 1.0).abs() < 1e-9);
    assert!(newton.course.len() < gauss_newton.course.len());
}

#[test]
fn joints_stay_within_their_ranges() {
    // An arm that moves from one side to the other goes inwards by bending its elbow, as far as its range permits.
    let free = vec![
        joint(None, JointKind::Fixed),
        joint(Some(0), JointKind::Spherical),
        joint(Some(1), HINGE),
        joint(Some(2), JointKind::Fixed),
    ];
    let pose = |angle: f64| {
        vec![
            JointPosition::Fixed,
            JointPosition::Turn(DQuat::from_rotation_z(angle)),
            // With a straight elbow, both bending directions would be equally good.
            JointPosition::Along([0.05, 0.0]),
            JointPosition::Fixed,
        ]
    };
    let widest = |geodesic: &Geodesic| {
        let elbow = |pose: &Vec<JointPosition>| match pose[2] {
            JointPosition::Along([angle, _]) => angle.abs(),
            _ => unreachable!("a hinge"),
        };
        geodesic.poses.iter().map(elbow).fold(0.0, f64::max)
    };
    let of = |joints: &[RigJoint]| {
        let rig = Rig::new(joints).unwrap();
        solve(&rig, &pose(-0.9), &pose(0.9), &Options::default()).unwrap()
    };
    let any = of(&free);
    let mut stiff = free.clone();
    stiff[2].range = JointRange::Axis([-0.25, 0.25]);
    let ranged = of(&stiff);
    stiff[2].range = JointRange::Axis([0.0, 0.0]);
    let locked = of(&stiff);
    assert!(any.converged && ranged.converged && locked.converged);
    assert!(widest(&any) > 0.3, "{}", widest(&any));
    // The product of force and gap is at most 1e-9 of the energy, and the force is above a hundredth of the
    // energy.
    assert!((-1e-7..=0.0).contains(&(widest(&ranged) - 0.25)), "{}", widest(&ranged));
    assert!(widest(&locked) <= 0.0);
    assert!(any.energy_m2 < ranged.energy_m2 && ranged.energy_m2 < locked.energy_m2);
}

/// Checks that a hinge without a range takes the shorter way round; a hinge with a range may not.
#[test]
fn hinges_go_the_shorter_way_round() {
    let mut joints = vec![
        joint(None, JointKind::Fixed),
        joint(Some(0), HINGE),
        joint(Some(1), JointKind::Fixed),
    ];
    let at = |angle: f64| {
        vec![JointPosition::Fixed, JointPosition::Along([angle, 0.0]), JointPosition::Fixed]
    };
    let length = |joints: &[RigJoint]| {
        let rig = Rig::new(joints).unwrap();
        let options = Options { steps: 200, ..Options::default() };
        solve(&rig, &at(3.0), &at(-3.0), &options).unwrap().length_m
    };
    let short = 0.3 * (std::f64::consts::TAU - 6.0);
    assert!((length(&joints) - short).abs() < 1e-4 * short, "{}", length(&joints));
    joints[1].range = JointRange::Axis([-3.1, 3.1]);
    assert!((length(&joints) - 0.3 * 6.0).abs() < 1e-3, "{}", length(&joints));
}

#[test]
fn a_locked_axis_holds_whichever_way_it_is_pulled() {
    let mut joints = rig_of_all_kinds();
    joints[3].range = JointRange::Axis([0.4, 0.4]);
    joints[6].range = JointRange::Axes([[0.2, 0.2], [-2.0, 2.0]]);
    let rig = Rig::new(&joints).unwrap();
    let found = solve(&rig, &pose(1.0), &pose(-1.0), &Options::default()).unwrap();
    assert!(found.converged, "{}", found.course.len());
    for pose in &found.poses {
        let [JointPosition::Along([hinge, _]), JointPosition::Along([first, _])] =
            [pose[3], pose[6]]
        else {
            unreachable!("a hinge and a cross")
        };
        assert!((hinge - 0.4).abs() < 1e-7 && (first - 0.2).abs() < 1e-7);
    }
}

#[test]
fn poses_that_are_nearly_the_same_are_no_trouble() {
    let rig = Rig::new(&rig_of_all_kinds()).unwrap();
    for share in [1e-2, 1e-3, 1e-4, 1e-6, 0.0] {
        let from = pose(1.0);
        let to = rig.between(&from, &pose(-1.0), share);
        let found = solve(&rig, &from, &to, &Options::default()).unwrap();
        assert!(found.converged && found.course.len() < 20, "{share}: {:?}", found.course);
    }
}

/// Tests the range of a ball joint. It ends at a sphere, whose curvature increases as the sphere gets smaller.
#[test]
fn the_way_goes_along_the_end_of_a_turns_range() {
    for most_rad in [0.7, 0.1, 0.01, 1e-4] {
        let mut joints = rig_of_all_kinds();
        joints[2].range = JointRange::Turn(most_rad);
        let rig = Rig::new(&joints).unwrap();
        let (from, mut to) = (pose(1.0), pose(-1.0));
        to[2] = JointPosition::Turn(DQuat::from_scaled_axis(DVec3::new(0.8, -0.2, 0.5)));
        let found = solve(&rig, &from, &to, &Options::default()).unwrap();
        assert!(found.converged && found.course.len() < 80, "{}", found.course.len());
        let turns = found.poses.iter().map(|pose| {
            let JointPosition::Turn(q) = pose[2] else { unreachable!("a ball") };
            joint::rotation_vector(q).length() - f64::from(most_rad)
        });
        let beyond_rad: Vec<f64> = turns.collect();
        assert!(beyond_rad.iter().all(|beyond| *beyond < 1e-15), "{beyond_rad:?}");
        // The product of force and gap is at most 1e-9 of the energy, and the ball is pulled with a hundredth of
        // the energy.
        assert!(beyond_rad[1..10].iter().any(|beyond| *beyond > -1e-7), "{beyond_rad:?}");
    }
}

/// Tests a figure of ball joints, like those of recorded skeletons: hips and collars hardly turn, and all other
/// joints arrive near the ends of their ranges. An active-set method needs more than 200 iterations for this.
#[test]
fn tight_ranges_converge() {
    let ball = |parent, x: f64, y: f64| RigJoint {
        offset_m: DVec3::new(x, y, 0.02),
        ..joint(Some(parent), JointKind::Spherical)
    };
    let mut joints = vec![joint(None, JointKind::Fixed)];
    for side in [-1.0, 1.0] {
        let hip = joints.len();
        joints.push(ball(0, 0.0, 0.0));
        joints.push(ball(hip, 0.1 * side, -0.1));
        joints.extend([0.4, 0.4, 0.15].map(|bone| ball(0, 0.0, -bone)));
        let collar = joints.len();
        joints.push(ball(0, 0.0, 0.3));
        joints.push(ball(collar, 0.2 * side, 0.1));
        joints.extend([0.3, 0.25, 0.1].map(|bone| ball(0, bone * side, 0.0)));
        for inner in [hip + 2, hip + 3, hip + 4, collar + 2, collar + 3, collar + 4] {
            joints[inner].parent = Some(inner - 1);
        }
    }
    let pose = |phase: f64| -> Vec<DVec3> {
        let turn = |index: usize| {
            let at = 1.7 * index as f64 + phase;
            DVec3::new(libm::sin(at), 0.7 * libm::cos(2.0 * at), 0.5 * libm::sin(3.0 * at))
        };
        (0..joints.len()).map(turn).collect()
    };
    let of = |vectors: &[DVec3], moves: &dyn Fn(usize) -> f64| -> Vec<JointPosition> {
        let turns = vectors.iter().enumerate().skip(1);
        let turns = turns.map(|(index, v)| DQuat::from_scaled_axis(*v * moves(index)));
        std::iter::once(JointPosition::Fixed).chain(turns.map(JointPosition::Turn)).collect()
    };
    #[expect(clippy::cast_possible_truncation, reason = "a range is in f32")]
    let within = |most: f64| JointRange::Turn(most as f32);
    for (phase, slack) in [(1.5, 1.05), (1.5, 1.3), (1.9, 1.3)] {
        let (a, b) = (pose(0.0), pose(phase));
        let mut ranged = joints.clone();
        let is_stiff = |index: usize| index % 5 == 1;
        for (index, joint) in ranged.iter_mut().enumerate().skip(1) {
            let most = slack * a[index].length().max(b[index].length());
            joint.range = within(if is_stiff(index) { 1e-3 } else { most });
        }
        let moves = |index: usize| if is_stiff(index) { 0.0 } else { 1.0 };
        let rig = Rig::new(&ranged).unwrap();
        let found = solve(&rig, &of(&a, &moves), &of(&b, &moves), &Options::default()).unwrap();
        assert!(found.converged && found.course.len() < 100, "{phase}: {}", found.course.len());
    }
}

/// Tests long chains. A step rotates their bones in the world; with steps in the joints' own coordinates they need
/// more than 200 iterations.
#[test]
fn chains_of_many_balls_converge() {
    for (count, size) in [(30, 0.05), (40, 0.05), (60, 0.1), (60, 0.2)] {
        let joints: Vec<_> = (0..count)
            .map(|index| RigJoint {
                offset_m: DVec3::new(0.0, 0.05, 0.0),
                ..joint(usize::checked_sub(index, 1), JointKind::Spherical)
            })
            .collect();
        let rig = Rig::new(&joints).unwrap();
        let pose = |phase: f64| -> Vec<_> {
            let turn = |index: usize| {
                let angle = size * libm::sin(0.3 * index as f64 + phase);
                DQuat::from_scaled_axis(DVec3::new(angle, 0.3 * angle, -angle))
            };
            (0..count).map(|index| JointPosition::Turn(turn(index))).collect()
        };
        let found = solve(&rig, &pose(0.0), &pose(2.0), &Options::default()).unwrap();
        assert!(found.converged, "{count} {size}: {}", found.gradient);
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let good = rig_of_all_kinds();
    for (index, bad) in [
        (3, RigJoint { weight: f64::NAN, ..good[3] }),
        (3, RigJoint { weight: -1.0, ..good[3] }),
        (3, RigJoint { parent: None, ..good[3] }),
        (3, RigJoint { parent: Some(3), ..good[3] }),
        (2, RigJoint { offset_m: DVec3::NAN, ..good[2] }),
        (2, RigJoint { rotation: DQuat::from_xyzw(0.0, 0.0, 0.0, 2.0), ..good[2] }),
        (3, RigJoint { range: JointRange::Turn(1.0), ..good[3] }),
        (3, RigJoint { range: JointRange::Axis([1.0, -1.0]), ..good[3] }),
        (3, RigJoint { kind: JointKind::Revolute { axis: Vec3::ZERO }, ..good[3] }),
    ] {
        let mut joints = good.clone();
        joints[index] = bad;
        assert!(matches!(Rig::new(&joints), Err(RigError::Joint { joint, .. }) if joint == index));
    }
    let rig = Rig::new(&good).unwrap();
    let (mut missing, mut nan) = (pose(1.0), pose(1.0));
    missing.pop();
    nan[3] = JointPosition::Along([f64::NAN, 0.0]);
    let of = |from: &[JointPosition]| solve(&rig, from, &pose(1.0), &Options::default());
    assert_eq!(of(&missing), Err(RigError::Count { what: "pose", expected: 9, found: 8 }));
    assert!(matches!(of(&nan), Err(RigError::Joint { joint: 3, .. })));
}
