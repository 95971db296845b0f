//! Firmware of Dynamixel X and MX(2.0): operating modes 0, 1, 3, 4, 5 and 16.

use sinew_servo_bus::dynamixel::hardware_error;
use sinew_servo_bus::dynamixel::table::drive_mode;

use super::{Debounce, Profile, Sensed};
use crate::model::Power;

/// PWM counts of the full supply voltage.
pub const PWM_COUNTS: f64 = 885.0;
/// Counts of one turn.
pub const TURN: i32 = 4096;
/// Speed of one velocity count, in counts of position per second: 0.229 rev/min.
pub const VELOCITY_COUNTS_S: f64 = 0.229 / 60.0 * 4096.0;
/// Acceleration of one acceleration count, in counts of position per s²: 214.577 rev/min².
pub const ACCELERATION_COUNTS_S2: f64 = 214.577 / 3600.0 * 4096.0;
/// Current, as a part of the stall current, and time, s: a larger current for this time is an overload. This is a
/// guess: the values of Feetech's registers.
const OVERLOAD: (f64, f64) = (0.8, 2.0);
/// Time after which a supply voltage outside its limits is an error, s. This is a guess.
const VOLTAGE_S: f64 = 0.01;
/// Maximum position error that Moving Status reports as "in position", counts. This is a guess.
const IN_POSITION: f64 = 10.0;

/// Contents of the registers, in the registers' counts unless the name contains a unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[expect(missing_docs, reason = "named as in the control table")]
pub struct Settings {
    pub torque_is_on: bool,
    pub mode: i32,
    pub drive_mode: i32,
    pub homing_offset: i32,
    pub moving_threshold: f64,
    pub temperature_limit_c: f64,
    pub voltage_limits_v: [f64; 2],
    pub shutdown: i32,
    pub current_limit_a: f64,
    pub velocity_limit: f64,
    pub pwm_limit: f64,
    pub velocity_i: f64,
    pub velocity_p: f64,
    pub position_d: f64,
    pub position_i: f64,
    pub position_p: f64,
    pub feedforward_2: f64,
    pub feedforward_1: f64,
    pub goal_pwm: f64,
    pub goal_current_a: f64,
    pub goal_velocity: f64,
    pub profile_acceleration: f64,
    pub profile_velocity: f64,
    pub goal_position: i32,
}

impl Settings {
    /// Returns whether clockwise counts as positive.
    pub fn is_reversed(&self) -> bool {
        self.drive_mode & drive_mode::REVERSE != 0
    }

    /// Returns -1 if the servo is reversed, 1 otherwise.
    pub fn sign(&self) -> f64 {
        if self.is_reversed() { -1.0 } else { 1.0 }
    }

    fn is_time_based(&self) -> bool {
        self.drive_mode & drive_mode::TIME_BASED != 0
    }
}

/// State of the firmware.
#[derive(Debug, Clone, Default)]
pub struct Firmware {
    /// Register contents at the last write.
    pub settings: Settings,
    /// Whole turns that the servo has cleared, counts: subtracted from the encoder count.
    pub forgotten: i32,
    /// Value of Hardware Error Status.
    pub errors: u8,
    /// Present point of the trajectory, in counts.
    pub profile: Profile,
    p_divisor: f64,
    profile_goal: f64,
    profile_limits: [f64; 2],
    integral: f64,
    last_error: f64,
    was_on: bool,
    last_mode: i32,
    overload: Debounce,
    voltage: Debounce,
}

impl Firmware {
    /// Creates firmware that has just started. `p_divisor` is the divisor of Position P Gain.
    pub fn new(p_divisor: f64) -> Self {
        Self { p_divisor, ..Self::default() }
    }

    /// Restarts, and clears whole turns.
    pub fn restart(&mut self, sensed_position: i32) {
        let (settings, p_divisor) = (self.settings, self.p_divisor);
        *self = Self { settings, ..Self::new(p_divisor) };
        self.forgotten = self.encoder(sensed_position).div_euclid(TURN) * TURN;
    }

    /// Returns the encoder's count in the servo's own direction. It is a guess that a reversed servo keeps its middle.
    fn encoder(&self, position: i32) -> i32 {
        if self.settings.is_reversed() { -position } else { position }
    }

    /// Returns the present position, counts.
    pub fn position(&self, sensed: &Sensed) -> i32 {
        self.encoder(sensed.position) - self.forgotten + self.settings.homing_offset
    }

    /// Returns whether an error has switched the servo off. Only a restart ends this.
    pub fn is_shut_down(&self) -> bool {
        i32::from(self.errors) & self.settings.shutdown != 0
    }

    /// Returns the values of Moving and Moving Status.
    pub fn motion(&self, sensed: &Sensed) -> [i32; 2] {
        let is_moving = sensed.velocity.abs() > self.settings.moving_threshold * VELOCITY_COUNTS_S;
        let goal = f64::from(self.settings.goal_position);
        let is_there = (goal - f64::from(self.position(sensed))).abs() <= IN_POSITION;
        let is_under_way = self.profile.velocity != 0.0;
        [is_moving.into(), i32::from(is_there) | i32::from(is_under_way) << 1]
    }

    /// Runs one tick of the control loop.
    pub fn tick(&mut self, sensed: &Sensed, dt_s: f64) -> Power {
        let sign = self.settings.sign();
        let own = Sensed { velocity: sign * sensed.velocity, ..*sensed };
        match self.own_tick(&own, dt_s) {
            Power::Current { current_a, limit } => {
                Power::Current { current_a: sign * current_a, limit }
            }
            Power::Duty { duty, limit_a } => Power::Duty { duty: sign * duty, limit_a },
            Power::Open => Power::Open,
        }
    }

    /// Runs one tick, with speed and power in the servo's own direction.
    fn own_tick(&mut self, sensed: &Sensed, dt_s: f64) -> Power {
        self.watch(sensed, dt_s);
        let is_on = self.settings.torque_is_on && !self.is_shut_down();
        if !is_on {
            self.was_on = false;
            return Power::Open;
        }
        if !self.was_on || self.last_mode != self.settings.mode {
            self.profile = Profile::at(f64::from(self.position(sensed)));
            self.profile_goal = f64::NAN;
            (self.integral, self.last_error) = (0.0, 0.0);
            (self.was_on, self.last_mode) = (true, self.settings.mode);
        }
        let s = &self.settings;
        let limit = (s.goal_pwm.abs().min(s.pwm_limit) / PWM_COUNTS).min(1.0);
        match s.mode {
            0 => {
                let most = s.current_limit_a;
                Power::Current { current_a: s.goal_current_a.clamp(-most, most), limit }
            }
            1 => {
                let pwm = self.velocity_pwm(sensed, dt_s, limit);
                Power::Duty { duty: pwm, limit_a: self.settings.current_limit_a }
            }
            16 => {
                let duty = s.goal_pwm.clamp(-s.pwm_limit, s.pwm_limit) / PWM_COUNTS;
                Power::Duty { duty, limit_a: f64::INFINITY }
            }
            mode => {
                let limit_a = if mode == 5 {
                    s.goal_current_a.abs().min(s.current_limit_a)
                } else {
                    f64::INFINITY
                };
                Power::Duty { duty: self.position_pwm(sensed, dt_s, limit), limit_a }
            }
        }
    }

    fn watch(&mut self, sensed: &Sensed, dt_s: f64) {
        let s = &self.settings;
        let [least, most] = s.voltage_limits_v;
        let is_outside = !(least..=most).contains(&sensed.supply_v);
        let (load, long_s) = OVERLOAD;
        for (is_wrong, bit) in [
            (self.voltage.lasts(is_outside, dt_s, VOLTAGE_S), hardware_error::INPUT_VOLTAGE),
            (sensed.case_c >= s.temperature_limit_c, hardware_error::OVERHEATING),
            (self.overload.lasts(sensed.load.abs() > load, dt_s, long_s), hardware_error::OVERLOAD),
        ] {
            if is_wrong {
                self.errors |= bit;
            }
        }
    }

    /// Returns speed and acceleration of the profile, counts/s and counts/s². Converts a time-based profile to a
    /// speed-based one when the goal changes.
    fn limits(&mut self, goal: f64) -> [f64; 2] {
        let s = &self.settings;
        let none = |value: f64, scale: f64| if value > 0.0 { value * scale } else { f64::INFINITY };
        if !s.is_time_based() {
            return [
                none(s.profile_velocity, VELOCITY_COUNTS_S),
                none(s.profile_acceleration, ACCELERATION_COUNTS_S2),
            ];
        }
        if goal.to_bits() != self.profile_goal.to_bits() {
            self.profile_goal = goal;
            let way = (goal - self.profile.position).abs();
            let (whole_s, ramp_s) = (s.profile_velocity * 1e-3, s.profile_acceleration * 1e-3);
            // Each of the two ramps takes at most half of the time.
            let ramp_s = ramp_s.min(0.5 * whole_s);
            let speed = none(way, 1.0 / (whole_s - ramp_s));
            self.profile_limits = [speed, none(speed, 1.0 / ramp_s)];
        }
        self.profile_limits
    }

    /// Computes PWM: PID on the position error e, plus feed-forward of the trajectory's speed v and acceleration a. PWM
    /// is the sum of `KP e`, `KI sum(e)`, `KD (e - e before)`, `KFF1 v` and `KFF2 a`, where KP = P/`p_divisor`, KI =
    /// I/65,536, KD = D/16, KFF = FF/4. Without a profile there is no feed-forward. Two details are guesses: sums and
    /// differences are per tick, and v and a are in the counts of their registers.
    fn position_pwm(&mut self, sensed: &Sensed, dt_s: f64, limit: f64) -> f64 {
        let goal = f64::from(self.settings.goal_position);
        let [speed, acceleration] = self.limits(goal);
        self.profile.step(goal, speed, acceleration, dt_s);
        let s = &self.settings;
        let error = self.profile.position - f64::from(self.position(sensed));
        let most = limit * PWM_COUNTS;
        self.integral = (self.integral + error * s.position_i / 65_536.0).clamp(-most, most);
        let change = error - self.last_error;
        self.last_error = error;
        let has_profile = speed.is_finite() || acceleration.is_finite();
        let ahead = if has_profile {
            s.feedforward_1 / 4.0 * self.profile.velocity / VELOCITY_COUNTS_S
                + s.feedforward_2 / 4.0 * self.profile.acceleration / ACCELERATION_COUNTS_S2
        } else {
            0.0
        };
        let pwm = error * s.position_p / self.p_divisor
            + self.integral
            + change * s.position_d / 16.0
            + ahead;
        pwm.clamp(-most, most) / PWM_COUNTS
    }

    /// Computes PWM: PI on the velocity error, in counts, with KP = P/128, KI = I/65,536 in each tick. It is a guess
    /// that the result is PWM.
    fn velocity_pwm(&mut self, sensed: &Sensed, dt_s: f64, limit: f64) -> f64 {
        let s = &self.settings;
        let goal = s.goal_velocity.clamp(-s.velocity_limit, s.velocity_limit);
        let acceleration = if s.profile_acceleration > 0.0 && !s.is_time_based() {
            s.profile_acceleration * ACCELERATION_COUNTS_S2
        } else {
            f64::INFINITY
        };
        self.profile.step_speed(goal * VELOCITY_COUNTS_S, acceleration, dt_s);
        let error = (self.profile.velocity - sensed.velocity) / VELOCITY_COUNTS_S;
        let most = limit * PWM_COUNTS;
        self.integral = (self.integral + error * s.velocity_i / 65_536.0).clamp(-most, most);
        (error * s.velocity_p / 128.0 + self.integral).clamp(-most, most) / PWM_COUNTS
    }
}
