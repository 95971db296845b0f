//! One run: one clip, tracked by one figure with one method.

use glam::DVec3;
use sinew_core::control::Gains;
use sinew_core::state_error::Method;
use sinew_core::trajectory::{backward_states, forward_targets_of_bodies};
use sinew_core::{Controller, JointStates, JointTargets, Transform, Workspace};

use super::error::RunError;
use super::reference::{moving_poses, one_step_before, world_poses};
use crate::figure::{BODIES, BODY_COUNT, BodyModel};
use crate::mocap::FigureMotion;
use crate::plant::{Drive, Mechanism, PlantBody, PlantSettings, Pose, Root};

/// Stiffness of eq. (11) in 1/s², critically damped: the paper's.
const KP: f32 = 200.0;

/// A body farther from its goal than this is lost, in metres: a few times the figure's height.
const LOST_M: f64 = 5.0;

/// One step of a run, after it was made: the figure at frame `frame`, in the world.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    /// Frame of the clip that both sides are at.
    pub frame: usize,
    /// Where the bodies should be: the clip, in its own dimensions.
    pub desired: &'a [Pose; BODY_COUNT],
    /// Where the plant has them.
    pub measured: &'a [Pose],
}

/// Number of steps of a run: from frame 0, where the figure starts without error, to the last frame but
/// one. A step needs the desired motion of three frames (forward differences of second order), so it starts
/// from the last but two at the latest.
pub(super) fn step_count(motion: &FigureMotion, seconds: Option<f64>) -> usize {
    frame_count(motion, seconds).saturating_sub(2)
}

/// Frames of a run, at least those of one step if the clip has them.
fn frame_count(motion: &FigureMotion, seconds: Option<f64>) -> usize {
    let frames = motion.rotation.len();
    match seconds {
        Some(seconds) => {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative, and saturates"
            )]
            let within = (seconds / motion.dt_s).round() as usize;
            frames.min(within.max(3))
        }
        None => frames,
    }
}

/// Tracks a clip and shows every step to `observe`. Returns the number of steps.
///
/// From frame n the controller has the clip's frames n to n+2, and the plant's poses of now and one step
/// before; its torques take the plant to frame n+1, and there it is compared with the clip. The figure
/// starts on the clip's pose and with its velocity, with its own dimensions.
///
/// Desired velocities are forward differences of the bodies' world poses, measured ones backward differences
/// of what the joints' sensors tell, as firmware has them.
///
/// # Errors
/// [`RunError`]: above all, if the figure diverges.
pub fn track(
    motion: &FigureMotion,
    model: &BodyModel,
    method: Method<BODY_COUNT>,
    seconds: Option<f64>,
    mut observe: impl FnMut(Step<'_>),
) -> Result<usize, RunError> {
    let steps = step_count(motion, seconds);
    if steps == 0 {
        return Err(RunError::TooShort { frames: frame_count(motion, seconds) });
    }
    let tree = model.tree()?;
    let mut targets = JointTargets::rest(&tree);
    let mut states = JointStates::rest(&tree);
    let controller = Controller::new(tree, Gains::critically_damped(KP)?, method)?;
    let mut workspace = Workspace::new();
    #[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
    let dt_s = motion.dt_s as f32;

    let start = moving_poses(motion, &model.offset_m);
    let mut before = measured_joints(&one_step_before(&start, motion.dt_s), &model.offset_m);
    let mechanism = Mechanism { root: Root::Driven, bodies: plant_bodies(model).to_vec() };
    let mut plant = PlantSettings::default().build(&mechanism, &start, motion.dt_s)?;
    let mut drive = Drive { root_force_n: DVec3::ZERO, torque_nm: vec![DVec3::ZERO; BODY_COUNT] };

    let mut window = [0, 1, 2].map(|frame| motion.joint_poses(frame));
    for frame in 0..steps {
        let state_error = |source| RunError::State { frame, source };
        let frames = window.each_ref().map(<[_; BODY_COUNT]>::as_slice);
        forward_targets_of_bodies(controller.tree(), frames, dt_s, &mut targets)
            .map_err(state_error)?;
        let now = measured_joints(plant.poses(), &model.offset_m);
        backward_states([&before, &now], dt_s, &mut states).map_err(state_error)?;

        let torques = controller.tick(&targets, &states, &[], &mut workspace);
        // No limits are set, so that nothing but an overflow is cut.
        if torques.iter().any(|torque| torque.reason.is_some()) {
            return Err(RunError::TorqueNotFinite { frame });
        }
        for ((torque, pose), drive_nm) in
            torques.iter().zip(plant.poses()).zip(&mut drive.torque_nm)
        {
            *drive_nm = pose.rotation * torque.value.moment_nm.as_dvec3();
        }
        drive.root_force_n = plant.poses()[0].rotation * torques[0].value.force_n.as_dvec3();
        plant.step(&drive);

        let desired = world_poses(motion, &motion.offset_m, frame + 1);
        check(frame + 1, &desired, plant.poses())?;
        observe(Step { frame: frame + 1, desired: &desired, measured: plant.poses() });
        before = now;
        let [_, next, after] = window;
        window = [next, after, motion.joint_poses(frame + 3)];
    }
    Ok(steps)
}

/// What the sensors of the figure's joints tell: the relative rotations, and the root's pose in the world.
///
/// The joints' positions are the model's. The plant's bodies drift apart at the joints by millimetres; a
/// sensor in a joint does not see that, and a rig's bearings do not do it.
fn measured_joints(poses: &[Pose], offset_m: &[DVec3; BODY_COUNT]) -> [Transform; BODY_COUNT] {
    std::array::from_fn(|body| match BODIES[body].parent {
        None => Transform::new(poses[body].rotation.as_quat(), poses[body].position_m.as_vec3()),
        Some(parent) => {
            let relative = poses[parent].rotation.conjugate() * poses[body].rotation;
            Transform::new(relative.as_quat(), offset_m[body].as_vec3())
        }
    })
}

/// Refuses a figure that is lost: nothing of it may get into a mean.
fn check(frame: usize, desired: &[Pose; BODY_COUNT], measured: &[Pose]) -> Result<(), RunError> {
    let mut worst = (0, 0.0);
    for (body, (desired, measured)) in desired.iter().zip(measured).enumerate() {
        let linear_m = (desired.position_m - measured.position_m).length();
        if !(linear_m.is_finite() && measured.rotation.is_finite()) {
            worst = (body, f64::INFINITY);
            break;
        }
        if linear_m > worst.1 {
            worst = (body, linear_m);
        }
    }
    let (body, linear_m) = worst;
    if linear_m > LOST_M {
        return Err(RunError::Diverged { frame, body: BODIES[body].name, linear_m });
    }
    Ok(())
}

fn plant_bodies(model: &BodyModel) -> [PlantBody; BODY_COUNT] {
    std::array::from_fn(|body| PlantBody {
        parent: BODIES[body].parent,
        offset_m: model.offset_m[body],
        mass: model.bodies[body],
    })
}
