//! Data for a test that compares the bits that two machines compute: a run that any machine can repeat, and all
//! numbers of the run.
//!
//! A run consists of a rig, a method, the desired poses of the joints in each frame, and their measured poses in each
//! tick. The machine answers with the intermediate results of its torques. The evaluation records all these data
//! during its own run. The frames are poses instead of a show, since the evaluation's performer has other dimensions
//! than the rig. Therefore the projection and the differences, which a show in coordinates does not need, are compared,
//! too.
//!
//! # Format of a run
//! All numbers are little-endian; `f32` is IEEE 754.
//!
//! | bytes | content |
//! | --- | --- |
//! | u32 | method, an index of [`MethodName::ALL`] |
//! | u32 | ticks t |
//! | u32 | frames f, at least 1 |
//! | u32 | length r of the rig in bytes |
//! | f32 | time between two frames, s |
//! | r | the rig, of n bodies and without servos, see [`sinew_rig::board`] |
//! | f x n x 28 | by frame and body the desired pose of its joint: rotation xyzw, then translation in m |
//! | n x 28 | by body the pose of its joint that was measured a tick before the first |
//! | t x n x 28 | by tick and body the measured pose of its joint |
//!
//! The answer has for each tick the [`QUANTITIES`] in their order, each by body, each component as an `f32`.

use sinew_core::glam::{Quat, Vec3};
use sinew_core::state_error::StateError;
use sinew_core::tracker::{
    Frame, FrameSource, MethodName, Timing, Tracker, extrapolate_before_start,
};
use sinew_core::{Transform, Twist, Workspace};

use crate::replay::{components, settings, tree};

/// Length of a pose, bytes.
const POSE_LEN: usize = 28;

const POSE: [&str; 7] = [
    "rotation x",
    "rotation y",
    "rotation z",
    "rotation w",
    "translation x",
    "translation y",
    "translation z",
];
const MOTION: [&str; 6] =
    ["angular x", "angular y", "angular z", "linear x", "linear y", "linear z"];
const ERROR: [&str; 12] = [
    "angular x",
    "angular y",
    "angular z",
    "linear x",
    "linear y",
    "linear z",
    "angular rate x",
    "angular rate y",
    "angular rate z",
    "linear rate x",
    "linear rate y",
    "linear rate z",
];
const WRENCH: [&str; 6] = ["moment x", "moment y", "moment z", "force x", "force y", "force z"];

/// Quantities of a tick that are compared, in the order in which they are computed, and the components of each.
pub const QUANTITIES: [(&str, &[&str]); 8] = [
    ("desired pose", &POSE),
    ("desired velocity", &MOTION),
    ("desired acceleration", &MOTION),
    ("measured pose", &POSE),
    ("measured velocity", &MOTION),
    ("state error", &ERROR),
    ("command", &MOTION),
    ("torque", &WRENCH),
];

/// Count of numbers for one body in a tick.
pub const NUMBERS: usize = {
    let mut sum = 0;
    let mut index = 0;
    while index < QUANTITIES.len() {
        sum += QUANTITIES[index].1.len();
        index += 1;
    }
    sum
};

/// Makes a run of a rig of at most `BODIES` bodies and `DOFS` dofs: `read` fills its slice with the next bytes of the
/// run, `write` receives the next bytes of the answer. Rig and frames are stored in `buffer`.
///
/// # Errors
/// The errors of `read` and `write`, or a description of the fault in the run.
pub fn perform<const BODIES: usize, const DOFS: usize>(
    buffer: &mut [u8],
    mut read: impl FnMut(&mut [u8]) -> Result<(), &'static str>,
    mut write: impl FnMut(&[u8]) -> Result<(), &'static str>,
) -> Result<(), &'static str> {
    let mut count = || {
        let mut bytes = [0; 4];
        read(&mut bytes)?;
        usize::try_from(u32::from_le_bytes(bytes)).map_err(|_| "a count is too large")
    };
    let (method, ticks, frames, length) = (count()?, count()?, count()?, count()?);
    let mut dt_s = [0; 4];
    read(&mut dt_s)?;
    let dt_s = f32::from_le_bytes(dt_s);
    let method = *MethodName::ALL.get(method).ok_or("there is no such method")?;
    let rig = buffer.get_mut(..length).ok_or("the rig is longer than the buffer")?;
    read(rig)?;
    let tree = tree::<BODIES, DOFS>(rig).map_err(|_| "the rig is not usable")?;
    let bodies = tree.len();
    let length = frames.saturating_mul(bodies).saturating_mul(POSE_LEN);
    let frames = buffer.get_mut(..length).ok_or("the frames are longer than the buffer")?;
    read(frames)?;
    let mut frames = RecordedFrames::<BODIES>::new(frames, bodies);
    let timing = Timing { dt_s, latency_ticks: 0 };
    let (settings, workspace) = (settings(method), Workspace::<BODIES, BODIES>::resolving());
    let mut tracker =
        Tracker::<BODIES, 1, BODIES>::with_workspace(tree, &settings, timing, workspace)
            .map_err(|_| "there is no such tracker")?;
    let mut reading = |measured: &mut [Transform; BODIES]| {
        for pose in measured.iter_mut().take(bodies) {
            let mut bytes = [0; POSE_LEN];
            read(&mut bytes)?;
            *pose = pose_of(&bytes);
        }
        Ok(())
    };
    let (mut measured, mut answer) = ([Transform::IDENTITY; BODIES], [[0; TICK_BYTES]; BODIES]);
    reading(&mut measured)?;
    let before = measured.get(..bodies).unwrap_or_default();
    tracker.begin(&mut frames, 0, before).map_err(|_| "the beginning was refused")?;
    for tick in 0..ticks {
        reading(&mut measured)?;
        let tick = i32::try_from(tick).map_err(|_| "there are too many ticks")?;
        let measured = measured.get(..bodies).unwrap_or_default();
        tracker.step(&mut frames, tick, measured).map_err(|_| "a tick was refused")?;
        write(tick_bytes(&mut tracker, &mut answer))?;
    }
    Ok(())
}

/// The frames of a run, read from the buffer. Frames before the first continue the first step backwards.
struct RecordedFrames<'a, const BODIES: usize> {
    recorded: &'a [[u8; POSE_LEN]],
    bodies: usize,
    poses: [Transform; BODIES],
}

impl<'a, const BODIES: usize> RecordedFrames<'a, BODIES> {
    fn new(bytes: &'a [u8], bodies: usize) -> Self {
        Self { recorded: bytes.as_chunks().0, bodies, poses: [Transform::IDENTITY; BODIES] }
    }

    /// Reads a frame, or the last one if there are fewer.
    fn read(&self, index: usize, poses: &mut [Transform; BODIES]) {
        let last = self.recorded.len().saturating_sub(self.bodies);
        let start = index.saturating_mul(self.bodies).min(last);
        let recorded = self.recorded.get(start..).unwrap_or_default();
        for (pose, bytes) in poses.iter_mut().zip(recorded).take(self.bodies) {
            *pose = pose_of(bytes);
        }
    }
}

impl<const BODIES: usize> FrameSource for RecordedFrames<'_, BODIES> {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        let mut poses = self.poses;
        if let Ok(index) = usize::try_from(index) {
            self.read(index, &mut poses);
        } else {
            let mut second = poses;
            self.read(1, &mut second);
            self.read(0, &mut poses);
            for (pose, second) in poses.iter_mut().zip(&second) {
                *pose = extrapolate_before_start(pose, second, index.unsigned_abs());
            }
        }
        self.poses = poses;
        Frame::Poses(self.poses.get(..self.bodies).unwrap_or_default())
    }
}

/// Length of the answer for one body in a tick, bytes.
pub const TICK_BYTES: usize = NUMBERS * 4;

/// Returns the answer for a tracker's last tick.
pub fn tick_bytes<'a, const BODIES: usize, const D: usize, const R: usize>(
    tracker: &mut Tracker<BODIES, D, R>,
    out: &'a mut [[u8; TICK_BYTES]; BODIES],
) -> &'a [u8] {
    let bodies = tracker.controller().tree().len();
    let mut errors = [StateError::ZERO; BODIES];
    tracker.errors(&mut errors);
    let bytes = out.as_flattened_mut();
    for (slot, number) in bytes.chunks_exact_mut(4).zip(numbers(tracker, &errors)) {
        slot.copy_from_slice(&number.to_le_bytes());
    }
    bytes.get(..bodies * TICK_BYTES).unwrap_or_default()
}

/// Returns a pose in the format of a run.
pub fn pose_bytes(pose: &Transform) -> [u8; POSE_LEN] {
    let mut bytes = [0; POSE_LEN];
    for (slot, number) in bytes.chunks_exact_mut(4).zip(pose_numbers(pose)) {
        slot.copy_from_slice(&number.to_le_bytes());
    }
    bytes
}

fn pose_of(bytes: &[u8; POSE_LEN]) -> Transform {
    let mut n = [0.0; 7];
    for (number, bytes) in n.iter_mut().zip(bytes.as_chunks().0) {
        *number = f32::from_le_bytes(*bytes);
    }
    let [x, y, z, w, right, up, back] = n;
    Transform::new(Quat::from_xyzw(x, y, z, w), Vec3::new(right, up, back))
}

/// Returns all numbers of the last tick, in the order of [`QUANTITIES`].
fn numbers<const BODIES: usize, const D: usize, const R: usize>(
    tracker: &Tracker<BODIES, D, R>,
    errors: &[StateError],
) -> impl Iterator<Item = f32> {
    let (targets, w) = (tracker.targets(), tracker.workspace());
    let states = tracker.states().as_slice();
    let (desired, bodies) = (targets.states(), states.len());
    desired
        .iter()
        .flat_map(|state| pose_numbers(&state.pose))
        .chain(desired.iter().flat_map(|state| motion_numbers(&state.velocity)))
        .chain(targets.accelerations().iter().flat_map(motion_numbers))
        .chain(states.iter().flat_map(|state| pose_numbers(&state.pose)))
        .chain(states.iter().flat_map(|state| motion_numbers(&state.velocity)))
        .chain(errors.iter().take(bodies).flat_map(error_numbers))
        .chain(w.commands().iter().take(bodies).flat_map(motion_numbers))
        .chain(w.torques().iter().take(bodies).flat_map(|torque| components(&torque.value)))
}

fn pose_numbers(pose: &Transform) -> [f32; 7] {
    let (Quat { x, y, z, w }, t) = (pose.rotation, pose.translation_m);
    [x, y, z, w, t.x, t.y, t.z]
}

fn motion_numbers(motion: &Twist) -> [f32; 6] {
    let (a, l) = (motion.angular, motion.linear);
    [a.x, a.y, a.z, l.x, l.y, l.z]
}

fn error_numbers(error: &StateError) -> [f32; 12] {
    let (a, l) = (error.angular_rad, error.linear_m);
    let (b, m) = (error.angular_rate_rad_s, error.linear_rate_m_s);
    [a.x, a.y, a.z, l.x, l.y, l.z, b.x, b.y, b.z, m.x, m.y, m.z]
}
