//! Image for QEMU's `mps2-an386` (Cortex-M4F): runs each kernel and each kind of tick, so that `cargo xtask budget`
//! can count their instructions. Prints the stack of the ticks, and the sizes of the types.
//!
//! Run it with `-icount shift=0`, see [`emulated`].

#![no_std]
#![no_main]

use core::hint::black_box;
use core::mem::size_of;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use sinew_bench::emulated::{
    self, FRAMES, GRAVITY_M_S2, LAG_FRAMES, controller, count, count_tick, enlarge, inverse,
};
use sinew_bench::rig::{DT_S, Rig};
use sinew_bench::{Frames, Root, figure, poses, states};
use sinew_core::control::{Limited, TorqueLimit};
use sinew_core::dynamics::{
    ArticulatedBody, CompositeBody, ResolvedAccelerationScratch, forward_dynamics, mass_matrix,
    resolved_acceleration,
};
use sinew_core::glam::Vec3;
use sinew_core::importance::{RestPose, cylinder_surface, descendants_length};
use sinew_core::observer::{Observer, ObserverSettings};
use sinew_core::pose_space::{LineWorkspace, PoseSpace};
use sinew_core::projection::{BodyWeight, BodyWeights, ManifoldProjection, ProjectionWorkspace};
use sinew_core::state_error::{
    self, AimStatus, Aims, Compensation, Method, References, StateError,
};
use sinew_core::tracker::{
    MethodName, RECOMMENDED_ROTATION_WEIGHT_M, Settings, StepError, Timing, Tracker,
};
use sinew_core::trajectory::{aligned_targets, backward_states};
use sinew_core::{
    BodyState, ForwardDifferences, JointState, JointStates, JointTargets, StateInputError,
    TorqueController, Transform, Tree, Twist, Workspace, Wrench, kinematics,
};

/// Number of delayed commands for which observers have room.
const ROOM: usize = 8;

/// Numbers in the mass matrix of 32 bodies: three dofs each, and six of the root.
const MATRIX_LEN: usize = (3 * 32 + 3) * (3 * 32 + 3);

#[entry]
fn main() -> ! {
    emulated::run(measure_all)
}

#[expect(clippy::large_stack_arrays, reason = "it is what a static begins with, not on the stack")]
fn measure_all() -> Result<(), &'static str> {
    let matrix = cortex_m::singleton!(MATRIX: [f32; MATRIX_LEN] = [0.0; MATRIX_LEN]);
    let matrix = matrix.ok_or("the matrix is taken")?;
    measure::<6>(matrix)?;
    measure::<18>(matrix)?;
    measure::<32>(matrix)?;
    importance::<18>()?;
    importance::<64>()?;
    distances::<18>()
}

/// Runs a tick of the core, in a separate function.
#[inline(never)]
fn core_tick<const N: usize>(
    rig: &mut Rig<N, N>,
    desired: &[Transform],
    measured: &[Transform],
) -> Result<(), StateInputError> {
    rig.tick(desired, measured).map(|torques| _ = black_box(torques))
}

/// Runs a tick as on boards, in a separate function.
#[inline(never)]
fn board_tick<const N: usize>(
    tracker: &mut Tracker<N, ROOM>,
    frames: &mut Frames<'_, N>,
    index: usize,
    measured: &[Transform],
) -> Result<(), StepError> {
    let index = i32::try_from(index).unwrap_or(i32::MAX);
    tracker.step(frames, index, measured).map(|tick| _ = black_box(tick.torques()))
}

fn measure<const N: usize>(matrix: &mut [f32]) -> Result<(), &'static str> {
    let fixed = figure::<N>(N, Root::Turning).map_err(|_| "the rig cannot be")?;
    let tree = figure::<N>(N, Root::Floating).map_err(|_| "the rig cannot be")?;
    inverse("rnea_fixed_root", &fixed);
    inverse("rnea_free_root", &tree);
    forward::<N>(matrix)?;
    let mut frames = [[Transform::IDENTITY; N]; FRAMES];
    for (index, frame) in frames.iter_mut().enumerate() {
        poses(tree.bodies(), DT_S * index as f32, frame);
    }
    errors(&tree);
    differences(&tree, &frames);
    others(&tree, &frames)?;
    ticks_of_core(&tree, &frames)?;
    ticks_of_boards(&tree, &frames)?;
    types::<N>();
    Ok(())
}

/// Measures the mass matrix and forward dynamics. They are used by simulators rather than rigs, but are part of the
/// core.
fn forward<const N: usize>(matrix: &mut [f32]) -> Result<(), &'static str> {
    let tree = figure::<N>(N, Root::Floating).map_err(|_| "the rig cannot be")?;
    let mut joints = [JointState::default(); N];
    let mut accelerations = [Twist::ZERO; N];
    states(tree.bodies(), &mut joints, &mut accelerations);
    let mut scratch = [CompositeBody::default(); N];
    count::<N>("crba", |_| {
        let (bodies, joints) = black_box((tree.bodies(), &joints[..]));
        black_box(mass_matrix(bodies, joints, &mut scratch, matrix));
    });
    let mut workspace = [ArticulatedBody::default(); N];
    let wrenches = [Wrench::new(Vec3::X, Vec3::ZERO); N];
    count::<N>("aba", |_| {
        let (bodies, joints) = black_box((tree.bodies(), &joints[..]));
        let (workspace, out) = (&mut workspace, &mut accelerations);
        forward_dynamics(bodies, joints, &wrenches, GRAVITY_M_S2, &[], workspace, out);
    });
    black_box(accelerations);
    Ok(())
}

/// Measures the importance of joints, which is computed once, not in a tick.
fn importance<const N: usize>() -> Result<(), &'static str> {
    let tree = figure::<N>(N, Root::Floating).map_err(|_| "the rig cannot be")?;
    let rest_pose = RestPose::of_tree(&tree).map_err(|_| "no rest pose")?;
    count::<N>("importance_lengths", |_| {
        black_box(descendants_length(black_box(&rest_pose), 0.1, 0.9).is_ok());
    });
    let radii_m = [0.05; N];
    count::<N>("importance_cylinders", |_| {
        black_box(cylinder_surface(black_box(&rest_pose), &radii_m, 0.001).is_ok());
    });
    Ok(())
}

/// Measures the distance of two poses in space: on the straight line between them in ten steps, and directly.
fn distances<const N: usize>() -> Result<(), &'static str> {
    let tree = figure::<N>(N, Root::Floating).map_err(|_| "the rig cannot be")?;
    let space = PoseSpace::new(&tree);
    let coordinates = |time_s: f32| {
        let mut at = [Transform::IDENTITY; N];
        poses(tree.bodies(), time_s, &mut at);
        space.coordinates(&at).map_err(|_| "the pose cannot be")
    };
    let (a, b) = (coordinates(0.3)?, coordinates(0.9)?);
    let mut workspace = LineWorkspace::new();
    count::<N>("pose_line_distance", |_| {
        black_box(space.line_distance(black_box(&a), &b, 10, &mut workspace));
    });
    count::<N>("pose_position_distance", |_| {
        let (a, b) = (space.body_poses(black_box(&a)), space.body_poses(&b));
        black_box(space.position_distance(&a, &b));
    });
    count::<N>("pose_angle_distance", |_| {
        black_box(space.angle_distance(black_box(&a), &b));
    });
    Ok(())
}

fn errors<const N: usize>(tree: &Tree<N>) {
    let (desired, measured) = (some_states(tree, 0.3), some_states(tree, 0.35));
    let (mut of_desired, mut of_measured) = ([BodyState::WORLD; N], [BodyState::WORLD; N]);
    kinematics::body_states(tree.bodies(), desired.as_slice(), &mut of_desired);
    count::<N>("forward_kinematics", |_| {
        let joints = black_box(measured.as_slice());
        kinematics::body_states(tree.bodies(), joints, &mut of_measured);
    });
    let mut errors = [StateError::ZERO; N];
    count::<N>("error_local", |_| {
        state_error::local(black_box(desired.as_slice()), measured.as_slice(), &mut errors);
    });
    count::<N>("error_world", |_| {
        state_error::world(black_box(&of_desired), &of_measured, &mut errors);
    });
    let references = References::egocentric(tree);
    count::<N>("error_accumulated", |_| {
        let references = black_box(references.as_slice());
        state_error::accumulated(references, &of_desired, &of_measured, &mut errors);
    });
    let mut status = [AimStatus::Leaf; N];
    for (name, aims) in [
        ("error_linear_compensation", Aims::heaviest_child(tree)),
        ("error_linear_compensation_all", Aims::all_children(tree)),
    ] {
        count::<N>(name, |_| {
            let (aims, settings) = black_box((aims.as_slice(), Compensation::default()));
            let (errors, status) = (&mut errors, &mut status);
            state_error::linear_compensation(
                aims,
                settings,
                &of_desired,
                &of_measured,
                errors,
                status,
            );
        });
    }
    black_box(errors);

    let weights = BodyWeights::rotations(tree);
    let mut scratch = [ResolvedAccelerationScratch::ZERO; N];
    let mut accelerations = [Twist::ZERO; N];
    count::<N>("resolved_acceleration", |_| {
        accelerations.fill(Twist::new(Vec3::X, Vec3::Y));
        let (bodies, joints) = black_box((tree.bodies(), measured.as_slice()));
        let (scratch, accelerations) = (&mut scratch, &mut accelerations);
        resolved_acceleration(bodies, joints, &of_measured, &weights, scratch, accelerations);
    });
    black_box(accelerations);
}

/// Returns the states of all joints at a time of the motion.
fn some_states<const N: usize>(tree: &Tree<N>, time_s: f32) -> JointStates<N> {
    let mut at = [[Transform::IDENTITY; N]; 2];
    let [before, now] = &mut at;
    poses(tree.bodies(), time_s - DT_S, before);
    poses(tree.bodies(), time_s, now);
    let mut joints = JointStates::rest(tree);
    // The poses were just made, so they are finite and unit.
    let _ = backward_states([&before[..], &now[..]], DT_S, &mut joints);
    joints
}

fn differences<const N: usize>(tree: &Tree<N>, frames: &[[Transform; N]; FRAMES]) {
    let [now, next, after, ..] = frames.each_ref().map(|frame| &frame[..]);
    let mut targets = JointTargets::rest(tree);
    let mut measured = JointStates::rest(tree);
    let mut differences = ForwardDifferences::new();
    black_box(differences.restart(tree, DT_S, now).is_ok());
    count::<N>("forward_differences", |run| {
        let frame = black_box(&frames[run + 1]);
        black_box(differences.advance(tree, frame, &mut targets).is_ok());
    });
    count::<N>("aligned_targets", |_| {
        black_box(aligned_targets(black_box([now, next, after]), DT_S, &mut targets).is_ok());
    });
    count::<N>("backward_differences", |run| {
        black_box(measured.update_poses(black_box(&frames[run]), DT_S).is_ok());
    });
}

fn others<const N: usize>(
    tree: &Tree<N>,
    frames: &[[Transform; N]; FRAMES],
) -> Result<(), &'static str> {
    let weights = [BodyWeight::new(1.0, RECOMMENDED_ROTATION_WEIGHT_M); N];
    let projection = ManifoldProjection::new(tree, &weights).map_err(|_| "no projection")?;
    let mut workspace = ProjectionWorkspace::new();
    let mut nearest = [Transform::IDENTITY; N];
    count::<N>("projection", |run| {
        let mut performer = frames[run];
        enlarge(&mut performer);
        let out = &mut nearest;
        black_box(projection.project(tree, &performer, &mut workspace, out).is_ok());
    });

    let settings = ObserverSettings::extended_state(1.0 / DT_S, DT_S).map_err(|_| "no observer")?;
    let mut observer = Observer::<N, ROOM>::new(settings, &JointStates::rest(tree), 0)
        .map_err(|_| "no observer")?;
    let mut targets = JointTargets::rest(tree);
    let (commands, torques) = ([Twist::ZERO; N], [Limited::default(); N]);
    count::<N>("observer", |run| {
        black_box(observer.observe(tree, &frames[run]).is_ok());
        observer.compensate(&mut targets);
        observer.record_commands(black_box(&commands), &torques);
    });

    let limit = TorqueLimit::new(5.0, 10.0).map_err(|_| "no limit")?;
    let limits = [limit; N];
    let wanted = core::array::from_fn::<_, N, _>(|body| {
        let moment = Vec3::new(1.0, 2.0, body as f32);
        Wrench::new(moment, Vec3::ZERO)
    });
    let mut allowed = [Limited::default(); N];
    count::<N>("limits", |_| {
        let (limits, wanted) = black_box((&limits, &wanted));
        for ((limit, wanted), allowed) in limits.iter().zip(wanted).zip(&mut allowed) {
            *allowed = limit.apply(*wanted);
        }
    });
    black_box(allowed);
    Ok(())
}

fn ticks_of_core<const N: usize>(
    tree: &Tree<N>,
    frames: &[[Transform; N]; FRAMES],
) -> Result<(), &'static str> {
    let settings = Compensation::default();
    let weights = BodyWeights::rotations(tree);
    for (name, method) in [
        ("tick_local", Method::Local),
        ("tick_world", Method::World),
        ("tick_accumulated", Method::Accumulated(References::egocentric(tree))),
        (
            "tick_linear_compensation",
            Method::LinearCompensation { aims: Aims::heaviest_child(tree), settings },
        ),
        ("tick_resolved_acceleration", Method::ResolvedAcceleration { weights }),
    ] {
        let frame = |index: usize| &frames[index][..];
        let first = [LAG_FRAMES, LAG_FRAMES + 1].map(frame);
        let (controller, workspace) = (controller(tree, method)?, Workspace::resolving());
        let mut rig = Rig::new(controller, workspace, first).map_err(|_| "a frame is refused")?;
        count_tick::<N, _>(name, |run| {
            core_tick(&mut rig, frame(run + LAG_FRAMES + 2), frame(run))
        })?;
    }
    Ok(())
}

fn ticks_of_boards<const N: usize>(
    tree: &Tree<N>,
    frames: &[[Transform; N]; FRAMES],
) -> Result<(), &'static str> {
    let mut enlarged = *frames;
    for frame in &mut enlarged {
        enlarge(frame);
    }
    let enlarged = &enlarged[LAG_FRAMES..];
    let timing = Timing { dt_s: DT_S, latency_ticks: 0 };
    for (name, method) in
        [("board_world", MethodName::World), ("board_recommended", MethodName::Recommended)]
    {
        let settings = Settings { method, ..Settings::default() };
        let mut tracker = Tracker::new(tree.clone(), &settings, timing)
            .map_err(|_| "there is no such tracker")?;
        let mut performance = Frames::new(enlarged);
        count_tick::<N, _>(name, |run| {
            board_tick(&mut tracker, &mut performance, run, &frames[run])
        })?;
    }
    // Consecutive ticks differ: one of every four is skipped.
    let mut tracker = Tracker::new(tree.clone(), &Settings::recommended(), timing)
        .map_err(|_| "there is no such tracker")?;
    let mut performance = Frames::new(enlarged);
    count_tick::<N, _>("board_recommended_after_jumps", |run| {
        if run % 3 == 0 {
            tracker.skip(1);
        }
        board_tick(&mut tracker, &mut performance, run + run / 3, &frames[run])
    })
}

fn types<const N: usize>() {
    for (name, bytes) in [
        ("Tree", size_of::<Tree<N>>()),
        ("TorqueController", size_of::<TorqueController<N>>()),
        ("ForwardDifferences", size_of::<ForwardDifferences<N>>()),
        ("JointTargets", size_of::<JointTargets<N>>()),
        ("JointStates", size_of::<JointStates<N>>()),
        ("Workspace", size_of::<Workspace<N>>()),
        ("Workspace_resolving", size_of::<Workspace<N, N>>()),
        ("ManifoldProjection", size_of::<ManifoldProjection<N>>()),
        ("ProjectionWorkspace", size_of::<ProjectionWorkspace<N>>()),
        ("Observer", size_of::<Observer<N, ROOM>>()),
        ("Tracker", size_of::<Tracker<N, ROOM>>()),
    ] {
        hprintln!("type={} bodies={} bytes={}", name, N, bytes);
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
