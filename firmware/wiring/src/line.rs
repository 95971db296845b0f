//! A line and a servo, as a wiring describes them.

use heapless::Vec;
use serde::{Deserialize, Serialize};
use sinew_firmware::controller::ServoSetup;
use sinew_servo_bus::dynamixel::table::MODELS;
use sinew_servo_bus::pca9685::{ChannelSetup, Prescale};
use sinew_servo_bus::{Schedule, Timing, Traffic, dynamixel, feetech, pca9685};

use crate::remote::{
    ChannelOf, DynamixelModeOf, DynamixelOf, FeetechOf, FeetechServoOf, ServoSetupOf, TimingOf,
    TrafficOf,
};
use crate::{Bus, WiringError};

/// A line of servos.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BusLine {
    /// Protocol of the line, with its settings.
    pub protocol: Protocol,
    /// Bit rate and delays of the line.
    #[serde(with = "TimingOf")]
    pub timing: Timing,
    /// Bytes and packets that the line carries in a tick.
    #[serde(with = "TrafficOf")]
    pub traffic: Traffic,
}

/// Protocol of a line, with its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Protocol {
    /// Dynamixel 2.0.
    Dynamixel(#[serde(with = "DynamixelOf")] dynamixel::Settings),
    /// Feetech's protocol.
    Feetech(#[serde(with = "FeetechOf")] feetech::Settings),
    /// Pulses of a PCA9685; [`Timing::baud`] is the rate of I2C.
    Pca9685(Pulses),
}

/// The clock of a PCA9685, and its pulse rate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pulses {
    /// Measured frequency of the chip's own oscillator, Hz; 25 MHz by the data sheet.
    pub oscillator_hz: f32,
    /// Pulse rate, Hz.
    pub rate_hz: f32,
}

/// A servo: its line, and its settings for the bus and for the controller.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Servo {
    /// Index of the servo's line.
    pub line: usize,
    /// Settings of the servo for its bus.
    pub on_line: LineServo,
    /// Settings of the servo for the controller.
    #[serde(with = "ServoSetupOf")]
    pub setup: ServoSetup,
}

/// Settings of a servo for the bus of its line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum LineServo {
    /// A Dynamixel servo.
    Dynamixel(Dynamixel),
    /// A Feetech servo.
    Feetech(#[serde(with = "FeetechServoOf")] feetech::ServoSetup),
    /// A channel of a PCA9685.
    Channel(#[serde(with = "ChannelOf")] ChannelSetup),
}

/// A [`dynamixel::ServoSetup`] with its model as a number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dynamixel {
    id: u8,
    model: u16,
    #[serde(with = "DynamixelModeOf")]
    mode: dynamixel::Mode,
    range_rad: [f32; 2],
    current_a: f32,
    pwm: f32,
    speed_rad_s: f32,
}

impl From<dynamixel::ServoSetup> for Dynamixel {
    fn from(setup: dynamixel::ServoSetup) -> Self {
        let dynamixel::ServoSetup { id, model, mode, range_rad, current_a, pwm, speed_rad_s } =
            setup;
        Self { id, model: model.number, mode, range_rad, current_a, pwm, speed_rad_s }
    }
}

impl Dynamixel {
    fn setup(self) -> Result<dynamixel::ServoSetup, WiringError> {
        let Self { id, model, mode, range_rad, current_a, pwm, speed_rad_s } = self;
        let known = MODELS.iter().find(|known| known.number == model);
        let model = known.ok_or(WiringError::Model { id, found: model })?;
        Ok(dynamixel::ServoSetup { id, model, mode, range_rad, current_a, pwm, speed_rad_s })
    }
}

impl BusLine {
    /// Returns the schedule of the line's bus at `rate_hz` ticks per second.
    ///
    /// # Errors
    /// [`WiringError`] if the line is too slow for that rate.
    pub fn schedule(&self, rate_hz: u32) -> Result<Schedule, WiringError> {
        Schedule::new(self.timing, &self.traffic, rate_hz).map_err(WiringError::Schedule)
    }

    /// Creates the line's bus with its servos.
    ///
    /// # Errors
    /// [`WiringError`] names the servo or the setting that is not possible on this line.
    pub fn bus<const SERVOS: usize>(
        &self,
        servos: impl Iterator<Item = LineServo>,
        rate_hz: u32,
    ) -> Result<Bus<SERVOS>, WiringError> {
        match self.protocol {
            Protocol::Dynamixel(settings) => {
                let setups = all::<_, SERVOS>(servos.map(LineServo::dynamixel))?;
                let bus = dynamixel::Bus::new(&setups, self.schedule(rate_hz)?, settings);
                bus.map(Bus::Dynamixel).map_err(WiringError::Setup)
            }
            Protocol::Feetech(settings) => {
                let setups = all::<_, SERVOS>(servos.map(LineServo::feetech))?;
                let bus = feetech::Bus::new(&setups, self.schedule(rate_hz)?, settings);
                bus.map(Bus::Feetech).map_err(WiringError::Setup)
            }
            Protocol::Pca9685(pulses) => {
                let setups = all::<_, SERVOS>(servos.map(LineServo::channel))?;
                let bus = pca9685::Bus::new(&setups, pulses.prescale()?, self.timing.baud);
                bus.map(Bus::Pca9685).map_err(WiringError::Setup)
            }
        }
    }

    /// Checks that [`Self::bus`] would succeed, without making the bus: a board checks a wiring when its stack is
    /// deepest, and a bus is large.
    ///
    /// # Errors
    /// Returns the errors of [`Self::bus`].
    pub fn check<const SERVOS: usize>(
        &self,
        servos: impl Iterator<Item = LineServo>,
        rate_hz: u32,
    ) -> Result<(), WiringError> {
        let checked = match self.protocol {
            Protocol::Dynamixel(_) => {
                let setups = all::<_, SERVOS>(servos.map(LineServo::dynamixel))?;
                dynamixel::Bus::<SERVOS>::check(&setups, &self.schedule(rate_hz)?)
            }
            Protocol::Feetech(settings) => {
                let setups = all::<_, SERVOS>(servos.map(LineServo::feetech))?;
                feetech::Bus::<SERVOS>::check(&setups, &self.schedule(rate_hz)?, settings)
            }
            Protocol::Pca9685(pulses) => {
                let setups = all::<_, SERVOS>(servos.map(LineServo::channel))?;
                pca9685::Bus::new(&setups, pulses.prescale()?, self.timing.baud).map(drop)
            }
        };
        checked.map_err(WiringError::Setup)
    }
}

impl LineServo {
    fn dynamixel(self) -> Result<dynamixel::ServoSetup, WiringError> {
        let Self::Dynamixel(own) = self else { return Err(WiringError::Protocol) };
        own.setup()
    }

    fn feetech(self) -> Result<feetech::ServoSetup, WiringError> {
        let Self::Feetech(own) = self else { return Err(WiringError::Protocol) };
        Ok(own)
    }

    fn channel(self) -> Result<ChannelSetup, WiringError> {
        let Self::Channel(own) = self else { return Err(WiringError::Protocol) };
        Ok(own)
    }
}

impl Pulses {
    /// Returns the divider of the chip's clock.
    ///
    /// # Errors
    /// [`WiringError::Pulses`] if the clock cannot be divided to this rate.
    pub fn prescale(&self) -> Result<Prescale, WiringError> {
        Prescale::new(self.oscillator_hz, self.rate_hz).map_err(|_| WiringError::Pulses)
    }
}

/// Collects all items, if there is room.
fn all<T, const SERVOS: usize>(
    items: impl Iterator<Item = Result<T, WiringError>>,
) -> Result<Vec<T, SERVOS>, WiringError> {
    let mut all = Vec::new();
    for item in items {
        all.push(item?).map_err(|_| WiringError::Servos { holds: SERVOS })?;
    }
    Ok(all)
}
