//! Shows which servo has an id: the servo moves by a few degrees and back, slowly and weakly, with its light on.

use std::time::Duration;

use sinew_servo_bus::table::{Item, Range};

use crate::guard::Guard;
use crate::quantity::Scale;
use crate::table::Role;
use crate::{Client, Exchange, ServiceError, Servo, Table};

/// Motion to either side, deg. Servos with much friction stop 3 degrees before the goal.
const WIGGLE_DEG: f64 = 6.0;
const SPEED_DEG_S: f64 = 15.0;
/// Maximum plausible speed: a gear with stick-slip is faster than its goal.
const MOST_DEG_S: f64 = 3.0 * SPEED_DEG_S;
const ACCELERATION_DEG_S2: f64 = 100.0;
/// Time of each motion for a servo without speed control, ms. The value also marks a servo that a killed program left
/// during its motion.
pub(crate) const RUNNING_TIME_MS: i32 = 500;
/// Share of the maximum torque, in addition to the holding torque: enough to lift the load, too little to hurt anybody.
const SHARE: f64 = 0.3;
/// Time of each motion: from one side to the other takes 0.95 s.
const WAY: Duration = Duration::from_secs(1);
const LOOK: Duration = Duration::from_millis(50);
/// Maximum distance between goal and position of a servo that rests, deg: a load makes it sag less than this.
const THERE_DEG: f64 = 10.0;
/// Maximum plausible change of the position when torque is switched on, deg. A larger change means that the servo now
/// counts its turns from another zero.
const REBASED_DEG: f64 = 45.0;
/// Allowed range of measured over commanded motion. With much friction, a servo moves half of the commanded motion.
const MOVED: [f64; 2] = [0.25, 1.5];

/// The result of a motion that identifies a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identified {
    /// Measured distance between the two ends, deg.
    pub moved_deg: f64,
    /// Commanded distance between the two ends, deg.
    pub asked_deg: f64,
    /// Whether the servo has a light.
    pub has_light: bool,
}

/// Moves a servo by a few degrees to either side and back, with its light on if it has one. Afterwards torque is on or
/// off as before, the servo is at the same position, and all registers are as before, even after an error or a signal.
///
/// # Errors
/// [`ServiceError::Fault`] if the servo reports a fault, also during the motion; [`ServiceError::State`] if it already
/// moves, is not in a position mode, is outside of its limits or has too little room between them, does not move as
/// commanded, loses its torque, or its position jumps; [`ServiceError::NotRestored`] if its state could not be restored
/// after an error; the errors of [`Client::read_bytes`].
pub fn identify<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
) -> Result<Identified, ServiceError> {
    let mut guard = Guard::begin_move(client, servo, MOST_DEG_S)?;
    let shown = show(&mut guard);
    guard.end(shown)
}

/// Makes the servo move.
fn show<E: Exchange>(guard: &mut Guard<'_, E>) -> Result<Identified, ServiceError> {
    let (was_on, held) = (guard.was_on(), guard.held());
    let (client, servo) = guard.parts();
    ensure_it_stands_in_position_mode(client, servo, was_on)?;
    let ends = ends(client, servo, held)?;
    for (item, raw) in gentle(client, servo, was_on)? {
        guard.change(&item, raw)?;
    }
    let moved = wiggle(guard, ends)?;
    let scale = Scale::of(&servo.table.role(Role::GoalPosition)?);
    let degrees = |counts: i32| scale.quantity(counts).value;
    Ok(Identified {
        moved_deg: degrees(moved),
        asked_deg: degrees(ends[1] - ends[0]),
        has_light: servo.table.register("LED").is_ok(),
    })
}

/// Refuses to move a servo by an angle if it is not in a position mode, or already moves.
pub(crate) fn ensure_it_stands_in_position_mode<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    was_on: bool,
) -> Result<(), ServiceError> {
    let refused = |what: String| Err(ServiceError::State { id: servo.id, what });
    if let Ok(item) = servo.table.register("Operating Mode") {
        let mode = client.read(servo, &item)?;
        let is_position = match servo.table {
            Table::Dynamixel(_) => [3, 4, 5].contains(&mode),
            Table::Feetech(_) => mode == 0,
        };
        if !is_position {
            return refused(format!(
                "its operating mode is {mode}, in which it cannot be moved by an angle. Set a mode of position first"
            ));
        }
    }
    // The servo's own motion flag flickers if its gear has play.
    let [goal, present] =
        [Role::GoalPosition, Role::PresentPosition].map(|role| servo.table.role(role));
    let way = client.read(servo, &goal?)? - client.read(servo, &present?)?;
    let way = Scale::of(&servo.table.role(Role::GoalPosition)?).quantity(way);
    if was_on && way.value.abs() > THERE_DEG {
        return refused(format!(
            "it is {way} from its goal: it moves, or something holds it. Wait until it rests"
        ));
    }
    Ok(())
}

/// Returns the two goals of the motion: a few degrees to either side, as far as the servo's limits allow.
fn ends<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    held: i32,
) -> Result<[i32; 2], ServiceError> {
    let scale = Scale::of(&servo.table.role(Role::GoalPosition)?);
    let wiggle = scale.raw(WIGGLE_DEG).unwrap_or(0);
    let ends = [held - wiggle, held + wiggle];
    let least = client.read(servo, &servo.table.role(Role::MinPosition)?)?;
    let most = client.read(servo, &servo.table.role(Role::MaxPosition)?)?;
    let has_limits = match servo.table {
        Table::Dynamixel(_) => client.read(servo, &servo.table.register("Operating Mode")?)? == 3,
        Table::Feetech(_) => least < most,
    };
    if !has_limits {
        return Ok(ends);
    }
    let refused = |what| Err(ServiceError::State { id: servo.id, what });
    if !(least..=most).contains(&held) {
        let [at, from, to] = [held, least, most].map(|raw| scale.quantity(raw));
        return refused(format!(
            "it is at {at}, outside of its limits, {from} to {to}: move it within them by hand first"
        ));
    }
    let ends = ends.map(|end| end.clamp(least, most));
    if ends[1] - ends[0] < wiggle {
        return refused(format!("its position limits leave less than {WIGGLE_DEG} deg to move"));
    }
    Ok(ends)
}

/// Returns register values that make the servo slow, and only as strong as its load requires.
fn gentle<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    was_on: bool,
) -> Result<Vec<(Item, i32)>, ServiceError> {
    let table = &servo.table;
    let raw = |name: &str, value: f64| -> Result<(Item, i32), ServiceError> {
        let item = table.register(name)?;
        Ok((item, Scale::of(&item).raw(value).unwrap_or(1).max(1)))
    };
    let mut gentle = Vec::new();
    match table {
        Table::Dynamixel(_) => {
            gentle.push((table.register("LED")?, 1));
            let is_in_time = client.read(servo, &table.register("Drive Mode")?)? & 4 != 0;
            let [speed, acceleration] = ["Profile Velocity", "Profile Acceleration"];
            if is_in_time {
                // Time of the whole motion, and of its acceleration, in ms.
                gentle.push((table.register(speed)?, 500));
                gentle.push((table.register(acceleration)?, 150));
            } else {
                gentle.push(raw(speed, SPEED_DEG_S)?);
                gentle.push(raw(acceleration, ACCELERATION_DEG_S2)?);
            }
            for [goal, limit, present] in [
                ["Goal PWM", "PWM Limit", "Present PWM"],
                ["Goal Current", "Current Limit", "Present Current"],
            ] {
                if let (Ok(goal), Ok(limit)) = (table.register(goal), table.register(limit)) {
                    let holds = holds(client, servo, present, was_on)?;
                    let most = client.read(servo, &limit)?;
                    gentle.push((goal, most.min(holds + share(&limit))));
                }
            }
        }
        Table::Feetech(_) => {
            if let Ok(time) = table.register("Running Time") {
                gentle.push((time, RUNNING_TIME_MS));
            } else {
                gentle.push(raw("Acceleration", ACCELERATION_DEG_S2)?);
                gentle.push(raw("Goal Velocity", SPEED_DEG_S)?);
            }
            // Changed first and restored last: `left` uses it as a mark.
            if let Ok(limit) = table.register("Torque Limit") {
                let holds = holds(client, servo, "Present Load", was_on)?;
                let most = client.read(servo, &limit)?;
                gentle.insert(0, (limit, most.min(holds + share(&limit))));
            }
        }
    }
    Ok(gentle)
}

/// Returns the torque or current that the servo needs to hold its load.
fn holds<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    present: &str,
    was_on: bool,
) -> Result<i32, ServiceError> {
    if !was_on {
        return Ok(0);
    }
    Ok(client.read(servo, &servo.table.register(present)?)?.abs())
}

/// Returns the allowed share of a limit's maximum.
fn share(limit: &Item) -> i32 {
    let most = match limit.range {
        Range::Between(_, most) => most,
        _ => 0,
    };
    #[expect(clippy::cast_possible_truncation, reason = "a share of a number of counts")]
    let share = (f64::from(most) * SHARE) as i32;
    share
}

/// Moves to both ends and back, and returns the distance between the measured ends, in counts.
fn wiggle<E: Exchange>(
    guard: &mut Guard<'_, E>,
    [least, most]: [i32; 2],
) -> Result<i32, ServiceError> {
    let (held, servo) = (guard.held(), guard.servo());
    let scale = Scale::of(&servo.table.role(Role::GoalPosition)?);
    let present = servo.table.role(Role::PresentPosition)?;
    let refused = |what: String| Err(ServiceError::State { id: servo.id, what });
    // The goal must be the present position before torque is on; on a Feetech, the goal itself switches torque on.
    guard.go_to(held)?;
    if !guard.was_on() {
        guard.hold()?;
    }
    let start = guard.client().read(servo, &present)?;
    let jump = scale.quantity(start - held);
    if jump.value.abs() > REBASED_DEG {
        return refused(format!(
            "its position changed by {jump} when its torque came on: it counts turns anew. Try again"
        ));
    }
    let (mut seen, mut now, mut before) = ([start; 2], start, held);
    for (index, target) in [most, least, most, held].into_iter().enumerate() {
        let begin = now;
        guard.go_to(target)?;
        let end = guard.client().now() + WAY;
        while guard.client().now() < end {
            guard.client().pause(LOOK);
            now = guard.look()?;
            seen = [seen[0].min(now), seen[1].max(now)];
        }
        let [moved, asked] = [now - begin, target - before];
        // Friction may stop the servo before the first end, and before its last position.
        let is_whole_way = matches!(index, 1 | 2);
        if is_whole_way && f64::from(moved) / f64::from(asked) < MOVED[0] {
            let [moved, asked] = [moved, asked].map(|counts| scale.quantity(counts));
            return refused(format!(
                "it hardly moves: by {moved} where {asked} was asked. It is blocked, or too weak for its load"
            ));
        }
        before = target;
    }
    let [moved, asked] = [seen[1] - seen[0], most - least];
    if f64::from(moved) > MOVED[1] * f64::from(asked) {
        let [moved, asked] = [moved, asked].map(|counts| scale.quantity(counts));
        return refused(format!(
            "it moved by {moved} where {asked} was asked: its encoder jumps, or something else moves it"
        ));
    }
    Ok(moved)
}

/// Describes the motion in words.
impl std::fmt::Display for Identified {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let light = if self.has_light { ", with its light on" } else { "" };
        write!(f, "it moved by {:.1} deg to and fro{light}", self.moved_deg)
    }
}
