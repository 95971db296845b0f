//! Reads positions with their times.

use std::time::Duration;

use sinew_servo_bus::table::Item;

use crate::table::Role;
use crate::{Client, Exchange, ServiceError, Servo, Table};

/// Minimum interval of readings: the servo's own program does not measure faster.
const PERIOD: Duration = Duration::from_micros(700);
/// Number of counts, in ms, after which the register Realtime Tick of a Dynamixel starts again at 0.
const TICKS: i32 = 32_768;

/// The clock that times the readings of a servo.
pub(super) enum Clock {
    /// The servo's own clock, in ms, read together with the position: adapters and hosts may answer late.
    Own(Item, Item),
    /// The host's clock, for a servo without a clock.
    Host(Item),
}

/// One reading, in counts, with the host's time and the servo's own time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    pub(super) host: Duration,
    own_ms: i32,
    pub(super) counts: i32,
}

impl Clock {
    pub(super) fn of(table: &Table) -> Result<Self, ServiceError> {
        let present = table.role(Role::PresentPosition)?;
        Ok(match table {
            Table::Dynamixel(_) => Self::Own(table.register("Realtime Tick")?, present),
            Table::Feetech(_) => Self::Host(present),
        })
    }

    /// Reads until the time `end`, as fast as line and servo allow, and appends the measurements that are new.
    pub(super) fn read_until<E: Exchange>(
        &self,
        client: &mut Client<E>,
        servo: &Servo,
        end: Duration,
        readings: &mut Vec<Reading>,
    ) -> Result<(), ServiceError> {
        let mut next = Duration::ZERO;
        loop {
            if let Some(gap) = next.checked_sub(client.now()) {
                client.pause(gap);
            }
            next = client.now() + PERIOD;
            let reading = self.read(client, servo)?;
            // A measurement that was read twice counts once.
            let is_new = match self {
                Self::Own(..) => readings.last().is_none_or(|last| last.own_ms != reading.own_ms),
                Self::Host(_) => true,
            };
            if is_new {
                readings.push(reading);
            }
            if reading.host >= end {
                return Ok(());
            }
        }
    }

    fn read<E: Exchange>(
        &self,
        client: &mut Client<E>,
        servo: &Servo,
    ) -> Result<Reading, ServiceError> {
        match self {
            Self::Own(tick, present) => {
                let length = present.address + u16::from(present.size) - tick.address;
                let (bytes, _) = client.read_bytes(servo.id, tick.address, length)?;
                let value = |item: &Item| {
                    let at = usize::from(item.address - tick.address);
                    item.value(bytes.get(at..).unwrap_or_default(), servo.table.order())
                };
                Ok(Reading { host: client.now(), own_ms: value(tick), counts: value(present) })
            }
            Self::Host(present) => {
                let counts = client.read(servo, present)?;
                Ok(Reading { host: client.now(), own_ms: 0, counts })
            }
        }
    }

    /// Returns times, s, since a moment of the host's clock, with positions in counts. The offset of the servo's own
    /// clock is the mean over all readings.
    pub(super) fn since(&self, moment: Duration, readings: &[Reading]) -> Vec<(f64, i32)> {
        let host_s = |reading: &Reading| reading.host.as_secs_f64() - moment.as_secs_f64();
        let mut times_s: Vec<f64> = readings.iter().map(host_s).collect();
        if let (Self::Own(..), Some(first)) = (self, readings.first()) {
            let own_s = |reading: &Reading| {
                1e-3 * f64::from((reading.own_ms - first.own_ms).rem_euclid(TICKS))
            };
            let late: f64 = readings.iter().map(|at| host_s(at) - own_s(at)).sum();
            let late = late / readings.len() as f64;
            times_s = readings.iter().map(|reading| own_s(reading) + late).collect();
        }
        times_s.into_iter().zip(readings.iter().map(|reading| reading.counts)).collect()
    }
}
