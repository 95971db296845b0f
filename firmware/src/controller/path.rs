//! The commanded pose: blends sources within the joints' range, speed and acceleration.

use heapless::Vec;
use sinew_core::math;
use sinew_rig::board::BoardRig;
use sinew_rig::drive::Numbers;

use super::coordinates::{
    JointIndices, between, number, parts, put, put_three, put_turn, three, turn,
};
use super::pose::Pose;
use crate::drives::follower::Follower;
use crate::supervisor::Moving;

/// Width of the wall at an end of a led joint's range: maximum in rad, and as a part of the range.
const WALL: (f32, f32) = (0.087, 0.1);

/// Effort of a wall at the end of the range, as a part of the joint's maximum effort.
const WALL_EFFORT: f32 = 0.5;

/// Maximum distance at which a commanded pose counts as equal to its source, rad or m.
pub(super) const THERE: f32 = 1e-3;

/// The commanded pose, advanced tick by tick.
#[derive(Debug, Clone)]
pub(super) struct Path<const DOFS: usize, const COORDS: usize> {
    parts: Vec<JointIndices, DOFS>,
    dofs: Vec<Axis, DOFS>,
    dt_s: f32,
    /// Pose at which the previous source ended.
    from: Pose<DOFS, COORDS>,
    now: Pose<DOFS, COORDS>,
}

/// Limits and follower of a dof.
#[derive(Debug, Clone, Copy)]
struct Axis {
    follower: Follower,
    /// Maximum speed, rad/s or m/s.
    speed: f32,
    /// Maximum effort, N m or N; infinite for no limit.
    effort: f32,
    range: [f32; 2],
    /// Speed of the drive's fastest shaft per speed of this dof, in rad per rad or m; at least 1.
    shaft: f32,
}

impl<const DOFS: usize, const COORDS: usize> Path<DOFS, COORDS> {
    /// Creates a path without dofs.
    pub(super) fn uninit() -> Self {
        let nowhere = Pose::new(0, 0);
        Self { parts: Vec::new(), dofs: Vec::new(), dt_s: 0.0, from: nowhere.clone(), now: nowhere }
    }

    /// Creates a path at the rig's home, or `None` if the rig has more coordinates than there is room for.
    #[inline(never)]
    pub(super) fn new<const BODIES: usize, const SERVOS: usize>(
        rig: &BoardRig<BODIES, DOFS, SERVOS>,
        dt_s: f32,
    ) -> Option<Self> {
        let tree = rig.tree();
        let (nq, nv) = (tree.coordinate_count(), tree.dof_count());
        if nq > COORDS {
            return None;
        }
        let mut dofs = Vec::new();
        for dof in rig.dofs() {
            let follower = Follower::within(dof.range, dof.speed, dof.acceleration, dt_s);
            let (speed, effort, range) = (dof.speed, dof.effort, dof.range);
            dofs.push(Axis { follower, speed, effort, range, shaft: 1.0 }).ok()?;
        }
        set_shafts(rig, &mut dofs);
        let now = Pose::new(nq, nv);
        let mut path = Self { parts: parts(tree)?, dofs, dt_s, from: now.clone(), now };
        let mut home: Vec<f32, DOFS> = Vec::new();
        home.extend(rig.dofs().iter().map(|dof| dof.home).take(DOFS));
        let mut at: Pose<DOFS, COORDS> = Pose::new(nq, nv);
        path.coordinates(&home, at.q_mut());
        path.place(at.q());
        Some(path)
    }

    /// Returns the commanded pose.
    pub(super) fn now(&self) -> &Pose<DOFS, COORDS> {
        &self.now
    }

    /// Converts positions by dof to coordinates; a ball joint's position is its rotation vector.
    pub(super) fn coordinates(&self, dofs: &[f32], q: &mut [f32]) {
        for part in &self.parts {
            match *part {
                JointIndices::Number { q: at, v } => put(q, at, number(dofs, v)),
                JointIndices::Turn { q: at, v } => put_turn(q, at, math::exp(three(dofs, v))),
            }
        }
    }

    /// Converts a pose to positions by dof; a ball joint's position is its rotation vector.
    pub(super) fn positions(&self, q: &[f32], out: &mut [f32]) {
        for part in &self.parts {
            match *part {
                JointIndices::Number { q: at, v } => put(out, v, number(q, at)),
                JointIndices::Turn { q: at, v } => {
                    put_three(out, v, math::log(turn(q, at)));
                }
            }
        }
    }

    /// Computes the commanded pose minus another pose, by dof; for a ball joint in body axes.
    pub(super) fn errors(&self, q: &[f32], out: &mut [f32]) {
        for part in &self.parts {
            match *part {
                JointIndices::Number { q: at, v } => {
                    put(out, v, number(self.now.q(), at) - number(q, at));
                }
                JointIndices::Turn { q: at, v } => {
                    put_three(out, v, between(turn(q, at), turn(self.now.q(), at)));
                }
            }
        }
    }

    /// Returns the dof of the first number of a pose that is outside of its range by more than `slack`. A rig in this
    /// pose cannot be armed.
    pub(super) fn beyond(&self, pose: &[f32], slack: f32) -> Option<usize> {
        self.parts.iter().find_map(|part| match *part {
            JointIndices::Number { q, v } => {
                let at = number(pose, q);
                let held = self.dofs.get(v).map_or(at, |axis| axis.follower.held(at));
                ((held - at).abs() > slack).then_some(v)
            }
            JointIndices::Turn { .. } => None,
        })
    }

    /// Returns the dof that most exceeds a speed of `most_rad_s` at the fastest shaft of its drive, if any does.
    pub(super) fn moving(&self, qd: &[f32], most_rad_s: f32) -> Option<Moving> {
        let (mut farthest, mut found) = (1.0, None);
        for (dof, (axis, rad_s)) in self.dofs.iter().zip(qd).enumerate() {
            let share = rad_s.abs() * axis.shaft / most_rad_s;
            if share > farthest {
                let most = most_rad_s / axis.shaft;
                (farthest, found) = (share, Some(Moving::new(dof, *rad_s, most)));
            }
        }
        found
    }

    /// Returns the ratio of a dof's speed to `most_rad_s` at the fastest shaft of its drive.
    pub(super) fn share(&self, dof: usize, speed: f32, most_rad_s: f32) -> f32 {
        speed.abs() * self.dofs.get(dof).map_or(1.0, |axis| axis.shaft) / most_rad_s
    }

    /// Computes by dof the effort that pushes a pose back from the ends of its ranges, N m or N. Ball joints have no
    /// walls.
    pub(super) fn walls(&self, pose: &[f32], out: &mut [f32]) {
        for part in &self.parts {
            if let JointIndices::Number { q, v } = *part {
                put(out, v, self.dofs.get(v).map_or(0.0, |axis| axis.wall(number(pose, q))));
            }
        }
    }

    /// Writes a pose on the way from the current pose to another. `part` is the share of the way, 0 to 1.
    pub(super) fn between(&self, to: &[f32], part: f32, q: &mut [f32]) {
        let from = self.now.q();
        for own in &self.parts {
            match *own {
                JointIndices::Number { q: at, .. } => {
                    put(q, at, number(from, at) + part * (number(to, at) - number(from, at)));
                }
                JointIndices::Turn { q: at, .. } => {
                    let (from, to) = (turn(from, at), turn(to, at));
                    put_turn(q, at, math::unit(from * math::exp(between(from, to) * part)));
                }
            }
        }
    }

    /// Stops in a pose, clamped to the ranges.
    pub(super) fn place(&mut self, q: &[f32]) {
        let Self { parts, dofs, now, from, .. } = self;
        now.rest();
        for part in parts.iter() {
            match *part {
                JointIndices::Number { q: at, v } => {
                    if let Some(axis) = dofs.get_mut(v) {
                        axis.follower.begin(number(q, at));
                        put(now.q_mut(), at, axis.follower.stop_rad());
                    }
                }
                JointIndices::Turn { q: at, .. } => put_turn(now.q_mut(), at, turn(q, at)),
            }
        }
        from.clone_from(now);
    }

    /// Starts another source: the previous source ends in the pose in which the joints can stop. Ball joints stop
    /// at once.
    pub(super) fn depart(&mut self) -> &Pose<DOFS, COORDS> {
        let Self { parts, dofs, now, from, .. } = self;
        from.clone_from(now);
        from.rest();
        for part in parts.iter() {
            if let JointIndices::Number { q, v } = *part
                && let Some(axis) = dofs.get(v)
            {
                put(from.q_mut(), q, axis.follower.stop_rad());
            }
        }
        from
    }

    /// Moves a dof of a pose by an amount; a numeric coordinate stays within its range.
    pub(super) fn jog(&self, dof: usize, by: f32, q: &mut [f32]) {
        let Some(axis) = self.dofs.get(dof) else { return };
        for part in &self.parts {
            match *part {
                JointIndices::Number { q: at, v } if v == dof => {
                    put(q, at, axis.follower.held(number(q, at) + by));
                }
                JointIndices::Turn { q: at, v } if (v..v.saturating_add(3)).contains(&dof) => {
                    let mut axis = [0.0; 3];
                    put(&mut axis, dof.saturating_sub(v), by);
                    put_turn(q, at, math::unit(turn(q, at) * math::exp(axis.into())));
                }
                _ => {}
            }
        }
    }

    /// Advances by a tick towards a goal. The goal has the weight `weight`, and the end of the previous source has
    /// the rest of the weight. Returns whether the goal is reached. `speed_rad_s` is the maximum speed of a joint;
    /// with `None` only the joints' own limits apply. O(dofs).
    pub(super) fn step(
        &mut self,
        goal: &Pose<DOFS, COORDS>,
        weight: f32,
        speed_rad_s: Option<f32>,
    ) -> bool {
        let Self { parts, dofs, dt_s, from, now } = self;
        let (mut is_there, is_over) = (true, weight >= 1.0);
        let [q, qd, qdd] = now.all_mut();
        for part in parts.iter() {
            match *part {
                JointIndices::Number { q: at, v } => {
                    let Some(axis) = dofs.get_mut(v) else { continue };
                    axis.follower.set_speed(axis.most(speed_rad_s));
                    let (from, to) = (number(from.q(), at), number(goal.q(), at));
                    let wanted = if is_over { to } else { from + weight * (to - from) };
                    let (next, limit) = axis.follower.step(wanted, weight * number(goal.qd(), v));
                    let exact = is_over && limit.is_none();
                    put(q, at, next);
                    put(qd, v, axis.follower.velocity_rad_s());
                    put(qdd, v, if exact { number(goal.qdd(), v) } else { 0.0 });
                    is_there &= (next - to).abs() <= THERE;
                }
                JointIndices::Turn { q: at, v } => {
                    let own = dofs.get(v..v.saturating_add(3)).unwrap_or_default();
                    let most =
                        own.iter().fold(f32::INFINITY, |m, axis| m.min(axis.most(speed_rad_s)));
                    let (from, to) = (turn(from.q(), at), turn(goal.q(), at));
                    let wanted = from * math::exp(between(from, to) * weight);
                    let here = turn(q, at);
                    let (mut way, far) = (between(here, wanted), most * *dt_s);
                    let length = math::length(way);
                    let is_limited = length > far;
                    if is_limited {
                        way *= far / length;
                    }
                    let next = math::unit(here * math::exp(way));
                    let exact = is_over && !is_limited;
                    put_turn(q, at, next);
                    put_three(qd, v, if exact { three(goal.qd(), v) } else { way / *dt_s });
                    put_three(qdd, v, if exact { three(goal.qdd(), v) } else { [0.0; 3].into() });
                    is_there &= math::length(between(next, to)) <= THERE;
                }
            }
        }
        is_there && is_over
    }
}

impl Axis {
    /// Returns the effort that pushes the dof back from the ends of its range. It increases linearly.
    fn wall(&self, at: f32) -> f32 {
        let [least, most] = self.range;
        let (wide, part) = WALL;
        let width = wide.min(part * (most - least));
        let beyond = at - at.max(least + width).min(most - width);
        let effort = -WALL_EFFORT * self.effort * (beyond / width).clamp(-1.0, 1.0);
        // Without a range, or a limit of effort, there is no wall.
        if effort.is_finite() { effort } else { 0.0 }
    }

    /// Returns the maximum speed of the dof: its own, or the speed at which the fastest shaft of its drive turns at
    /// `speed_rad_s`, if that is lower.
    fn most(&self, speed_rad_s: Option<f32>) -> f32 {
        speed_rad_s.map_or(self.speed, |speed| self.speed.min(speed / self.shaft))
    }
}

/// Computes the ratio of the shafts' speed to a joint's speed in the home pose. If several joints turn a shaft, each
/// of them may use its full speed: the ratio is for the sum.
fn set_shafts<const BODIES: usize, const DOFS: usize, const SERVOS: usize>(
    rig: &BoardRig<BODIES, DOFS, SERVOS>,
    axes: &mut [Axis],
) {
    for drive in rig.drives() {
        let mut home = Numbers::new();
        for dof in &drive.dofs {
            let dof = rig.dofs().get(usize::from(*dof));
            // There is room: a drive's number of dofs is limited.
            let _ = home.push(dof.map_or(0.0, |dof| dof.home));
        }
        let Ok(pose) = drive.drive.at_joints(&home) else { continue };
        let mut sums = Numbers::new();
        let _ = sums.resize(drive.servos.len(), 0.0);
        for place in 0..home.len() {
            let mut alone = Numbers::new();
            let _ = alone.resize(home.len(), 0.0);
            put(&mut alone, place, 1.0);
            let Ok(shafts) = pose.servo_velocities(&alone) else { continue };
            sums.iter_mut().zip(&shafts).for_each(|(sum, shaft)| *sum += shaft.abs());
        }
        let fastest = sums.iter().fold(1.0_f32, |most, sum| most.max(*sum));
        for dof in &drive.dofs {
            if let Some(axis) = axes.get_mut(usize::from(*dof)) {
                axis.shaft = fastest;
            }
        }
    }
}
