//! Lowering: each joint goes down slowly, as `docs/lowering.md` describes.

use heapless::Vec;
use sinew_rig::board::BoardRig;

use super::controller::Readings;
use super::coordinates::{number, put};
use super::feed::Sources;
use super::path::Path;
use super::performance::Performance;
use super::report::filled;
use super::watch::Watch;
use crate::supervisor::Settings;

/// Ratio of a joint's target speed to its maximum speed. It is below 1, because static friction may release a joint
/// suddenly.
const PACE: f32 = 0.7;
/// Ratio of a lowered goal's speed to the target speed. It is below 1, so that a servo that sticks can catch up.
const LED: f32 = 0.7;
/// Rate at which more of the weight is carried again, per excess of a joint's speed over the target speed, 1/s.
const BACK_PER_S: f32 = 3.0;
/// Minimum of the released part of a weight. It is negative, so that a joint that was too fast keeps its whole weight
/// for a moment.
const LEAST_LOWERED: f32 = -0.25;
/// A joint rests if its speed is below this part of the target speed. The rig is down after all joints have rested
/// for a third of the fading time.
const RESTS: f32 = 0.1;
const RESTED: f32 = 1.33;
/// Maximum distance of a lowered goal ahead of its servo, rad.
const LEAD_RAD: f32 = 0.07;
/// Weight below which a joint's goal is lowered more slowly, as a part of the joint's maximum effort; and the
/// maximum of this weight, N m or N.
const SLIGHT: f32 = 0.01;
const SLIGHT_MOST: f32 = 0.03;
/// Minimum of the weight of `SLIGHT`, N m or N.
const LEAST_NM: f32 = 1e-6;

/// Released part of the weight of each dof, while the rig is lowered.
#[derive(Debug)]
pub(super) struct Lowering<const DOFS: usize> {
    released: Vec<f32, DOFS>,
}

/// Parts of the controller that a rig is lowered with.
pub(super) struct Parts<
    'p,
    'a,
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
> {
    pub(super) rig: &'p BoardRig<BODIES, DOFS, SERVOS>,
    pub(super) path: &'p mut Path<DOFS, COORDS>,
    pub(super) sources: &'p mut Sources<'a, DOFS, COORDS>,
    pub(super) performance: &'p Performance<'a, BODIES, DOFS, SERVOS>,
    pub(super) readings: &'p Readings<DOFS, SERVOS, COORDS>,
    pub(super) watch: &'p Watch<DOFS, SERVOS>,
    pub(super) settings: &'p Settings,
    pub(super) dt_s: f32,
}

impl<const DOFS: usize> Lowering<DOFS> {
    /// Creates a state in which nothing is released.
    #[inline]
    pub(super) fn new() -> Self {
        // An array would be created as a whole on the stack, and then moved.
        Self { released: filled(DOFS, 0.0) }
    }

    /// Carries all weights again.
    pub(super) fn reset(&mut self) {
        self.released.fill(0.0);
    }

    /// Returns the released part of each dof's weight.
    pub(super) fn released(&self) -> &[f32] {
        &self.released
    }

    /// Releases the weight of each joint while it is slow, and carries more of it while it is fast. Goals of servos
    /// in position mode are moved down, at most a limited distance ahead of their servo. Writes the speed of each
    /// dof: the trusted measured speed for dofs that are braked, the goal's speed for dofs with a goal. The weight of
    /// a dof without a trusted reading is released by time. Returns whether the rig is down.
    // Not inlined into its caller, which has a large stack frame.
    #[inline(never)]
    pub(super) fn step<const BODIES: usize, const SERVOS: usize, const COORDS: usize>(
        &mut self,
        parts: Parts<'_, '_, BODIES, DOFS, SERVOS, COORDS>,
        speeds: &mut [f32; DOFS],
    ) -> bool {
        let Parts { rig, path, sources, performance, readings, watch, settings, dt_s } = parts;
        let Settings { lower_s, lower_rad_s, .. } = *settings;
        let pace = PACE * lower_rad_s;
        let (mut to, mut led) = ([0.0; DOFS], [0.0; DOFS]);
        path.positions(readings.tracked.q(), &mut to);
        let mut is_down = true;
        let dofs = rig.dofs().iter().zip(&readings.dofs).zip(speeds).zip(&mut self.released);
        for (index, (((dof, measured), speed), released)) in dofs.enumerate() {
            let measured = measured.filter(|measured| watch.is_fresh(measured));
            if performance.corrects(index) {
                *speed = measured.map_or(0.0, |measured| measured.velocity);
            } else {
                let least = (SLIGHT * dof.effort).clamp(LEAST_NM, SLIGHT_MOST);
                let down = (-performance.weight(index) / least).clamp(-1.0, 1.0);
                let at = number(&to, index);
                let ahead = measured.map_or(0.0, |measured| at - measured.position);
                let is_held = ahead * down > LEAD_RAD * down.abs();
                let down = if is_held { 0.0 } else { LED * pace * down };
                put(&mut led, index, down);
                put(&mut to, index, at + dt_s * down);
                *speed = number(path.now().qd(), index);
            }
            let share = path.share(index, *speed, pace);
            // From 1 on nothing is carried: the joint must rest for a while longer.
            let most = if share < RESTS { RESTED } else { 1.0 };
            // A joint that moves up, pushed by a hand for example, gets no help.
            let left = if *speed * performance.weight(index) > 0.0 { 1.0 } else { 1.0 - share };
            let is_slow = left > 0.0 && *released >= 0.0;
            let rate = if is_slow { 1.0 / lower_s.max(dt_s) } else { BACK_PER_S };
            *released = (*released + dt_s * rate * left).max(LEAST_LOWERED).min(most);
            is_down &= *released >= RESTED;
        }
        let goal = sources.lower();
        path.coordinates(&to, goal.q_mut());
        let [_, qd, _] = goal.all_mut();
        qd.iter_mut().zip(led).for_each(|(qd, led)| *qd = led);
        path.step(goal, 1.0, Some(pace));
        is_down
    }
}
