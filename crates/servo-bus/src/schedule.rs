//! What rate a bus allows, and which servos are read in which tick.

use core::fmt;

/// How fast a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Bits per second; a byte has ten.
    pub baud: u32,
    /// How long a servo waits before it answers.
    pub return_delay_us: u32,
    /// How long the controller takes from the last byte of one packet to the first of what follows: its own line
    /// driver, an adapter.
    pub turnaround_us: u32,
}

/// Bytes of a packet for several servos.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cost {
    /// However many servos there are.
    pub fixed: u32,
    /// For each servo.
    pub each: u32,
}

impl Cost {
    /// Bytes for so many servos.
    pub fn bytes(self, servos: u32) -> u32 {
        if servos == 0 { 0 } else { self.fixed.saturating_add(self.each.saturating_mul(servos)) }
    }
}

/// What goes over a bus in a tick. Bytes are without stuffing: it adds a byte where data have FF FF FD in a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Traffic {
    /// How many servos.
    pub servos: u32,
    /// Commands to all, in every tick.
    pub write: Cost,
    /// The question to the servos that are read.
    pub ask: Cost,
    /// Their answers.
    pub answer: Cost,
    /// Whether every servo waits for its return delay, or only the first.
    pub delay_each: bool,
    /// Whether every servo is asked by itself, so that the controller's turnaround comes as often.
    pub ask_each: bool,
    /// Bytes of one question and its answer besides: what is read seldom, or asked again. 0 for none.
    pub extra: u32,
}

/// How the reads of a bus are spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Schedule {
    tick_us: u32,
    groups: u32,
    busy_us: u32,
    timing: Timing,
}

/// The bus cannot do what is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScheduleError {
    /// Commands and one read do not fit in a tick.
    TooFast {
        /// What was asked for.
        asked_hz: u32,
        /// What is possible, with one servo read in a tick.
        most_hz: u32,
    },
    /// Rate, baud or number of servos is zero, or too large.
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
    /// How long so many bytes take, rounded up.
    pub fn bytes_us(&self, bytes: u32) -> u32 {
        let bit_ns = u64::from(bytes).saturating_mul(10_000_000);
        let us = bit_ns.div_ceil(u64::from(self.baud.max(1)));
        u32::try_from(us).unwrap_or(u32::MAX)
    }

    /// How long one question and its answer take.
    pub fn request_us(&self, out: u32, back: u32) -> u32 {
        let waits =
            if back == 0 { 0 } else { self.return_delay_us.saturating_add(self.turnaround_us) };
        self.bytes_us(out.saturating_add(back)).saturating_add(waits)
    }
}

impl Traffic {
    /// The same with commands of so many bytes to each servo: 8 for a position and a speed of a Dynamixel, 6 of a
    /// Feetech.
    #[must_use]
    pub fn with_goal(mut self, goal_len: u32) -> Self {
        // Its id comes before.
        self.write.each = goal_len.saturating_add(1);
        self
    }

    /// How long a tick is busy that writes all servos and reads so many.
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
    /// As many reads in a tick of `rate_hz` as fit.
    ///
    /// # Errors
    /// [`ScheduleError::TooFast`] with the rate that is possible; [`ScheduleError::Number`].
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

    /// The fastest rate at which every servo is read in every tick, Hz.
    pub fn fastest_hz(timing: &Timing, traffic: &Traffic) -> u32 {
        1_000_000_u32.checked_div(traffic.busy_us(timing, traffic.servos).max(1)).unwrap_or(0)
    }

    /// The length of a tick, us.
    pub fn tick_us(&self) -> u32 {
        self.tick_us
    }

    /// In how many ticks every servo is read once.
    pub fn groups(&self) -> u32 {
        self.groups
    }

    /// How long the bus is busy in a tick, us.
    pub fn busy_us(&self) -> u32 {
        self.busy_us
    }

    /// How often each servo is read, Hz.
    pub fn read_hz(&self) -> f32 {
        1e6 / (self.tick_us.max(1) as f32 * self.groups as f32)
    }

    /// How fast the line is.
    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// Whether servo `index` is read in tick `tick`.
    pub fn reads(&self, tick: u32, index: usize) -> bool {
        let group = tick.checked_rem(self.groups).unwrap_or(0);
        u32::try_from(index).ok().and_then(|index| index.checked_rem(self.groups)) == Some(group)
    }
}
