//! Plausibility check of a servo's readings: a servo cannot turn arbitrarily far in a tick.
//!
//! A reading is expected at the last position plus the servo's previous movement. The tolerance is half of the play
//! of its gear and steps of its encoder ([`REST_RAD`]), the effect of twice its stall torque on its rotor alone
//! ([`EFFORT`]), and twice the expected movement, since the load may bounce. A reading outside of the tolerance is a
//! jump: of an encoder, a horn or bytes. The servo is then assumed at its expected position, and the jump is stored
//! as an offset, which is subtracted from the next readings. If a later reading fits better without the offset, the
//! jump has ended. The tracker therefore moves nothing because of a jump, whatever its size. [`Belief::is_jumped`]
//! reports a jump that stays.
//!
//! A jump that is smaller than the servo's possible movement in a tick is not detected, and the rig follows it: 1 deg
//! for an XL330 at 400 Hz, 1.7 deg for an STS3215 at 100 Hz, at standstill.
//!
//! A servo in position mode follows its own encoder: it moves before a board can know of the jump. Its goal
//! contains the offset as soon as the servo's own speed shows that the encoder has jumped; otherwise, from the time
//! at which the fault is detected. (If only the bytes of a reading were wrong, the servo has not moved.)

use sinew_servo_bus::{Command, Feedback};

use super::settings::ServoSetup;
use sinew_rig::servo::Servo;

/// Maximum deviation of a servo at rest, rad: a gear's play of 0.5 deg, and two steps of an encoder of 4096.
const REST_RAD: f32 = 0.012;
/// Factor from half the play of the gear and a step of its encoder to the maximum deviation at rest.
const REST: f32 = 1.5;
/// Torque that accelerates the rotor, as a multiple of the stall torque: the motor's, and as much from outside.
const EFFORT: f32 = 2.0;
/// Number of consecutive readings with an offset after which the jump is a fault: as many as replies may be missed
/// before a servo counts as silent.
const MOST: u8 = 5;
/// Number of readings after a jump in which the servo's own speed is not used, since it contains the jump.
const SETTLING: u8 = 30;
/// Increase of a profile's speed per offset, 1/s, so that the servo covers the offset within 1 ms.
const HASTE_PER_S: f32 = 1000.0;

/// Plausibility check of a servo.
#[derive(Debug, Clone, Copy)]
pub(super) struct Belief {
    rest_rad: f32,
    /// Maximum increase of the movement per tick, rad.
    gained_rad: f32,
    /// Movement in the last tick, rad.
    way_rad: f32,
    offset_rad: f32,
    /// Total number of readings that were not believed.
    count: u16,
    /// Number of consecutive readings with an offset.
    jumped: u8,
    /// Number of readings since the last jump.
    settled: u8,
    /// Whether the servo's own speed contains the jump.
    is_own: bool,
}

impl Belief {
    pub(super) fn new(servo: &Servo, setup: &ServoSetup, dt_s: f32) -> Self {
        let own = servo.settings();
        // If the rotor's inertia is not known, every movement is possible.
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

    /// Returns the believed value of a reading that follows the believed reading `before`. `late` is the number of
    /// ticks that were left out. The offset of a jump is subtracted. Without torque (`is_on` is false) a jump is
    /// reported for a while, and then believed.
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
            // NaN does not count as a jump.
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

    /// Returns whether a jump has lasted so long that it is a fault.
    pub(super) fn is_jumped(&self) -> bool {
        self.jumped >= MOST
    }

    /// Returns the total number of readings that were not believed.
    pub(super) fn count(&self) -> u32 {
        self.count.into()
    }

    /// Returns the command for a servo whose encoder may have jumped. A goal is shifted by the offset, because the
    /// servo follows its encoder.
    pub(super) fn sent(&self, command: Command) -> Command {
        if self.jumped == 0 || !(self.is_own || self.is_jumped()) {
            return command;
        }
        // For one tick the offset is doubled: the servo was accelerated by the jump, and is decelerated by the same
        // amount.
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
