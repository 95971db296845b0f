//! A run: one motion, tracked by one rig with one setup.

use sinew_core::control::{LimitReason, Limited};
use sinew_core::{TorqueController, Transform, Wrench};
use sinew_figure::plant::{Drive, Plant, Pose};
use sinew_rig::mechanism::{JointModel, Link};

use super::capacity::CAPACITY;
use super::drives::Drives;
use super::error::RunError;
use super::metrics::Errors;
use super::motion::{EvaluatedMotion, count_frames, count_steps};
use super::pose_error::PoseError;
use super::reference::{Frames, Performance, one_step_before};
use super::rig::Rig;
use super::sensors::Sensors;
use super::setup::{RigTracker, Setup};
use super::step::Step;

/// Lower bound, in metres, of the distance from its goal above which a body counts as lost. It applies to rigs with
/// short bones.
const LOST_LEAST_M: f64 = 0.1;

/// A run that is ready to start: a motion, the rig that performs it, its controller, its sensors and drives, and
/// the plant.
///
/// The rig starts in the motion's pose and with its velocity, with the rig's own dimensions.
pub struct Run<'a> {
    pub(super) performer: Performer<'a>,
    pub(super) plant: Box<dyn Plant>,
}

/// All of a run except its plant.
pub(super) struct Performer<'a> {
    motion: &'a dyn EvaluatedMotion,
    setup: &'a Setup,
    steps: usize,
    rig: Rig,
    tracker: Box<RigTracker>,
    sensors: Sensors,
    drives: Drives,
    frames: Frames<'a>,
    /// Distance of a body from its goal above which the rig counts as lost.
    lost_m: f64,
    /// Frame at which the present step begins.
    frame: usize,
    /// Sensor readings in the previous tick and in this tick.
    readings: [Vec<Transform>; 2],
    /// Number of joints that did not receive their desired torque in this tick.
    limited: usize,
    desired: Vec<Pose>,
    errors: Vec<PoseError>,
}

impl<'a> Run<'a> {
    /// Creates a run of the first `seconds` of a motion, or of the whole motion. `stream` is the number of the
    /// motion, which selects its noise.
    ///
    /// # Errors
    /// [`RunError`] if the motion is too short, or the setup does not fit it.
    pub fn new(
        motion: &'a dyn EvaluatedMotion,
        setup: &'a Setup,
        seconds: Option<f64>,
        stream: u64,
    ) -> Result<Self, RunError> {
        let steps = count_steps(motion, seconds);
        if steps == 0 {
            return Err(RunError::TooShort { frames: count_frames(motion, seconds) });
        }
        let rig = motion.rig(setup)?;
        let mut tracker = setup.make_tracker(&rig, motion.dt_s())?;
        let performance = Performance { motion, setup, links: rig.links() };
        let start = performance.start();
        let built = setup.disturbance.build(rig.mechanism());
        let plant = setup.plant.build(&built, &start, motion.dt_s())?;
        let mut sensors = Sensors::new(&setup.disturbance, stream);
        let mut before = Vec::new();
        rig.joint_poses(&one_step_before(&start, motion.dt_s()), &mut before);
        sensors.read(rig.links(), &mut before);
        let mut frames = Frames::new(motion, setup);
        let refused = |source| RunError::State { frame: 0, source };
        tracker.begin(&mut frames, 0, before.as_slice()).map_err(refused)?;
        let performer = Performer {
            motion,
            setup,
            steps,
            tracker,
            sensors,
            drives: Drives::new(rig.links(), &setup.disturbance),
            frames,
            lost_m: compute_lost_m(&performance),
            rig,
            frame: 0,
            readings: [before, Vec::new()],
            limited: 0,
            desired: Vec::new(),
            errors: Vec::new(),
        };
        Ok(Self { performer, plant })
    }

    /// Tracks the motion and passes every step to `observe`. Returns the number of steps.
    ///
    /// At frame n the controller receives the motion's frames n to n+2, and the plant's present poses and those of
    /// the previous step. Its torques move the plant to frame n+1, where the plant is compared with the motion.
    /// The drives add the friction of their joints, which they know.
    ///
    /// Measured velocities are backward differences of the joint sensors' readings, as in firmware.
    ///
    /// # Errors
    /// [`RunError`], in particular if the rig diverges.
    pub fn track(self, mut observe: impl FnMut(Step<'_>)) -> Result<usize, RunError> {
        let Self { mut performer, mut plant } = self;
        while !performer.is_done() {
            performer.sense(plant.poses());
            performer.act(plant.poses())?;
            plant.step(performer.drive());
            observe(performer.compare(plant.poses())?);
        }
        Ok(performer.steps)
    }

    /// Tracks the motion. Returns the errors of all steps, and the number of steps.
    ///
    /// # Errors
    /// Those of [`track`](Self::track).
    pub fn measure(self) -> Result<(Errors, usize), RunError> {
        let mut errors = Errors::default();
        let steps = self.track(|step| errors.add_step(&step))?;
        Ok((errors, steps))
    }
}

impl Performer<'_> {
    /// Returns whether the last step has ended.
    pub(super) fn is_done(&self) -> bool {
        self.frame == self.steps
    }

    /// Returns the number of steps of the run.
    pub(super) fn steps(&self) -> usize {
        self.steps
    }

    /// Reads the joints' sensors at the beginning of the present step, when the plant has these poses.
    pub(super) fn sense(&mut self, poses: &[Pose]) {
        if self.frame > 0 {
            self.readings.swap(0, 1);
        }
        let [_, now] = &mut self.readings;
        self.rig.joint_poses(poses, now);
        self.sensors.read(self.rig.links(), now);
    }

    /// Computes the drives of the present step from the readings of the sensors, with the run's own tracker.
    pub(super) fn act(&mut self, poses: &[Pose]) -> Result<(), RunError> {
        let Self { setup, frame, steps, tracker, .. } = self;
        let [_, now] = &self.readings;
        let tick = i32::try_from(*frame).map_err(|_| RunError::TooLong { frames: *steps })?;
        let tick = tracker.step(&mut self.frames, tick, now.as_slice());
        let tick = tick.map_err(|source| RunError::State { frame: *frame, source })?;
        let performance = Performance { motion: self.motion, setup, links: self.rig.links() };
        self.limited = drive(&mut self.drives, &performance, *frame, tick.torques(), poses)?;
        Ok(())
    }

    /// Computes the drives like [`Self::act`] if the run's own tracker has not followed the previous step.
    pub(super) fn act_anew(&mut self, poses: &[Pose]) -> Result<(), RunError> {
        let Self { frame, steps, tracker, .. } = self;
        let [before, _] = &self.readings;
        let tick = i32::try_from(*frame).map_err(|_| RunError::TooLong { frames: *steps })?;
        let begun = tracker.begin(&mut self.frames, tick, before.as_slice());
        begun.map_err(|source| RunError::State { frame: *frame, source })?;
        self.act(poses)
    }

    /// Computes the drives of the present step from torques that are computed elsewhere.
    pub(super) fn act_by(
        &mut self,
        torques: &[Limited<Wrench>],
        poses: &[Pose],
    ) -> Result<(), RunError> {
        let Self { motion, setup, frame, rig, drives, .. } = self;
        let performance = Performance { motion: *motion, setup, links: rig.links() };
        self.limited = drive(drives, &performance, *frame, torques, poses)?;
        Ok(())
    }

    /// Returns the time of a step, s.
    pub(super) fn dt_s(&self) -> f64 {
        self.motion.dt_s()
    }

    /// Returns whether [`sinew_batch::Trackers`] can replace the run's own tracker, as far as settings decide it.
    pub(super) fn has_plain_tracker(&self) -> bool {
        self.setup.plain_tracker().is_some()
    }

    /// Returns the controller of the run's own tracker.
    pub(super) fn controller(&self) -> &TorqueController<CAPACITY> {
        self.tracker.controller()
    }

    /// Reads the frame that is `ahead` frames after that of the present step.
    pub(super) fn read_frame(&mut self, ahead: usize) {
        self.frames.read(self.frame + ahead);
    }

    /// Returns the poses of the joints in the frame that was read last.
    pub(super) fn frame_poses(&self) -> &[Transform] {
        self.frames.joints()
    }

    /// Returns the readings of the sensors in the previous tick and in this tick.
    pub(super) fn readings(&self) -> [&[Transform]; 2] {
        self.readings.each_ref().map(Vec::as_slice)
    }

    /// Returns the drives of the present step.
    pub(super) fn drive(&self) -> &Drive {
        self.drives.drive()
    }

    /// Ends the present step: compares the poses of the plant at its end with the motion.
    pub(super) fn compare<'s>(&'s mut self, poses: &'s [Pose]) -> Result<Step<'s>, RunError> {
        self.frame += 1;
        let Self { motion, setup, frame, rig, desired, errors, .. } = self;
        Performance { motion: *motion, setup, links: rig.links() }.desired(*frame, desired);
        errors.clear();
        errors.extend(PoseError::between(desired, poses));
        check(*frame, rig, errors, poses, self.lost_m)?;
        let [before, now] = &self.readings;
        Ok(Step {
            frame: *frame,
            desired,
            measured: poses,
            errors,
            rig,
            limited: self.limited,
            readings: [before, now],
            tracker: Some(&mut self.tracker),
        })
    }
}

/// Passes torques to the drives. Returns the number of joints that did not receive their desired torque.
fn drive(
    drives: &mut Drives,
    performance: &Performance<'_>,
    frame: usize,
    torques: &[Limited<Wrench>],
    poses: &[Pose],
) -> Result<usize, RunError> {
    if torques.iter().any(|torque| torque.reason == Some(LimitReason::NotFinite)) {
        return Err(RunError::TorqueNotFinite { frame });
    }
    Ok(drives.act(performance, frame, torques, poses))
}

/// Computes the maximum plausible distance of a body from its goal, in metres: the sum of all bone lengths of the
/// rig and of the motion, and of the slides' ranges. Every body that follows its motion is nearer to its goal.
fn compute_lost_m(performance: &Performance<'_>) -> f64 {
    let Performance { motion, setup, links } = *performance;
    let mut joints = Vec::new();
    motion.joint_poses(setup, 0, &mut joints);
    let below_root = links.iter().zip(&joints).filter(|(link, _)| link.parent.is_some());
    let own_m: f64 = links.iter().map(|link| link.position_m.length()).sum();
    let of_motion_m: f64 = below_root.map(|(_, pose)| pose.position_m.length()).sum();
    let slides_m: f64 = links.iter().filter_map(slide_m).sum();
    (own_m + of_motion_m + slides_m).max(LOST_LEAST_M)
}

/// Returns the maximum distance of a slide from its zero, m; 1 m, the size of a rig, if the slide has no range.
fn slide_m(link: &Link) -> Option<f64> {
    matches!(link.joint, JointModel::Prismatic(_)).then(|| {
        let ends = link.ranges.first().map_or([1.0; 2], |range| range.map(f64::abs));
        ends[0].max(ends[1])
    })
}

/// Returns an error if the rig is lost, since its errors must not be included in a mean.
fn check(
    frame: usize,
    rig: &Rig,
    errors: &[PoseError],
    measured: &[Pose],
    lost_m: f64,
) -> Result<(), RunError> {
    let mut worst = (0, 0.0);
    for (body, (PoseError { linear_m, .. }, measured)) in errors.iter().zip(measured).enumerate() {
        if !(linear_m.is_finite() && measured.rotation.is_finite()) {
            worst = (body, f64::INFINITY);
            break;
        }
        if *linear_m > worst.1 {
            worst = (body, *linear_m);
        }
    }
    let (body, linear_m) = worst;
    if linear_m > lost_m {
        let body = rig.links()[body].name.clone();
        return Err(RunError::Diverged { frame, body, linear_m });
    }
    Ok(())
}
