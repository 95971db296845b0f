//! From a goal to a trajectory with limited speed and acceleration.

/// Where the trajectory is. Units are the caller's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Profile {
    /// Position.
    pub position: f64,
    /// Speed.
    pub velocity: f64,
    /// Acceleration.
    pub acceleration: f64,
}

impl Profile {
    /// At rest somewhere.
    pub fn at(position: f64) -> Self {
        Self { position, ..Self::default() }
    }

    /// Time passes, on the way to `goal`. Infinite limits are none: the trajectory is at its goal at once. It brakes in
    /// time, and may start again from any state.
    pub fn step(&mut self, goal: f64, speed: f64, acceleration: f64, dt: f64) {
        let way = goal - self.position;
        // The fastest speed from which it can still stop: v²/2a and half a step of travel are left.
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

    /// Time passes, on the way to a speed.
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
        // 0.25 s each for the ramps, and 100/50 - 0.25 s between their middles; a few steps to creep in.
        assert!((time - 2.25).abs() < 0.02, "{time}");
    }

    #[test]
    fn without_limits_it_is_there_at_once() {
        let mut profile = Profile::at(3.0);
        profile.step(7.0, f64::INFINITY, f64::INFINITY, 1e-3);
        assert_eq!(profile.position.to_bits(), 7.0_f64.to_bits());
    }
}
