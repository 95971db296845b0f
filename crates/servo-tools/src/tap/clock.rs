//! Readings of a position, each with its time.

use std::time::Duration;

use sinew_servo_bus::table::Item;

use crate::table::Role;
use crate::{Client, Exchange, ServiceError, Servo, Table};

/// Its own program measures no faster.
const PERIOD: Duration = Duration::from_micros(700);
/// Realtime Tick of a Dynamixel counts milliseconds up to this.
const TICKS: i32 = 32_768;

/// How a servo's readings get their time.
pub(super) enum Clock {
    /// Its own, in ms, in one read with the position: adapters and hosts may answer late.
    Own(Item, Item),
    /// The host's, where the servo has none.
    Host(Item),
}

/// One reading.
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

    /// Reads as often as line and servo allow.
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
            // A measurement that was read twice is one.
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

    /// Returns times since a moment of the host, s, and counts. The servo's own clock is set by the mean of all
    /// readings.
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
