//! The state that a bus keeps of one servo, for any protocol.

use heapless::Vec;

use crate::counts::round;
use crate::{Command, CommandError, Effort, Feedback, Health, Limit, Plausible, SetupError};

/// Readings and errors of one servo.
#[derive(Debug, Clone)]
pub(crate) struct ServoState {
    pub(crate) feedback: Option<Feedback>,
    pub(crate) health: Health,
    position: Plausible,
    /// Whether the servo was asked in this tick and has not answered.
    pub(crate) is_awaited: bool,
}

/// One reading: position in counts, the rest in SI units.
pub(crate) struct Reading {
    pub(crate) position: i32,
    pub(crate) rad_per_count: f32,
    pub(crate) velocity_rad_s: f32,
    pub(crate) effort: Effort,
}

impl ServoState {
    pub(crate) fn new(position: Plausible) -> Self {
        Self { feedback: None, health: Health::default(), position, is_awaited: false }
    }

    /// Begins a tick: counts a missing reply, and increases the age of the readings.
    pub(crate) fn age(&mut self) {
        if core::mem::take(&mut self.is_awaited) {
            self.health.missed = self.health.missed.saturating_add(1);
            self.health.missed_in_a_row = self.health.missed_in_a_row.saturating_add(1);
        }
        self.health.age_ticks = self.health.age_ticks.saturating_add(1);
        if let Some(feedback) = &mut self.feedback {
            feedback.age_ticks = feedback.age_ticks.saturating_add(1);
        }
    }

    /// Records an answer. Returns whether the servo was asked.
    pub(crate) fn answered(&mut self) -> bool {
        self.health.missed_in_a_row = 0;
        core::mem::take(&mut self.is_awaited)
    }

    pub(crate) fn take(&mut self, reading: &Reading) {
        let steps = self.feedback.map_or(1, |feedback| feedback.age_ticks.max(1));
        let Some(position) = self.position.accept(reading.position, steps) else {
            self.health.not_believed = self.health.not_believed.saturating_add(1);
            return;
        };
        self.feedback = Some(Feedback {
            position_rad: position as f32 * reading.rad_per_count,
            velocity_rad_s: reading.velocity_rad_s,
            effort: reading.effort,
            age_ticks: 0,
        });
    }
}

/// Creates the servos of a bus from their setups. Ids must be unique and at most `most_id`.
pub(crate) fn servos_of<Setup: Copy, Servo, const SERVOS: usize>(
    setups: &[Setup],
    id_of: impl Fn(&Setup) -> u8,
    most_id: u8,
    servo_of: impl Fn(Setup) -> Result<Servo, SetupError>,
) -> Result<Vec<Servo, SERVOS>, SetupError> {
    let mut servos = Vec::new();
    each_servo(setups, id_of, most_id, |setup| {
        servos.push(servo_of(setup)?).map_err(|_| SetupError::Capacity { holds: SERVOS })
    })?;
    Ok(servos)
}

/// Checks that [`servos_of`] would accept these setups, without memory for all servos at once.
pub(crate) fn check_servos<Setup: Copy, Servo, const SERVOS: usize>(
    setups: &[Setup],
    id_of: impl Fn(&Setup) -> u8,
    most_id: u8,
    servo_of: impl Fn(Setup) -> Result<Servo, SetupError>,
) -> Result<(), SetupError> {
    each_servo(setups, id_of, most_id, |setup| servo_of(setup).map(drop))?;
    if setups.len() > SERVOS { Err(SetupError::Capacity { holds: SERVOS }) } else { Ok(()) }
}

fn each_servo<Setup: Copy>(
    setups: &[Setup],
    id_of: impl Fn(&Setup) -> u8,
    most_id: u8,
    mut take: impl FnMut(Setup) -> Result<(), SetupError>,
) -> Result<(), SetupError> {
    for (index, setup) in setups.iter().enumerate() {
        let id = id_of(setup);
        if id > most_id {
            return Err(SetupError::Id(id));
        }
        if setups.iter().take(index).any(|other| id_of(other) == id) {
            return Err(SetupError::Shared(id));
        }
        take(*setup)?;
    }
    Ok(())
}

/// Converts a number to counts within bounds. Also returns `limit` if the number was cut.
pub(crate) fn limited(
    value: f32,
    scale: f32,
    bounds: [i32; 2],
    limit: Limit,
) -> (i32, Option<Limit>) {
    let wanted = round(value / scale, [i32::MIN, i32::MAX]);
    let [least, most] = bounds;
    let held = wanted.max(least).min(most);
    (held, (held != wanted).then_some(limit))
}

/// Refuses NaN and infinite numbers, before any number is limited.
pub(crate) fn check_finite(command: &Command) -> Result<(), CommandError> {
    let all = |numbers: &[f32], what| {
        let is_finite = numbers.iter().all(|number| number.is_finite());
        if is_finite { Ok(()) } else { Err(CommandError::NotFinite(what)) }
    };
    match *command {
        Command::Torque(_) | Command::Stiffness(_) => Ok(()),
        Command::Position(rad) => all(&[rad], "position"),
        Command::PositionWithin { position_rad, current_a } => {
            all(&[position_rad, current_a], "position or current")
        }
        Command::PositionAt { position_rad, speed_rad_s } => {
            all(&[position_rad, speed_rad_s], "position or speed")
        }
        Command::Current(a) => all(&[a], "current"),
        Command::Pwm(ratio) => all(&[ratio], "PWM"),
    }
}

/// Converts a range in rad to counts, rounded inwards.
pub(crate) fn count_range(
    id: u8,
    [least, most]: [f32; 2],
    scale: f32,
    bounds: [i32; 2],
) -> Result<[i32; 2], SetupError> {
    if !(least.is_finite() && most.is_finite() && least <= most) {
        return Err(SetupError::Setting { id, what: "range_rad" });
    }
    let range = [round(least / scale + 0.5, bounds), round(most / scale - 0.5, bounds)];
    let [low, high] = range;
    if low > high { Err(SetupError::Setting { id, what: "range_rad" }) } else { Ok(range) }
}

/// Checks that a number is finite and positive.
pub(crate) fn check_positive(id: u8, what: &'static str, value: f32) -> Result<(), SetupError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(SetupError::Setting { id, what }) }
}
