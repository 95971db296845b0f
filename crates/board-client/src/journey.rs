//! A journey: a motion of all joints to a pose, such as the home pose or a pose of a show.

use std::time::Duration;

/// Longest time that the board, which follows with a delay, may need after the planned end of the motion. The second
/// constant is for a board that does not send the pose that it commands.
const ARRIVE: Duration = Duration::from_secs(20);
const ARRIVE_BLIND: Duration = Duration::from_secs(3);
/// Largest distance of each coordinate from its goal at which a pose counts as reached, rad or m.
const THERE: f32 = 2e-3;
/// Ratio of the profile's peak speed to its mean speed.
const PEAK: f32 = 1.5;

/// A motion from one pose to another, with a smooth start and end.
#[derive(Debug, Clone)]
pub struct Journey {
    from: Vec<f32>,
    to: Vec<f32>,
    /// For each ball joint: the index of the first coordinate of its quaternion.
    balls: Vec<usize>,
    begun: Duration,
    takes: Duration,
}

impl Journey {
    /// Plans a motion. `blocks`: first coordinate and number of coordinates of each joint; `most_rad_s`: the maximum
    /// speed of a joint.
    pub fn new(
        from: &[f32],
        to: &[f32],
        blocks: &[(usize, usize)],
        most_rad_s: f32,
        now: Duration,
    ) -> Self {
        let balls: Vec<usize> =
            blocks.iter().filter(|(_, count)| *count == 4).map(|(first, _)| *first).collect();
        let is_of_ball = |k: usize| balls.iter().any(|first| (*first..first + 4).contains(&k));
        let mut to = to.to_vec();
        let mut most = 0.0_f32;
        for ball in &balls {
            let dot: f32 = (*ball..ball + 4).map(|k| from[k] * to[k]).sum();
            // Both signs are the same rotation: the nearer one is used.
            if dot < 0.0 {
                to[*ball..ball + 4].iter_mut().for_each(|x| *x = -*x);
            }
            most = most.max(2.0 * dot.abs().min(1.0).acos());
        }
        for (k, (a, b)) in from.iter().zip(&to).enumerate() {
            if !is_of_ball(k) {
                most = most.max((a - b).abs());
            }
        }
        let takes = Duration::from_secs_f32((PEAK * most / most_rad_s).clamp(0.1, 600.0));
        Self { from: from.to_vec(), to, balls, begun: now, takes }
    }

    /// Makes the motion last at least this long.
    #[must_use]
    pub fn lasting(self, least: Duration) -> Self {
        Self { takes: self.takes.max(least), ..self }
    }

    /// Returns the planned pose at a time.
    pub fn at(&self, now: Duration) -> Vec<f32> {
        let s = now.saturating_sub(self.begun).div_duration_f32(self.takes).min(1.0);
        let part = s * s * (3.0 - 2.0 * s);
        let mut q: Vec<f32> =
            self.from.iter().zip(&self.to).map(|(a, b)| a + part * (b - a)).collect();
        for ball in &self.balls {
            let own = &mut q[*ball..ball + 4];
            let norm = own.iter().map(|x| x * x).sum::<f32>().sqrt();
            for x in own {
                *x /= norm;
            }
        }
        q
    }

    /// Returns whether the motion is over: its time has passed, and the pose that the board commands has arrived, or
    /// the board had enough time to arrive.
    pub fn is_over(&self, commanded: Option<&[f32]>, now: Duration) -> bool {
        let Some(after) = now.checked_sub(self.begun + self.takes) else { return false };
        let Some(commanded) = commanded else { return after >= ARRIVE_BLIND };
        // A ball joint's quaternion may have the other sign.
        let is_there = |(k, (a, b)): (usize, (&f32, &f32))| {
            let is_ball = self.balls.iter().any(|first| (*first..first + 4).contains(&k));
            (a - b).abs() < THERE || is_ball && (a + b).abs() < THERE
        };
        commanded.iter().zip(&self.to).enumerate().all(is_there) || after >= ARRIVE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_journey_ends_at_its_pose_and_keeps_its_speed() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        // A hinge, and a ball that turns by 90 degrees, of which the goal has the other sign.
        let from = [0.0, 0.0, 0.0, 0.0, 1.0];
        let to = [0.5, -half, 0.0, 0.0, -half];
        let journey = Journey::new(&from, &to, &[(0, 1), (1, 4)], 0.3, Duration::ZERO);
        let mut before = journey.at(Duration::ZERO);
        for k in 1..2000 {
            let q = journey.at(Duration::from_millis(10 * k));
            assert!((q[0] - before[0]).abs() <= 0.3 * 0.0101);
            let norm: f32 = q[1..].iter().map(|x| x * x).sum();
            assert!((norm - 1.0).abs() < 1e-5);
            before = q;
        }
        assert!((before[0] - 0.5).abs() < 1e-6 && (before[1] - half).abs() < 1e-6);
        let s = Duration::from_secs;
        assert!(!journey.is_over(Some(&to), s(1)));
        assert!(journey.is_over(Some(&to), s(12)) && !journey.is_over(Some(&from), s(12)));
        assert!(journey.is_over(None, s(12)) && journey.is_over(Some(&from), s(40)));
    }
}
