//! Taps a servo: writes to it, and reads its motion.

use std::time::Duration;

use sinew_servo_bus::table::{Item, Range};

use super::clock::Clock;
use super::fit::Tap;
use super::plan::{Direction, Plan};
use crate::guard::Guard;
use crate::identify::ensure_it_stands_in_position_mode;
use crate::quantity::{Quantity, Scale};
use crate::table::Role;
use crate::{Client, Exchange, ServiceError, Servo, Table};

/// Operating mode of Dynamixels: position with a current limit.
const MODE_CURRENT_POSITION: i32 = 5;
/// Motion that counts as the start of creeping, in counts.
const MOVES: i32 = 3;
/// Step by which the torque limit grows every [`RAMP`] until the servo creeps, as a part of the full torque.
const RAMP_PART: f64 = 0.005;
const RAMP: Duration = Duration::from_millis(8);
/// Maximum torque for friction, in addition to that for gravity, as a part of the full torque.
const MOST_CREEP: f64 = 0.4;
/// Maximum time to brake, with as much torque as the tap itself.
const MOST_BRAKE: Duration = Duration::from_millis(400);
/// Maximum speed of these kinds of servos, deg/s.
const MOST_DEG_S: f64 = 1500.0;
/// Minimum motion of a successful tap, counts.
const LEAST_WAY: i32 = 10;
/// Interval of readings while the servo waits: they also keep its watchdog from expiring.
const LOOK: Duration = Duration::from_millis(50);
/// Wait after the way back, before the servo is checked for rest.
const SETTLE: Duration = Duration::from_millis(200);
/// Time for which the position must stay within one count to be at rest. The wait for rest takes at most
/// [`MOST_SETTLE`].
const STANDS: Duration = Duration::from_millis(80);
const MOST_SETTLE: Duration = Duration::from_secs(2);

/// The recorded readings of all taps.
pub(super) struct Recorded {
    pub(super) taps: Vec<Tap>,
    /// Maximum distance from the start position, rad.
    pub(super) farthest_rad: f64,
}

/// The registers that a tap needs.
struct Registers {
    goal: Item,
    present: Item,
    /// Limit of the torque.
    limit: Item,
    /// Maximum value of the limit that the servo allows. The next field is the value for the full torque. Both are in
    /// counts.
    most: i32,
    full: f64,
    /// Position gain before and during the test; `None` if it does not change.
    gain: Option<(Item, [i32; 2])>,
    clock: Clock,
}

/// Taps the servo, and returns the readings. Afterwards the servo's previous state is restored, if it still answers.
pub(super) fn record<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    plan: &Plan,
) -> Result<Recorded, ServiceError> {
    let mut guard = Guard::begin_move(client, servo, MOST_DEG_S)?;
    let recorded = taps(&mut guard, plan);
    guard.end(recorded)
}

fn taps<E: Exchange>(guard: &mut Guard<'_, E>, plan: &Plan) -> Result<Recorded, ServiceError> {
    let (was_on, held) = (guard.was_on(), guard.held());
    let (client, servo) = guard.parts();
    ensure_it_stands_in_position_mode(client, servo, was_on)?;
    let registers = registers(client, servo, plan)?;
    ensure_strength(client, servo, &registers, plan)?;
    ensure_room(client, servo, plan, held)?;
    // The torque limit is lowered first, and therefore restored last.
    for (item, raw) in settings(client, servo, &registers, plan)? {
        guard.change(&item, raw)?;
    }
    if let Some((gain, _)) = &registers.gain {
        guard.note(gain)?;
    }
    guard.go_to(held)?;
    if !was_on {
        guard.hold()?;
    }
    ensure_it_answers_writes(guard, &registers, plan)?;
    let (mut taps, mut farthest) = (Vec::new(), 0);
    for index in 0..plan.taps {
        let is_up = match plan.direction {
            Direction::Up => true,
            Direction::Down => false,
            Direction::Both => index % 2 == 0,
        };
        let sign = if is_up { 1 } else { -1 };
        let (tap, reached) = one(guard, &registers, &plan.of_tap(index), sign)?;
        guard.look()?;
        let way_rad = f64::from(reached) * servo.table.rad_per_count();
        if reached < LEAST_WAY || way_rad > plan.reach_rad() {
            let what = format!(
                "a tap moved it by {:.1} deg, where up to {:.0} were expected: it is blocked, its gear slips or its \
                 encoder jumps",
                way_rad.to_degrees(),
                plan.reach_rad().to_degrees()
            );
            return Err(ServiceError::State { id: servo.id, what });
        }
        taps.push(tap);
        farthest = farthest.max(reached);
    }
    Ok(Recorded { taps, farthest_rad: f64::from(farthest) * servo.table.rad_per_count() })
}

fn registers<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    plan: &Plan,
) -> Result<Registers, ServiceError> {
    let table = &servo.table;
    let (limit, most, gain) = match table {
        Table::Dynamixel(_) => {
            let limit = table.register("Goal PWM")?;
            let most = client.read(servo, &table.register("PWM Limit")?)?;
            (limit, most, Some(gain(client, servo, plan)?))
        }
        Table::Feetech(_) => {
            let limit = table.register("Torque Limit")?;
            (limit, client.read(servo, &limit)?, None)
        }
    };
    Ok(Registers {
        goal: table.role(Role::GoalPosition)?,
        present: table.role(Role::PresentPosition)?,
        limit,
        most,
        full: 100.0 / Scale::of(&limit).step,
        gain,
        clock: Clock::of(table)?,
    })
}

/// Returns the position gain of a Dynamixel, before and during the test.
fn gain<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    plan: &Plan,
) -> Result<(Item, [i32; 2]), ServiceError> {
    let gain = servo.table.register("Position P Gain")?;
    let before = client.read(servo, &gain)?;
    let most = match gain.range {
        Range::Between(_, most) => most,
        _ => before,
    };
    #[expect(clippy::cast_possible_truncation, reason = "it is within the register's range")]
    let raised = (f64::from(before) * plan.gain).min(f64::from(most)) as i32;
    Ok((gain, [before, raised]))
}

/// Returns the register values for the time of the test: no profile, and little torque.
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
            if let Some(most) = current_limit(client, servo)? {
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

/// Returns the maximum current of a servo in mode 5 (position with a current limit), in counts; `None` in other modes.
fn current_limit<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
) -> Result<Option<i32>, ServiceError> {
    let table = &servo.table;
    if !table.has_current()
        || client.read(servo, &table.register("Operating Mode")?)? != MODE_CURRENT_POSITION
    {
        return Ok(None);
    }
    client.read(servo, &table.register("Current Limit")?).map(Some)
}

/// Refuses if the servo's limits are lower than the tap needs, because the step would then be smaller than planned.
fn ensure_strength<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    registers: &Registers,
    plan: &Plan,
) -> Result<(), ServiceError> {
    let refused = |name: &str, has: Quantity, takes: Quantity| {
        let what = format!(
            "its {name} is {has}, and this tap takes up to {takes}: raise it for the test, or tap with less --strength"
        );
        Err(ServiceError::State { id: servo.id, what })
    };
    let takes = registers.counts(plan.most_part());
    if takes > registers.most {
        let name = if registers.gain.is_some() { "PWM Limit" } else { "Torque Limit" };
        let scale = Scale::of(&registers.limit);
        return refused(name, scale.quantity(registers.most), scale.quantity(takes));
    }
    if let Some(most) = current_limit(client, servo)? {
        let scale = Scale::of(&servo.table.register("Current Limit")?);
        let takes = scale.raw(plan.most_part() * plan.full_a).unwrap_or(i32::MAX);
        if takes > most {
            return refused("Current Limit", scale.quantity(most), scale.quantity(takes));
        }
    }
    Ok(())
}

/// Refuses a servo that does not answer writes in time: the oscillation would be over before the first reading.
fn ensure_it_answers_writes<E: Exchange>(
    guard: &mut Guard<'_, E>,
    registers: &Registers,
    plan: &Plan,
) -> Result<(), ServiceError> {
    let (client, servo) = guard.parts();
    let begin = client.now();
    put(client, servo, &registers.limit, registers.part(plan.back_part()))?;
    if client.now() < begin + client.patience() {
        return Ok(());
    }
    let what = "it does not answer writes, or too late: set its Status Return Level so that it does, 2 for a Dynamixel \
        (`sinew servo apply`)";
    Err(ServiceError::State { id: servo.id, what: what.to_owned() })
}

/// Refuses if the servo's position limits leave too little room.
fn ensure_room<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    plan: &Plan,
    held: i32,
) -> Result<(), ServiceError> {
    let scale = Scale::of(&servo.table.role(Role::GoalPosition)?);
    let way_deg = plan.reach_rad().to_degrees();
    let way = scale.raw(way_deg).unwrap_or(0);
    let least = client.read(servo, &servo.table.role(Role::MinPosition)?)?;
    let most = client.read(servo, &servo.table.role(Role::MaxPosition)?)?;
    let up = plan.direction != Direction::Down && held + way > most;
    let down = plan.direction != Direction::Up && held - way < least;
    if least < most && (up || down) {
        let [at, from, to] = [held, least, most].map(|raw| scale.quantity(raw));
        let what = format!(
            "it is at {at}, and its limits are {from} and {to}: this tap needs {way_deg:.0} deg of room. Less \
             --strength needs less"
        );
        return Err(ServiceError::State { id: servo.id, what });
    }
    Ok(())
}

impl Registers {
    /// Converts a part of the full torque to counts.
    fn counts(&self, part: f64) -> i32 {
        #[expect(clippy::cast_possible_truncation, reason = "a part of some thousand counts")]
        let counts = (part * self.full).round() as i32;
        counts
    }

    /// Converts a part of the full torque to counts, limited to what the servo allows.
    fn part(&self, part: f64) -> i32 {
        self.counts(part).clamp(1, self.most.max(1))
    }
}

/// Writes quickly, without reading back.
fn put<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    item: &Item,
    raw: i32,
) -> Result<(), ServiceError> {
    let request = Client::<E>::write_request(servo, item, raw)?;
    client.send(servo.id, &request)
}

/// Waits, and checks the position meanwhile.
fn wait<E: Exchange>(
    guard: &mut Guard<'_, E>,
    registers: &Registers,
    time: Duration,
) -> Result<(), ServiceError> {
    let end = guard.client().now() + time;
    loop {
        let left = end.saturating_sub(guard.client().now());
        guard.client().pause(left.min(LOOK));
        if left <= LOOK {
            return Ok(());
        }
        position(guard, registers)?;
    }
}

/// Reads and checks the position, in counts.
fn position<E: Exchange>(
    guard: &mut Guard<'_, E>,
    registers: &Registers,
) -> Result<i32, ServiceError> {
    let (client, servo) = guard.parts();
    let now = client.read(servo, &registers.present)?;
    guard.follow(now)?;
    Ok(now)
}

/// Taps once: lets the servo creep, makes the step of torque, and moves the servo back to its start. Returns the tap,
/// and the maximum distance from the start, in counts.
fn one<E: Exchange>(
    guard: &mut Guard<'_, E>,
    registers: &Registers,
    plan: &Plan,
    sign: i32,
) -> Result<(Tap, i32), ServiceError> {
    let (held, servo) = (guard.held(), guard.servo());
    let way = Scale::of(&registers.goal).raw(plan.way_rad.to_degrees()).unwrap_or(0);
    let start = (0.8 * plan.gravity_part).max(RAMP_PART);
    guard.change(&registers.limit, registers.part(start))?;
    if let Some((gain, [_, raised])) = &registers.gain {
        guard.change(gain, *raised)?;
    }
    guard.go_to(held + sign * way)?;
    let mut part = creep(guard, registers, plan, (start, sign))?;
    // The teeth have met. They must come to rest on each other; then the servo accelerates, which keeps them together.
    wait(guard, registers, Duration::from_secs_f64(plan.meet_s))?;
    part += plan.preload;
    put(guard.client(), servo, &registers.limit, registers.part(part))?;
    let preload = Duration::from_secs_f64((plan.preload_s - plan.before_s).max(0.0));
    wait(guard, registers, preload)?;
    let mut readings = Vec::new();
    let client = guard.client();
    let step = client.now() + Duration::from_secs_f64(plan.before_s);
    registers.clock.read_until(client, servo, step, &mut readings)?;
    let before = registers.part(part);
    let after = registers.part(part + plan.strength);
    put(client, servo, &registers.limit, after)?;
    let step = client.now();
    let end = step + Duration::from_secs_f64(plan.window_s);
    registers.clock.read_until(client, servo, end, &mut readings)?;
    for reading in &readings {
        guard.follow_at(reading.host, reading.counts)?;
    }
    let reached = back(guard, registers, plan, sign)?;
    let count_rad = servo.table.rad_per_count();
    let samples = registers
        .clock
        .since(step, &readings)
        .into_iter()
        .map(|(time_s, counts)| [time_s, f64::from(sign * (counts - held)) * count_rad]);
    // Near its goal, the servo gives less torque than its limit.
    let pushed_rad = plan.way_rad - Plan::lead_rad(part + plan.strength);
    let samples = samples.take_while(|[_, position_rad]| *position_rad < pushed_rad);
    let step = f64::from(after - before) / registers.full;
    Ok((Tap { samples: samples.collect(), step, meet_s: plan.meet_s }, reached))
}

/// Raises the torque until the servo moves. Returns the necessary part of the full torque.
fn creep<E: Exchange>(
    guard: &mut Guard<'_, E>,
    registers: &Registers,
    plan: &Plan,
    (start, sign): (f64, i32),
) -> Result<f64, ServiceError> {
    let servo = guard.servo();
    let mut part = start;
    let mut least = position(guard, registers)?;
    loop {
        let now = position(guard, registers)?;
        least = if sign > 0 { least.min(now) } else { least.max(now) };
        if sign * (now - least) >= MOVES {
            return Ok(part);
        }
        part += RAMP_PART;
        if part > MOST_CREEP + plan.gravity_part {
            // The cause may be that torque is off, or that the servo is too hot.
            guard.look()?;
            let what = format!(
                "it does not move with {:.0} % of its torque: blocked, or too weak for its load",
                100.0 * part
            );
            return Err(ServiceError::State { id: servo.id, what });
        }
        put(guard.client(), servo, &registers.limit, registers.part(part))?;
        guard.client().pause(RAMP);
    }
}

/// Brakes, moves back to the start with little torque, and waits until the servo rests. Returns the maximum distance
/// from the start, in counts.
fn back<E: Exchange>(
    guard: &mut Guard<'_, E>,
    registers: &Registers,
    plan: &Plan,
    sign: i32,
) -> Result<i32, ServiceError> {
    let held = guard.held();
    guard.go_to(held)?;
    let end = guard.client().now() + MOST_BRAKE;
    let mut reached = i32::MIN;
    loop {
        let now = sign * (position(guard, registers)? - held);
        if now < reached || guard.client().now() > end {
            break;
        }
        reached = now;
    }
    guard.change(&registers.limit, registers.part(plan.back_part()))?;
    if let Some((gain, [shipped, _])) = &registers.gain {
        guard.change(gain, *shipped)?;
    }
    settle(guard, registers, plan)?;
    Ok(reached)
}

/// Waits until the servo rests. At first its torque is so low that friction stops it, since with much play in its gear
/// it would otherwise swing around its goal for long. If this torque is too low to hold the load, the servo gets the
/// torque to return.
fn settle<E: Exchange>(
    guard: &mut Guard<'_, E>,
    registers: &Registers,
    plan: &Plan,
) -> Result<(), ServiceError> {
    wait(guard, registers, SETTLE)?;
    for part in [plan.calm_part(), plan.back_part()] {
        guard.change(&registers.limit, registers.part(part))?;
        if stands(guard, registers)? {
            return Ok(());
        }
    }
    let what = format!(
        "it does not come to rest within {} s after a tap: something moves it, or it swings round its goal",
        2 * MOST_SETTLE.as_secs()
    );
    Err(ServiceError::State { id: guard.servo().id, what })
}

/// Waits for a limited time until the servo rests, and returns whether it does.
fn stands<E: Exchange>(
    guard: &mut Guard<'_, E>,
    registers: &Registers,
) -> Result<bool, ServiceError> {
    let end = guard.client().now() + MOST_SETTLE;
    let mut ends = [position(guard, registers)?; 2];
    let mut since = guard.client().now();
    while guard.client().now() < since + STANDS {
        guard.client().pause(RAMP);
        let now = position(guard, registers)?;
        ends = [ends[0].min(now), ends[1].max(now)];
        if ends[1] - ends[0] > 1 {
            ends = [now; 2];
            since = guard.client().now();
        }
        if guard.client().now() > end {
            return Ok(false);
        }
    }
    Ok(true)
}
