//! A Dynamixel's registers, connected to its simulated firmware.

use std::ops::Range;

use sinew_servo_bus::BusDevice;
use sinew_servo_bus::dynamixel::device::Memory;
use sinew_servo_bus::dynamixel::table::{Table, address, drive_mode};
use sinew_servo_bus::dynamixel::{Device, Event, Instruction};

use super::codes::whole;
use super::error::ServoError;
use super::limits::{LONGEST, check_memory};
use super::restrictions;
use crate::firmware::Sensed;
use crate::firmware::dynamixel::{Firmware, PWM_COUNTS, Settings, VELOCITY_COUNTS_S};
use crate::model::{Parameters, Power};

// Addresses that only servos use; the same in all models by the e-manual.
const HOMING_OFFSET: u16 = 20;
const MOVING_THRESHOLD: u16 = 24;
const VELOCITY_I: u16 = 76;
const VELOCITY_P: u16 = 78;
const POSITION_D: u16 = 80;
const POSITION_I: u16 = 82;
const FEEDFORWARD_2: u16 = 88;
const FEEDFORWARD_1: u16 = 90;
const PROFILE_ACCELERATION: u16 = 108;
const PROFILE_VELOCITY: u16 = 112;
const REALTIME_TICK: u16 = 120;
const MOVING_STATUS: u16 = 123;
const PRESENT_PWM: u16 = 124;
const VELOCITY_TRAJECTORY: u16 = 136;
const POSITION_TRAJECTORY: u16 = 140;
const TICKS: i32 = 32_768;

/// A simulated Dynamixel.
pub(super) struct Dynamixel<'m> {
    pub(super) device: Device<'m, LONGEST>,
    pub(super) firmware: Firmware,
    current_unit_a: Option<f64>,
    no_limit_a: f64,
    time_ms: f64,
}

impl<'m> Dynamixel<'m> {
    pub(super) fn new(
        kind: &Parameters,
        table: Table,
        id: u8,
        memory: &'m mut [u8],
    ) -> Result<Self, ServoError> {
        check_memory(memory, table.size())?;
        let mut servo = Self {
            device: Device::new(table, id, memory),
            firmware: Firmware::new(kind.position_p_divisor),
            current_unit_a: table.model.current.map(|current| current.unit_a.into()),
            no_limit_a: f64::INFINITY,
            time_ms: 0.0,
        };
        servo.device.memory_mut().restrict(&restrictions::DYNAMIXEL);
        servo.restart(0);
        Ok(servo)
    }

    /// Restarts at the encoder's count, with the present position as its goal.
    pub(super) fn restart(&mut self, encoder: i32) {
        self.load();
        self.firmware.restart(encoder);
        self.reset_goals(encoder);
    }

    /// Resets the goals so that nothing moves. Except in current mode, the full current is then allowed. It is a guess
    /// that a start and a change of mode do this.
    fn reset_goals(&mut self, encoder: i32) {
        let sensed = Sensed { position: encoder, ..Sensed::default() };
        let position = self.firmware.position(&sensed);
        let memory = self.device.memory_mut();
        memory.set(address::GOAL_POSITION, position);
        let is_current_mode = memory.get(address::OPERATING_MODE) == 0;
        let current = if is_current_mode { 0 } else { memory.get(address::CURRENT_LIMIT) };
        memory.set(address::GOAL_CURRENT, current);
        if memory.get(address::OPERATING_MODE) == 16 {
            memory.set(address::GOAL_PWM, 0);
        }
        self.load();
    }

    /// Copies the registers to the firmware's settings.
    fn load(&mut self) {
        let memory = self.device.memory();
        let get = |at: u16| f64::from(memory.get(at));
        let amps = |at: u16| self.current_unit_a.map_or(self.no_limit_a, |unit| get(at) * unit);
        self.firmware.settings = Settings {
            torque_is_on: memory.torque_is_on(),
            mode: memory.get(address::OPERATING_MODE),
            drive_mode: memory.get(address::DRIVE_MODE),
            homing_offset: memory.get(HOMING_OFFSET),
            moving_threshold: get(MOVING_THRESHOLD),
            temperature_limit_c: get(address::TEMPERATURE_LIMIT),
            voltage_limits_v: [get(address::MIN_VOLTAGE) * 0.1, get(address::MAX_VOLTAGE) * 0.1],
            shutdown: memory.get(address::SHUTDOWN),
            current_limit_a: amps(address::CURRENT_LIMIT),
            velocity_limit: get(address::VELOCITY_LIMIT),
            pwm_limit: get(address::PWM_LIMIT),
            velocity_i: get(VELOCITY_I),
            velocity_p: get(VELOCITY_P),
            position_d: get(POSITION_D),
            position_i: get(POSITION_I),
            position_p: get(address::POSITION_P),
            feedforward_2: get(FEEDFORWARD_2),
            feedforward_1: get(FEEDFORWARD_1),
            goal_pwm: get(address::GOAL_PWM),
            goal_current_a: amps(address::GOAL_CURRENT),
            goal_velocity: get(address::GOAL_VELOCITY),
            profile_acceleration: get(PROFILE_ACCELERATION),
            profile_velocity: get(PROFILE_VELOCITY),
            goal_position: memory.get(address::GOAL_POSITION),
        };
    }

    /// Processes the events of the bus. Returns whether the servo restarts.
    pub(super) fn take_events(&mut self, sensed: &Sensed) -> bool {
        let (mut is_written, mut starts) = (false, false);
        let was_reversed = self.firmware.settings.is_reversed();
        while let Some(event) = self.device.next_event() {
            match event {
                Event::Written { address: first, length } => {
                    let written = first..first.saturating_add(length);
                    if written.contains(&address::OPERATING_MODE) {
                        self.load();
                        self.reset_goals(sensed.position);
                    }
                    self.switch_on_by_goal(&written);
                    is_written = true;
                }
                Event::Rebooted | Event::FactoryReset => starts = true,
                Event::TurnsCleared => self.firmware.restart(sensed.position),
                Event::WatchdogRanOut => self.stop(sensed),
            }
        }
        if starts {
            self.restart(sensed.position);
        } else if is_written {
            self.load();
            if self.firmware.settings.is_reversed() != was_reversed {
                self.restart(sensed.position);
            }
        }
        starts
    }

    /// Switches torque on if Drive Mode says so and the goal of the operating mode was written.
    fn switch_on_by_goal(&mut self, written: &Range<u16>) {
        let memory = self.device.memory_mut();
        let goal = match memory.get(address::OPERATING_MODE) {
            0 => address::GOAL_CURRENT,
            1 => address::GOAL_VELOCITY,
            16 => address::GOAL_PWM,
            _ => address::GOAL_POSITION,
        };
        let is_set = memory.get(address::DRIVE_MODE) & drive_mode::ON_BY_GOAL != 0;
        if is_set && written.contains(&goal) {
            memory.set(address::TORQUE_ENABLE, 1);
        }
    }

    /// Stops the servo as its bus watchdog does: depending on the operating mode, the servo holds its position, or
    /// its motor gets no current or no PWM.
    fn stop(&mut self, sensed: &Sensed) {
        let position = self.firmware.position(sensed);
        let memory = self.device.memory_mut();
        memory.set(address::GOAL_POSITION, position);
        memory.set(address::GOAL_VELOCITY, 0);
        match memory.get(address::OPERATING_MODE) {
            0 => memory.set(address::GOAL_CURRENT, 0),
            16 => memory.set(address::GOAL_PWM, 0),
            _ => {}
        }
        self.load();
    }

    pub(super) fn lose_torque(&mut self) {
        self.device.memory_mut().set(address::TORQUE_ENABLE, 0);
        self.firmware.settings.torque_is_on = false;
    }

    pub(super) fn keep_torque(&mut self) {
        self.device.memory_mut().set(address::TORQUE_ENABLE, 1);
        self.firmware.settings.torque_is_on = true;
    }

    pub(super) fn tick(&mut self, sensed: &Sensed, dt_s: f64) -> Power {
        self.time_ms += dt_s * 1e3;
        self.device.pass_time(whole(dt_s * 1e6).unsigned_abs());
        let power = self.firmware.tick(sensed, dt_s);
        if self.firmware.is_shut_down() && self.firmware.settings.torque_is_on {
            self.lose_torque();
        }
        power
    }

    /// Writes the sensor values to the registers.
    pub(super) fn publish(&mut self, sensed: &Sensed) {
        let [moving, moving_status] = self.firmware.motion(sensed);
        let sign = self.firmware.settings.sign();
        let effort = match self.current_unit_a {
            Some(unit) => whole(sign * sensed.current_a / unit),
            // Load is the applied duty cycle, in 0.1 %.
            None => whole(sign * sensed.duty * 1e3),
        };
        let firmware = &self.firmware;
        let values = [
            (address::HARDWARE_ERROR, firmware.errors.into()),
            (REALTIME_TICK, whole(self.time_ms) % TICKS),
            (address::MOVING, moving),
            (MOVING_STATUS, moving_status),
            (PRESENT_PWM, whole(sign * sensed.duty * PWM_COUNTS)),
            (address::PRESENT_CURRENT, effort),
            (address::PRESENT_VELOCITY, whole(sign * sensed.velocity / VELOCITY_COUNTS_S)),
            (address::PRESENT_POSITION, firmware.position(sensed)),
            (VELOCITY_TRAJECTORY, whole(firmware.profile.velocity / VELOCITY_COUNTS_S)),
            (POSITION_TRAJECTORY, whole(firmware.profile.position)),
            (address::PRESENT_VOLTAGE, whole(sensed.supply_v * 10.0)),
            (address::PRESENT_TEMPERATURE, whole(sensed.case_c)),
        ];
        let memory: &mut Memory<'_> = self.device.memory_mut();
        for (at, value) in values {
            memory.set(at, value);
        }
    }

    /// Reacts to a loss of power: a reboot without an instruction.
    pub(super) fn reboot(&mut self) {
        self.device.silence();
        let id = u8::try_from(self.device.memory().get(address::ID)).unwrap_or(0);
        let mut packet = [0; 16];
        if let Ok(len) = Instruction::Reboot.encode(id, &mut packet) {
            self.device.hear(&packet[..len]);
        }
        // The answer to the reboot is discarded.
        self.device.speak(&mut []);
    }
}
