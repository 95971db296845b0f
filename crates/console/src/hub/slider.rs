//! A joint that follows a slider: computes the speed to send to the board from the slider's goal.

use std::time::Duration;

use super::act::EVERY;

/// Speed per distance from the goal, 1/s; the joint decelerates towards its goal.
const PER_S: f32 = 8.0;
/// Time in which a joint at rest reaches its maximum speed, s, and time in which it brakes from this speed. A servo
/// gets friction and drag in advance; with a faster change of speed, they would move it by a jerk.
const RISE_S: f32 = 0.15;
const BRAKE_S: f32 = 0.04;
/// Distance from the goal at which it counts as reached, rad or m.
const THERE: f32 = 2e-4;
/// Longest time for which the board uses a speed, s.
const VALID_S: f32 = 0.2;
/// Time at the goal after which the joint's position is taken from the board. Before it, the joint may still be
/// approaching the goal, so that its position is of no use.
const SETTLED: Duration = Duration::from_millis(1500);
/// Time without a message of the slider after which the joint stops.
const SILENT: Duration = Duration::from_millis(150);

/// A slider that is held, and the motion of its joint.
#[derive(Debug, Clone)]
pub(super) struct Slider {
    /// Index of the dof.
    pub(super) dof: usize,
    /// Index of the dof's coordinate in a pose.
    pub(super) coordinate: usize,
    goal: f32,
    range: [f32; 2],
    most: f32,
    /// Position that the board commands, computed from the speeds that it got.
    at: f32,
    velocity: f32,
    /// Whether the velocity does not yet have the value that the distance from the goal needs.
    changes: bool,
    told: Duration,
    fed: Duration,
    /// Time at which the joint reached its goal.
    still: Duration,
    /// Pose of the rig, if other joints follow this joint; otherwise empty.
    pose: Vec<f32>,
}

impl Slider {
    /// Starts at a commanded position. `most`: the maximum speed, rad/s or m/s.
    pub(super) fn new(
        (dof, coordinate): (usize, usize),
        at: f32,
        (range, most): ([f32; 2], f32),
        now: Duration,
    ) -> Self {
        let at = at.clamp(range[0], range[1]);
        let (velocity, goal) = (0.0, at);
        // The first speed is that of a joint that has started to move an interval ago.
        let told = now.saturating_sub(EVERY);
        let (fed, still, pose, changes) = (now, now, Vec::new(), false);
        Self { dof, coordinate, goal, range, most, at, velocity, changes, told, fed, still, pose }
    }

    /// Makes the slider send poses instead of speeds, because other joints follow its joint. `pose`: present pose of
    /// the rig.
    pub(super) fn lead(&mut self, pose: Vec<f32>) {
        self.pose = pose;
    }

    /// Returns the rig's pose with the present position of the slider's joint; `None` if no other joint follows this
    /// joint. The caller must move the followers in this pose.
    pub(super) fn pose(&self) -> Option<Vec<f32>> {
        let mut pose = self.pose.clone();
        *pose.get_mut(self.coordinate)? = self.at;
        Some(pose)
    }

    /// Sets the goal, and returns whether it is another goal than before. The page repeats its message while the slider
    /// is held.
    pub(super) fn feed(&mut self, goal: f32, now: Duration) -> bool {
        let goal = goal.clamp(self.range[0], self.range[1]);
        let is_new = (goal - self.goal).abs() > 0.0;
        (self.goal, self.fed) = (goal, now);
        is_new
    }

    /// Returns whether the page has sent nothing for too long.
    pub(super) fn is_silent(&self, now: Duration) -> bool {
        now.saturating_sub(self.fed) >= SILENT
    }

    /// Returns the speed to send, rad/s or m/s. `commanded`: the position that the board commands by its telemetry.
    pub(super) fn velocity(&mut self, commanded: Option<f32>, now: Duration) -> f32 {
        let since_s = now.saturating_sub(self.told).as_secs_f32().min(VALID_S);
        self.at = (self.at + self.velocity * since_s).clamp(self.range[0], self.range[1]);
        self.told = now;
        if now.saturating_sub(self.still) >= SETTLED
            && let Some(commanded) = commanded.filter(|at| at.is_finite())
        {
            (self.at, self.still) = (commanded, now);
        }
        let far = self.goal - self.at;
        if far.abs() <= THERE {
            (self.velocity, self.changes) = (0.0, false);
            return self.velocity;
        }
        self.still = now;
        let wanted = (far * PER_S).clamp(-self.most, self.most);
        let [rise, brake] = [RISE_S, BRAKE_S].map(|time_s| self.most / time_s * since_s);
        let way = if self.velocity < 0.0 { -1.0 } else { 1.0 };
        let before = way * self.velocity;
        self.velocity = way * (way * wanted).clamp((before - brake).max(-rise), before + rise);
        self.changes = (self.velocity - wanted).abs() > 0.0;
        self.velocity
    }

    /// Returns whether the joint is still changing its speed, as of the last call of [`Self::velocity`].
    pub(super) fn changes(&self) -> bool {
        self.changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn a_slider_leads_to_its_goal_within_speed_and_range() {
        let mut slider = Slider::new((0, 0), 0.0, ([-1.0, 0.5], 0.35), ms(0));
        let mut at = 0.0_f32;
        for k in 0..300 {
            slider.feed(2.0, ms(20 * k));
            let velocity = slider.velocity(None, ms(20 * k));
            assert!(velocity.abs() <= 0.35 && velocity >= 0.0);
            at += 0.02 * velocity;
        }
        assert!((at - 0.5).abs() < 1e-3, "{at}");
    }

    #[test]
    fn a_joint_starts_and_turns_round_gradually() {
        let mut slider = Slider::new((0, 0), 0.0, ([-1.0, 1.0], 0.3), ms(100));
        assert!(slider.feed(0.9, ms(100)) && !slider.feed(0.9, ms(100)));
        let mut speeds = |goal: f32, from: u64| {
            slider.feed(goal, ms(from));
            [0, 20, 40, 60].map(|later| slider.velocity(None, ms(from + later)))
        };
        let near = |speeds: [f32; 4], expected: [f32; 4]| {
            assert!(speeds.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{speeds:?}");
        };
        near(speeds(0.9, 100), [0.04, 0.08, 0.12, 0.16]);
        near(speeds(-0.9, 180), [0.01, -0.04, -0.08, -0.12]);
        // A new goal arrives 5 ms after the last speed was sent.
        near(speeds(0.9, 245), [-0.0825, 0.04, 0.08, 0.12]);
    }

    #[test]
    fn a_joint_at_rest_is_where_the_board_says() {
        let mut slider = Slider::new((0, 0), 0.2, ([-1.0, 1.0], 0.35), ms(0));
        slider.feed(0.2, ms(0));
        assert!(slider.velocity(Some(0.19), ms(20)).abs() < 1e-6);
        assert!(slider.velocity(Some(0.19), ms(1600)) > 0.05);
    }

    #[test]
    fn a_page_that_falls_silent_is_noticed() {
        let mut slider = Slider::new((0, 0), 0.0, ([-1.0, 1.0], 0.35), ms(0));
        slider.feed(0.5, ms(100));
        assert!(!slider.is_silent(ms(249)) && slider.is_silent(ms(250)));
    }
}
