//! A Feetech's registers, connected to its simulated firmware.

use sinew_servo_bus::BusDevice;
use sinew_servo_bus::feetech::table::address;
use sinew_servo_bus::feetech::{Device, Event, Instruction, Table};

use super::codes::{duty_per_rad, whole};
use super::error::ServoError;
use super::limits::{MEMORY_LEN, check_memory};
use super::restrictions;
use crate::firmware::Sensed;
use crate::firmware::feetech::{Firmware, Settings};
use crate::model::{Parameters, Power};

// Addresses of the STS table that only servos use.
const MAX_TEMPERATURE: u8 = 13;
const MAX_VOLTAGE: u8 = 14;
const MIN_VOLTAGE: u8 = 15;
const UNLOADING: u8 = 19;
const P: u8 = 21;
const STARTUP_FORCE: u8 = 24;
const DEAD_ZONES: [u8; 2] = [26, 27];
const PROTECTION_CURRENT: u8 = 28;
const MODE: u8 = 33;
const PROTECTIVE_TORQUE: u8 = 34;
const PROTECTION_TIME: u8 = 35;
const OVERLOAD_TORQUE: u8 = 36;
const CURRENT_TIME: u8 = 38;
const GOAL_PWM: u8 = 44;
const PRESENT_LOAD: u8 = 60;
const PRESENT_VOLTAGE: u8 = 62;
const PRESENT_TEMPERATURE: u8 = 63;
const MOVING: u8 = 66;
const TARGET_POSITION: u8 = 67;
/// Current of one count, A.
const CURRENT_A: f64 = 0.0065;
/// Guess: excess temperature, current and overload switch torque off, as in dumps of new servos.
const SHIPPED_UNLOADING: i32 = 44;

/// A simulated Feetech.
pub(super) struct Feetech<'m> {
    pub(super) device: Device<'m>,
    pub(super) firmware: Firmware,
}

impl<'m> Feetech<'m> {
    pub(super) fn new(
        kind: &Parameters,
        table: Table,
        id: u8,
        memory: &'m mut [u8],
    ) -> Result<Self, ServoError> {
        check_memory(memory, MEMORY_LEN)?;
        let duty_per_count = duty_per_rad(kind) * kind.resolution_rad;
        let speed_cap = kind.speed_cap_rad_s.map_or(f64::INFINITY, |cap| cap / kind.resolution_rad);
        let mut servo = Self {
            device: Device::new(table, id, memory),
            firmware: Firmware::new(duty_per_count, speed_cap),
        };
        servo.device.set(UNLOADING, SHIPPED_UNLOADING);
        servo.device.restrict(&restrictions::FEETECH);
        servo.restart(0);
        Ok(servo)
    }

    /// Restarts at the encoder's count, with the present position as its goal.
    pub(super) fn restart(&mut self, encoder: i32) {
        self.load();
        self.firmware.restart(encoder);
        let sensed = Sensed { position: encoder, ..Sensed::default() };
        self.device.set(address::GOAL_POSITION, self.firmware.position(&sensed));
        self.load();
    }

    fn load(&mut self) {
        let device = &self.device;
        let get = |at: u8| f64::from(device.get(at));
        self.firmware.settings = Settings {
            torque: device.get(address::TORQUE_ENABLE),
            mode: device.get(MODE),
            position_limits: [device.get(address::MIN_POSITION), device.get(address::MAX_POSITION)],
            temperature_limit_c: get(MAX_TEMPERATURE),
            voltage_limits_v: [get(MIN_VOLTAGE) * 0.1, get(MAX_VOLTAGE) * 0.1],
            unloading: device.get(UNLOADING),
            homing_offset: device.get(address::HOMING_OFFSET),
            p: get(P),
            startup_force: get(STARTUP_FORCE) * 1e-3,
            dead_zone: DEAD_ZONES.map(get),
            protection_current_a: get(PROTECTION_CURRENT) * CURRENT_A,
            protection_current_s: get(CURRENT_TIME) * 0.01,
            protective_torque: get(PROTECTIVE_TORQUE) * 0.01,
            protection_s: get(PROTECTION_TIME) * 0.01,
            overload_torque: get(OVERLOAD_TORQUE) * 0.01,
            phase: u8::try_from(device.get(address::PHASE)).unwrap_or(0),
            acceleration: get(address::ACCELERATION),
            goal_position: device.get(address::GOAL_POSITION),
            goal_pwm: get(GOAL_PWM) * 1e-3,
            goal_speed: get(address::GOAL_SPEED),
            torque_limit: get(address::TORQUE_LIMIT) * 1e-3,
        };
    }

    /// Processes the events of the bus. Returns whether the servo restarts.
    pub(super) fn take_events(&mut self, sensed: &Sensed) -> bool {
        let (mut is_written, mut starts) = (false, false);
        while let Some(event) = self.device.next_event() {
            match event {
                Event::Written { address: first, length } => {
                    let written = first..first.saturating_add(length);
                    if written.contains(&address::GOAL_POSITION) {
                        self.firmware.take_goal();
                    }
                    is_written = true;
                }
                Event::Rebooted | Event::FactoryReset => starts = true,
                Event::TurnsCleared => self.firmware.clear_turns(sensed),
                Event::PositionSet(_) => is_written = true,
            }
        }
        if starts {
            self.restart(sensed.position);
        } else if is_written {
            let before = self.firmware.settings;
            self.load();
            self.firmware.moved_zero(&before, sensed);
        }
        starts
    }

    pub(super) fn lose_torque(&mut self) {
        self.device.set(address::TORQUE_ENABLE, 0);
        self.firmware.settings.torque = 0;
    }

    pub(super) fn keep_torque(&mut self) {
        self.device.set(address::TORQUE_ENABLE, 1);
        self.firmware.settings.torque = 1;
    }

    pub(super) fn tick(&mut self, sensed: &Sensed, dt_s: f64) -> Power {
        let power = self.firmware.tick(sensed, dt_s);
        if self.firmware.is_unloaded() && self.firmware.settings.torque != 0 {
            self.lose_torque();
        }
        power
    }

    /// Writes the sensor values to the registers.
    pub(super) fn publish(&mut self, sensed: &Sensed) {
        let firmware = &self.firmware;
        let speed = firmware.velocity(sensed) / firmware.settings.speed_counts();
        let values = [
            (address::PRESENT_POSITION, firmware.reported(sensed)),
            (address::PRESENT_SPEED, whole(speed)),
            (PRESENT_LOAD, whole(firmware.settings.motor_sign() * sensed.duty * 1e3)),
            (PRESENT_VOLTAGE, whole(sensed.supply_v * 10.0)),
            (PRESENT_TEMPERATURE, whole(sensed.case_c)),
            (address::STATUS, firmware.errors.into()),
            (MOVING, firmware.is_moving(sensed).into()),
            (TARGET_POSITION, whole(firmware.profile.position)),
            (
                address::PRESENT_CURRENT,
                whole(firmware.settings.motor_sign() * sensed.current_a / CURRENT_A),
            ),
        ];
        for (at, value) in values {
            self.device.set(at, value);
        }
    }

    /// Reacts to a loss of power: a reboot without an instruction.
    pub(super) fn reboot(&mut self) {
        self.device.silence();
        let id = u8::try_from(self.device.get(address::ID)).unwrap_or(0);
        let mut packet = [0; 16];
        if let Ok(len) =
            Instruction::Reboot.encode(self.device.table().model.family, id, &mut packet)
        {
            self.device.hear(&packet[..len]);
        }
        self.device.speak(&mut []);
    }
}
