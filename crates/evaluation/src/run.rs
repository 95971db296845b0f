//! A run: one motion, tracked by one rig with one setup.

use sinew_core::control::LimitReason;
use sinew_figure::plant::{Plant, Pose};
use sinew_rig::mechanism::{JointModel, Link};

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
    motion: &'a dyn EvaluatedMotion,
    setup: &'a Setup,
    steps: usize,
    rig: Rig,
    tracker: Box<RigTracker>,
    plant: Box<dyn Plant>,
    sensors: Sensors,
    drives: Drives,
    /// Poses of the bodies one step before the start, in the world.
    before_start: Vec<Pose>,
    /// Distance of a body from its goal above which the rig counts as lost.
    lost_m: f64,
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
        let tracker = setup.make_tracker(&rig, motion.dt_s())?;
        let performance = Performance { motion, setup, links: rig.links() };
        let start = performance.start();
        let built = setup.disturbance.build(rig.mechanism());
        Ok(Self {
            motion,
            setup,
            steps,
            tracker,
            plant: setup.plant.build(&built, &start, motion.dt_s())?,
            sensors: Sensors::new(&setup.disturbance, stream),
            drives: Drives::new(rig.links(), &setup.disturbance),
            before_start: one_step_before(&start, motion.dt_s()),
            lost_m: compute_lost_m(&performance),
            rig,
        })
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
        let Self { motion, setup, steps, rig, lost_m, .. } = self;
        let Self { mut tracker, mut plant, mut sensors, mut drives, before_start, .. } = self;
        let performance = Performance { motion, setup, links: rig.links() };
        let mut frames = Frames::new(motion, setup);
        let (mut desired, mut errors) = (Vec::new(), Vec::new());
        let (mut before, mut now) = (Vec::new(), Vec::new());
        rig.joint_poses(&before_start, &mut before);
        sensors.read(rig.links(), &mut before);
        let refused = |frame| move |source| RunError::State { frame, source };
        tracker.begin(&mut frames, 0, before.as_slice()).map_err(refused(0))?;
        for frame in 0..steps {
            rig.joint_poses(plant.poses(), &mut now);
            sensors.read(rig.links(), &mut now);
            let tick = i32::try_from(frame).map_err(|_| RunError::TooLong { frames: steps })?;
            let tick = tracker.step(&mut frames, tick, now.as_slice()).map_err(refused(frame))?;
            let torques = tick.torques();
            if torques.iter().any(|torque| torque.reason == Some(LimitReason::NotFinite)) {
                return Err(RunError::TorqueNotFinite { frame });
            }
            let (drive, limited) = drives.act(&performance, frame, torques, plant.poses());
            plant.step(drive);

            performance.desired(frame + 1, &mut desired);
            errors.clear();
            errors.extend(PoseError::between(&desired, plant.poses()));
            check(frame + 1, &rig, &errors, plant.poses(), lost_m)?;
            observe(Step {
                frame: frame + 1,
                desired: &desired,
                measured: plant.poses(),
                errors: &errors,
                rig: &rig,
                limited,
                readings: [&before, &now],
                tracker: &mut tracker,
            });
            std::mem::swap(&mut before, &mut now);
        }
        Ok(steps)
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
