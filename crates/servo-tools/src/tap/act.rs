//! A servo that is tapped: what is written to it, and read meanwhile.

use std::time::Duration;

use sinew_servo_bus::table::{Item, Range};

use super::fit::Tap;
use crate::identify::{ensure_it_stands_in_position_mode, ensure_no_fault, set_all};
use crate::quantity::Scale;
use crate::store::{set_torque, store, torque_is_on};
use crate::table::Role;
use crate::{Client, Exchange, ServiceError, Servo, Table};

/// Where its goal is while it creeps and is tapped, degrees from where it stood: it does not get there.
pub(super) const GOAL_DEG: f64 = 35.0;
/// It has begun to creep when it has moved by so many counts.
const MOVES: i32 = 3;
/// The limit of torque grows by so much every [`RAMP`] until it creeps.
const RAMP_PART: f64 = 0.005;
const RAMP: Duration = Duration::from_millis(8);
/// The most that it may take to creep, of its full torque.
const MOST_CREEP: f64 = 0.6;
/// It is read for so long before the tap.
const BEFORE: Duration = Duration::from_millis(25);
/// It speeds up by so much of its full torque meanwhile.
const PRELOAD_PART: f64 = 0.1;
/// Its own program measures no faster.
const READING: Duration = Duration::from_micros(700);
/// It comes back and stands.
const SETTLE: Duration = Duration::from_millis(200);
/// It stands when it moves by no more than a count for so long; it is waited for no longer than [`MOST_SETTLE`].
const STANDS: Duration = Duration::from_millis(80);
const MOST_SETTLE: Duration = Duration::from_secs(4);
/// It goes back with so much more than gravity takes, of its full torque.
const BACK_PART: f64 = 0.3;

/// Which way to tap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Towards larger positions.
    Up,
    /// Towards smaller ones.
    Down,
    /// In turn.
    Both,
}

/// How to tap.
pub(super) struct Plan {
    pub(super) taps: u32,
    pub(super) direction: Direction,
    /// Step, of the full torque.
    pub(super) strength: f64,
    /// What gravity takes, of the full torque.
    pub(super) gravity_part: f64,
    /// How long it speeds up before the step, s.
    pub(super) preload_s: f64,
    /// How long to read after the step, s.
    pub(super) window_s: f64,
    /// Factor on the gain of position.
    pub(super) gain: f64,
}

/// Registers that a tap needs.
struct Registers {
    goal: Item,
    present: Item,
    limit: Item,
    most: i32,
    /// Gain of position, as it is and as it is while tapped; none where it stays.
    gain: Option<(Item, [i32; 2])>,
}

/// Taps, and gives what was read.
pub(super) fn record<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    plan: &Plan,
    goes_on: &mut dyn FnMut(u32) -> bool,
) -> Result<Vec<Tap>, ServiceError> {
    ensure_no_fault(client, servo)?;
    let was_on = torque_is_on(client, servo)?;
    ensure_it_stands_in_position_mode(client, servo, was_on)?;
    let registers = registers(client, servo, plan)?;
    let held = client.read(servo, if was_on { &registers.goal } else { &registers.present })?;
    ensure_room(client, servo, plan, held)?;
    let settings = settings(client, servo, &registers, plan)?;
    let mut before = Vec::new();
    for (item, _) in &settings {
        before.push((*item, client.read(servo, item)?));
    }
    if let Some((gain, [shipped, _])) = registers.gain {
        before.push((gain, shipped));
    }
    let recorded = set_all(client, servo, &settings).and_then(|()| {
        store(client, servo, &registers.goal, held)?;
        if !was_on {
            set_torque(client, servo, true)?;
        }
        let mut taps = Vec::new();
        for index in 0..plan.taps {
            if !goes_on(index) {
                let what = "the test was ended; it stands as before".to_owned();
                return Err(ServiceError::State { id: servo.id, what });
            }
            let is_up = match plan.direction {
                Direction::Up => true,
                Direction::Down => false,
                Direction::Both => index % 2 == 0,
            };
            taps.push(one(client, servo, &registers, plan, held, if is_up { 1 } else { -1 })?);
        }
        Ok(taps)
    });
    // What is weak is strong again only when nothing moves.
    let calm = store(client, servo, &registers.goal, held).and_then(|()| {
        if was_on { Ok(()) } else { set_torque(client, servo, false) }
    });
    let restored = set_all(client, servo, &before);
    let taps = recorded?;
    calm.and(restored)?;
    Ok(taps)
}

fn registers<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    plan: &Plan,
) -> Result<Registers, ServiceError> {
    let table = &servo.table;
    let (limit, gain) = match table {
        Table::Dynamixel(_) => {
            let gain = table.register("Position P Gain")?;
            let shipped = client.read(servo, &gain)?;
            let most = match gain.range {
                Range::Between(_, most) => most,
                _ => shipped,
            };
            #[expect(clippy::cast_possible_truncation, reason = "it is clamped to the register's range")]
            let raised = (f64::from(shipped) * plan.gain).min(f64::from(most)) as i32;
            (table.register("Goal PWM")?, Some((gain, [shipped, raised])))
        }
        Table::Feetech(_) => (table.register("Torque Limit")?, None),
    };
    let most = match table {
        Table::Dynamixel(_) => client.read(servo, &table.register("PWM Limit")?)?,
        Table::Feetech(_) => 1000,
    };
    Ok(Registers {
        goal: table.role(Role::GoalPosition)?,
        present: table.role(Role::PresentPosition)?,
        limit,
        most,
        gain,
    })
}

/// What is set for the time of the test: no profile, and little torque.
fn settings<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    registers: &Registers,
    plan: &Plan,
) -> Result<Vec<(Item, i32)>, ServiceError> {
    let table = &servo.table;
    let mut settings = vec![(registers.limit, registers.part(plan.back_part()))];
    match table {
        Table::Dynamixel(_) => {
            settings.push((table.register("Profile Velocity")?, 0));
            settings.push((table.register("Profile Acceleration")?, 0));
            let mode = client.read(servo, &table.register("Operating Mode")?)?;
            if mode == 5 {
                let most = client.read(servo, &table.register("Current Limit")?)?;
                settings.push((table.register("Goal Current")?, most));
            }
        }
        Table::Feetech(_) => {
            settings.push((table.register("Acceleration")?, 0));
            settings.push((table.register("Goal Velocity")?, 0));
        }
    }
    Ok(settings)
}

/// Refuses to tap where its limits of position leave no room.
fn ensure_room<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    plan: &Plan,
    held: i32,
) -> Result<(), ServiceError> {
    let scale = Scale::of(&servo.table.role(Role::GoalPosition)?);
    let way = scale.raw(GOAL_DEG).unwrap_or(0);
    let least = client.read(servo, &servo.table.role(Role::MinPosition)?)?;
    let most = client.read(servo, &servo.table.role(Role::MaxPosition)?)?;
    let up = plan.direction != Direction::Down && held + way > most;
    let down = plan.direction != Direction::Up && held - way < least;
    if least < most && (up || down) {
        let [at, from, to] = [held, least, most].map(|raw| scale.quantity(raw));
        let what = format!(
            "it stands at {at}, and its limits are {from} and {to}: a tap needs {GOAL_DEG} deg of room"
        );
        return Err(ServiceError::State { id: servo.id, what });
    }
    Ok(())
}

impl Plan {
    fn back_part(&self) -> f64 {
        (self.gravity_part + BACK_PART).min(1.0)
    }
}

impl Registers {
    /// Counts of the full torque.
    fn full(&self) -> f64 {
        match self.limit.range {
            Range::Between(_, most) => f64::from(most),
            _ => 885.0,
        }
    }

    /// Counts of a part of the full torque.
    fn part(&self, part: f64) -> i32 {
        #[expect(clippy::cast_possible_truncation, reason = "a part of some hundred counts")]
        let counts = (part * self.full()).round() as i32;
        counts.clamp(1, self.most)
    }
}

/// Writes without reading back: it must be quick.
fn put<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    item: &Item,
    raw: i32,
) -> Result<(), ServiceError> {
    let request = Client::<E>::write_request(servo, item, raw)?;
    client.send(servo.id, &request)
}

/// Taps once: creeps, steps, and comes back.
fn one<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    registers: &Registers,
    plan: &Plan,
    held: i32,
    sign: i32,
) -> Result<Tap, ServiceError> {
    let way = Scale::of(&registers.goal).raw(GOAL_DEG).unwrap_or(0);
    let mut part = (0.8 * plan.gravity_part).max(RAMP_PART);
    store(client, servo, &registers.limit, registers.part(part))?;
    if let Some((gain, [_, raised])) = &registers.gain {
        store(client, servo, gain, *raised)?;
    }
    store(client, servo, &registers.goal, held + sign * way)?;
    let start = client.read(servo, &registers.present)?;
    let mut least = start;
    loop {
        let now = client.read(servo, &registers.present)?;
        least = if sign > 0 { least.min(now) } else { least.max(now) };
        if sign * (now - least) >= MOVES {
            break;
        }
        part += RAMP_PART;
        if part > MOST_CREEP + plan.gravity_part {
            let what = format!(
                "it does not move with {:.0} % of its torque: blocked, or too weak for what hangs on it",
                100.0 * part
            );
            return Err(ServiceError::State { id: servo.id, what });
        }
        put(client, servo, &registers.limit, registers.part(part))?;
        client.pause(RAMP);
    }
    // It speeds up: so its teeth touch, whatever the play.
    let mut step_to = |client: &mut Client<E>, more: f64| {
        let before = registers.part(part);
        part += more;
        let after = registers.part(part);
        put(client, servo, &registers.limit, after)?;
        Ok::<_, ServiceError>((client.now(), f64::from(after - before) / registers.full()))
    };
    let preload = step_to(client, PRELOAD_PART)?;
    client.pause(Duration::from_secs_f64(plan.preload_s).saturating_sub(BEFORE));
    let mut readings = Vec::new();
    let begin = client.now();
    read_until(client, servo, registers, begin + BEFORE, &mut readings)?;
    let (step, more) = step_to(client, plan.strength)?;
    let end = step + Duration::from_secs_f64(plan.window_s);
    read_until(client, servo, registers, end, &mut readings)?;
    // Back, gently.
    put(client, servo, &registers.goal, held)?;
    put(client, servo, &registers.limit, registers.part(plan.back_part()))?;
    if let Some((gain, [shipped, _])) = &registers.gain {
        put(client, servo, gain, *shipped)?;
    }
    store(client, servo, &registers.goal, held)?;
    settle(client, servo, registers)?;
    let count_rad = servo.table.rad_per_count();
    let since = |at: Duration| at.as_secs_f64() - step.as_secs_f64();
    let steps = vec![[since(preload.0), preload.1], [0.0, more]];
    let samples = readings.into_iter().map(|(at, counts)| {
        [since(at), f64::from(sign * (counts - held)) * count_rad]
    });
    Ok(Tap { samples: samples.collect(), steps })
}

/// Waits until it stands.
fn settle<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    registers: &Registers,
) -> Result<(), ServiceError> {
    client.pause(SETTLE);
    let end = client.now() + MOST_SETTLE;
    let mut ends = [client.read(servo, &registers.present)?; 2];
    let mut since = client.now();
    while client.now() < since + STANDS && client.now() < end {
        client.pause(RAMP);
        let now = client.read(servo, &registers.present)?;
        ends = [ends[0].min(now), ends[1].max(now)];
        if ends[1] - ends[0] > 1 {
            ends = [now; 2];
            since = client.now();
        }
    }
    Ok(())
}

/// Reads its position as often as the line allows.
fn read_until<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    registers: &Registers,
    end: Duration,
    readings: &mut Vec<(Duration, i32)>,
) -> Result<(), ServiceError> {
    let mut last: Option<Duration> = None;
    loop {
        if let Some(gap) = last.and_then(|last| (last + READING).checked_sub(client.now())) {
            client.pause(gap);
        }
        last = Some(client.now());
        let counts = client.read(servo, &registers.present)?;
        let now = client.now();
        readings.push((now, counts));
        if now >= end {
            return Ok(());
        }
    }
}
