//! The controller's side of up to 16 hobby servos.

use heapless::Vec;

use super::register::{CHANNELS, OFF, PERIOD, channel};
use super::setup::Prescale;
use crate::counts::round;
use crate::servo_state::{check_finite, check_positive};
use crate::settings::ServoRequirements;
use crate::sink::Sink;
use crate::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
    SetupError,
};

/// Setup of a servo on a channel: its pulses and the positions that they mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelSetup {
    /// Channel of the chip, 0 to 15.
    pub channel: u8,
    /// Pulses at the two ends of the range, us. 1000 and 2000 are safe for all servos; use a wider range only after
    /// calibration. The second pulse may be shorter than the first.
    pub pulse_us: [f32; 2],
    /// Positions at these pulses, rad, the smaller first. They are also the range of the servo.
    pub range_rad: [f32; 2],
}

/// A PCA9685 and its servos. The servos give no feedback, so they are never read.
#[derive(Debug, Clone)]
pub struct Bus {
    servos: Vec<ChannelSetup, CHANNELS>,
    prescale: Prescale,
    i2c_hz: u32,
    channels: [Channel; CHANNELS],
}

#[derive(Debug, Clone, Copy)]
struct Channel {
    /// Length of the pulse in counts; `None` before the first command.
    counts: Option<u16>,
    is_on: bool,
    is_changed: bool,
}

impl Bus {
    /// Creates a bus for these servos on a chip with this pulse rate. `i2c_hz` is the bit rate of I2C.
    ///
    /// # Errors
    /// [`SetupError`] names the channel and the wrong setting. Pulses must be longer than 100 us and shorter than the
    /// period.
    pub fn new(
        setups: &[ChannelSetup],
        prescale: Prescale,
        i2c_hz: u32,
    ) -> Result<Self, SetupError> {
        let mut servos: Vec<ChannelSetup, CHANNELS> = Vec::new();
        for setup in setups {
            let id = setup.channel;
            if usize::from(id) >= CHANNELS {
                return Err(SetupError::Id(id));
            }
            if servos.iter().any(|other| other.channel == id) {
                return Err(SetupError::Shared(id));
            }
            let [least, most] = setup.range_rad;
            if !(least.is_finite() && most.is_finite()) || least >= most {
                return Err(SetupError::Setting { id, what: "range_rad" });
            }
            let most_us = prescale.step_us() * f32::from(PERIOD);
            for pulse_us in setup.pulse_us {
                check_positive(id, "pulse_us", pulse_us)?;
                if !(100.0..most_us).contains(&pulse_us) {
                    return Err(SetupError::Setting { id, what: "pulse_us" });
                }
            }
            servos.push(*setup).map_err(|_| SetupError::Capacity { holds: CHANNELS })?;
        }
        let channels = [Channel { counts: None, is_on: false, is_changed: false }; CHANNELS];
        Ok(Self { servos, prescale, i2c_hz, channels })
    }
}

impl Channel {
    /// Returns the register bytes of a channel. Pulses of different channels start one after the other, so that not all
    /// servos draw current at once.
    fn bytes(self, index: usize) -> [u8; 4] {
        let Some(counts) = self.counts.filter(|_| self.is_on) else { return OFF };
        let on = u16::try_from(index).unwrap_or(0).wrapping_mul(PERIOD / 16) % PERIOD;
        let off = on.wrapping_add(counts) % PERIOD;
        let ([a, b], [c, d]) = (on.to_le_bytes(), off.to_le_bytes());
        [a, b, c, d]
    }
}

impl ServoBus for Bus {
    fn len(&self) -> usize {
        self.servos.len()
    }

    /// [`Command::Torque`] switches the pulses on or off. Pulses begin only after a first position.
    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        let count = self.servos.len();
        let setup = self.servos.get(servo).ok_or(CommandError::Servo { index: servo, count })?;
        check_finite(&command)?;
        let index = usize::from(setup.channel);
        let channel =
            self.channels.get_mut(index).ok_or(CommandError::Servo { index: servo, count })?;
        match command {
            Command::Torque(on) => {
                channel.is_changed |= channel.is_on != on;
                channel.is_on = on;
                Ok(None)
            }
            Command::Position(rad) => {
                let [least, most] = setup.range_rad;
                let held = rad.max(least).min(most);
                let [first_us, second_us] = setup.pulse_us;
                let pulse_us =
                    first_us + (second_us - first_us) * ((held - least) / (most - least));
                let counts = round(
                    pulse_us / self.prescale.step_us(),
                    [1, i32::from(PERIOD).saturating_sub(1)],
                );
                let counts = u16::try_from(counts).ok();
                channel.is_changed |= channel.counts != counts;
                channel.counts = counts;
                Ok((held.to_bits() != rad.to_bits()).then_some(Limit::Position))
            }
            Command::PositionWithin { .. } => {
                Err(CommandError::Unsupported("position with a current"))
            }
            Command::PositionAt { .. } => Err(CommandError::Unsupported("position with a speed")),
            Command::Current(_) => Err(CommandError::Unsupported("current")),
            Command::Pwm(_) => Err(CommandError::Unsupported("PWM")),
            Command::Stiffness(_) => Err(CommandError::Unsupported("stiffness")),
        }
    }

    /// Writes all channels that changed, and those between them, in one I2C write; writes nothing if no channel
    /// changed.
    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        let changed = || self.channels.iter().enumerate().filter(|(_, channel)| channel.is_changed);
        let (Some((first, _)), Some((last, _))) = (changed().next(), changed().next_back()) else {
            return Ok(Request::default());
        };
        let mut sink = Sink::new(out);
        sink.extend(&[channel(first)]);
        for (index, channel) in
            self.channels.iter().enumerate().take(last.saturating_add(1)).skip(first)
        {
            sink.extend(&channel.bytes(index));
        }
        let len = sink.finish()?;
        for channel in &mut self.channels {
            channel.is_changed = false;
        }
        // Bits on the wire: 9 for each byte and for the address, plus start and stop.
        let bits = u64::try_from(len)
            .unwrap_or(u64::MAX)
            .saturating_add(1)
            .saturating_mul(9)
            .saturating_add(2);
        let time_us = bits.saturating_mul(1_000_000).div_ceil(u64::from(self.i2c_hz.max(1)));
        Ok(Request { len, reply_len: 0, time_us: u32::try_from(time_us).unwrap_or(u32::MAX) })
    }

    fn plan_more(
        &mut self,
        _left_us: u32,
        _out: &mut [u8],
    ) -> Result<Option<Request>, EncodeError> {
        Ok(None)
    }

    fn reply(&mut self, _bytes: &[u8]) -> bool {
        true
    }

    /// Ignores the request: hobby servos have no registers.
    fn compare(&mut self, _asked: Option<(usize, ServoRequirements)>) {}

    fn compared(&self) -> Compared {
        Compared::Nothing
    }

    fn feedback(&self, _servo: usize) -> Option<Feedback> {
        None
    }

    fn health(&self, servo: usize) -> Option<Health> {
        self.servos.get(servo).map(|_| Health::default())
    }
}
