//! A complete servo: physics, firmware, and the registers of `sinew-servo-bus`' devices.

pub(crate) mod codes;
mod dynamixel;
pub(crate) mod error;
mod feetech;
pub(crate) mod limits;
mod on_line;
mod restrictions;

use std::collections::VecDeque;

use sinew_servo_bus::dynamixel::table::{BAUDS as DYNAMIXEL_BAUDS, address};
use sinew_servo_bus::feetech::table::{BAUDS as FEETECH_BAUDS, address as feetech_address};

use crate::firmware::{Sensed, pulse};
use crate::load::{Load, Push, Shaft};
use crate::model::{Draw, Flow, Gear, Heat, Motor, Parameters, Power};
use crate::registers::RegisterTable;
use codes::{code_of, duty_per_rad, whole};
use dynamixel::Dynamixel;
pub use error::ServoError;
use feetech::Feetech;
pub use limits::MEMORY_LEN;

/// Step of the physics, s.
pub const STEP_S: f64 = 2.5e-4;
/// Time constant of the filter with which the servo computes its speed, s. This is a guess.
const SPEED_FILTER_S: f64 = 0.01;

enum Program<'m> {
    Dynamixel(Box<Dynamixel<'m>>),
    Feetech(Box<Feetech<'m>>),
    Pulse(pulse::Firmware),
}

/// A simulated servo.
pub struct Servo<'m> {
    program: Program<'m>,
    gear: Gear,
    motor: Motor,
    heat: Heat,
    sensed: Sensed,
    /// Measurements of the servo's last ticks, the newest first. The servo reports the last entry, which is the
    /// oldest.
    past: VecDeque<Sensed>,
    delay_ticks: usize,
    power: Power,
    draw: Draw,
    rad_per_count: f64,
    stall_a_v: f64,
    brown_out_v: f64,
    boot_s: f64,
    /// Time until the servo has started, s; 0 while it runs.
    starts_in_s: f64,
    steps_per_tick: u32,
    steps: u32,
    gear_steps: u32,
    is_published: bool,
    lost_w: [f64; 2],
    /// Offset that is added to the encoder's reading, rad: a fault.
    pub encoder_jump_rad: f64,
    /// Whether the supply is cut: a fault.
    pub is_unplugged: bool,
    is_torque_stuck: bool,
}

impl<'m> Servo<'m> {
    /// Creates a servo with factory settings that has just started, at the middle of its range. `memory` holds its
    /// registers: [`MEMORY_LEN`] bytes.
    ///
    /// # Errors
    /// [`ServoError`] if `memory` is too small, or the servo's kind has no register table.
    pub fn new(kind: &Parameters, id: u8, memory: &'m mut [u8]) -> Result<Self, ServoError> {
        let program = match RegisterTable::of(&kind.name) {
            Some(RegisterTable::Dynamixel(table)) => {
                Program::Dynamixel(Box::new(Dynamixel::new(kind, table, id, memory)?))
            }
            Some(RegisterTable::Feetech(table)) => {
                Program::Feetech(Box::new(Feetech::new(kind, table, id, memory)?))
            }
            None => return Err(ServoError::NoTable(kind.name.clone())),
        };
        Ok(Self::with(kind, program, kind.resolution_rad))
    }

    /// Creates a hobby servo at the middle of its range, without a pulse.
    pub fn on_pulses(kind: &Parameters) -> Self {
        // The servo's resolution is a dead band; the potentiometer itself has no steps.
        let rad_per_count = kind.resolution_rad / 64.0;
        let firmware = pulse::Firmware::new(duty_per_rad(kind), rad_per_count, kind);
        Self::with(kind, Program::Pulse(firmware), rad_per_count)
    }

    fn with(kind: &Parameters, program: Program<'m>, rad_per_count: f64) -> Self {
        let steps = whole(1.0 / (kind.loop_hz * STEP_S)).max(1).unsigned_abs();
        let mut servo = Self {
            program,
            gear: Gear::new(kind),
            motor: Motor::new(kind),
            heat: Heat::new(kind),
            sensed: Sensed { supply_v: kind.voltage_v, ..Sensed::default() },
            past: VecDeque::new(),
            delay_ticks: usize::try_from(whole(kind.reading_delay_s / (f64::from(steps) * STEP_S)))
                .unwrap_or_default(),
            power: Power::Open,
            draw: Draw::default(),
            rad_per_count,
            stall_a_v: 1.0 / kind.resistance_ohm,
            brown_out_v: kind.brown_out_v,
            boot_s: kind.boot_s,
            starts_in_s: 0.0,
            steps_per_tick: steps,
            steps: 0,
            gear_steps: 1,
            is_published: false,
            lost_w: [0.0; 2],
            encoder_jump_rad: 0.0,
            is_unplugged: false,
            is_torque_stuck: false,
        };
        servo.place(0.5 * kind.range_rad);
        servo
    }

    /// Places the shaft at a position, rad, at rest, and restarts the servo.
    pub fn place(&mut self, position_rad: f64) {
        self.gear.place(position_rad);
        self.sensed.position = whole(position_rad / self.rad_per_count);
        self.past.clear();
        match &mut self.program {
            Program::Dynamixel(servo) => servo.restart(self.sensed.position),
            Program::Feetech(servo) => servo.restart(self.sensed.position),
            Program::Pulse(_) => {}
        }
        self.is_published = false;
    }

    /// Returns the value of a register, or 0 if there is no register at `address`.
    pub fn get(&self, address: u16) -> i32 {
        match &self.program {
            Program::Dynamixel(servo) => servo.device.memory().get(address),
            Program::Feetech(servo) => {
                u8::try_from(address).map_or(0, |address| servo.device.get(address))
            }
            Program::Pulse(_) => 0,
        }
    }

    /// Sets a register, even if a controller could not write it, and restarts the servo.
    pub fn set(&mut self, address: u16, value: i32) {
        match &mut self.program {
            Program::Dynamixel(servo) => servo.device.memory_mut().set(address, value),
            Program::Feetech(servo) => {
                if let Ok(address) = u8::try_from(address) {
                    servo.device.set(address, value);
                }
            }
            Program::Pulse(_) => {}
        }
        self.place(self.gear.shaft.position_rad);
    }

    /// Sets the baud rate, bits per second.
    ///
    /// # Errors
    /// [`ServoError::Baud`] if the protocol has no code for this rate.
    pub fn set_baud(&mut self, baud: u32) -> Result<(), ServoError> {
        let (bauds, register): (&[u32], u16) = match &self.program {
            Program::Dynamixel(_) => (&DYNAMIXEL_BAUDS, address::BAUD),
            Program::Feetech(_) => (&FEETECH_BAUDS, feetech_address::BAUD.into()),
            Program::Pulse(_) => return Ok(()),
        };
        self.set(register, code_of(baud, bauds)?);
        Ok(())
    }

    /// Returns the baud rate, bits per second; 0 for a servo without a bus.
    pub fn baud(&self) -> u32 {
        match &self.program {
            Program::Dynamixel(servo) => servo.device.baud(),
            Program::Feetech(servo) => servo.device.baud(),
            Program::Pulse(_) => 0,
        }
    }

    /// Sets the pulse of a hobby servo, us; `None` for no pulse.
    pub fn set_pulse(&mut self, pulse_us: Option<f64>) {
        if let Program::Pulse(firmware) = &mut self.program {
            firmware.pulse_us = pulse_us;
        }
    }

    /// Returns the pulse of a hobby servo, us; `None` without a pulse or for another servo.
    pub fn pulse_us(&self) -> Option<f64> {
        match &self.program {
            Program::Pulse(firmware) => firmware.pulse_us,
            _ => None,
        }
    }

    /// Returns position and speed of the shaft.
    pub fn shaft(&self) -> Shaft {
        self.gear.shaft
    }

    /// Sets position and speed of the shaft, from the plant; the rotor follows as far as the gear moves it.
    pub fn set_shaft(&mut self, shaft: Shaft) {
        self.gear.lead(STEP_S, shaft);
    }

    /// Returns the push on the shaft in the last step.
    pub fn push(&self) -> Push {
        self.gear.push()
    }

    /// Returns torques and friction of the last step.
    pub fn flow(&self) -> Flow {
        self.gear.flow()
    }

    /// Returns the gear, so that the caller can jam it or read its energy.
    pub fn gear_mut(&mut self) -> &mut Gear {
        &mut self.gear
    }

    /// Divides each step of the gear into `steps` steps, at least 1. For tests of how a gear oscillates: a step of
    /// length h damps an oscillation at stiffness K like an additional damping of K h. With one step, which is the
    /// default, an XM430's damping of 0.225 N m s acts as 0.284.
    pub fn refine_gear(&mut self, steps: u32) {
        self.gear_steps = steps.max(1);
    }

    /// Returns the temperatures.
    pub fn heat(&self) -> &Heat {
        &self.heat
    }

    /// Returns the temperatures, so that the caller can change them, for example for a fault or warmer air.
    pub fn heat_mut(&mut self) -> &mut Heat {
        &mut self.heat
    }

    /// Returns the load of the servo on its supply.
    pub fn draw(&self) -> Draw {
        self.draw
    }

    /// Returns the current in the winding, A.
    pub fn current_a(&self) -> f64 {
        self.motor.current_a
    }

    /// Returns the power lost in the winding and by friction in the last step, W.
    pub fn lost_w(&self) -> [f64; 2] {
        self.lost_w
    }

    /// Returns whether the servo has power and has started.
    pub fn runs(&self) -> bool {
        !self.is_unplugged && self.starts_in_s <= 0.0
    }

    /// Switches torque off without a report: a fault.
    pub fn lose_torque(&mut self) {
        match &mut self.program {
            Program::Dynamixel(servo) => servo.lose_torque(),
            Program::Feetech(servo) => servo.lose_torque(),
            Program::Pulse(firmware) => firmware.pulse_us = None,
        }
    }

    /// Keeps torque on despite all commands, or ends this fault.
    pub fn stick_torque(&mut self, is_stuck: bool) {
        self.is_torque_stuck = is_stuck;
        self.keep_torque();
    }

    /// Switches torque on again if the servo has the fault that its torque stays on.
    fn keep_torque(&mut self) {
        if self.is_torque_stuck {
            match &mut self.program {
                Program::Dynamixel(servo) => servo.keep_torque(),
                Program::Feetech(servo) => servo.keep_torque(),
                Program::Pulse(_) => {}
            }
        }
    }

    /// Restarts the servo, like after a loss of power.
    pub fn reboot(&mut self) {
        match &mut self.program {
            Program::Dynamixel(servo) => servo.reboot(),
            Program::Feetech(servo) => servo.reboot(),
            Program::Pulse(_) => {}
        }
        self.take_events();
        self.starts_in_s = self.boot_s;
    }

    fn take_events(&mut self) {
        let starts = match &mut self.program {
            Program::Dynamixel(servo) => servo.take_events(&self.sensed),
            Program::Feetech(servo) => servo.take_events(&self.sensed),
            Program::Pulse(_) => false,
        };
        if starts {
            self.starts_in_s = self.boot_s;
        }
    }

    /// Advances the servo by [`STEP_S`].
    pub fn step(&mut self, supply_v: f64, load: &impl Load) {
        let supply_v = if self.is_unplugged { 0.0 } else { supply_v };
        if supply_v < self.brown_out_v {
            if self.starts_in_s <= 0.0 {
                self.reboot();
            }
            self.starts_in_s = self.boot_s;
        }
        self.sensed.supply_v = supply_v;
        if self.steps == 0 {
            self.steps = self.steps_per_tick;
            self.tick();
        }
        self.steps -= 1;
        let ratio = self.heat.resistance_ratio();
        for _ in 0..self.gear_steps {
            let speed = self.gear.rotor.velocity_rad_s;
            let motor = self.motor.characteristic(self.power, supply_v, speed, ratio);
            self.gear.step(STEP_S / f64::from(self.gear_steps), motor, load);
        }
        let flow = self.gear.flow();
        let speed = self.gear.rotor.velocity_rad_s;
        let (draw, winding_w) = self.motor.settle(flow.motor_nm, speed, supply_v, ratio);
        self.draw = if self.is_unplugged { Draw::default() } else { draw };
        self.lost_w = [winding_w, flow.friction_w];
        self.heat.step(STEP_S, winding_w, flow.friction_w);
    }

    fn tick(&mut self) {
        let dt_s = f64::from(self.steps_per_tick) * STEP_S;
        self.sense(dt_s);
        if self.delay_ticks > 0 {
            self.past.truncate(self.delay_ticks);
            self.past.push_front(self.sensed);
        }
        self.is_published = false;
        if !self.runs() {
            self.starts_in_s = (self.starts_in_s - dt_s).max(0.0);
            self.power = Power::Open;
            return;
        }
        self.take_events();
        self.power = match &mut self.program {
            Program::Dynamixel(servo) => servo.tick(&self.sensed, dt_s),
            Program::Feetech(servo) => servo.tick(&self.sensed, dt_s),
            Program::Pulse(firmware) => firmware.tick(&self.sensed, dt_s),
        };
    }

    /// Returns the reported measurements, which may be older than the present ones by the servo's reading delay.
    fn told(&self) -> Sensed {
        self.past.back().copied().unwrap_or(self.sensed)
    }

    fn sense(&mut self, dt_s: f64) {
        let seen_rad = self.gear.shaft.position_rad + self.encoder_jump_rad;
        let position = whole(seen_rad / self.rad_per_count);
        let sensed = &mut self.sensed;
        let speed = f64::from(position - sensed.position) / dt_s;
        sensed.velocity += (speed - sensed.velocity) * dt_s / (SPEED_FILTER_S + dt_s);
        sensed.position = position;
        sensed.current_a = self.motor.current_a;
        sensed.duty = self.motor.duty;
        sensed.case_c = self.heat.case_c;
        let stall_a = sensed.supply_v * self.stall_a_v;
        sensed.load = if stall_a > 0.0 { sensed.current_a / stall_a } else { 0.0 };
    }
}
