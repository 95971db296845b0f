//! One run: one motion, tracked by one rig with one setup.

use sinew_core::control::LimitReason;
use sinew_core::{Transform, Wrench};
use sinew_figure::plant::{Drive, Pose};
use sinew_rig::mechanism::{JointModel, Link};

use super::disturbance::{DelayLine, Sensors};
use super::error::RunError;
use super::friction::FrictionFeed;
use super::off::Off;
use super::reference::{Frames, Performance, one_step_before};
use super::rig::Rig;
use super::setup::{RigTracker, Setup};
use super::take::Take;

/// A rig of short bones is not lost as long as it is nearer than this.
const LOST_LEAST_M: f64 = 0.1;

/// One step of a run, after it was made: the rig at frame `frame`, in the world.
#[derive(Debug)]
pub struct Step<'a> {
    /// Frame of the motion that both sides are at.
    pub frame: usize,
    /// Where the bodies should be: the motion, in its own dimensions.
    pub desired: &'a [Pose],
    /// Where the plant has them.
    pub measured: &'a [Pose],
    /// How far each is off.
    pub off: &'a [Off],
    /// The rig, as its controller knows it.
    pub rig: &'a Rig,
    /// How many joints were not given the torque they wanted.
    pub limited: usize,
    /// What the sensors gave the controller in the tick before, and in this one.
    pub readings: [&'a [Transform]; 2],
    /// What has made the torques.
    pub tracker: &'a mut RigTracker,
}

impl Step<'_> {
    /// The widest gap between the two sides of a joint, in metres: what the plant's constraints let through.
    pub fn widest_gap_m(&self) -> f64 {
        let gaps_m = (0..self.rig.links().len()).map(|body| self.rig.gap_m(body, self.measured));
        gaps_m.fold(0.0, f64::max)
    }
}

/// Number of steps of a run: from frame 0, where the rig starts without error, to the last frame but
/// one. A step needs the desired motion of three frames (forward differences of second order), so it starts
/// from the last but two at the latest.
pub fn step_count(take: &dyn Take, seconds: Option<f64>) -> usize {
    frame_count(take, seconds).saturating_sub(2)
}

/// Frames of a run, at least those of one step if the motion has them.
fn frame_count(take: &dyn Take, seconds: Option<f64>) -> usize {
    let frames = take.frame_count();
    match seconds {
        Some(seconds) => {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative, and saturates"
            )]
            let within = (seconds / take.dt_s()).round() as usize;
            frames.min(within.max(3))
        }
        None => frames,
    }
}

/// Tracks a motion and shows every step to `observe`. Returns the number of steps.
///
/// From frame n the controller has the motion's frames n to n+2, and the plant's poses of now and one step
/// before; its torques take the plant to frame n+1, and there it is compared with the motion. The drives add what the
/// friction of their joints takes, which they know. The rig starts on the motion's pose and with its velocity, with its
/// own dimensions.
///
/// Measured velocities are backward differences of what the joints' sensors tell, as firmware has them.
/// `stream` tells motions apart in what is random of a run.
///
/// # Errors
/// [`RunError`]: above all, if the rig diverges.
pub fn track(
    take: &dyn Take,
    setup: &Setup,
    seconds: Option<f64>,
    stream: u64,
    mut observe: impl FnMut(Step<'_>),
) -> Result<usize, RunError> {
    let steps = step_count(take, seconds);
    if steps == 0 {
        return Err(RunError::TooShort { frames: frame_count(take, seconds) });
    }
    let rig = Rig::of(take, setup)?;
    let mut tracker = setup.tracker(&rig, take.dt_s())?;
    let performance = Performance { take, setup, links: rig.links() };
    let mut frames = Frames::new(performance);

    let start = performance.start();
    let built = setup.disturbance.built(rig.mechanism());
    let mut plant = setup.plant.build(&built, &start, take.dt_s())?;
    let mut sensors = Sensors::new(&setup.disturbance, stream);
    let mut delay = DelayLine::new(setup.disturbance.latency_steps);
    let mut friction = FrictionFeed::of(rig.links(), setup.disturbance.torque_limit_nm);
    let mut wanted = Vec::new();
    let mut drive = Drive::none(rig.links().len());
    let lost_m = lost_m(&performance);
    let (mut desired, mut off) = (Vec::new(), Vec::new());

    let (mut before, mut now) = (Vec::new(), Vec::new());
    rig.joint_poses(&one_step_before(&start, take.dt_s()), &mut before);
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
        let mut limited = torques.iter().filter(|torque| torque.reason.is_some()).count();
        wanted.clear();
        wanted.extend(torques.iter().map(|torque| torque.value));
        if let Some(friction) = &mut friction {
            limited += friction.add(&performance, frame, &mut wanted);
        }
        let arriving = delay.pass(wanted.iter().copied());
        set_drive(&mut drive, arriving, plant.poses());
        plant.step(&drive);

        performance.desired(frame + 1, &mut desired);
        off.clear();
        off.extend(Off::of_all(&desired, plant.poses()));
        check(frame + 1, &rig, &off, plant.poses(), lost_m)?;
        observe(Step {
            frame: frame + 1,
            desired: &desired,
            measured: plant.poses(),
            off: &off,
            rig: &rig,
            limited,
            readings: [&before, &now],
            tracker: &mut tracker,
        });
        std::mem::swap(&mut before, &mut now);
    }
    Ok(steps)
}

/// Turns wrenches from body axes to the world's.
fn set_drive(drive: &mut Drive, wanted: &[Wrench], poses: &[Pose]) {
    let drives = drive.torque_nm.iter_mut().zip(&mut drive.force_n);
    for ((wanted, pose), (torque_nm, force_n)) in wanted.iter().zip(poses).zip(drives) {
        *torque_nm = pose.rotation * wanted.moment_nm.as_dvec3();
        *force_n = pose.rotation * wanted.force_n.as_dvec3();
    }
}

/// How far a body may be from its goal, in metres: as far as the bones of the rig and of the motion reach together, and
/// slides can go. No body of a rig that stands where it should can be farther off.
fn lost_m(performance: &Performance<'_>) -> f64 {
    let Performance { take, setup, links } = *performance;
    let mut joints = Vec::new();
    take.joint_poses(setup, 0, &mut joints);
    let below_root = links.iter().zip(&joints).filter(|(link, _)| link.parent.is_some());
    let own_m: f64 = links.iter().map(|link| link.position_m.length()).sum();
    let of_motion_m: f64 = below_root.map(|(_, pose)| pose.position_m.length()).sum();
    let slides_m: f64 = links.iter().filter_map(slide_m).sum();
    (own_m + of_motion_m + slides_m).max(LOST_LEAST_M)
}

/// How far a slide goes from its zero at most; one without a range as far as rigs are large.
fn slide_m(link: &Link) -> Option<f64> {
    matches!(link.joint, JointModel::Prismatic(_)).then(|| {
        let ends = link.ranges.first().map_or([1.0; 2], |range| range.map(f64::abs));
        ends[0].max(ends[1])
    })
}

/// Refuses a rig that is lost: nothing of it may get into a mean.
fn check(
    frame: usize,
    rig: &Rig,
    off: &[Off],
    measured: &[Pose],
    lost_m: f64,
) -> Result<(), RunError> {
    let mut worst = (0, 0.0);
    for (body, (Off { linear_m, .. }, measured)) in off.iter().zip(measured).enumerate() {
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
