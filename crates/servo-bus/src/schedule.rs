//! Computes the rate that a bus allows, and decides which servos are read in which tick.

use core::fmt;

/// Speed and delays of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Baud rate, bits per second. A byte takes ten bits.
    pub baud: u32,
    /// Delay of a servo before it answers, us.
    pub return_delay_us: u32,
    /// Time that the controller needs between the last byte of one packet and the first byte of the next, us: for its
    /// line driver or adapter.
    pub turnaround_us: u32,
}

/// Length of a packet for several servos, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cost {
    /// Bytes that do not depend on the number of servos.
    pub fixed: u32,
    /// Additional bytes for each servo.
    pub each: u32,
}

impl Cost {
    /// Returns the length for `servos` servos; 0 for none.
    pub fn bytes(self, servos: u32) -> u32 {
        if servos == 0 { 0 } else { self.fixed.saturating_add(self.each.saturating_mul(servos)) }
    }
}

/// Traffic on a bus in one tick, in bytes without stuffing. Stuffing adds a byte for each FF FF FD in the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Traffic {
    /// Number of servos.
    pub servos: u32,
    /// Commands to all servos, in every tick.
    pub write: Cost,
    /// Question to the servos that are read.
    pub ask: Cost,
    /// Answers of the servos that are read.
    pub answer: Cost,
    /// Whether every servo waits for its return delay, or only the first servo.
    pub delay_each: bool,
    /// Whether every servo is asked alone, which costs the controller's turnaround each time.
    pub ask_each: bool,
    /// Bytes of one additional question with its answer, for rare reads and repeated questions; 0 for none.
    pub extra: u32,
}

/// A plan that spreads the reads of a bus over ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Schedule {
    tick_us: u32,
    groups: u32,
    busy_us: u32,
    timing: Timing,
}

/// The error that a bus cannot reach the requested rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScheduleError {
    /// The commands and one read do not fit in a tick.
    TooFast {
        /// Requested rate, Hz.
        asked_hz: u32,
        /// Maximum rate with one servo read in each tick, Hz.
        most_hz: u32,
    },
    /// Rate, baud rate or number of servos is zero, or too large.
    Number,
}

impl fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFast { asked_hz, most_hz } => {
                write!(
                    f,
                    "the bus cannot do {asked_hz} Hz; at most {most_hz} Hz, with one servo read in a tick"
                )
            }
            Self::Number => {
                f.write_str("rate, baud and number of servos must be from 1 to 10 million")
            }
        }
    }
}

impl core::error::Error for ScheduleError {}

impl Timing {
    /// Returns the time of `bytes` bytes on the line, us, rounded up.
    pub fn bytes_us(&self, bytes: u32) -> u32 {
        let bit_ns = u64::from(bytes).saturating_mul(10_000_000);
        let us = bit_ns.div_ceil(u64::from(self.baud.max(1)));
        u32::try_from(us).unwrap_or(u32::MAX)
    }

    /// Returns the time of one question of `out` bytes and its answer of `back` bytes, us.
    pub fn request_us(&self, out: u32, back: u32) -> u32 {
        let waits =
            if back == 0 { 0 } else { self.return_delay_us.saturating_add(self.turnaround_us) };
        self.bytes_us(out.saturating_add(back)).saturating_add(waits)
    }
}

impl Traffic {
    /// Sets the length of the command to each servo, in bytes: for position and speed, 8 for a Dynamixel and 6 for a
    /// Feetech.
    #[must_use]
    pub fn with_goal(mut self, goal_len: u32) -> Self {
        // The servo's id precedes its command.
        self.write.each = goal_len.saturating_add(1);
        self
    }

    /// Returns how long the bus is busy in a tick that writes all servos and reads `read` of them, us.
    pub fn busy_us(&self, timing: &Timing, read: u32) -> u32 {
        let bytes = self.write.bytes(self.servos);
        let bytes =
            bytes.saturating_add(self.ask_bytes(read)).saturating_add(self.answer_bytes(read));
        let delays = if self.delay_each { read } else { read.min(1) };
        let turns = if self.ask_each { read } else { read.min(1) };
        let extra_turns = u32::from(self.extra > 0);
        timing
            .bytes_us(bytes.saturating_add(self.extra))
            .saturating_add(
                delays.saturating_add(extra_turns).saturating_mul(timing.return_delay_us),
            )
            .saturating_add(turns.saturating_add(extra_turns).saturating_mul(timing.turnaround_us))
    }

    fn ask_bytes(&self, read: u32) -> u32 {
        if self.ask_each { self.ask.bytes(1).saturating_mul(read) } else { self.ask.bytes(read) }
    }

    fn answer_bytes(&self, read: u32) -> u32 {
        self.answer.bytes(read)
    }
}

impl Schedule {
    /// Creates a schedule at `rate_hz`, with as many reads in each tick as fit.
    ///
    /// # Errors
    /// [`ScheduleError::TooFast`] with the maximum rate; [`ScheduleError::Number`] for an invalid number.
    pub fn new(timing: Timing, traffic: &Traffic, rate_hz: u32) -> Result<Self, ScheduleError> {
        let plain = |number: u32| (1..=10_000_000).contains(&number);
        if !plain(timing.baud) || !plain(rate_hz) || !plain(traffic.servos) {
            return Err(ScheduleError::Number);
        }
        let tick_us = 1_000_000_u32.checked_div(rate_hz).unwrap_or(0);
        for groups in 1..=traffic.servos {
            let read = traffic.servos.div_ceil(groups);
            let busy_us = traffic.busy_us(&timing, read);
            if busy_us <= tick_us {
                return Ok(Self { tick_us, groups, busy_us, timing });
            }
        }
        let least_us = traffic.busy_us(&timing, 1).max(1);
        let most_hz = 1_000_000_u32.checked_div(least_us).unwrap_or(0);
        Err(ScheduleError::TooFast { asked_hz: rate_hz, most_hz })
    }

    /// Returns the maximum rate at which every servo is read in every tick, Hz.
    pub fn fastest_hz(timing: &Timing, traffic: &Traffic) -> u32 {
        1_000_000_u32.checked_div(traffic.busy_us(timing, traffic.servos).max(1)).unwrap_or(0)
    }

    /// Returns the length of a tick, us.
    pub fn tick_us(&self) -> u32 {
        self.tick_us
    }

    /// Returns the number of ticks in which every servo is read once.
    pub fn groups(&self) -> u32 {
        self.groups
    }

    /// Returns how long the bus is busy in a tick, us.
    pub fn busy_us(&self) -> u32 {
        self.busy_us
    }

    /// Returns the rate at which each servo is read, Hz.
    pub fn read_hz(&self) -> f32 {
        1e6 / (self.tick_us.max(1) as f32 * self.groups as f32)
    }

    /// Returns speed and delays of the line.
    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// Returns whether servo `index` is read in tick `tick`.
    pub fn reads(&self, tick: u32, index: usize) -> bool {
        let group = tick.checked_rem(self.groups).unwrap_or(0);
        u32::try_from(index).ok().and_then(|index| index.checked_rem(self.groups)) == Some(group)
    }
}
