//! The live stream's jitter buffer, as a source of poses for the controller.

use heapless::Vec;
use sinew_core::glam::Quat;
use sinew_core::{JointKind, math};
use sinew_link::message::LiveFrame;
use sinew_link::{Coordinate, Following, LiveBuffer, LiveSettings, LiveSetupError};
use sinew_rig::board::BoardRig;

use crate::controller::LiveSource;

/// Number of frames in the buffer: 150 ms of delay and 100 ms of jitter at 60 frames per second, and some more.
const FRAMES: usize = 24;

/// Maximum speed that the buffer accepts, rad/s or m/s. It is used for joints without a limit.
const FASTEST: f32 = 1e6;

/// Minimum speed that the buffer accepts, rad/s or m/s. It is used for a joint that cannot move.
const SLOWEST: f32 = 1e-6;

/// A stream of poses for a rig with at most `COORDS` coordinates.
#[derive(Debug)]
pub(super) struct Live<const COORDS: usize> {
    buffer: LiveBuffer<COORDS, FRAMES>,
    joints: Vec<Coordinate, COORDS>,
    before: Option<[f32; COORDS]>,
    tick_s: f32,
    age_us: Option<u32>,
}

impl<const COORDS: usize> Live<COORDS> {
    /// Creates the stream for the joints of a rig. A floating joint cannot be streamed to, and is treated as one that
    /// stands still.
    #[inline(never)]
    pub(super) fn new<const BODIES: usize, const DOFS: usize, const SERVOS: usize>(
        rig: &BoardRig<BODIES, DOFS, SERVOS>,
        settings: LiveSettings,
    ) -> Result<Self, LiveSetupError> {
        let mut joints: Vec<Coordinate, COORDS> = Vec::new();
        let (mut room, mut first) = (Ok(()), 0_usize);
        for body in rig.tree().bodies() {
            let count = body.joint.dof_count();
            let own = rig.dofs().iter().skip(first).take(count);
            first = first.saturating_add(count);
            let mut speeds = own.map(|dof| dof.speed.clamp(SLOWEST, FASTEST));
            if matches!(body.joint, JointKind::Spherical | JointKind::Free) {
                let speed = speeds.fold(FASTEST, f32::min);
                room = room.and(joints.push(Coordinate::Rotation { speed }));
                if body.joint == JointKind::Free {
                    for _ in 0..3 {
                        room = room.and(joints.push(Coordinate::Scalar { speed }));
                    }
                }
            } else {
                room = speeds
                    .try_fold((), |(), speed| joints.push(Coordinate::Scalar { speed }))
                    .and(room);
            }
        }
        let needs = rig.tree().coordinate_count();
        room.map_err(|_| LiveSetupError::Capacity { room: COORDS, needs })?;
        let buffer = LiveBuffer::new(&joints, settings)?;
        Ok(Self { buffer, joints, before: None, tick_s: settings.tick_s, age_us: None })
    }

    /// Adds a frame that arrived. The buffer counts the frames that it refuses.
    pub(super) fn push(&mut self, frame: &LiveFrame, now_us: u64) {
        let _ = self.buffer.push(frame, now_us);
    }

    /// Returns the age of the newest frame, ms, or `None` if there is no frame.
    pub(super) fn age_ms(&self) -> Option<u16> {
        self.age_us.map(|age| u16::try_from(age / 1000).unwrap_or(u16::MAX))
    }
}

impl<const COORDS: usize> LiveSource for Live<COORDS> {
    fn target(&mut self, now_us: u64, q: &mut [f32], qd: &mut [f32], qdd: &mut [f32]) -> bool {
        let target = self.buffer.step(now_us);
        self.age_us = target.age_us;
        let is_fed = matches!(target.following, Following::Interpolated | Following::Held);
        if !is_fed || target.q.len() != q.len() {
            self.before = None;
            return false;
        }
        let mut now = [0.0; COORDS];
        for ((to, q), from) in now.iter_mut().zip(q.iter_mut()).zip(target.q) {
            (*to, *q) = (*from, *from);
        }
        // In its first tick the stream has no velocity.
        let before = self.before.replace(now).unwrap_or(now);
        qd.fill(0.0);
        qdd.fill(0.0);
        let (mut from, mut to, mut speeds) = (before.as_slice(), now.as_slice(), qd);
        for joint in &self.joints {
            let width = if joint.len() == 4 { 3 } else { 1 };
            let (Some((a, a_rest)), Some((b, b_rest)), Some((own, rest))) = (
                from.split_at_checked(joint.len()),
                to.split_at_checked(joint.len()),
                speeds.split_at_mut_checked(width),
            ) else {
                break;
            };
            (from, to, speeds) = (a_rest, b_rest, rest);
            match (a, b, own) {
                ([a], [b], [speed]) => *speed = (b - a) / self.tick_s,
                (&[ax, ay, az, aw], &[bx, by, bz, bw], [x, y, z]) => {
                    let a = Quat::from_xyzw(ax, ay, az, aw);
                    let turn = math::log(a.conjugate() * Quat::from_xyzw(bx, by, bz, bw));
                    (*x, *y, *z) =
                        (turn.x / self.tick_s, turn.y / self.tick_s, turn.z / self.tick_s);
                }
                _ => {}
            }
        }
        true
    }
}
