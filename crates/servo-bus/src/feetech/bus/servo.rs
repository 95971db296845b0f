//! State of one servo of the bus: converts commands to goals in counts, and replies to readings.

use super::setup::{Mode, ServoSetup, Settings};
use crate::counts::{most_counts, profile_counts, step_counts};
use crate::feetech::status::Status;
use crate::feetech::table::{CURRENT, Family};
use crate::servo_state::{Reading, ServoState, check_positive, count_range, limited};
use crate::table::Unit;
use crate::{Command, CommandError, Effort, Limit, Plausible, Schedule, SetupError};

/// Counts of full PWM: one count is 0.1 %.
const PWM_COUNTS: i32 = 1000;
/// Maximum profile speed that the register can hold without its sign bit, in counts.
const MOST_SPEED: i32 = 32_767;

#[derive(Debug, Clone)]
pub(super) struct Servo {
    pub(super) setup: ServoSetup,
    pub(super) state: ServoState,
    range: [i32; 2],
    pub(super) torque: Option<bool>,
    /// Torque as it was last commanded; off at the start.
    is_on: bool,
    pub(super) position: Option<i32>,
    /// Speed of the profile that leads to the position, in counts of speed.
    pub(super) speed: Option<i32>,
    pub(super) pwm: Option<i32>,
    /// Whether the servo was asked in this tick.
    pub(super) was_asked: bool,
}

impl Servo {
    pub(super) fn new(
        setup: ServoSetup,
        family: Family,
        schedule: &Schedule,
    ) -> Result<Self, SetupError> {
        let id = setup.id;
        let bounds = [0, family.most_count()];
        let range = count_range(id, setup.range_rad, family.rad_per_count(), bounds)?;
        check_positive(id, "speed_rad_s", setup.speed_rad_s)?;
        check_positive(id, "pwm", setup.pwm)?;
        let step = step_counts(setup.speed_rad_s, schedule.tick_us(), family.rad_per_count());
        let state = ServoState::new(Plausible::new(bounds, step));
        Ok(Self {
            setup,
            state,
            range,
            torque: None,
            is_on: false,
            position: None,
            speed: None,
            pwm: None,
            was_asked: false,
        })
    }

    pub(super) fn command(
        &mut self,
        command: Command,
        settings: Settings,
    ) -> Result<Option<Limit>, CommandError> {
        let family = settings.family;
        match command {
            Command::Torque(on) => {
                (self.torque, self.is_on) = (Some(on), on);
                if !on {
                    (self.position, self.speed, self.pwm) = (None, None, None);
                }
                Ok(None)
            }
            Command::Position(_) | Command::PositionAt { .. }
                if self.setup.mode == Mode::Position && !self.is_on =>
            {
                Ok(Some(Limit::TorqueOff))
            }
            Command::Position(rad) if self.setup.mode == Mode::Position => {
                let (counts, limit) =
                    limited(rad, family.rad_per_count(), self.range, Limit::Position);
                (self.position, self.speed) = (Some(counts), None);
                Ok(limit)
            }
            Command::PositionAt { position_rad, speed_rad_s }
                if self.setup.mode == Mode::Position =>
            {
                let (counts, limit) =
                    limited(position_rad, family.rad_per_count(), self.range, Limit::Position);
                self.position = Some(counts);
                self.speed =
                    Some(profile_counts(speed_rad_s, settings.rad_s_per_count(), MOST_SPEED));
                Ok(limit)
            }
            Command::Pwm(_) if self.setup.mode == Mode::Pwm && !self.is_on => {
                Ok(Some(Limit::TorqueOff))
            }
            Command::Pwm(ratio) if self.setup.mode == Mode::Pwm => {
                let scale = 1.0 / PWM_COUNTS as f32;
                let most = most_counts(self.setup.pwm, scale, PWM_COUNTS);
                let (counts, limit) =
                    limited(ratio, scale, [most.saturating_neg(), most], Limit::Pwm);
                self.pwm = Some(counts);
                Ok(limit)
            }
            Command::Position(_) | Command::PositionAt { .. } => {
                Err(CommandError::Unsupported("position"))
            }
            Command::Pwm(_) => Err(CommandError::Unsupported("PWM")),
            Command::PositionWithin { .. } => {
                Err(CommandError::Unsupported("position with a current"))
            }
            Command::Current(_) => Err(CommandError::Unsupported("current")),
            // The gains are in EEPROM, which stays locked.
            Command::Stiffness(_) => Err(CommandError::Unsupported("stiffness")),
        }
    }

    pub(super) fn take(&mut self, status: &Status<'_>, settings: Settings) {
        let family = settings.family;
        let Some((&[p0, p1, v0, v1, l0, l1, voltage, temperature], rest)) =
            status.data.split_first_chunk::<8>()
        else {
            return;
        };
        let current = match *rest {
            [_, _, _, _, _, low, high] => Some(family.signed([low, high], 15)),
            _ => None,
        };
        self.state.answered();
        let health = &mut self.state.health;
        health.alert = status.bits != 0;
        health.hardware_error = status.bits;
        health.voltage_v = Some(f32::from(voltage) * Unit::DECIVOLT.scale);
        health.temperature_c = Some(f32::from(temperature));
        health.age_ticks = 0;
        self.state.take(&Reading {
            position: family.signed([p0, p1], 15),
            rad_per_count: family.rad_per_count(),
            velocity_rad_s: family.signed([v0, v1], 15) as f32 * settings.rad_s_per_count(),
            effort: match current {
                Some(current) => Effort::Current(current as f32 * CURRENT.scale),
                None => Effort::Load(family.signed([l0, l1], 10) as f32 * Unit::PER_MILLE.scale),
            },
        });
    }
}
