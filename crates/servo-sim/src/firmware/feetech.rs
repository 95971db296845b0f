//! Feetech STS and SMS: modes 0 (position), 1 (speed) and 2 (PWM).

use sinew_servo_bus::feetech::status_bit;

use super::{Debounce, Profile, Sensed};
use crate::model::Power;

/// Counts of a turn.
pub const TURN: i32 = 4096;
/// Counts per s² of one count of acceleration.
pub const ACCELERATION_COUNTS_S2: f64 = 100.0;
/// P Coefficient as shipped, for which the stiffness is known.
const SHIPPED_P: f64 = 32.0;
/// Guess, as for the Dynamixel.
const VOLTAGE_S: f64 = 0.01;

/// What stands in the registers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[expect(missing_docs, reason = "named as in the memory table")]
pub struct Settings {
    /// 0 off, 1 on, 2 damped.
    pub torque: i32,
    pub mode: i32,
    pub position_limits: [i32; 2],
    pub temperature_limit_c: f64,
    pub voltage_limits_v: [f64; 2],
    /// Which errors switch torque off.
    pub unloading: i32,
    pub homing_offset: i32,
    pub p: f64,
    /// Part of the supply.
    pub startup_force: f64,
    pub dead_zone: [f64; 2],
    pub protection_current_a: f64,
    pub protection_current_s: f64,
    pub protective_torque: f64,
    pub protection_s: f64,
    pub overload_torque: f64,
    /// Counts of position a second that one count of speed is.
    pub speed_counts: f64,
    pub acceleration: f64,
    pub goal_position: i32,
    /// Of mode 2: part of the supply.
    pub goal_pwm: f64,
    pub goal_speed: f64,
    pub torque_limit: f64,
}

/// The program's state.
#[derive(Debug, Clone, Default)]
pub struct Firmware {
    /// The registers, as they were when something was last written.
    pub settings: Settings,
    /// Counts that its zero is from the encoder's: whole turns that it forgot, and where it was told that it is.
    pub forgotten: i32,
    /// What its status byte says.
    pub errors: u8,
    /// Where the trajectory is, counts.
    pub profile: Profile,
    /// Part of the supply for an error of one count, with P as shipped.
    duty_per_count: f64,
    /// Fastest speed of its trajectory, counts/s.
    speed_cap: f64,
    was_on: bool,
    overload: Debounce,
    current: Debounce,
    voltage: Debounce,
}

impl Firmware {
    /// A program that has just started. An error of one count makes it apply a part of the supply; its trajectory goes
    /// no faster than `speed_cap` counts/s.
    pub fn new(duty_per_count: f64, speed_cap: f64) -> Self {
        Self { duty_per_count, speed_cap, ..Self::default() }
    }

    /// Starts anew, and forgets whole turns.
    pub fn restart(&mut self, sensed_position: i32) {
        let settings = self.settings;
        *self = Self { settings, ..Self::new(self.duty_per_count, self.speed_cap) };
        self.forgotten = sensed_position.div_euclid(TURN) * TURN;
    }

    /// Present position, counts.
    pub fn position(&self, sensed: &Sensed) -> i32 {
        sensed.position - self.forgotten - self.settings.homing_offset
    }

    /// A new goal ends an overload.
    pub fn take_goal(&mut self) {
        self.errors &= !status_bit::OVERLOAD;
        self.overload = Debounce::default();
    }

    /// Whether an error that unloads is there.
    pub fn is_unloaded(&self) -> bool {
        // An overload does not unload: it makes weak.
        i32::from(self.errors & !status_bit::OVERLOAD) & self.settings.unloading != 0
    }

    /// Moving.
    pub fn is_moving(&self, sensed: &Sensed) -> bool {
        self.profile.velocity != 0.0 || sensed.velocity.abs() > MOVING_COUNTS_S
    }

    /// A tick.
    pub fn tick(&mut self, sensed: &Sensed, dt_s: f64) -> Power {
        self.watch(sensed, dt_s);
        let s = &self.settings;
        if s.torque == 0 || self.is_unloaded() {
            self.was_on = false;
            return Power::Open;
        }
        if s.torque == 2 {
            self.was_on = false;
            return Power::Duty { duty: 0.0, limit_a: f64::INFINITY };
        }
        if !self.was_on {
            self.profile = Profile::at(f64::from(self.position(sensed)));
            self.was_on = true;
        }
        let weak = self.errors & status_bit::OVERLOAD != 0;
        let most = if weak { s.protective_torque.min(s.torque_limit) } else { s.torque_limit };
        let duty = match s.mode {
            2 => s.goal_pwm,
            1 => self.speed_duty(sensed, dt_s),
            _ => self.position_duty(sensed, dt_s),
        };
        Power::Duty { duty: duty.clamp(-most, most), limit_a: f64::INFINITY }
    }

    fn watch(&mut self, sensed: &Sensed, dt_s: f64) {
        let s = &self.settings;
        let [least, most] = s.voltage_limits_v;
        let is_outside = !(least..=most).contains(&sensed.supply_v);
        let is_overloaded = sensed.load.abs() > s.overload_torque;
        let has_current = sensed.current_a.abs() > s.protection_current_a;
        let mut errors = self.errors & status_bit::OVERLOAD;
        for (is_wrong, bit) in [
            (self.voltage.lasts(is_outside, dt_s, VOLTAGE_S), status_bit::VOLTAGE),
            (sensed.case_c >= s.temperature_limit_c, status_bit::TEMPERATURE),
            (self.current.lasts(has_current, dt_s, s.protection_current_s), status_bit::CURRENT),
            (self.overload.lasts(is_overloaded, dt_s, s.protection_s), status_bit::OVERLOAD),
        ] {
            if is_wrong {
                errors |= bit;
            }
        }
        self.errors = errors;
    }

    fn acceleration(&self) -> f64 {
        let counts = self.settings.acceleration;
        if counts > 0.0 { counts * ACCELERATION_COUNTS_S2 } else { f64::INFINITY }
    }

    fn position_duty(&mut self, sensed: &Sensed, dt_s: f64) -> f64 {
        let s = self.settings;
        let [least, most] = s.position_limits;
        // Both 0: several turns.
        let goal = if least < most { s.goal_position.clamp(least, most) } else { s.goal_position };
        let asked = s.goal_speed.abs() * s.speed_counts;
        let speed = if asked > 0.0 { asked.min(self.speed_cap) } else { self.speed_cap };
        self.profile.step(f64::from(goal), speed, self.acceleration(), dt_s);
        self.duty(sensed)
    }

    /// It follows a position that moves on at the speed: no faster than it can follow.
    fn speed_duty(&mut self, sensed: &Sensed, dt_s: f64) -> f64 {
        let s = self.settings;
        let speed = (s.goal_speed * s.speed_counts).clamp(-self.speed_cap, self.speed_cap);
        self.profile.step_speed(speed, self.acceleration(), dt_s);
        let present = f64::from(self.position(sensed));
        let lead = SHIPPED_P / (self.duty_per_count * s.p.max(1.0));
        self.profile.position = self.profile.position.clamp(present - lead, present + lead);
        self.duty(sensed)
    }

    /// P on the error of position. D and I have no part in it: the damping of identified servos (0.56 to 0.6 N m s for
    /// gains as shipped) is that of back-EMF and viscous friction alone, and I is shipped as 0. That Minimum Startup
    /// Force is a least is a guess.
    fn duty(&self, sensed: &Sensed) -> f64 {
        let s = &self.settings;
        let error = self.profile.position - f64::from(self.position(sensed));
        let [clockwise, counter] = s.dead_zone;
        if (-clockwise..=counter).contains(&error) {
            return 0.0;
        }
        let duty = error * self.duty_per_count * s.p / SHIPPED_P;
        duty.abs().max(s.startup_force).copysign(error)
    }
}

/// Guess: below this it does not move.
const MOVING_COUNTS_S: f64 = 50.0;
