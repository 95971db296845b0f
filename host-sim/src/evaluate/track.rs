//! One run: one clip, tracked by one figure with one setup.

use std::array;

use glam::DVec3;
use sinew_core::Transform;
use sinew_core::control::LimitReason;
use sinew_core::tracker::{Frame, FrameSource};

use super::disturbance::{DelayLine, Sensors, Wanted};
use super::error::RunError;
use super::levers::Levers;
use super::reference::{Performance, one_step_before};
use super::setup::{FigureTracker, Setup};
use crate::figure::{BODIES, BODY_COUNT, BodyModel, FigureMotion};
use crate::plant::{Drive, Mechanism, PlantBody, Pose};

/// One step of a run, after it was made: the figure at frame `frame`, in the world.
#[derive(Debug)]
pub struct Step<'a> {
    /// Frame of the clip that both sides are at.
    pub frame: usize,
    /// Where the bodies should be: the clip, in its own dimensions.
    pub desired: &'a [Pose; BODY_COUNT],
    /// Where the plant has them.
    pub measured: &'a [Pose],
    /// Where the figure's joints are in their parents' frames, in metres.
    pub offset_m: &'a [DVec3; BODY_COUNT],
    /// What a turn of each of them moves.
    pub levers: &'a Levers,
    /// How many joints were not given the torque they wanted.
    pub limited: usize,
    /// What the sensors gave the controller in the tick before, and in this one.
    pub readings: [&'a [Transform; BODY_COUNT]; 2],
    /// What has made the torques.
    pub tracker: &'a mut FigureTracker,
}

impl Step<'_> {
    /// The widest gap between the two sides of a joint, in metres: what the plant's constraints let through.
    pub fn widest_gap_m(&self) -> f64 {
        let mut widest_m: f64 = 0.0;
        for (body, place) in BODIES.iter().enumerate() {
            if let Some(parent) = place.parent {
                let parent = &self.measured[parent];
                let joint = parent.position_m + parent.rotation * self.offset_m[body];
                widest_m = widest_m.max(joint.distance(self.measured[body].position_m));
            }
        }
        widest_m
    }
}

/// Number of steps of a run: from frame 0, where the figure starts without error, to the last frame but
/// one. A step needs the desired motion of three frames (forward differences of second order), so it starts
/// from the last but two at the latest.
pub fn step_count(motion: &FigureMotion, seconds: Option<f64>) -> usize {
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
/// Measured velocities are backward differences of what the joints' sensors tell, as firmware has them.
/// `stream` tells clips apart in what is random of a run.
///
/// # Errors
/// [`RunError`]: above all, if the figure diverges.
pub fn track(
    motion: &FigureMotion,
    setup: &Setup,
    seconds: Option<f64>,
    stream: u64,
    mut observe: impl FnMut(Step<'_>),
) -> Result<usize, RunError> {
    let steps = step_count(motion, seconds);
    if steps == 0 {
        return Err(RunError::TooShort { frames: frame_count(motion, seconds) });
    }
    let model = setup.model(motion)?;
    let levers = Levers::of(&model)?;
    let mut tracker = setup.tracker(&model, &levers, motion.dt_s)?;
    let performance = Performance { motion, root: setup.root };
    let mut frames = ClipFrames { performance, joints: [Transform::IDENTITY; BODY_COUNT] };

    let start = performance.start(&model.offset_m);
    let mechanism =
        Mechanism { root: setup.root, bodies: plant_bodies(&setup.disturbance.built(&model)) };
    let mut plant = setup.plant.build(&mechanism, &start, motion.dt_s)?;
    let mut sensors = Sensors::new(&setup.disturbance, stream);
    let mut delay = DelayLine::new(setup.disturbance.latency_steps);
    let mut drive = Drive { root_force_n: DVec3::ZERO, torque_nm: vec![DVec3::ZERO; BODY_COUNT] };
    let lost_m = length_m(&model.offset_m) + length_m(&motion.offset_m);

    let before = one_step_before(&start, motion.dt_s);
    let mut before = sensors.read(measured_joints(&before, &model.offset_m));
    let refused = |frame| move |source| RunError::State { frame, source };
    tracker.begin(&mut frames, 0, &before).map_err(refused(0))?;
    for frame in 0..steps {
        let now = sensors.read(measured_joints(plant.poses(), &model.offset_m));
        let tick = i32::try_from(frame).map_err(|_| RunError::TooLong { frames: steps })?;
        let tick = tracker.step(&mut frames, tick, &now).map_err(refused(frame))?;
        let torques = tick.torques();
        if torques.iter().any(|torque| torque.reason == Some(LimitReason::NotFinite)) {
            return Err(RunError::TorqueNotFinite { frame });
        }
        let limited = torques.iter().filter(|torque| torque.reason.is_some()).count();
        let wanted = array::from_fn(|joint| torques[joint].value);
        set_drive(&mut drive, delay.pass(&wanted), plant.poses());
        plant.step(&drive);

        let desired = performance.world_poses(&motion.offset_m, frame + 1);
        check(frame + 1, &desired, plant.poses(), lost_m)?;
        observe(Step {
            frame: frame + 1,
            desired: &desired,
            measured: plant.poses(),
            offset_m: &model.offset_m,
            levers: &levers,
            limited,
            readings: [&before, &now],
            tracker: &mut tracker,
        });
        before = now;
    }
    Ok(steps)
}

/// A clip's frames, as the tracker asks for them.
struct ClipFrames<'a> {
    performance: Performance<'a>,
    joints: [Transform; BODY_COUNT],
}

impl FrameSource for ClipFrames<'_> {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        self.joints = match usize::try_from(index) {
            Ok(index) => self.performance.joint_poses(index),
            Err(_) => self.performance.joint_poses_before(index.unsigned_abs()),
        };
        Frame::Poses(&self.joints)
    }
}

/// What the sensors of the figure's joints tell: the relative rotations, and the root's pose in the world.
///
/// The joints' positions are the model's. The plant's bodies drift apart at the joints by millimetres; a
/// sensor in a joint does not see that, and a rig's bearings do not do it.
fn measured_joints(poses: &[Pose], offset_m: &[DVec3; BODY_COUNT]) -> [Transform; BODY_COUNT] {
    array::from_fn(|body| match BODIES[body].parent {
        None => Transform::new(poses[body].rotation.as_quat(), poses[body].position_m.as_vec3()),
        Some(parent) => {
            let relative = poses[parent].rotation.conjugate() * poses[body].rotation;
            Transform::new(relative.as_quat(), offset_m[body].as_vec3())
        }
    })
}

/// Turns torques from body axes to the world's.
fn set_drive(drive: &mut Drive, torques: &Wanted, poses: &[Pose]) {
    for ((torque, pose), drive_nm) in torques.iter().zip(poses).zip(&mut drive.torque_nm) {
        *drive_nm = pose.rotation * torque.moment_nm.as_dvec3();
    }
    drive.root_force_n = poses[0].rotation * torques[0].force_n.as_dvec3();
}

/// Length of all bones together, in metres. No body of a figure that stands where it should can be farther
/// from its goal than the bones of both figures reach.
fn length_m(offset_m: &[DVec3; BODY_COUNT]) -> f64 {
    offset_m.iter().map(|offset| offset.length()).sum()
}

/// Refuses a figure that is lost: nothing of it may get into a mean.
fn check(
    frame: usize,
    desired: &[Pose; BODY_COUNT],
    measured: &[Pose],
    lost_m: f64,
) -> Result<(), RunError> {
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
    if linear_m > lost_m {
        return Err(RunError::Diverged { frame, body: BODIES[body].name, linear_m });
    }
    Ok(())
}

fn plant_bodies(model: &BodyModel) -> Vec<PlantBody> {
    BODIES
        .iter()
        .zip(model.offset_m)
        .zip(model.bodies)
        .map(|((body, offset_m), mass)| PlantBody { parent: body.parent, offset_m, mass })
        .collect()
}
