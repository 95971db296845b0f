//! The drives of a run: friction feed-forward and latency.

use std::collections::VecDeque;

use sinew_core::Wrench;
use sinew_core::control::Limited;
use sinew_figure::plant::{Drive, Pose};
use sinew_rig::mechanism::Link;

use super::disturbance::Disturbance;
use super::friction::FrictionFeed;
use super::reference::Performance;

/// The drives of all joints. They convert the controller's wrenches to the wrenches that act on the plant.
pub(super) struct Drives {
    friction: Option<FrictionFeed>,
    delay: DelayLine,
    wanted: Vec<Wrench>,
    drive: Drive,
}

impl Drives {
    pub(super) fn new(links: &[Link], disturbance: &Disturbance) -> Self {
        Self {
            friction: FrictionFeed::new(links, disturbance.torque_limit_nm),
            delay: DelayLine::new(disturbance.latency_steps),
            wanted: Vec::new(),
            drive: Drive::none(links.len()),
        }
    }

    /// Accepts the desired wrenches of a frame, in body axes, and computes those that act now on the bodies at these
    /// poses. Returns the number of joints that did not receive their desired wrench.
    pub(super) fn act(
        &mut self,
        performance: &Performance<'_>,
        frame: usize,
        torques: &[Limited<Wrench>],
        poses: &[Pose],
    ) -> usize {
        let mut limited = torques.iter().filter(|torque| torque.reason.is_some()).count();
        self.wanted.clear();
        self.wanted.extend(torques.iter().map(|torque| torque.value));
        if let Some(friction) = &mut self.friction {
            limited += friction.add(performance, frame, &mut self.wanted);
        }
        let arriving = self.delay.pass(self.wanted.iter().copied());
        set_drive(&mut self.drive, arriving, poses);
        limited
    }

    /// Returns the wrenches that act now.
    pub(super) fn drive(&self) -> &Drive {
        &self.drive
    }
}

/// Rotates wrenches from body axes to world axes.
fn set_drive(drive: &mut Drive, wanted: &[Wrench], poses: &[Pose]) {
    let drives = drive.torque_nm.iter_mut().zip(&mut drive.force_n);
    for ((wanted, pose), (torque_nm, force_n)) in wanted.iter().zip(poses).zip(drives) {
        *torque_nm = pose.rotation * wanted.moment_nm.as_dvec3();
        *force_n = pose.rotation * wanted.force_n.as_dvec3();
    }
}

/// A queue of torques that have not yet arrived at the drives. Its length is the latency in steps. The torques are in
/// body axes, since a motor keeps its torque while its body turns.
struct DelayLine {
    steps: usize,
    waiting: VecDeque<Vec<Wrench>>,
}

impl DelayLine {
    fn new(steps: usize) -> Self {
        Self { steps, waiting: VecDeque::with_capacity(steps + 1) }
    }

    /// Queues the torques that are desired now. Returns the torques that arrive now.
    fn pass(&mut self, wanted: impl Iterator<Item = Wrench>) -> &[Wrench] {
        let mut slot = if self.waiting.len() > self.steps {
            self.waiting.pop_front().unwrap_or_default()
        } else {
            Vec::new()
        };
        slot.clear();
        slot.extend(wanted);
        self.waiting.push_back(slot);
        &self.waiting[0]
    }
}

#[cfg(test)]
mod tests {
    use sinew_core::glam::Vec3;

    use super::*;

    #[test]
    fn torques_arrive_late_and_the_first_is_held() {
        let arrivals = |steps: usize| {
            let mut line = DelayLine::new(steps);
            [1_u8, 2, 3, 4, 5].map(|n| {
                let wrench = Wrench::new(Vec3::X * f32::from(n), Vec3::ZERO);
                line.pass([wrench].into_iter())[0].moment_nm.x.to_bits()
            })
        };
        let bits = |numbers: [u8; 5]| numbers.map(|n| f32::from(n).to_bits());
        assert_eq!(arrivals(0), bits([1, 2, 3, 4, 5]));
        assert_eq!(arrivals(1), bits([1, 1, 2, 3, 4]));
        assert_eq!(arrivals(3), bits([1, 1, 1, 1, 2]));
    }
}
