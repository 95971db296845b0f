//! Computes a trajectory to a goal with limited speed and acceleration.

/// A point of the trajectory. The caller chooses the units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Profile {
    /// Position on the trajectory.
    pub position: f64,
    /// Speed on the trajectory.
    pub velocity: f64,
    /// Acceleration on the trajectory.
    pub acceleration: f64,
}

impl Profile {
    /// Creates a trajectory at rest at a position.
    pub fn at(position: f64) -> Self {
        Self { position, ..Self::default() }
    }

    /// Advances by `dt` towards `goal`. Infinite limits mean no limits: the trajectory jumps to its goal. The
    /// trajectory brakes in time, and can start from any state.
    pub fn step(&mut self, goal: f64, speed: f64, acceleration: f64, dt: f64) {
        let way = goal - self.position;
        // Maximum speed from which the trajectory can still stop at its goal, after a distance of v²/2a plus half a
        // step of motion.
        let brakes = if acceleration.is_finite() {
            let step = 0.5 * acceleration * dt;
            libm::sqrt(step * step + 2.0 * acceleration * way.abs()) - step
        } else {
            f64::INFINITY
        };
        let wanted = speed.min(brakes).min(way.abs() / dt).copysign(way);
        let before = self.velocity;
        let change = acceleration * dt;
        self.velocity = wanted.clamp(before - change, before + change);
        self.acceleration = (self.velocity - before) / dt;
        self.position += self.velocity * dt;
        if (goal - self.position).abs() <= 1e-9 * (1.0 + goal.abs()) {
            self.position = goal;
        }
    }

    /// Advances by `dt` towards a goal speed.
    pub fn step_speed(&mut self, goal: f64, acceleration: f64, dt: f64) {
        let before = self.velocity;
        let change = acceleration * dt;
        self.velocity = goal.clamp(before - change, before + change);
        self.acceleration = (self.velocity - before) / dt;
        self.position += self.velocity * dt;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_keeps_its_limits_and_arrives_when_a_trapezoid_does() {
        let (mut profile, dt, mut time) = (Profile::at(0.0), 1e-3, 0.0);
        while (profile.position - 100.0).abs() > 0.01 && time < 10.0 {
            profile.step(100.0, 50.0, 200.0, dt);
            assert!(profile.velocity <= 50.0 + 1e-9 && profile.acceleration.abs() <= 200.0 + 1e-6);
            assert!(profile.position <= 100.0 + 1e-6);
            time += dt;
        }
        // 0.25 s for each of the two ramps, and 100/50 - 0.25 s between the ramps; plus a few steps for the end.
        assert!((time - 2.25).abs() < 0.02, "{time}");
    }

    #[test]
    fn without_limits_it_is_there_at_once() {
        let mut profile = Profile::at(3.0);
        profile.step(7.0, f64::INFINITY, f64::INFINITY, 1e-3);
        assert_eq!(profile.position.to_bits(), 7.0_f64.to_bits());
    }
}
