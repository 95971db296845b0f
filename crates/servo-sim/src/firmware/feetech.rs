//! Firmware of Feetech STS and SMS: modes 0 (position), 1 (speed) and 2 (PWM).

use sinew_servo_bus::feetech::status_bit;
use sinew_servo_bus::feetech::table::phase;

use super::{Debounce, Profile, Sensed};
use crate::model::Power;

/// Counts of one turn.
pub const TURN: i32 = 4096;
/// Acceleration of one acceleration count, in counts of position per s².
pub const ACCELERATION_COUNTS_S2: f64 = 100.0;
/// Factory value of P Coefficient, for which the stiffness is known.
const SHIPPED_P: f64 = 32.0;
/// Time after which a supply voltage outside its limits is an error, s. This is a guess, as for the Dynamixel.
const VOLTAGE_S: f64 = 0.01;

/// Contents of the registers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[expect(missing_docs, reason = "named as in the memory table")]
pub struct Settings {
    /// Torque: 0 off, 1 on, 2 damped.
    pub torque: i32,
    pub mode: i32,
    pub position_limits: [i32; 2],
    pub temperature_limit_c: f64,
    pub voltage_limits_v: [f64; 2],
    /// Mask of the errors that switch torque off.
    pub unloading: i32,
    pub homing_offset: i32,
    pub p: f64,
    /// Minimum duty cycle, as a part of the supply.
    pub startup_force: f64,
    pub dead_zone: [f64; 2],
    pub protection_current_a: f64,
    pub protection_current_s: f64,
    pub protective_torque: f64,
    pub protection_s: f64,
    pub overload_torque: f64,
    pub phase: u8,
    pub acceleration: f64,
    pub goal_position: i32,
    /// Goal of mode 2, as a part of the supply.
    pub goal_pwm: f64,
    pub goal_speed: f64,
    pub torque_limit: f64,
}

impl Settings {
    fn has(&self, bit: u8) -> bool {
        self.phase & bit != 0
    }

    /// Returns the speed of one speed count, in counts of position per second.
    pub fn speed_counts(&self) -> f64 {
        if self.has(phase::FINE_SPEED) { 1.0 } else { 50.0 }
    }

    /// Returns -1 if the motor is reversed, 1 otherwise.
    pub fn motor_sign(&self) -> f64 {
        if self.has(phase::REVERSED_MOTOR) { -1.0 } else { 1.0 }
    }

    /// Returns whether goals are limited to a range within one turn: in mode 0, if the minimum position is below the
    /// maximum.
    fn is_single_turn(&self) -> bool {
        let [least, most] = self.position_limits;
        self.mode == 0 && least < most
    }
}

/// State of the firmware.
#[derive(Debug, Clone, Default)]
pub struct Firmware {
    /// Register contents at the last write.
    pub settings: Settings,
    /// Whole turns that are subtracted from the encoder count.
    forgotten: i32,
    /// Value of the status byte.
    pub errors: u8,
    /// Present point of the trajectory, in counts.
    pub profile: Profile,
    /// Duty cycle per count of position error, with the factory P.
    duty_per_count: f64,
    /// Maximum speed of the trajectory, counts/s.
    speed_cap: f64,
    was_on: bool,
    overload: Debounce,
    current: Debounce,
    voltage: Debounce,
}

impl Firmware {
    /// Creates firmware that has just started. `duty_per_count` is the duty cycle per count of position error,
    /// `speed_cap` the maximum speed of the trajectory, counts/s.
    pub fn new(duty_per_count: f64, speed_cap: f64) -> Self {
        Self { duty_per_count, speed_cap, ..Self::default() }
    }

    /// Restarts, and clears whole turns.
    pub fn restart(&mut self, sensed_position: i32) {
        let settings = self.settings;
        *self = Self { settings, ..Self::new(self.duty_per_count, self.speed_cap) };
        self.clear_turns(&Sensed { position: sensed_position, ..Sensed::default() });
    }

    /// Clears whole turns: the present position is within one turn.
    pub fn clear_turns(&mut self, sensed: &Sensed) {
        self.forgotten += self.position(sensed).div_euclid(TURN) * TURN;
    }

    /// Clears whole turns if the registers that move the zero have changed since `before`.
    pub fn moved_zero(&mut self, before: &Settings, sensed: &Sensed) {
        let zero =
            |settings: &Settings| (settings.homing_offset, settings.has(phase::REVERSED_ENCODER));
        if zero(before) != zero(&self.settings) {
            self.clear_turns(sensed);
        }
    }

    /// Returns the present position over all turns since the start, counts.
    pub fn position(&self, sensed: &Sensed) -> i32 {
        let encoder = if self.settings.has(phase::REVERSED_ENCODER) {
            -sensed.position
        } else {
            sensed.position
        };
        encoder - self.forgotten - self.settings.homing_offset
    }

    /// Returns the position that the servo reports, counts.
    pub fn reported(&self, sensed: &Sensed) -> i32 {
        let position = self.position(sensed);
        if self.settings.has(phase::ALL_TURNS) { position } else { position.rem_euclid(TURN) }
    }

    /// Returns the present speed, counts/s.
    pub fn velocity(&self, sensed: &Sensed) -> f64 {
        if self.settings.has(phase::REVERSED_ENCODER) { -sensed.velocity } else { sensed.velocity }
    }

    /// Ends an overload, because a new goal was written.
    pub fn take_goal(&mut self) {
        self.errors &= !status_bit::OVERLOAD;
        self.overload = Debounce::default();
    }

    /// Returns whether an error has switched torque off.
    pub fn is_unloaded(&self) -> bool {
        // An overload does not switch torque off: it reduces torque.
        i32::from(self.errors & !status_bit::OVERLOAD) & self.settings.unloading != 0
    }

    /// Returns the value of Moving.
    pub fn is_moving(&self, sensed: &Sensed) -> bool {
        self.profile.velocity != 0.0 || sensed.velocity.abs() > MOVING_COUNTS_S
    }

    /// Runs one tick of the control loop.
    pub fn tick(&mut self, sensed: &Sensed, dt_s: f64) -> Power {
        self.watch(sensed, dt_s);
        let s = self.settings;
        if s.torque == 0 || self.is_unloaded() {
            self.was_on = false;
            return Power::Open;
        }
        if s.torque == 2 {
            self.was_on = false;
            return Power::Duty { duty: 0.0, limit_a: f64::INFINITY };
        }
        if !self.was_on {
            // Guess: a servo that was turned by hand over its seam has forgotten this.
            if s.is_single_turn() {
                self.clear_turns(sensed);
            }
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
        Power::Duty { duty: s.motor_sign() * duty.clamp(-most, most), limit_a: f64::INFINITY }
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
        // If both limits are 0, the servo may make several turns.
        let goal =
            if s.is_single_turn() { s.goal_position.clamp(least, most) } else { s.goal_position };
        let asked = s.goal_speed.abs() * s.speed_counts();
        let is_fastest = asked == 0.0 && s.has(phase::ZERO_IS_FASTEST);
        let speed = if is_fastest { self.speed_cap } else { asked.min(self.speed_cap) };
        self.profile.step(f64::from(goal), speed, self.acceleration(), dt_s);
        self.duty(sensed)
    }

    /// Computes the duty cycle in speed mode. The servo follows a position that moves at the commanded speed, but no
    /// faster than the servo can follow.
    fn speed_duty(&mut self, sensed: &Sensed, dt_s: f64) -> f64 {
        let s = self.settings;
        let speed = (s.goal_speed * s.speed_counts()).clamp(-self.speed_cap, self.speed_cap);
        self.profile.step_speed(speed, self.acceleration(), dt_s);
        let present = f64::from(self.position(sensed));
        let lead = SHIPPED_P / (self.duty_per_count * s.p.max(1.0));
        self.profile.position = self.profile.position.clamp(present - lead, present + lead);
        self.duty(sensed)
    }

    /// Computes the duty cycle: P on the position error, and 0 in the dead zone. D and I are ignored: the damping of
    /// identified servos (0.56 to 0.6 N m s with factory gains) is that of back-EMF and viscous friction alone, and the
    /// factory I is 0. It is a guess that Minimum Startup Force is a minimum of the duty cycle.
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

/// Speed below which the servo does not report motion, counts/s. This is a guess.
const MOVING_COUNTS_S: f64 = 50.0;
