//! The last check of a command before the bus. It shares no code with the drives' own limits, so that a mistake in
//! one of them is not in the other.

mod settings;

pub use settings::{GoalLimits, GuardLimits, GuardReason, GuardSettings, VoltageLimits};

use settings::FADE_S;
use sinew_servo_bus::{Command, Feedback};

use super::Permission;
use crate::SettingError;
use crate::drives::Condition;

/// Rounding of a position in f32, and of the sums that lead to it, rad.
const ROUNDING_RAD: f32 = 1e-5;
/// Maximum ratio of a profile's speed to its goal's speed: the drive's ratio plus a tolerance for rounding.
const HASTE: f32 = 1.2;
/// Factor and offset, rad/s, by which a measured speed may exceed the limit: noise of velocities.
const OVERSPEED: (f32, f32) = (1.25, 0.1);
/// Limits the commands of a servo, tick by tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guard {
    settings: GuardSettings,
    dt_s: f32,
    sent: Option<Sent>,
}

/// The last goal and its velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sent {
    own_rad: f32,
    velocity_rad_s: f32,
}

/// The permitted command, and the reason if it was changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guarded {
    /// Command for the bus; `None` if nothing may be sent.
    pub command: Option<Command>,
    /// Reason for which the guard changed or refused the command.
    pub reason: Option<GuardReason>,
}

impl Guard {
    /// Creates the guard of a servo, for ticks of `dt_s`.
    ///
    /// # Errors
    /// [`SettingError`] names the invalid setting.
    pub fn new(settings: GuardSettings, dt_s: f32) -> Result<Self, SettingError> {
        SettingError::check("dt_s", dt_s, [1e-4, 1.0])?;
        settings.check()?;
        Ok(Self { settings, dt_s, sent: None })
    }

    /// Checks a command and returns the permitted one. Call it once per tick and servo, with the servo's last reading.
    /// O(1).
    pub fn check(
        &mut self,
        command: Command,
        condition: &Condition,
        permission: &Permission,
    ) -> Guarded {
        let feedback = condition
            .feedback
            .filter(|read| read.position_rad.is_finite() && read.velocity_rad_s.is_finite());
        if command == Command::Torque(false) {
            self.sent = None;
            return Guarded { command: Some(command), reason: None };
        }
        if !permission.torque {
            self.sent = None;
            return Guarded { command: None, reason: Some(GuardReason::NotAllowed) };
        }
        let is_finite = match command {
            Command::Position(a) | Command::Current(a) | Command::Pwm(a) => a.is_finite(),
            Command::PositionWithin { position_rad: a, current_a: b }
            | Command::PositionAt { position_rad: a, speed_rad_s: b } => (a + b).is_finite(),
            _ => true,
        };
        if !is_finite {
            return Guarded { command: None, reason: Some(GuardReason::NotFinite) };
        }
        let fresh = feedback.filter(|read| self.age_s(*read) <= self.settings.stale_s);
        let (command, reason) = match (command, self.settings.limits) {
            (Command::Torque(_) | Command::Stiffness(_), _) => (command, None),
            (Command::Position(_) | Command::PositionAt { .. }, GuardLimits::Goal(goal))
                if self.sent.is_none() && goal.tells && fresh.is_none() =>
            {
                return Guarded { command: None, reason: Some(GuardReason::Stale) };
            }
            (Command::Position(rad), GuardLimits::Goal(goal)) => {
                let (rad, reason) = self.position(&goal, rad, feedback, permission);
                (Command::Position(rad), reason)
            }
            (Command::PositionAt { position_rad, speed_rad_s }, GuardLimits::Goal(goal)) => {
                let (position_rad, reason) =
                    self.position(&goal, position_rad, feedback, permission);
                let speed = self.speed(permission) + goal.offset_rad_s;
                let most = HASTE * speed + ROUNDING_RAD / self.dt_s;
                let (speed_rad_s, fast) = within(speed_rad_s, [0.0, most], GuardReason::Speed);
                (Command::PositionAt { position_rad, speed_rad_s }, reason.or(fast))
            }
            (Command::Current(wanted_a), GuardLimits::Current { most_a }) => {
                let (held_a, reason) = self.effort(wanted_a, fresh, permission, |_| {
                    // A tolerance of 1e-6 allows for the rounding of the drive's own limit.
                    let most_a = most_a * permission.effort * (1.0 + 1e-6);
                    (0.0, [-most_a, most_a], GuardReason::Current)
                });
                (Command::Current(held_a), reason)
            }
            (Command::Pwm(wanted), GuardLimits::Voltage(limits)) => {
                let (held, reason) = self.effort(wanted, fresh, permission, |read| {
                    // A tolerance of 1e-4 s allows for rounding.
                    let old_s = self.settings.stale_s - FADE_S - 1e-4;
                    let is_blind = condition.temperature_c.is_none() || self.age_s(read) > old_s;
                    let (coasting, ends) = limits.parts(
                        read.velocity_rad_s,
                        condition.supply_v,
                        self.settings.speed_rad_s,
                        (permission.effort, is_blind),
                    );
                    (coasting, ends, GuardReason::Voltage)
                });
                (Command::Pwm(held), reason)
            }
            _ => return Guarded { command: None, reason: Some(GuardReason::Kind) },
        };
        Guarded { command: Some(command), reason }
    }

    fn age_s(&self, read: Feedback) -> f32 {
        read.age_ticks as f32 * self.dt_s
    }

    /// Returns the maximum speed of the servo, rad/s: its own, or the permitted speed if that is lower.
    fn speed(&self, permission: &Permission) -> f32 {
        let allowed = permission.speed_rad_s.map(|speed| speed * self.settings.gear);
        allowed.map_or(self.settings.speed_rad_s, |speed| speed.min(self.settings.speed_rad_s))
    }

    /// Limits a goal by the last goal, the measured position and the range. Returns the permitted position on the bus,
    /// rad, and the reason if it was changed.
    fn position(
        &mut self,
        goal: &GoalLimits,
        bus_rad: f32,
        feedback: Option<Feedback>,
        permission: &Permission,
    ) -> (f32, Option<GuardReason>) {
        let GuardSettings { zero_rad, range_rad, .. } = self.settings;
        let wanted_rad = bus_rad - zero_rad;
        let measured = feedback.map(|read| (read.position_rad - zero_rad, read.age_ticks));
        // The first goal starts at the servo's position; for a servo that reports none, at the goal itself.
        let from = self.sent.unwrap_or(Sent {
            own_rad: measured.map_or(wanted_rad, |(own_rad, _)| own_rad),
            velocity_rad_s: 0.0,
        });
        let speed = self.speed(permission) + goal.offset_rad_s;
        let way = wanted_rad - from.own_rad;
        let most = speed * self.dt_s + ROUNDING_RAD;
        let (way, mut reason) = within(way, [-most, most], GuardReason::Speed);

        let along = if way < 0.0 { -from.velocity_rad_s } else { from.velocity_rad_s };
        let gained = goal.acceleration_rad_s2 * self.dt_s + 2.0 * goal.offset_rad_s;
        let most = (along.max(0.0) + gained) * self.dt_s + ROUNDING_RAD;
        let (way, soon) = within(way, [-most, most], GuardReason::Acceleration);
        reason = soon.or(reason);

        let mut own_rad = from.own_rad + way;
        // Towards a servo that is held or pushed, the goal may jump: the servo then pulls less.
        if let Some((measured_rad, age_ticks)) = measured {
            let lead = goal.lead_rad + speed * age_ticks as f32 * self.dt_s;
            let near = [measured_rad - lead, measured_rad + lead];
            let (held, far) = within(own_rad, near, GuardReason::Lead);
            (own_rad, reason) = (held, far.or(reason));
        }
        let (own_rad, beyond) = within(own_rad, range_rad, GuardReason::Range);
        let velocity_rad_s = ((own_rad - from.own_rad) / self.dt_s).max(-speed).min(speed);
        self.sent = Some(Sent { own_rad, velocity_rad_s });

        // A goal that is not limited is sent unchanged, with its own bits.
        let is_held = (wanted_rad - own_rad).abs() > ROUNDING_RAD;
        let goal_rad = if is_held || beyond.is_some() { own_rad + zero_rad } else { bus_rad };
        (goal_rad, beyond.or(reason).filter(|_| is_held))
    }

    /// Limits a current or a part of the supply by the servo's last reading, and returns it with the reason if it was
    /// changed. `limits` returns the command with which the servo coasts, the minimum and maximum command, and the
    /// reason for a command outside of them.
    fn effort(
        &self,
        wanted: f32,
        fresh: Option<Feedback>,
        permission: &Permission,
        limits: impl Fn(Feedback) -> (f32, [f32; 2], GuardReason),
    ) -> (f32, Option<GuardReason>) {
        let GuardSettings { zero_rad, range_rad: [least, most], .. } = self.settings;
        let Some(read) = fresh else {
            let reason = (wanted.abs() > 0.0).then_some(GuardReason::Stale);
            return (0.0, reason);
        };
        let (coasting, ends, much) = limits(read);
        let (mut held, mut reason) = within(wanted, ends, much);
        let (factor, noise_rad_s) = OVERSPEED;
        let fastest = factor * self.speed(permission) + noise_rad_s;
        let own_rad = read.position_rad - zero_rad;
        for (up, down, end, why) in [
            (
                read.velocity_rad_s > fastest,
                read.velocity_rad_s < -fastest,
                coasting,
                GuardReason::Speed,
            ),
            (own_rad > most, own_rad < least, 0.0, GuardReason::Range),
        ] {
            if up && held > end || down && held < end {
                (held, reason) = (end, Some(why));
            }
        }
        (held, reason.filter(|_| (held - wanted).abs() > 0.0))
    }
}

/// Clamps a finite value, and returns it with `reason` if it was changed.
fn within(value: f32, [least, most]: [f32; 2], reason: GuardReason) -> (f32, Option<GuardReason>) {
    let held = value.max(least).min(most);
    (held, ((held - value).abs() > 0.0).then_some(reason))
}
