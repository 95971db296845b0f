//! What is believed of a servo's readings: no more than it can have turned.
//!
//! A reading is expected where the last one was, as far on as the servo turned before. It can be off by half of the
//! play of its gear and steps of its encoder ([`REST_RAD`]), by what twice its stall torque does to its rotor alone
//! ([`EFFORT`]), and by twice the way that was expected, since what it moves may bounce. A reading that is farther off
//! is a jump, of an encoder, a horn or bytes: the servo counts as where it was expected, and the jump as an offset,
//! which is taken off the readings behind it. Readings behind a jump that fit better without the offset end it. The
//! tracker moves nothing for a jump then, whatever its size; [`Belief::is_jumped`] is found where it stays.
//!
//! A jump that is smaller than what the servo can turn in a tick is not seen, and followed: 1 deg of an XL330 at 400
//! Hz, 1.7 deg of an STS3215 at 100 Hz, if they stand.
//!
//! A servo by position follows its own encoder: before a board can know, it moves. It gets its goal with the offset as
//! soon as its own speed says that the jump is of its encoder, and not of bytes, which it does not follow; else with
//! the fault.

use sinew_servo_bus::{Command, Feedback};

use super::settings::ServoSetup;
use sinew_rig::servo::Servo;

/// What a servo can be off at rest, rad: the play of a gear of 0.5 deg, and two steps of an encoder of 4096.
const REST_RAD: f32 = 0.012;
/// The same, in half its play and a step of its encoder.
const REST: f32 = 1.5;
/// Torque that accelerates the rotor, in its stall torque: the motor's, and as much from outside.
const EFFORT: f32 = 2.0;
/// Readings in a row with an offset, until it is a fault: as many as replies that may be missed.
const MOST: u8 = 5;
/// Readings behind a jump in which the servo's own speed, which has the jump in it, counts for nothing.
const SETTLING: u8 = 30;
/// What a profile is sped up by, so that it has an offset within 1 ms, 1/s.
const HASTE_PER_S: f32 = 1000.0;

/// One servo.
#[derive(Debug, Clone, Copy)]
pub(super) struct Belief {
    rest_rad: f32,
    /// The way that it gains in a tick, at most, rad.
    gained_rad: f32,
    /// Its last way in a tick, rad.
    way_rad: f32,
    offset_rad: f32,
    /// Readings that were not believed, over all.
    count: u16,
    /// Readings with an offset, in a row.
    jumped: u8,
    /// Readings since the last jump.
    settled: u8,
    /// Its own speed has the jump in it.
    is_own: bool,
}

impl Belief {
    pub(super) fn new(servo: &Servo, setup: &ServoSetup, dt_s: f32) -> Self {
        let own = servo.settings();
        // Of a rotor that is not known every way can be.
        let gained_rad = EFFORT * setup.stall_nm / own.rotor_inertia_kg_m2 * dt_s * dt_s;
        let rest_rad = REST_RAD.max(REST * setup.rest_rad * own.gear.abs());
        Self {
            rest_rad,
            gained_rad,
            way_rad: 0.0,
            offset_rad: 0.0,
            count: 0,
            jumped: 0,
            settled: SETTLING,
            is_own: false,
        }
    }

    /// What is believed of a reading, behind what was believed `before`. `late`: ticks that were left out. Without
    /// torque (`is_on`) a jump is told for a while, and then believed.
    pub(super) fn step(
        &mut self,
        before: Option<Feedback>,
        read: Feedback,
        (dt_s, late): (f32, u32),
        is_on: bool,
    ) -> Feedback {
        let Some(before) = before.filter(|_| is_on || self.jumped < u8::MAX) else {
            (self.offset_rad, self.jumped) = (0.0, 0);
            self.way_rad = read.velocity_rad_s * dt_s;
            return read;
        };
        if read.age_ticks > 0 {
            return Feedback { age_ticks: read.age_ticks, ..before };
        }
        let ticks = before.age_ticks.saturating_add(1).saturating_add(late) as f32;
        let expected_rad = self.way_rad * ticks;
        let off_rad = read.position_rad - before.position_rad - expected_rad;
        let most_rad = self.rest_rad + self.gained_rad * ticks * ticks + 2.0 * expected_rad.abs();
        let kept_rad = off_rad - self.offset_rad;
        let is_kept =
            self.jumped > 0 && kept_rad.abs() < off_rad.abs() && kept_rad.abs() <= most_rad;
        self.settled = self.settled.saturating_add(1);
        if is_kept || off_rad.abs() > most_rad {
            if !is_kept {
                (self.offset_rad, self.settled) = (off_rad, 0);
                let more_rad = read.velocity_rad_s * dt_s - self.way_rad;
                self.is_own = more_rad.abs() > self.gained_rad && more_rad * off_rad > 0.0;
            }
            self.jumped = self.jumped.saturating_add(1);
            if self.jumped <= MOST {
                self.count = self.count.saturating_add(1);
            }
        } else {
            // NaN is no jump.
            if self.jumped > 0 {
                self.settled = 0;
            }
            (self.offset_rad, self.jumped) = (0.0, 0);
        }
        let position_rad = read.position_rad - self.offset_rad;
        self.way_rad = (position_rad - before.position_rad) / ticks;
        let velocity_rad_s =
            if self.settled < SETTLING { self.way_rad / dt_s } else { read.velocity_rad_s };
        Feedback { position_rad, velocity_rad_s, ..read }
    }

    /// Whether it has jumped, and stays there.
    pub(super) fn is_jumped(&self) -> bool {
        self.jumped >= MOST
    }

    /// Readings that were not believed, over all.
    pub(super) fn count(&self) -> u32 {
        self.count.into()
    }

    /// A command for a servo whose encoder has jumped: its goal, too, is in its encoder's counts.
    pub(super) fn sent(&self, command: Command) -> Command {
        if self.jumped == 0 || !(self.is_own || self.is_jumped()) {
            return command;
        }
        // For a tick it is sent as far to the other side: as it was pushed it is stopped.
        let is_first = self.is_own && self.settled == 0;
        let offset_rad = if is_first { 2.0 * self.offset_rad } else { self.offset_rad };
        match command {
            Command::Position(rad) => Command::Position(rad + offset_rad),
            Command::PositionAt { position_rad, speed_rad_s } => Command::PositionAt {
                position_rad: position_rad + offset_rad,
                speed_rad_s: speed_rad_s + HASTE_PER_S * offset_rad.abs(),
            },
            Command::PositionWithin { position_rad, current_a } => {
                Command::PositionWithin { position_rad: position_rad + offset_rad, current_a }
            }
            other => other,
        }
    }
}
