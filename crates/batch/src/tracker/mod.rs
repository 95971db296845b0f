//! Trackers of several figures, which take their ticks together: see `sinew_core::tracker::Tracker`.

mod commands;
mod desired;
mod measured;
mod rigs;
#[cfg(test)]
mod tests;

use std::array::from_fn;

use glam::{Mat3, Vec3};
use sinew_core::control::{ControlLaw, Limited};
use sinew_core::{Body, JointKind, TorqueController, Transform, Wrench};

use crate::efforts::FARTHEST_FROM_UNIT;
use crate::joint::Motion;
use crate::lanes::{Matrices, OwnInertias, Poses, States, Twists, Vectors};
use crate::sweep::Moving;
use crate::turn::normalize;
use crate::widest::{Work, widest};
use commands::{
    Measured, command_from_compensated_error, command_from_local_error, command_from_world_error,
};
use desired::Desired;
use measured::{move_body, place_root, set_velocity, turn_body};
use rigs::{Errors, Gains, Link};

/// Number of trackers that take their ticks together.
pub const TRACKER_LANES: usize = 8;

const L: usize = TRACKER_LANES;

/// Shortest time step of differences that the core accepts, s.
const SHORTEST_STEP_S: f32 = 1e-9;

/// Trackers of several rigs of ball joints: frames and readings in, limited torques out, with the bits of a
/// [`Tracker`](sinew_core::tracker::Tracker) for each rig.
///
/// The settings are those of the paper: targets by forward differences of the bodies, measured velocities by backward
/// differences, errors by the methods Local, World or Linear Compensation, inverse dynamics, no projection, observer,
/// rest zone or supply.
#[derive(Debug)]
pub struct Trackers {
    links: Vec<Link>,
    errors: Errors,
    rate_hz: f32,
    desired: Desired,
    /// Poses of the joints in the last readings and in the new readings.
    readings: [Vec<Poses<L>>; 2],
    /// Measured velocities and commanded accelerations of the joints.
    joints: Vec<Motion<L>>,
    /// Measured states of the world and of the bodies.
    bodies: Vec<States<L>>,
    /// Motions of the world and of the bodies, which follow from the commands.
    moving: Vec<Moving<L>>,
    torques: [Vec<Limited<Wrench>>; L],
}

impl Trackers {
    /// Joins the trackers of several rigs with these controllers, which run once every `dt_s` seconds. Inertias, gains
    /// and limits may differ. O(bodies).
    ///
    /// Returns `None`
    /// - if a rig has rotors, or other joints than ball joints and a free root;
    /// - if a controller has another law, another method, partial compensation (β other than 1), or a body that aims
    ///   at a point or at several children;
    /// - if the structures of the rigs, the methods, the aims or gravity differ;
    /// - if `dt_s` is not a finite number from 1e-9.
    pub fn join<const N: usize>(
        controllers: [&TorqueController<N>; TRACKER_LANES],
        dt_s: f32,
    ) -> Option<Self> {
        let first = controllers[0];
        let (bodies, errors) = (first.tree().bodies(), Errors::new(first.method())?);
        let is_alike = |controller: &&TorqueController<N>| {
            let own = controller.tree().bodies();
            own.len() == bodies.len()
                && own.iter().zip(bodies).all(|(own, of_first)| {
                    (own.parent, own.joint) == (of_first.parent, of_first.joint)
                        && own.rotor_inertia == 0.0
                })
                && Errors::new(controller.method()).as_ref() == Some(&errors)
                && controller.law() == ControlLaw::InverseDynamics
                && controller.gravity_m_s2() == first.gravity_m_s2()
        };
        let has_ball = |(index, body): (usize, &Body)| match body.joint {
            JointKind::Free => index == 0,
            JointKind::Spherical => true,
            _ => false,
        };
        let is_steady = dt_s.is_finite() && dt_s >= SHORTEST_STEP_S;
        if !(is_steady
            && controllers.iter().all(is_alike)
            && bodies.iter().enumerate().all(has_ball))
        {
            return None;
        }
        let link = |(index, body): (usize, &Body)| Link {
            parent: body.parent.map_or(0, |parent| parent + 1),
            is_free: body.joint == JointKind::Free,
            inertias: OwnInertias::new(
                controllers.map(|controller| &controller.tree().bodies()[index].inertia),
            ),
            gains: Gains::new(controllers.map(|controller| controller.gains()[index])),
            limits: controllers.map(|controller| controller.limits()[index]),
        };
        let count = bodies.len();
        let still = Motion {
            rotation: Matrices::ZERO,
            arm: Vectors::ZERO,
            velocity: Twists::ZERO,
            acceleration: Twists::ZERO,
        };
        let rate_hz = 1.0 / dt_s;
        Some(Self {
            links: bodies.iter().enumerate().map(link).collect(),
            desired: Desired::new(count, rate_hz, errors == Errors::Local),
            errors,
            rate_hz,
            readings: [(); 2].map(|()| vec![Poses::IDENTITY; count]),
            bodies: vec![States::REST; count + 1],
            joints: vec![still; count],
            moving: vec![Moving::falling(first.gravity_m_s2()); count + 1],
            torques: from_fn(|_| vec![Limited { value: Wrench::ZERO, reason: None }; count]),
        })
    }

    /// Starts before the first tick: `frames` are those of the tick and of the next tick, `readings` those of a tick
    /// earlier. The caller has checked them. The rigs count as at rest. O(n).
    ///
    /// # Panics
    /// If a frame or a reading has fewer poses than the rigs have bodies.
    pub fn begin(&mut self, frames: [[&[Transform]; L]; 2], readings: [&[Transform]; L]) {
        let bodies = 0..self.links.len();
        let of_frame = |poses| bodies.clone().map(move |index| of_body(poses, index));
        self.desired.begin(&self.links, frames.map(of_frame));
        for (slot, mut poses) in self.readings[1].iter_mut().zip(of_frame(readings)) {
            normalize(&mut poses.rotation);
            *slot = poses;
        }
    }

    /// Computes the torques of a tick, after [`Self::begin`]. `frames` are those of the tick after the next, `readings`
    /// those of the tick. O(n).
    ///
    /// Returns for each rig whether its frame and its reading are valid. From the first tick with an invalid one, the
    /// torques of this rig have no meaning, although later ticks may return `true`. Other rigs are not affected.
    ///
    /// # Panics
    /// If a frame or a reading has fewer poses than the rigs have bodies.
    pub fn step(
        &mut self,
        frames: [&[Transform]; TRACKER_LANES],
        readings: [&[Transform]; TRACKER_LANES],
    ) -> [bool; TRACKER_LANES] {
        self.take(frames, readings);
        widest(Step(self))
    }

    /// Computes the torques of a tick with these instructions.
    #[cfg(test)]
    fn step_with(
        &mut self,
        instructions: crate::widest::Instructions,
        frames: [&[Transform]; L],
        readings: [&[Transform]; L],
    ) -> [bool; L] {
        self.take(frames, readings);
        instructions.run(Step(self))
    }

    /// Stores frames and readings.
    fn take(&mut self, frames: [&[Transform]; L], readings: [&[Transform]; L]) {
        for (index, slot) in self.desired.next_frame().iter_mut().enumerate() {
            *slot = of_body(frames, index);
        }
        self.readings.swap(0, 1);
        for (index, slot) in self.readings[1].iter_mut().enumerate() {
            *slot = of_body(readings, index);
        }
    }

    /// Returns the wrench of each joint's drive of a rig in the last tick, see [`TorqueController::tick`].
    pub fn torques(&self, lane: usize) -> &[Limited<Wrench>] {
        &self.torques[lane]
    }
}

/// Returns the poses of a body in all lanes.
fn of_body(poses: [&[Transform]; L], index: usize) -> Poses<L> {
    let mut of_body = Poses::IDENTITY;
    for (lane, poses) in poses.into_iter().enumerate() {
        of_body.set(lane, poses[index]);
    }
    of_body
}

struct Step<'a>(&'a mut Trackers);

impl Work for Step<'_> {
    type Output = [bool; L];

    #[inline(always)]
    fn run(self) -> [bool; L] {
        let Trackers { links, errors, rate_hz, desired, readings, joints, bodies, moving, torques } =
            self.0;
        let [before, now] = readings;
        let are_valid = are_valid(desired.newest_frame(), now);
        desired.advance(links);
        for (index, (link, joint)) in links.iter().zip(joints.iter_mut()).enumerate() {
            let pose = &mut now[index];
            set_velocity(&mut joint.velocity, &before[index], pose, *rate_hz);
            let (above, below) = bodies.split_at_mut(index + 1);
            let (parent, body) = (&above[link.parent], &mut below[0]);
            match errors {
                Errors::Local => {}
                Errors::World if link.parent == 0 => place_root(body, pose, &joint.velocity),
                Errors::World => turn_body(body, parent, pose, &joint.velocity),
                Errors::LinearCompensation { .. } => {
                    move_body(body, parent, pose, &joint.velocity);
                }
            }
            let (goal, out) = (desired.goal(index), &mut joint.acceleration);
            let measured = Measured { joint: pose, joint_velocity: &joint.velocity, body };
            match errors {
                Errors::Local => command_from_local_error(link, goal, measured, out),
                Errors::World => command_from_world_error(link, goal, measured, out),
                Errors::LinearCompensation { aims, settings } => match aims[index] {
                    None => command_from_world_error(link, goal, measured, out),
                    Some(child) => {
                        let aim = (desired.goal(child), *settings);
                        command_from_compensated_error(link, goal, measured, aim, out);
                    }
                },
            }
            for lane in 0..L {
                let pose = pose.at(lane);
                joint.rotation.set(lane, Mat3::from_quat(pose.rotation));
                joint.arm.set(lane, pose.translation_m);
            }
            let (above, below) = moving.split_at_mut(index + 1);
            below[0].follow(&above[link.parent], joint, link.is_free, &link.inertias);
        }
        for (index, (link, joint)) in links.iter().zip(joints.iter()).enumerate().rev() {
            let (above, below) = moving.split_at_mut(index + 1);
            if link.parent > 0 {
                above[link.parent].carry(&below[0], joint);
            }
            for (lane, torques) in torques.iter_mut().enumerate() {
                let force_n = if link.is_free { below[0].force.at(lane) } else { Vec3::ZERO };
                let wanted = Wrench::new(below[0].moment.at(lane), force_n);
                torques[index] = link.limits[lane].apply(wanted);
            }
        }
        are_valid
    }
}

/// Maximum squared distance of a valid position from the parent, m².
const FARTHEST_M2: f32 = 1e6 * 1e6;

/// Returns for each lane whether the core accepts the poses.
#[inline(always)]
fn are_valid(frame: &[Poses<L>], reading: &[Poses<L>]) -> [bool; L] {
    let mut are_valid = [true; L];
    for poses in frame.iter().chain(reading) {
        for (lane, is_valid) in are_valid.iter_mut().enumerate() {
            let Transform { rotation, translation_m } = poses.at(lane);
            // The comparisons also exclude NaN.
            *is_valid &= (translation_m.dot(translation_m) <= FARTHEST_M2)
                & ((rotation.dot(rotation) - 1.0).abs() <= FARTHEST_FROM_UNIT);
        }
    }
    are_valid
}
