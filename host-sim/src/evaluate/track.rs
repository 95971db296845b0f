//! One run: one clip, tracked by one figure with one setup.

use std::array;

use glam::DVec3;
use sinew_core::control::LimitReason;
use sinew_core::projection::{ManifoldProjection, ProjectionWorkspace};
use sinew_core::trajectory::{aligned_targets, forward_targets, live_targets};
use sinew_core::{
    BodyState, Controller, ForwardDifferences, JointTargets, Transform, Twist, Workspace,
};

use super::controller::{ControllerSettings, DesiredVelocity, DifferencesName, narrow};
use super::disturbance::{DelayLine, Sensors, Wanted};
use super::error::RunError;
use super::estimate::Estimate;
use super::levers::Levers;
use super::reference::{Performance, one_step_before};
use super::setup::Setup;
use super::supply::Supply;
use crate::figure::{BODIES, BODY_COUNT, BodyModel, FigureMotion};
use crate::plant::{Drive, Mechanism, PlantBody, Pose};

/// One step of a run, after it was made: the figure at frame `frame`, in the world.
#[derive(Debug, Clone, Copy)]
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

    /// The poses of the plant's joints as sensors without faults tell them, each in its parent's frame.
    pub fn joint_poses(&self) -> [Transform; BODY_COUNT] {
        measured_joints(self.measured, self.offset_m)
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
    let controller = setup.controller(&model, motion.dt_s)?;
    let performance = Performance { motion, root: setup.controller.root };
    let looks_ahead = setup.effective_controller().observer.predict;
    let ahead = if looks_ahead { setup.disturbance.latency_steps } else { 0 };
    let mut desired = Desired::new(performance, &controller, setup, ahead)?;
    let supply = Supply::new(setup, controller.tree(), &levers)?;
    let mut workspace = Workspace::resolving();

    let start = performance.start(&model.offset_m);
    let mechanism = Mechanism {
        root: setup.controller.root,
        bodies: plant_bodies(&setup.disturbance.built(&model)),
    };
    let mut plant = setup.plant.build(&mechanism, &start, motion.dt_s)?;
    let mut sensors = Sensors::new(&setup.disturbance, stream);
    let mut delay = DelayLine::new(setup.disturbance.latency_steps);
    let mut drive = Drive { root_force_n: DVec3::ZERO, torque_nm: vec![DVec3::ZERO; BODY_COUNT] };
    let lost_m = length_m(&model.offset_m) + length_m(&motion.offset_m);

    let before = one_step_before(&start, motion.dt_s);
    let before = sensors.read(measured_joints(&before, &model.offset_m));
    let mut estimate = Estimate::new(setup, controller.tree(), &before, desired.dt_s)?;
    for frame in 0..steps {
        let state_error = |source| RunError::State { frame, source };
        let now = sensors.read(measured_joints(plant.poses(), &model.offset_m));
        estimate.observe(controller.tree(), &now).map_err(state_error)?;
        let targets = desired.targets(frame + ahead)?;
        estimate.compensate(targets);
        controller.tick(targets, estimate.states(), &[], &mut workspace);
        supply.share(&controller, estimate.states(), &mut workspace);
        let torques = workspace.torques();
        if torques.iter().any(|torque| torque.reason == Some(LimitReason::NotFinite)) {
            return Err(RunError::TorqueNotFinite { frame });
        }
        let limited = torques.iter().filter(|torque| torque.reason.is_some()).count();
        let wanted = array::from_fn(|joint| torques[joint].value);
        let torques: [_; BODY_COUNT] = array::from_fn(|joint| torques[joint]);
        estimate.sent(workspace.commands(), &torques);
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
        });
    }
    Ok(steps)
}

/// The desired side of a run: what the clip asks of the joints.
struct Desired<'a> {
    performance: Performance<'a>,
    settings: ControllerSettings,
    dt_s: f32,
    controller: &'a Controller<BODY_COUNT>,
    projection: Option<(ManifoldProjection<BODY_COUNT>, ProjectionWorkspace<BODY_COUNT>)>,
    targets: JointTargets<BODY_COUNT>,
    of_bodies: ForwardDifferences<BODY_COUNT>,
    /// Joint poses of three frames: the last one is that of the tick and as many farther as the differences
    /// look ahead.
    window: [[Transform; BODY_COUNT]; 3],
}

impl<'a> Desired<'a> {
    /// The targets from frame `first` on.
    fn new(
        performance: Performance<'a>,
        controller: &'a Controller<BODY_COUNT>,
        setup: &Setup,
        first: usize,
    ) -> Result<Self, RunError> {
        let settings = setup.effective_controller();
        let projection = setup.projection(controller.tree())?;
        let mut desired = Self {
            performance,
            settings,
            dt_s: narrow(performance.motion.dt_s),
            controller,
            projection: projection.map(|projection| (projection, ProjectionWorkspace::new())),
            targets: JointTargets::rest(controller.tree()),
            of_bodies: ForwardDifferences::new(),
            window: [[Transform::IDENTITY; BODY_COUNT]; 3],
        };
        let newest = first + desired.frames_ahead();
        for back in [3, 2, 1] {
            let poses = match newest.checked_sub(back) {
                Some(frame) => performance.joint_poses(frame),
                None => performance.joint_poses_before(back - newest),
            };
            desired.take_in(&poses)?;
        }
        let (tree, dt_s) = (controller.tree(), desired.dt_s);
        let [_, second, third] = &desired.window;
        desired
            .of_bodies
            .restart(tree, dt_s, second)
            .and_then(|()| desired.of_bodies.advance(tree, third, &mut desired.targets))
            .map_err(|source| RunError::State { frame: first, source })?;
        Ok(desired)
    }

    /// How many frames the differences look ahead.
    const fn frames_ahead(&self) -> usize {
        match self.settings.differences {
            DifferencesName::Forward => 2,
            DifferencesName::Aligned => 1,
            DifferencesName::Live => 0,
        }
    }

    /// Takes the next frame of the clip into the window, as the figure should perform it.
    fn take_in(&mut self, poses: &[Transform; BODY_COUNT]) -> Result<(), RunError> {
        let mut nearest = *poses;
        if let Some((projection, workspace)) = &mut self.projection {
            projection.project(self.controller.tree(), poses, workspace, &mut nearest)?;
        }
        let [_, second, third] = self.window;
        self.window = [second, third, nearest];
        Ok(())
    }

    /// Targets at `frame`; frames come one after the other.
    fn targets(&mut self, frame: usize) -> Result<&mut JointTargets<BODY_COUNT>, RunError> {
        self.take_in(&self.performance.joint_poses(frame + self.frames_ahead()))?;

        let window = self.window.each_ref().map(<[_; BODY_COUNT]>::as_slice);
        let (tree, dt_s, targets) = (self.controller.tree(), self.dt_s, &mut self.targets);
        match (self.settings.differences, self.settings.desired_velocity) {
            (DifferencesName::Aligned, _) => aligned_targets(window, dt_s, targets),
            (DifferencesName::Live, _) => live_targets(window, dt_s, targets),
            (DifferencesName::Forward, DesiredVelocity::Bodies) => {
                self.of_bodies.advance(tree, window[2], targets)
            }
            (DifferencesName::Forward, _) => forward_targets(window, dt_s, targets),
        }
        .map_err(|source| RunError::State { frame, source })?;
        if self.settings.differences == DifferencesName::Forward {
            self.replace_velocities(frame)?;
        }
        Ok(&mut self.targets)
    }

    /// Puts velocities that are no forward differences in the place of those.
    fn replace_velocities(&mut self, frame: usize) -> Result<(), RunError> {
        match self.settings.desired_velocity {
            DesiredVelocity::Bodies | DesiredVelocity::Joints => Ok(()),
            DesiredVelocity::Zero => self.set_velocities(frame, |_| Twist::ZERO),
            DesiredVelocity::Backward => {
                let moving = self.performance.backward(frame);
                let bodies: [BodyState; BODY_COUNT] = moving.map(|moving| BodyState {
                    pose: Transform::new(
                        moving.pose.rotation.as_quat(),
                        moving.pose.position_m.as_vec3(),
                    ),
                    velocity: Twist::new(
                        moving.angular_rad_s.as_vec3(),
                        moving.linear_m_s.as_vec3(),
                    ),
                });
                self.set_velocities(frame, |body| {
                    let parent = BODIES[body].parent.map_or(BodyState::WORLD, |p| bodies[p]);
                    bodies[body].joint_state(&parent).velocity
                })
            }
        }
    }

    fn set_velocities(
        &mut self,
        frame: usize,
        velocity: impl Fn(usize) -> Twist,
    ) -> Result<(), RunError> {
        for joint in 0..BODY_COUNT {
            self.targets
                .set_velocity(joint, velocity(joint))
                .map_err(|source| RunError::State { frame, source })?;
        }
        Ok(())
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
