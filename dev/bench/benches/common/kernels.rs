//! The kernels of the core and its ticks, ready to run on rigs of any size.

use std::error::Error;
use std::hint::black_box;

use sinew_bench::rig::{DT_S, Rig};
use sinew_bench::{Frames, Root, figure, poses, states};
use sinew_core::control::Gains;
use sinew_core::dynamics::{
    ArticulatedBody, BodyMotion, CompositeBody, ResolvedAccelerationScratch, dof_count,
    forward_dynamics, inverse_dynamics, mass_matrix, resolved_acceleration,
};
use sinew_core::glam::Vec3;
use sinew_core::pose_space::{LineWorkspace, PoseSpace};
use sinew_core::projection::{BodyWeight, BodyWeights, ManifoldProjection, ProjectionWorkspace};
use sinew_core::state_error::{
    self, AimStatus, Aims, Compensation, Method, References, StateError,
};
use sinew_core::tracker::{RECOMMENDED_ROTATION_WEIGHT_M, Settings, Timing, Tracker};
use sinew_core::trajectory::{aligned_targets, backward_states};
use sinew_core::{
    BodyState, ForwardDifferences, JointState, JointStates, JointTargets, TorqueController,
    Transform, Tree, Twist, Workspace, Wrench, kinematics,
};

/// Numbers of bodies.
pub(crate) const SIZES: [usize; 6] = [1, 6, 18, 32, 64, 128];

/// A function that is run repeatedly.
pub(crate) struct Kernel {
    pub(crate) name: &'static str,
    pub(crate) run: Box<dyn FnMut()>,
}

/// Number of frames of the ticks' motion, which is repeated.
const FRAMES: usize = 64;
/// Number of frames by which the rig is late.
const LAG_FRAMES: usize = 4;
/// Scale of the show's performer relative to the rig.
const LARGER: f32 = 1.1;
const GRAVITY_M_S2: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// Returns all kernels for a rig of one of [`SIZES`].
pub(crate) fn of_size(bodies: usize) -> Result<Vec<Kernel>, Box<dyn Error>> {
    match bodies {
        1 => all::<1>(),
        6 => all::<6>(),
        18 => all::<18>(),
        32 => all::<32>(),
        64 => all::<64>(),
        128 => all::<128>(),
        _ => Err(format!("no rig of {bodies} bodies; there are {SIZES:?}").into()),
    }
}

/// Returns all kernels for a rig of `N` bodies with a free root and spherical joints. Capacity and size are equal, as
/// on a board.
fn all<const N: usize>() -> Result<Vec<Kernel>, Box<dyn Error>> {
    let tree = figure::<N>(N, Root::Floating)?;
    let frames: Vec<[Transform; N]> = (0..FRAMES)
        .map(|index| {
            let mut frame = [Transform::IDENTITY; N];
            poses(tree.bodies(), DT_S * index as f32, &mut frame);
            frame
        })
        .collect();
    let mut kernels = errors(&tree, &frames)?;
    kernels.extend(dynamics(&tree, &frames)?);
    kernels.extend(differences(&tree, &frames));
    kernels.push(projection(&tree, &frames)?);
    kernels.extend(distances(&tree, &frames)?);
    kernels.extend(ticks(&tree, &frames)?);
    Ok(kernels)
}

fn kernel(name: &'static str, run: impl FnMut() + 'static) -> Kernel {
    Kernel { name, run: Box::new(run) }
}

/// Returns the states of the joints at a frame.
fn at<const N: usize>(
    tree: &Tree<N>,
    frames: &[[Transform; N]],
    index: usize,
) -> Result<JointStates<N>, Box<dyn Error>> {
    let mut joints = JointStates::rest(tree);
    let before = index.checked_sub(1).ok_or("the first frame has none before it")?;
    backward_states([&frames[before], &frames[index]], DT_S, &mut joints)?;
    Ok(joints)
}

fn errors<const N: usize>(
    tree: &Tree<N>,
    frames: &[[Transform; N]],
) -> Result<Vec<Kernel>, Box<dyn Error>> {
    let (desired, measured) = (at(tree, frames, 1 + LAG_FRAMES)?, at(tree, frames, 1)?);
    let (mut of_desired, mut of_measured) = ([BodyState::WORLD; N], [BodyState::WORLD; N]);
    kinematics::body_states(tree.bodies(), desired.as_slice(), &mut of_desired);
    kinematics::body_states(tree.bodies(), measured.as_slice(), &mut of_measured);
    let references = References::egocentric(tree);
    let (one, every) = (Aims::heaviest_child(tree), Aims::all_children(tree));

    let mut kernels = Vec::new();
    let (bodies, joints, mut world) = (tree.clone(), measured.clone(), of_measured);
    kernels.push(kernel("forward_kinematics", move || {
        kinematics::body_states(black_box(bodies.bodies()), joints.as_slice(), &mut world);
        black_box(&world);
    }));
    let mut out = [StateError::ZERO; N];
    kernels.push(kernel("error_local", move || {
        state_error::local(black_box(desired.as_slice()), measured.as_slice(), &mut out);
        black_box(&out);
    }));
    kernels.push(kernel("error_world", move || {
        state_error::world(black_box(&of_desired), &of_measured, &mut out);
        black_box(&out);
    }));
    kernels.push(kernel("error_accumulated", move || {
        let references = black_box(references.as_slice());
        state_error::accumulated(references, &of_desired, &of_measured, &mut out);
        black_box(&out);
    }));
    for (name, aims) in
        [("error_linear_compensation", one), ("error_linear_compensation_all", every)]
    {
        let mut status = [AimStatus::Leaf; N];
        kernels.push(kernel(name, move || {
            let (aims, settings) = black_box((aims.as_slice(), Compensation::default()));
            let (out, status) = (&mut out, &mut status);
            state_error::linear_compensation(
                aims,
                settings,
                &of_desired,
                &of_measured,
                out,
                status,
            );
            black_box(&out);
        }));
    }
    Ok(kernels)
}

fn dynamics<const N: usize>(
    tree: &Tree<N>,
    frames: &[[Transform; N]],
) -> Result<Vec<Kernel>, Box<dyn Error>> {
    let (mut joints, mut accelerations) = ([JointState::default(); N], [Twist::ZERO; N]);
    states(tree.bodies(), &mut joints, &mut accelerations);
    let (mut scratch, mut wrenches) = ([BodyMotion::default(); N], [Wrench::ZERO; N]);
    let rig = tree.clone();
    let rnea = kernel("rnea", move || {
        let (bodies, joints, accelerations) = black_box((rig.bodies(), &joints, &accelerations));
        let (scratch, wrenches) = (&mut scratch, &mut wrenches);
        inverse_dynamics(bodies, joints, accelerations, GRAVITY_M_S2, &[], scratch, wrenches);
        black_box(&wrenches);
    });

    let dofs = dof_count(tree.bodies());
    let mut matrix = vec![0.0; dofs * dofs];
    let (rig, mut scratch) = (tree.clone(), [CompositeBody::default(); N]);
    let crba = kernel("mass_matrix", move || {
        let (bodies, joints) = black_box((rig.bodies(), &joints));
        black_box(mass_matrix(bodies, joints, &mut scratch, &mut matrix));
        black_box(&matrix);
    });

    let (rig, mut scratch) = (tree.clone(), [ArticulatedBody::default(); N]);
    let (passive, mut out) = ([Wrench::ZERO; N], [Twist::ZERO; N]);
    let aba = kernel("forward_dynamics", move || {
        let (bodies, joints, wrenches) = black_box((rig.bodies(), &joints, &passive));
        let (scratch, out) = (&mut scratch, &mut out);
        forward_dynamics(bodies, joints, wrenches, GRAVITY_M_S2, &[], scratch, out);
        black_box(&out);
    });

    let joints = at(tree, frames, 1)?;
    let mut world = [BodyState::WORLD; N];
    kinematics::body_states(tree.bodies(), joints.as_slice(), &mut world);
    let weights = BodyWeights::rotations(tree);
    let (mut scratch, mut out) = ([ResolvedAccelerationScratch::ZERO; N], [Twist::ZERO; N]);
    let rig = tree.clone();
    let resolved = kernel("resolved_acceleration", move || {
        out.fill(black_box(Twist::new(Vec3::X, Vec3::Y)));
        let (bodies, joints) = black_box((rig.bodies(), joints.as_slice()));
        resolved_acceleration(bodies, joints, &world, &weights, &mut scratch, &mut out);
        black_box(&out);
    });
    Ok(vec![rnea, crba, aba, resolved])
}

fn differences<const N: usize>(tree: &Tree<N>, frames: &[[Transform; N]]) -> Vec<Kernel> {
    let window = || [frames[0], frames[1], frames[2]];
    let (mut targets, mut measured) = (JointTargets::rest(tree), JointStates::rest(tree));
    let (rig, aligned) = (tree.clone(), window());
    let mut aligned_out = targets.clone();
    let frames = frames.to_vec();
    let performance = frames.clone();
    let (mut index, mut of_measured) = ((1..FRAMES).cycle(), (1..FRAMES).cycle());
    let mut differences = ForwardDifferences::new();
    done(differences.restart(&rig, DT_S, &frames[0]));
    vec![
        kernel("forward_differences", move || {
            let now = index.next().unwrap_or_default();
            done(differences.advance(&rig, black_box(&frames[now]), &mut targets));
        }),
        kernel("aligned_targets", move || {
            let window = black_box(&aligned).each_ref().map(|frame| &frame[..]);
            done(aligned_targets(window, DT_S, &mut aligned_out));
        }),
        kernel("backward_differences", move || {
            let now = of_measured.next().unwrap_or_default();
            done(measured.update_poses(black_box(&performance[now]), DT_S));
        }),
    ]
}

/// Returns the projection: one sweep for each frame of a larger performer.
fn projection<const N: usize>(
    tree: &Tree<N>,
    frames: &[[Transform; N]],
) -> Result<Kernel, Box<dyn Error>> {
    let projection =
        ManifoldProjection::new(tree, &[BodyWeight::new(1.0, RECOMMENDED_ROTATION_WEIGHT_M); N])?;
    let (mut workspace, mut nearest) = (ProjectionWorkspace::new(), [Transform::IDENTITY; N]);
    let (rig, performance) = (tree.clone(), enlarged(frames));
    let mut index = (0..FRAMES).cycle();
    Ok(kernel("projection", move || {
        let frame = &performance[index.next().unwrap_or_default()];
        done(projection.project(&rig, black_box(frame), &mut workspace, &mut nearest));
        black_box(&nearest);
    }))
}

/// Returns the distances of two poses: on the straight line between them in ten steps, directly, and by angles.
fn distances<const N: usize>(
    tree: &Tree<N>,
    frames: &[[Transform; N]],
) -> Result<Vec<Kernel>, Box<dyn Error>> {
    // A kernel owns its data, but a space borrows its rig, so the rig is leaked.
    let space = PoseSpace::<'static, N>::new(Box::leak(Box::new(tree.clone())));
    let (a, b) = (space.coordinates(&frames[0])?, space.coordinates(&frames[FRAMES - 1])?);
    let places = (space.body_poses(&a), space.body_poses(&b));
    let mut workspace = LineWorkspace::new();
    let (direct, by_angles, ends) = (space.clone(), space.clone(), (a.clone(), b.clone()));
    Ok(vec![
        kernel("line_distance", move || {
            black_box(space.line_distance(black_box(&a), &b, 10, &mut workspace));
        }),
        kernel("position_distance", move || {
            black_box(direct.position_distance(black_box(&places.0), &places.1));
        }),
        kernel("angle_distance", move || {
            black_box(by_angles.angle_distance(black_box(&ends.0), &ends.1));
        }),
    ])
}

/// Returns whole ticks, from poses to torques: of the core with each method, and of boards with the setting for real
/// rigs.
fn ticks<const N: usize>(
    tree: &Tree<N>,
    frames: &[[Transform; N]],
) -> Result<Vec<Kernel>, Box<dyn Error>> {
    let gains = Gains::critically_damped(200.0)?;
    let aims = Aims::heaviest_child(tree);
    let settings = Compensation::default();
    let weights = BodyWeights::rotations(tree);
    let mut kernels = Vec::new();
    for (name, method) in [
        ("tick_world", Method::World),
        ("tick_linear_compensation", Method::LinearCompensation { aims, settings }),
        ("tick_resolved_acceleration", Method::ResolvedAcceleration { weights }),
    ] {
        let frames = frames.to_vec();
        let first = [&frames[LAG_FRAMES][..], &frames[LAG_FRAMES + 1][..]];
        let controller = TorqueController::new(tree.clone(), gains, method)?;
        let mut rig = Rig::new(controller, Workspace::resolving(), first)?;
        let mut index = (0..FRAMES - LAG_FRAMES - 2).cycle();
        kernels.push(kernel(name, move || {
            let now = index.next().unwrap_or_default();
            let frame = |index: usize| &frames[index][..];
            done(rig.tick(frame(now + LAG_FRAMES + 2), frame(now)));
        }));
    }

    // An application borrows its frames from flash forever.
    let performance = enlarged(&frames[LAG_FRAMES..]).leak();
    let timing = Timing { dt_s: DT_S, latency_ticks: 0 };
    let mut tracker = Tracker::<N, 8>::new(tree.clone(), &Settings::recommended(), timing)?;
    let (mut performance, frames) = (Frames::new(performance), frames.to_vec());
    let mut index = (0..FRAMES - LAG_FRAMES).cycle();
    kernels.push(kernel("tick_recommended", move || {
        let now = index.next().unwrap_or_default();
        let tick = i32::try_from(now).unwrap_or_default();
        done(tracker.step(&mut performance, tick, black_box(&frames[now])));
    }));
    Ok(kernels)
}

fn enlarged<const N: usize>(frames: &[[Transform; N]]) -> Vec<[Transform; N]> {
    let mut frames = frames.to_vec();
    for pose in frames.iter_mut().flat_map(|frame| frame.iter_mut().skip(1)) {
        pose.translation_m *= LARGER;
    }
    frames
}

/// Checks that nothing was refused: a refused call takes almost no time, and the bench would print too short a
/// time.
fn done<T, E: std::fmt::Debug>(result: Result<T, E>) {
    black_box(result.expect("the bench's own motion is not refused"));
}
