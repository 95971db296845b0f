//! A generator of positions that follow a target within limits of range, speed and acceleration.

use sinew_core::math;
use sinew_rig::servo::Servo;

use super::Limit;

/// Maximum distance from the target, rad, at which the result counts as not limited: the rounding of f32 after
/// several turns.
const NEAR_RAD: f32 = 1e-5;

/// Number of braking ticks beyond which parts of a tick are below the rounding of f32.
const MANY_TICKS: f32 = 1e5;

/// Follows a target. Its position is equal to the target whenever the limits allow that, and it brakes in time for the
/// ends of the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Follower {
    range_rad: [f32; 2],
    speed_rad_s: f32,
    acceleration_rad_s2: f32,
    dt_s: f32,
    position_rad: f32,
    velocity_rad_s: f32,
}

impl Follower {
    /// Creates a follower at rest at the servo's zero, or at the nearest end of its range.
    pub(super) fn new(servo: &Servo, dt_s: f32) -> Self {
        let own = servo.settings();
        Self::within(own.range_rad, own.speed_rad_s, own.acceleration_rad_s2, dt_s)
    }

    /// Creates a follower with any limits. For a prismatic joint, all values are in m instead of rad.
    pub(crate) fn within(
        range_rad: [f32; 2],
        speed_rad_s: f32,
        acceleration_rad_s2: f32,
        dt_s: f32,
    ) -> Self {
        let (position_rad, velocity_rad_s) = (0.0, 0.0);
        let mut follower = Self {
            range_rad,
            speed_rad_s,
            acceleration_rad_s2,
            dt_s,
            position_rad,
            velocity_rad_s,
        };
        follower.begin(0.0);
        follower
    }

    /// Sets the maximum speed. A lower maximum applies at once, without braking: a caller that asks for less must not
    /// wait.
    pub(crate) fn set_speed(&mut self, speed_rad_s: f32) {
        self.speed_rad_s = speed_rad_s;
        self.velocity_rad_s = self.velocity_rad_s.max(-speed_rad_s).min(speed_rad_s);
    }

    /// Returns the position at which the follower would stop if it brakes from now on, rad.
    pub(crate) fn stop_rad(&self) -> f32 {
        let v = self.velocity_rad_s;
        // At rest, and with an acceleration of zero, the division is not finite: the braking distance is then zero.
        let way = 0.5 * v * v.abs() / self.acceleration_rad_s2;
        self.held(self.position_rad + if way.is_finite() { way } else { 0.0 })
    }

    /// Clamps a position to the range, rad.
    pub(crate) fn held(&self, position_rad: f32) -> f32 {
        let [least, most] = self.range_rad;
        position_rad.max(least).min(most)
    }

    /// Returns the current position, rad.
    pub(super) fn position_rad(&self) -> f32 {
        self.position_rad
    }

    /// Returns the current speed, rad/s.
    pub(crate) fn velocity_rad_s(&self) -> f32 {
        self.velocity_rad_s
    }

    /// Restarts at rest at a position, or at the nearest end of the range, rad.
    pub(crate) fn begin(&mut self, own_rad: f32) {
        let [least, most] = self.range_rad;
        self.position_rad = own_rad.max(least).min(most);
        self.velocity_rad_s = 0.0;
    }

    /// Advances by a tick. Returns the position at its end, rad, and the limit that was reached, if any.
    pub(crate) fn step(&mut self, target_rad: f32, velocity_rad_s: f32) -> (f32, Option<Limit>) {
        let ([least, most], dt_s) = (self.range_rad, self.dt_s);
        let mut goal = Clamped { value: target_rad, limit: None };
        goal.within([least, most], Limit::Range);
        let moves_rad_s = if goal.limit.is_some() { 0.0 } else { velocity_rad_s };
        // The distance is relative to the target, which keeps moving.
        let way_rad = goal.value - (self.position_rad + moves_rad_s * dt_s);
        let brakes = self.brakes(way_rad.abs());
        let mut speed = Clamped { value: way_rad / dt_s, limit: goal.limit };
        speed.within([-brakes, brakes], Limit::Acceleration);
        speed.value += moves_rad_s;
        speed.within([-self.speed_rad_s, self.speed_rad_s], Limit::Speed);
        let ends = [-self.brakes(self.position_rad - least), self.brakes(most - self.position_rad)];
        speed.within(ends, Limit::Acceleration);
        let change = self.acceleration_rad_s2 * dt_s;
        let near = [self.velocity_rad_s - change, self.velocity_rad_s + change];
        speed.within(near, Limit::Acceleration);

        self.velocity_rad_s = speed.value;
        self.position_rad = (self.position_rad + speed.value * dt_s).max(least).min(most);
        let is_there = (self.position_rad - target_rad).abs() <= NEAR_RAD;
        (self.position_rad, speed.limit.filter(|_| !is_there))
    }

    /// Returns the maximum speed from which the follower can stop within a distance, in whole ticks of full braking.
    /// With n ticks, `way = dt (n v - a dt n (n - 1) / 2)`.
    fn brakes(&self, way_rad: f32) -> f32 {
        if self.acceleration_rad_s2 == f32::INFINITY {
            return f32::INFINITY;
        }
        let change = self.acceleration_rad_s2 * self.dt_s;
        let ways = way_rad.max(0.0) / (change * self.dt_s);
        if ways.is_nan() || change <= 0.0 {
            return 0.0;
        }
        // The number of ticks need not be whole; for many ticks the rounding makes no difference.
        let ticks = math::sqrt(0.25 + 2.0 * ways) - 0.5;
        if ticks > MANY_TICKS {
            return change * ticks;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to MANY_TICKS; parts are to go"
        )]
        let whole = (ticks as u32).saturating_add(1) as f32;
        change * (ways / whole + 0.5 * (whole - 1.0))
    }
}

/// A value with the last limit that changed it.
struct Clamped {
    value: f32,
    limit: Option<Limit>,
}

impl Clamped {
    fn within(&mut self, [least, most]: [f32; 2], limit: Limit) {
        let held = self.value.max(least).min(most);
        if (held - self.value).abs() > 0.0 {
            *self = Self { value: held, limit: Some(limit) };
        }
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may fail by panicking")]
mod tests {
    use proptest::prelude::*;
    use sinew_rig::servo::{ServoSettings, SignalLoss};

    use super::*;

    fn follower(speed: f32, acceleration: f32, dt_s: f32) -> Follower {
        let servo = Servo::new(ServoSettings {
            gear: 1.0,
            offset_rad: 0.0,
            range_rad: [-1.0, 2.0],
            torque_nm: 1.0,
            speed_rad_s: speed,
            acceleration_rad_s2: acceleration,
            torque_constant_nm_a: 1.0,
            position_gain_nm_rad: 1.0,
            friction_nm: 0.0,
            damping_nm_s: 0.0,
            rotor_inertia_kg_m2: 0.0,
            on_signal_loss: SignalLoss::Limp,
        });
        Follower::new(&servo.unwrap(), dt_s)
    }

    proptest! {
        #[test]
        fn nothing_leaves_range_speed_or_acceleration(
            speed in 0.0_f32..20.0,
            acceleration in prop::sample::select(&[0.0, 3.0, 50.0, 1e4, f32::INFINITY][..]),
            dt_s in 0.001_f32..0.02,
            targets in prop::collection::vec((-1e6_f32..1e6, -1e6_f32..1e6), 1..40),
            near in prop::collection::vec((-3.0_f32..3.0, -10.0_f32..10.0), 1..40),
        ) {
            let mut follower = follower(speed, acceleration, dt_s);
            let (mut at, mut before) = (0.0, 0.0);
            for (target, velocity) in targets.into_iter().chain(near) {
                let (next, _) = follower.step(target, velocity);
                prop_assert!((-1.0..=2.0).contains(&next));
                // Rounding of a position close to 2 is 1.2e-7 rad; rounding of a speed is that value divided by a
                // tick.
                let (moved, rounding) = ((next - at) / dt_s, 5e-7 / dt_s);
                prop_assert!(moved.abs() <= speed + rounding, "{moved} rad/s");
                let changed = (moved - before).abs();
                prop_assert!(changed <= acceleration * dt_s * 1.001 + 4.0 * rounding, "{changed} rad/s at once");
                (at, before) = (next, moved);
            }
        }

        #[test]
        fn a_target_within_its_limits_is_met(phase in 0.0_f32..6.0, dt_s in 0.001_f32..0.02) {
            // A sine of 0.8 rad at 2 rad/s has a maximum speed of 1.6 rad/s and a maximum acceleration of 3.2
            // rad/s².
            let mut follower = follower(3.0, 10.0, dt_s);
            for tick in 0..1000_u16 {
                let angle = phase + 2.0 * dt_s * f32::from(tick);
                let (target, velocity) = (0.5 + 0.8 * libm::sinf(angle), 1.6 * libm::cosf(angle));
                let (at, limit) = follower.step(target, velocity);
                // The follower may take 3 s to catch up.
                if f32::from(tick) * dt_s > 3.0 {
                    prop_assert!((at - target).abs() <= 1e-5, "{at} for {target}");
                    prop_assert_eq!(limit, None);
                }
            }
        }
    }

    #[test]
    fn it_says_what_limits_it() {
        let mut fast = follower(3.0, f32::INFINITY, 0.01);
        assert_eq!(fast.step(0.03, 0.0), (0.03, None));
        assert_eq!(fast.step(1.0, 0.0).1, Some(Limit::Speed));
        let mut smooth = follower(3.0, 10.0, 0.01);
        assert_eq!(smooth.step(0.5, 0.0).1, Some(Limit::Acceleration));
        let mut at_end = follower(100.0, f32::INFINITY, 0.01);
        at_end.begin(5.0);
        assert_eq!(at_end.step(2.5, 1.0), (2.0, Some(Limit::Range)));
    }
}
