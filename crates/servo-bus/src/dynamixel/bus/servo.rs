//! State of one servo of the bus: converts commands to goals in counts, and replies to readings.

use super::setup::{Mode, ServoSetup};
use crate::counts::{most_counts, profile_counts, step_counts};
use crate::dynamixel::status::{ErrorCode, Status};
use crate::dynamixel::table::{POSITION, PWM_COUNTS, VELOCITY, address};
use crate::servo_state::{Reading, ServoState, check_positive, count_range, limited};
use crate::table::Unit;
use crate::{Command, CommandError, Effort, Limit, Plausible, Schedule, SetupError};

const RAD_PER_COUNT: f32 = POSITION.scale;
const RAD_S_PER_COUNT: f32 = VELOCITY.scale;
/// Maximum profile velocity that the register can hold, in its counts.
const MOST_SPEED: i32 = 32_767;
const MOST_GAIN: u16 = 16_383;
/// Maximum position either way in the modes of several turns, counts: 256 turns.
const MOST_TURNS: i32 = 1_048_575;

#[derive(Debug, Clone)]
pub(super) struct Servo {
    pub(super) setup: ServoSetup,
    pub(super) state: ServoState,
    range: [i32; 2],
    pub(super) goals: Goals,
    /// Torque as it was last sent.
    torque: Option<bool>,
    /// Whether the servo is asked together with the others in this tick.
    pub(super) is_in_group: bool,
    /// Whether the servo did not answer when it was asked alone. Until it answers, it is left out of the group's read,
    /// because a silent servo breaks a fast sync read for the servos after it.
    pub(super) is_left_out: bool,
}

/// Commanded goals that are not sent yet, in counts.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Goals {
    pub(super) torque: Option<bool>,
    pub(super) gain: Option<u16>,
    pub(super) pwm: Option<i16>,
    pub(super) current: Option<i16>,
    pub(super) position: Option<i32>,
    /// Speed of the profile that leads to the position.
    pub(super) speed: Option<i32>,
}

impl Servo {
    pub(super) fn new(setup: ServoSetup, schedule: &Schedule) -> Result<Self, SetupError> {
        let id = setup.id;
        let bounds =
            if setup.mode == Mode::Position { [0, 4095] } else { [-MOST_TURNS, MOST_TURNS] };
        let range = count_range(id, setup.range_rad, RAD_PER_COUNT, bounds)?;
        check_positive(id, "speed_rad_s", setup.speed_rad_s)?;
        check_positive(id, "pwm", setup.pwm)?;
        check_positive(id, "current_a", setup.current_a)?;
        let has_current = setup.model.current.is_some();
        if matches!(setup.mode, Mode::Current | Mode::CurrentPosition) && !has_current {
            return Err(SetupError::Setting { id, what: "mode (the model has no current sensor)" });
        }
        let step = step_counts(setup.speed_rad_s, schedule.tick_us(), RAD_PER_COUNT);
        // A reading is valid even outside of the range of goals.
        let state = ServoState::new(Plausible::new([-MOST_TURNS, MOST_TURNS], step));
        let (is_in_group, is_left_out) = (false, false);
        let (goals, torque) = (Goals::default(), None);
        Ok(Self { setup, state, range, goals, torque, is_in_group, is_left_out })
    }

    /// Returns whether the servo's torque is commanded on.
    pub(super) fn is_on(&self) -> bool {
        self.torque == Some(true)
    }

    /// Clears the goals after all of them were written to this tick's packets.
    pub(super) fn planned(&mut self) {
        let goals = core::mem::take(&mut self.goals);
        if let Some(is_on) = goals.torque {
            self.torque = Some(is_on);
            // Torque off also clears the watchdog; it is read again when torque is on.
            self.state.health.has_stopped &= is_on;
        }
    }

    pub(super) fn command(&mut self, command: Command) -> Result<Option<Limit>, CommandError> {
        let mode = self.setup.mode;
        let mut goals = self.goals;
        let limit = match command {
            Command::Torque(on) => {
                goals.torque = Some(on);
                None
            }
            Command::Position(rad) if mode.is_position() => {
                let (counts, limit) = limited(rad, RAD_PER_COUNT, self.range, Limit::Position);
                (goals.position, goals.speed) = (Some(counts), None);
                limit
            }
            Command::PositionAt { position_rad, speed_rad_s } if mode.is_position() => {
                let (counts, limit) =
                    limited(position_rad, RAD_PER_COUNT, self.range, Limit::Position);
                goals.position = Some(counts);
                goals.speed = Some(profile_counts(speed_rad_s, RAD_S_PER_COUNT, MOST_SPEED));
                limit
            }
            Command::PositionWithin { position_rad, current_a }
                if mode == Mode::CurrentPosition =>
            {
                let (counts, limit) =
                    limited(position_rad, RAD_PER_COUNT, self.range, Limit::Position);
                let (current, current_limit) = self.current(current_a.max(0.0))?;
                goals.position = Some(counts);
                goals.current = Some(current);
                limit.or(current_limit)
            }
            Command::Current(a) if mode == Mode::Current => {
                let (current, limit) = self.current(a)?;
                goals.current = Some(current);
                limit
            }
            Command::Pwm(ratio) if mode == Mode::Pwm => {
                let scale = 1.0 / PWM_COUNTS as f32;
                let most = most_counts(self.setup.pwm, scale, PWM_COUNTS);
                let (counts, limit) =
                    limited(ratio, scale, [most.saturating_neg(), most], Limit::Pwm);
                goals.pwm = i16::try_from(counts).ok();
                limit
            }
            Command::Stiffness(gain) if mode.is_position() => {
                goals.gain = Some(gain.min(MOST_GAIN));
                (gain > MOST_GAIN).then_some(Limit::Stiffness)
            }
            Command::Position(_) | Command::PositionAt { .. } => {
                return Err(CommandError::Unsupported("position"));
            }
            Command::PositionWithin { .. } => {
                return Err(CommandError::Unsupported("position with a current"));
            }
            Command::Current(_) => return Err(CommandError::Unsupported("current")),
            Command::Pwm(_) => return Err(CommandError::Unsupported("PWM")),
            Command::Stiffness(_) => return Err(CommandError::Unsupported("stiffness")),
        };
        self.goals = goals;
        Ok(limit)
    }

    fn current(&self, a: f32) -> Result<(i16, Option<Limit>), CommandError> {
        let current = self.setup.model.current.ok_or(CommandError::Unsupported("current"))?;
        let most = most_counts(self.setup.current_a, current.unit_a, current.limit.into());
        let (counts, limit) =
            limited(a, current.unit_a, [most.saturating_neg(), most], Limit::Current);
        Ok((i16::try_from(counts).unwrap_or(0), limit))
    }

    /// Processes a reply to a read from `address`.
    pub(super) fn take(&mut self, status: &Status<'_>, address: u16, length: u16) {
        if !status.answers(self.setup.id, length.into()) {
            return;
        }
        self.is_left_out = false;
        let health = &mut self.state.health;
        health.alert = status.error.alert();
        health.last_error = status.error.code().map_or(0, ErrorCode::number);
        if !health.alert {
            health.hardware_error = 0;
        }
        // With an error the data are not a reading: the servo is alive, but has measured nothing.
        let data = if status.error.code().is_some() { &[] } else { status.data };
        match (address, data) {
            (address::PRESENT_CURRENT, &[c0, c1, v0, v1, v2, v3, p0, p1, p2, p3]) => {
                let effort = i16::from_le_bytes([c0, c1]);
                let reading = Reading {
                    position: i32::from_le_bytes([p0, p1, p2, p3]),
                    rad_per_count: RAD_PER_COUNT,
                    velocity_rad_s: i32::from_le_bytes([v0, v1, v2, v3]) as f32 * RAD_S_PER_COUNT,
                    effort: self.setup.model.current.map_or_else(
                        || Effort::Load(f32::from(effort) * Unit::PER_MILLE.scale),
                        |current| Effort::Current(f32::from(effort) * current.unit_a),
                    ),
                };
                self.state.answered();
                self.state.take(&reading);
            }
            (address::PRESENT_VOLTAGE, &[low, high, temperature]) => {
                health.voltage_v =
                    Some(f32::from(u16::from_le_bytes([low, high])) * Unit::DECIVOLT.scale);
                health.temperature_c = Some(f32::from(temperature));
                health.age_ticks = 0;
            }
            (address::HARDWARE_ERROR, &[bits]) => health.hardware_error = bits,
            (address::BUS_WATCHDOG, &[raw]) => health.has_stopped = raw.cast_signed() < 0,
            _ if address == address::PRESENT_CURRENT => {
                self.state.answered();
            }
            _ => {}
        }
    }
}
