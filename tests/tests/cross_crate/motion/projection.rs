//! The manifold projection against dense least squares in f64.

use proptest::collection::vec;
use proptest::prelude::*;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::projection::{
    BodyWeight, JointRange, ManifoldProjection, ProjectionError, ProjectionWorkspace,
};
use sinew_core::{Body, Inertia, JointKind, Transform, Tree, math};
use sinew_test_support::nearest_pose::{self, Problem, distance};
use sinew_test_support::property;
use sinew_test_support::reference::Pose;
use sinew_test_support::rig::{CAPACITY, Coordinates, Joints, Rig, rigs};
use sinew_test_support::subtree_form::SubtreeForm;

/// Bodies of the rigs whose dense problems are solved often.
const MOST: usize = 24;

/// Most sweeps of a call.
const MANY: u8 = u8::MAX;

/// After which a rig counts as one that moves for ever.
const MOST_CALLS: usize = 12;

/// A rig, where its bodies should be, and how the projection is set.
#[derive(Debug, Clone)]
struct Case {
    rig: Rig,
    desired: Vec<Transform>,
    weights: Vec<BodyWeight>,
    ranges: Vec<JointRange>,
    root_held: bool,
}

impl Case {
    fn projection(&self, sweeps: u8) -> ManifoldProjection<CAPACITY> {
        let tree = &self.rig.tree;
        let projection = ManifoldProjection::new(tree, &self.weights)
            .and_then(|projection| projection.with_ranges(tree, &self.ranges))
            .expect("weights and ranges that fit")
            .with_sweeps(sweeps);
        if self.root_held { projection.with_root_held() } else { projection }
    }

    /// The first call, with at least the twenty sweeps that it makes.
    fn projected(&self, sweeps: u8) -> Vec<Transform> {
        let mut workspace = Box::new(ProjectionWorkspace::new());
        self.next(sweeps, &mut workspace)
    }

    /// After so many sweeps that nothing moves any more, or for ever: some rigs come nearer by only 1 % with each.
    fn settled(&self) -> Vec<Transform> {
        let mut workspace = Box::new(ProjectionWorkspace::new());
        let mut last = self.next(MANY, &mut workspace);
        for _ in 0..MOST_CALLS {
            let next = self.next(MANY, &mut workspace);
            let before: Vec<_> = last.iter().map(nearest_pose::pose).collect();
            let moved = largest_distance(&next, &before);
            last = next;
            if moved < 0.1 * SMALL {
                break;
            }
        }
        last
    }

    fn next(&self, sweeps: u8, workspace: &mut ProjectionWorkspace<CAPACITY>) -> Vec<Transform> {
        let mut out = self.desired.clone();
        self.projection(sweeps)
            .project(&self.rig.tree, &self.desired, workspace, &mut out)
            .expect("a good pose");
        out
    }

    fn problem(&self) -> Problem {
        let Self { rig, desired, weights, ranges, root_held } = self;
        Problem::new(&rig.tree, weights, ranges, *root_held, desired)
    }
}

fn number() -> impl Strategy<Value = f32> {
    -1.0f32..1.0
}

/// The poses of a rig's joints.
fn joint_poses(rig: &Rig) -> Vec<Transform> {
    rig.states().as_slice().iter().map(|state| state.pose).collect()
}

/// How a desired pose is off one that the rig can take: its dimensions by up to `stretch` of them, then its joints by
/// up to `twist` rad in any direction, as no joint of this kind may be able to.
#[derive(Debug, Clone, Copy)]
struct Unlike {
    stretch: f32,
    twist: f32,
}

/// What ranges the joints of a case have.
#[derive(Debug, Clone, Copy)]
enum Ranged {
    No,
    /// With ends next to where the joints are, so far off at the most.
    Near(f32),
    /// Anywhere.
    Wild,
}

fn cases(
    most: usize,
    joints: Joints,
    unlike: Unlike,
    ranged: Ranged,
) -> impl Strategy<Value = Case> {
    (rigs(most, joints), vec(vec(number(), 16), most), any::<bool>()).prop_map(
        move |(rig, numbers, root_held)| {
            let root_held = root_held && joints == Joints::Mixed;
            let mut desired = joint_poses(&rig);
            let (mut weights, mut ranges) = (Vec::new(), Vec::new());
            for (((pose, body), motion), numbers) in
                desired.iter_mut().zip(rig.tree.bodies()).zip(&rig.motions).zip(&numbers)
            {
                pose.translation_m *= 1.0 + unlike.stretch * numbers[0];
                let twist = Vec3::new(numbers[1], numbers[2], numbers[3]) * unlike.twist;
                pose.rotation = math::unit(pose.rotation * math::exp(twist));
                // Some positions do not count at all, save where without them nothing would be best.
                let slides = matches!(body.joint, JointKind::Free | JointKind::Prismatic { .. });
                let least = if slides { 0.2 } else { 0.0 };
                let position = (2.0 * numbers[4]).max(least);
                weights.push(BodyWeight::new(position, 0.1 + 0.9 * numbers[5].abs()));
                ranges.push(range(body.joint, motion, &numbers[6..], ranged));
            }
            Case { rig, desired, weights, ranges, root_held }
        },
    )
}

/// A range of a kind of joint from six numbers; every fourth joint has none. `near`: its ends are up to so far (rad
/// or m) from where the joint is, on any side.
fn range(joint: JointKind, at: &Coordinates, numbers: &[f32], ranged: Ranged) -> JointRange {
    let ends = |a: f32, b: f32, middle: f32| match ranged {
        Ranged::Near(near) => [middle + near * a.min(b), middle + near * a.max(b)],
        _ => [2.0 * a.min(b), 2.0 * a.max(b)],
    };
    if matches!(ranged, Ranged::No) || numbers[4].abs() < 0.25 {
        return JointRange::Any;
    }
    let [first, second] = at.along;
    match joint {
        JointKind::Revolute { .. } | JointKind::Prismatic { .. } => {
            JointRange::Axis(ends(numbers[0], numbers[1], first))
        }
        JointKind::Universal { .. } => JointRange::Axes([
            ends(numbers[0], numbers[1], first),
            ends(numbers[2], numbers[3], second),
        ]),
        JointKind::Spherical => JointRange::Turn(match ranged {
            Ranged::Near(near) => {
                let angle = math::length(math::log(at.rotation));
                (angle + near * numbers[0]).clamp(0.1, 3.0)
            }
            _ => 0.1 + 2.0 * numbers[0].abs(),
        }),
        JointKind::Fixed | JointKind::Free => JointRange::Any,
    }
}

fn largest_distance(poses: &[Transform], dense: &[Pose]) -> f64 {
    poses
        .iter()
        .zip(dense)
        .fold(0.0, |most, (pose, dense)| most.max(distance(&nearest_pose::pose(pose), dense)))
}

/// What f32 knows of a pose that some twenty others were multiplied into: four hundred roundings of 6e-8, which go to
/// and fro, are 1e-6. Ten times as much for rigs that hold less well than others where their best is.
const SMALL: f64 = 1e-5;

/// What the cost may be above the least by roundings: in proportion to them where joints are pressed against the ends
/// of their ranges, else to their squares.
const SMALL_SHARE: f64 = 1e-5;

proptest! {
    #![proptest_config(property(150))]

    #[test]
    fn one_sweep_is_one_dense_step(
        case in prop_oneof![
            cases(MOST, Joints::Figure, Unlike { stretch: 0.2, twist: 0.0 }, Ranged::No),
            cases(MOST, Joints::Mixed, Unlike { stretch: 0.1, twist: 0.0 }, Ranged::No),
        ],
    ) {
        // From where the joints are as desired no turn is left over, and the derivative of its logarithm is one.
        let problem = case.problem();
        let (dense, largest) = problem.step(&problem.nearest(&case.desired));
        // A step of three such components is cut short.
        prop_assume!(largest < 0.28);

        // The first call makes more sweeps than one: here of a pose that it has nothing to do for.
        let mut workspace = ProjectionWorkspace::new();
        let alike = Case { desired: joint_poses(&case.rig), ..case.clone() };
        alike.next(1, &mut workspace);
        let got = case.next(1, &mut workspace);
        let apart = largest_distance(&got, &problem.joint_poses(&dense));
        prop_assert!(apart < SMALL, "{apart:e} rad or m apart");
    }

    #[test]
    fn many_sweeps_find_the_dense_optimum(
        case in prop_oneof![
            cases(MOST, Joints::Figure, Unlike { stretch: 0.3, twist: 0.3 }, Ranged::No),
            cases(MOST, Joints::Mixed, Unlike { stretch: 0.1, twist: 0.1 }, Ranged::No),
            cases(MOST, Joints::Mixed, Unlike { stretch: 0.1, twist: 0.1 }, Ranged::Near(0.3)),
        ],
    ) {
        let problem = case.problem();
        let got = problem.nearest(&case.settled());
        let best = problem.solve(&problem.nearest(&case.desired));
        let (cost, least) = (problem.cost(&got), problem.cost(&best));
        prop_assert!(cost <= least * (1.0 + SMALL_SHARE) + 1e-10, "{cost} m², the least is {least} m²");
        let off = problem.off_the_best(&got);
        prop_assert!(off < SMALL, "{off:e} rad or m from where Karush, Kuhn and Tucker have it");
        // There may be more than one best; next to one of them the dense solution is this one.
        let again = problem.joint_poses(&problem.solve(&got));
        let apart = largest_distance(&case.settled(), &again);
        prop_assert!(apart < 2.0 * SMALL, "{apart:e} rad or m apart");
    }

    #[test]
    fn with_ranges_far_off_it_settles_next_to_an_optimum(
        case in cases(MOST, Joints::Mixed, Unlike { stretch: 0.1, twist: 0.1 }, Ranged::Near(0.8)),
    ) {
        // Joints change between the ends of their ranges for ever: undamped sweeps were at up to four times the least
        // cost. The largest that damping left in 1200 cases was 19 % above it.
        let problem = case.problem();
        let got = problem.nearest(&case.settled());
        let (cost, least) = (problem.cost(&got), problem.cost(&problem.solve(&got)));
        prop_assert!(cost <= least * 1.2 + 1e-10, "{cost} m², the least near it is {least} m²");
    }

    #[test]
    fn no_sweep_leaves_the_ranges(
        case in cases(MOST, Joints::Mixed, Unlike { stretch: 0.5, twist: 2.0 }, Ranged::Wild),
        growth in 0.0f32..30.0,
    ) {
        let mut workspace = ProjectionWorkspace::new();
        let turns: Vec<Quat> = case.desired.iter().rev().map(|pose| pose.rotation).collect();
        let mut frame = case;
        for _ in 0..6 {
            let got = frame.next(1, &mut workspace);
            // Only what f32 rounds: of an angle, and of a way out to where it is.
            let way = got.iter().fold(1.0, |most, pose| pose.translation_m.length().max(most));
            let outside = frame.problem().excess(&got);
            prop_assert!(outside < 1e-6 * f64::from(way), "{outside:e} rad or m outside, of {way} m");
            // From frame to frame as far off as no performer goes.
            for (pose, turn) in frame.desired.iter_mut().zip(&turns) {
                pose.translation_m = (pose.translation_m * (1.0 + growth)).clamp_length_max(1e4);
                pose.rotation = math::unit(pose.rotation * *turn);
            }
        }
    }

    #[test]
    fn equal_dimensions_give_the_input_bit_for_bit(
        (rig, numbers) in (rigs(CAPACITY, Joints::Figure), vec(vec(number(), 3), CAPACITY)),
    ) {
        let weights = vec![BodyWeight::new(1.0, 0.3); rig.tree.len()];
        let projection = ManifoldProjection::new(&rig.tree, &weights).expect("good weights");
        let mut workspace = ProjectionWorkspace::new();
        let mut desired = joint_poses(&rig);
        let mut out = desired.clone();
        for _ in 0..20 {
            for (pose, turn) in desired.iter_mut().zip(&numbers) {
                let turn = Vec3::new(turn[0], turn[1], turn[2]);
                pose.rotation = math::unit(pose.rotation * math::exp(turn));
            }
            desired[0].translation_m += Vec3::X * 0.1;
            projection.project(&rig.tree, &desired, &mut workspace, &mut out).expect("a good pose");
            prop_assert_eq!(&out, &desired);
        }
    }

    #[test]
    fn a_held_root_stays_where_it_is_desired(
        case in cases(CAPACITY, Joints::Mixed, Unlike { stretch: 0.2, twist: 0.2 }, Ranged::Near(0.3)),
    ) {
        let case = Case { root_held: true, ..case };
        prop_assert_eq!(case.projected(1)[0], case.desired[0]);
    }

    #[test]
    fn huge_poses_give_finite_ones_and_are_forgotten(
        case in cases(MOST, Joints::Mixed, Unlike { stretch: 0.1, twist: 0.1 }, Ranged::Near(0.3)),
        size in prop_oneof![Just(1e6f32), Just(1e18), Just(1e30), Just(f32::MAX)],
        body in 0..MOST,
    ) {
        let mut workspace = ProjectionWorkspace::new();
        let mut huge = case.clone();
        let body = body % huge.desired.len();
        huge.desired[body].translation_m = Vec3::new(size, -size, 0.5 * size);
        for frame in [&case, &huge, &huge] {
            let got = frame.next(1, &mut workspace);
            prop_assert!(got.iter().all(|pose| pose.is_finite()), "{got:?}");
        }
        // The joints come back from where the huge pose has pulled them: to an optimum, not always to the same.
        let mut got = case.next(MANY, &mut workspace);
        for _ in 0..2 {
            got = case.next(MANY, &mut workspace);
        }
        let problem = case.problem();
        let got = problem.nearest(&got);
        let (cost, least) = (problem.cost(&got), problem.cost(&problem.solve(&got)));
        prop_assert!(cost <= least * 1.01 + 1e-10, "{cost} m², the least near it is {least} m²");
    }
}

fn body(parent: Option<usize>, joint: JointKind, offset_m: Vec3) -> Body {
    let placement = Transform::from_translation(offset_m);
    Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 }
}

/// As many bodies as fit, each on the one before, and where a tenth longer ones are that wind along.
fn longest_chain(joint: impl Fn(usize) -> JointKind) -> Case {
    let mut tree = Tree::new();
    let mut desired = Vec::new();
    for index in 0..CAPACITY {
        let offset_m = Vec3::new(0.02, 0.05, -0.01);
        let body = body(index.checked_sub(1), joint(index), offset_m);
        tree.push(body).expect("as many as fit");
        let turn = Vec3::new(0.1, 0.2, -0.1) * (0.3 * index as f32).sin();
        desired.push(Transform::new(math::exp(turn), offset_m * 1.1));
    }
    let weights = vec![BodyWeight::new(1.0, 0.5); CAPACITY];
    let ranges = vec![JointRange::Any; CAPACITY];
    let rig = Rig { tree, motions: Vec::new() };
    Case { rig, desired, weights, ranges, root_held: false }
}

#[test]
fn the_longest_chains_reach_the_dense_optimum() {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let hinges = |index: usize| match index {
        0 => JointKind::Free,
        _ => JointKind::Revolute { axis: axes[index % 3] },
    };
    let ball = |index: usize| if index == 0 { JointKind::Free } else { JointKind::Spherical };
    for case in [Box::new(longest_chain(hinges)), Box::new(longest_chain(ball))] {
        // A turn far in moves all of the seven metres farther out, which f32 knows to a few micrometres: the pose is
        // only good to half a milliradian, and the cost to the square of that.
        let problem = case.problem();
        let got = problem.nearest(&case.settled());
        let (cost, least) = (problem.cost(&got), problem.cost(&problem.solve(&got)));
        assert!(cost <= least * (1.0 + SMALL_SHARE), "{cost} m², the least is {least} m²");
    }
}

#[test]
fn what_is_refused_changes_nothing() {
    let case = longest_chain(|_| JointKind::Spherical);
    let projection = case.projection(1);
    let (tree, good) = (&case.rig.tree, &case.desired);
    let mut workspace = ProjectionWorkspace::new();
    let mut out = good.clone();
    projection.project(tree, good, &mut workspace, &mut out).expect("a good pose");
    let before = (workspace.clone(), out.clone());

    let mut refuse = |desired: &[Transform], bodies: usize, error: ProjectionError| {
        let got = projection.project(tree, desired, &mut workspace, &mut out[..bodies]);
        assert_eq!(got, Err(error));
        assert_eq!((&workspace, &out), (&before.0, &before.1));
    };
    let count = |found| ProjectionError::Count { expected: CAPACITY, found };
    refuse(&good[1..], CAPACITY, count(CAPACITY - 1));
    refuse(good, 5, count(5));
    for bad in [
        Transform { translation_m: Vec3::new(0.0, f32::NAN, 0.0), ..good[7] },
        Transform { translation_m: Vec3::X * f32::INFINITY, ..good[7] },
        Transform { rotation: Quat::from_xyzw(0.0, f32::NAN, 0.0, 1.0), ..good[7] },
        Transform { rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 1.1), ..good[7] },
    ] {
        let mut desired = good.clone();
        desired[7] = bad;
        refuse(&desired, CAPACITY, ProjectionError::InvalidPose { joint: 7 });
    }
}

#[test]
fn ranges_that_do_not_fit_are_refused() {
    let kinds = [
        (JointKind::Free, JointRange::Turn(1.0)),
        (JointKind::Fixed, JointRange::Axis([0.0, 1.0])),
        (JointKind::Spherical, JointRange::Turn(0.0)),
        (JointKind::Spherical, JointRange::Turn(f32::NAN)),
        (JointKind::Spherical, JointRange::Axis([0.0, 1.0])),
        (JointKind::Revolute { axis: Vec3::X }, JointRange::Axis([0.5, 0.4])),
        (JointKind::Revolute { axis: Vec3::X }, JointRange::Axis([0.0, 3.2])),
        (JointKind::Revolute { axis: Vec3::X }, JointRange::Axis([f32::NAN, 1.0])),
        (JointKind::Prismatic { axis: Vec3::X }, JointRange::Axis([0.0, f32::INFINITY])),
        (
            JointKind::Universal { first: Vec3::X, second: Vec3::Y },
            JointRange::Axes([[0.0, 1.0], [1.0, 0.0]]),
        ),
    ];
    for (joint, range) in kinds {
        let tree = Tree::<1>::from_bodies(&[body(None, joint, Vec3::ZERO)]).expect("a tree");
        let projection =
            ManifoldProjection::new(&tree, &[BodyWeight::new(1.0, 1.0)]).expect("a good weight");
        let error = ProjectionError::Range { joint: 0 };
        assert_eq!(projection.with_ranges(&tree, &[range]), Err(error), "{joint:?} {range:?}");
    }
}

/// A figure of 18 bodies, by parent and offset in m.
const FIGURE: [(usize, [f32; 3]); 18] = [
    (0, [0.0, 1.0, 0.0]),
    (0, [0.0, 0.15, 0.0]),
    (1, [0.0, 0.25, 0.0]),
    (2, [0.0, 0.3, 0.0]),
    (2, [-0.05, 0.2, 0.0]),
    (4, [-0.14, 0.0, 0.0]),
    (5, [-0.29, 0.0, 0.0]),
    (6, [-0.26, 0.0, 0.0]),
    (2, [0.05, 0.2, 0.0]),
    (8, [0.14, 0.0, 0.0]),
    (9, [0.29, 0.0, 0.0]),
    (10, [0.26, 0.0, 0.0]),
    (0, [-0.09, -0.05, 0.0]),
    (12, [0.0, -0.42, 0.0]),
    (13, [0.0, -0.43, 0.0]),
    (0, [0.09, -0.05, 0.0]),
    (15, [0.0, -0.42, 0.0]),
    (16, [0.0, -0.43, 0.0]),
];

fn figure() -> Tree<18> {
    let bodies = FIGURE.iter().enumerate().map(|(index, (parent, offset_m))| {
        let joint = if index == 0 { JointKind::Free } else { JointKind::Spherical };
        body((index > 0).then_some(*parent), joint, Vec3::from_array(*offset_m))
    });
    Tree::from_bodies(&bodies.collect::<Vec<_>>()).expect("a figure")
}

/// A tenth larger, its joints in smooth motion of a few rad/s.
fn performance(tree: &Tree<18>, time_s: f32) -> Vec<Transform> {
    let joint = |(index, body): (usize, &Body)| {
        let swing = |k: u8| {
            let phase = 2.4 * index as f32 + f32::from(k);
            0.6 * ((3.0 + f32::from(k)) * time_s + phase).sin()
        };
        let turn = Vec3::new(swing(0), swing(1), swing(2));
        Transform::new(math::exp(turn), body.placement.translation_m * 1.1)
    };
    tree.bodies().iter().enumerate().map(joint).collect()
}

/// Mean over the frames of what each route's cost is above the least, as a share of it.
fn mean_excess(mut project: impl FnMut(&Tree<18>, &[Transform], &mut [Transform])) -> f64 {
    const RECOMMENDED_ROTATION_WEIGHT_M: f32 = 0.5;
    let tree = figure();
    let (weights, ranges) =
        ([BodyWeight::new(1.0, RECOMMENDED_ROTATION_WEIGHT_M); 18], [JointRange::Any; 18]);
    let (mut sum, mut count) = (0.0, 0.0);
    for frame in 0..120 {
        let desired = performance(&tree, frame as f32 * 0.01);
        let mut out = desired.clone();
        project(&tree, &desired, &mut out);
        // After the start.
        if frame >= 20 {
            let problem = Problem::new(&tree, &weights, &ranges, false, &desired);
            let got = problem.nearest(&out);
            sum += problem.cost(&got) / problem.cost(&problem.solve(&got)) - 1.0;
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn articulated_sweeps_are_nearer_to_the_best_than_the_subtree_form() {
    const RECOMMENDED_ROTATION_WEIGHT_M: f32 = 0.5;
    let articulated = |sweeps: u8| {
        let projection = ManifoldProjection::new(
            &figure(),
            &[BodyWeight::new(1.0, RECOMMENDED_ROTATION_WEIGHT_M); 18],
        )
        .expect("good weights")
        .with_sweeps(sweeps);
        let mut workspace = ProjectionWorkspace::new();
        mean_excess(|tree, desired, out| {
            projection.project(tree, desired, &mut workspace, out).expect("a good pose");
        })
    };
    let subtree = |sweeps: usize| {
        let mut route = SubtreeForm::new(&figure(), RECOMMENDED_ROTATION_WEIGHT_M);
        mean_excess(|tree, desired, out| route.project(tree, desired, sweeps, out))
    };
    // Two sweeps of a subtree take as many instructions as an articulated one, counted on x86-64: 36 800 a frame and
    // 37 100. Above the least by 3.6e-5 and 2.4e-6 of it; twice as many sweeps, by 1.4e-6 and 4e-8.
    for sweeps in 1..=2 {
        let (articulated, subtree) = (articulated(sweeps), subtree(2 * usize::from(sweeps)));
        assert!(
            articulated < 0.2 * subtree,
            "{sweeps}: {articulated} of the least above it, {subtree}"
        );
    }
    // Both look for the same.
    let converged = subtree(60);
    assert!(converged < SMALL_SHARE, "{converged} of the least above it");
}
