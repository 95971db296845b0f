//! A curve through poses, and its distances from the ends of ranges.

use nalgebra::DVector;

use super::joint::JointPosition;
use super::limit::Limit;
use super::rig::{Rig, RigPose};

/// A curve, and the positions of the joints along it.
pub(super) struct Curve {
    pub(super) poses: Vec<Vec<JointPosition>>,
    pub(super) placed: Vec<RigPose>,
    /// Limits of each inner pose.
    pub(super) limits: Vec<Vec<Limit>>,
    pub(super) energy_m2: f64,
}

impl Curve {
    pub(super) fn new(rig: &Rig, poses: Vec<Vec<JointPosition>>) -> Self {
        let placed: Vec<_> = poses.iter().map(|pose| rig.place(pose)).collect();
        let energy_m2 =
            placed.windows(2).map(|pair| (&pair[1].f - &pair[0].f).norm_squared()).sum();
        let limits = poses[1..poses.len() - 1].iter().map(|pose| rig.limits(pose)).collect();
        Self { poses, placed, limits, energy_m2 }
    }

    /// Returns the inner poses, without the two ends.
    pub(super) fn inner(&self) -> &[RigPose] {
        &self.placed[1..self.placed.len() - 1]
    }

    pub(super) fn length_m(&self) -> f64 {
        self.placed.windows(2).map(|pair| (&pair[1].f - &pair[0].f).norm()).sum()
    }

    /// Returns the curve with its inner poses moved into all ranges, at least the share `margin` of each range's width
    /// away from the range's ends. The two end poses are unchanged.
    pub(super) fn within(&self, rig: &Rig, margin: f64) -> Self {
        let mut poses = self.poses.clone();
        let last = poses.len() - 1;
        for pose in &mut poses[1..last] {
            *pose = rig.within(pose, margin);
        }
        Self::new(rig, poses)
    }

    /// Sets the force of each limit so that its product with the limit's gap is `height`.
    pub(super) fn push(&mut self, height: f64) {
        for limit in self.limits.iter_mut().flatten() {
            limit.force = height / limit.gap;
        }
    }

    /// Returns the curve after a step, and the share of the step that was made: below 1 if the whole step would not
    /// leave a part of every gap. Forces are those after the whole step, to first order, with barriers of this height.
    pub(super) fn stepped(&self, rig: &Rig, step: &[DVector<f64>], height: f64) -> (Self, f64) {
        let along = || {
            let poses = self.limits.iter().zip(step);
            poses.flat_map(|(limits, step)| limits.iter().map(|limit| (limit, step[limit.column])))
        };
        let mut share = along().map(|(limit, step)| limit.share(step)).fold(1.0, f64::min);
        let mut next = self.moved(rig, step, share);
        // Curved gaps decrease more than their slopes predict.
        let is_inside = |next: &Self| {
            let gaps = next.limits.iter().flatten().zip(self.limits.iter().flatten());
            gaps.into_iter().all(|(after, before)| after.is_left(before))
        };
        while !is_inside(&next) && share > 0.0 {
            share *= 0.5;
            next = self.moved(rig, step, share);
        }
        for (after, (before, step)) in next.limits.iter_mut().flatten().zip(along()) {
            after.force = before.force_after(step, height);
        }
        (next, share)
    }

    fn moved(&self, rig: &Rig, step: &[DVector<f64>], share: f64) -> Self {
        let mut poses = self.poses.clone();
        for ((pose, at), step) in poses[1..].iter_mut().zip(self.inner()).zip(step) {
            *pose = rig.stepped(pose, at, (step * share).as_slice());
        }
        Self::new(rig, poses)
    }

    /// Returns the decrease of the energy to the next curve, including the energy of barriers of this height:
    /// `-height ln gap` for each limit.
    pub(super) fn gain_m2(&self, next: &Self, height: f64) -> f64 {
        let gaps = next.limits.iter().flatten().zip(self.limits.iter().flatten());
        let closer: f64 = gaps.map(|(after, before)| libm::log(after.gap / before.gap)).sum();
        self.energy_m2 - next.energy_m2 + height * closer
    }
}
