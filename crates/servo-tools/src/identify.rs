//! Which servo is which: it moves by a few degrees and back, slowly and weakly, with its light on.

use std::time::Duration;

use sinew_servo_bus::table::{Item, Range};

use crate::quantity::Scale;
use crate::store::{set_torque, store, torque_is_on};
use crate::table::Role;
use crate::{Client, Exchange, ServiceError, Servo, Table, watch};

/// How far it moves to either side: servos with much friction stop 3 degrees short.
const WIGGLE_DEG: f64 = 6.0;
const SPEED_DEG_S: f64 = 15.0;
const ACCELERATION_DEG_S2: f64 = 100.0;
/// Limits of torque for a servo that was limp: it must lift what hangs on it, and hurt nobody.
const SHARE: f64 = 0.3;
/// From one side to the other takes 0.95 s.
const WAY: Duration = Duration::from_secs(1);
const LOOK: Duration = Duration::from_millis(50);
/// A servo that holds something sags by less than this.
const THERE_DEG: f64 = 10.0;
/// Where its position changes by so much when torque comes, it has another zero than it said.
const REBASED_DEG: f64 = 45.0;

/// What a wiggle came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identified {
    /// From one end to the other, as it moved.
    pub moved_deg: f64,
    /// The same, as it was told to.
    pub asked_deg: f64,
    /// Whether it has a light.
    pub has_light: bool,
}

/// Moves a servo by a few degrees to either side and back, with its light on where there is one. A servo that was limp
/// is limp afterwards, one that held holds what it held; all registers are as before, also where something fails on the
/// way.
///
/// # Errors
/// [`ServiceError::Fault`] if it reports trouble, [`ServiceError::State`] if it moves, is in no mode of position or
/// stands outside of its limits.
pub fn identify<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
) -> Result<Identified, ServiceError> {
    let state = ensure_no_fault(client, servo)?;
    let was_on = torque_is_on(client, servo)?;
    ensure_it_stands_in_position_mode(client, servo, was_on)?;
    let goal = servo.table.role(Role::GoalPosition)?;
    let place = state.position.raw;
    let held = if was_on { client.read(servo, &goal)? } else { place };
    let ends = ends(client, servo, held)?;

    let gentle = gentle(client, servo, was_on)?;
    let mut before = Vec::new();
    for (item, _) in &gentle {
        before.push((*item, client.read(servo, item)?));
    }
    let moved =
        set_all(client, servo, &gentle).and_then(|()| wiggle(client, servo, held, ends, was_on));
    // The light goes out last, and what was weak is strong again only when nothing moves.
    let calm =
        if was_on { store(client, servo, &goal, held) } else { set_torque(client, servo, false) };
    let restored = set_all(client, servo, &before);
    let moved = moved?;
    calm.and(restored)?;
    let degrees = |counts: i32| Scale::of(&goal).quantity(counts).value;
    Ok(Identified {
        moved_deg: degrees(moved),
        asked_deg: degrees(ends[1] - ends[0]),
        has_light: servo.table.register("LED").is_ok(),
    })
}

/// Returns what it measures, unless it reports trouble.
pub(crate) fn ensure_no_fault<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
) -> Result<watch::State, ServiceError> {
    let state = watch::look(client, servo)?;
    if !state.errors.is_empty() {
        let help = match servo.table {
            Table::Dynamixel(_) => "`sinew servo reboot` clears it, once its cause is gone",
            Table::Feetech(_) => {
                "It clears itself when its cause is gone; an overload with the next goal"
            }
        };
        return Err(ServiceError::Fault { id: servo.id, what: state.errors.join(", "), help });
    }
    Ok(state)
}

/// Refuses to move a servo by an angle where it is in no such mode, or is on its way.
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
    // Its own flag for motion flickers where its gear has play.
    let [goal, present] =
        [Role::GoalPosition, Role::PresentPosition].map(|role| servo.table.role(role));
    let way = client.read(servo, &goal?)? - client.read(servo, &present?)?;
    let way = Scale::of(&servo.table.role(Role::GoalPosition)?).quantity(way);
    if was_on && way.value.abs() > THERE_DEG {
        return refused(format!(
            "it is {way} from its goal: it moves, or something holds it. Wait until it stands"
        ));
    }
    Ok(())
}

/// A few degrees to either side of where it stands, as far as its limits leave room.
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
            "it stands at {at}, outside of its limits, {from} to {to}: move it there by hand first"
        ));
    }
    let ends = ends.map(|end| end.clamp(least, most));
    if ends[1] - ends[0] < wiggle {
        return refused(format!("its position limits leave less than {WIGGLE_DEG} deg to move"));
    }
    Ok(ends)
}

/// What makes it slow; and weak, unless it holds something.
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
                // Milliseconds of the way, and of its beginning.
                gentle.push((table.register(speed)?, 500));
                gentle.push((table.register(acceleration)?, 150));
            } else {
                gentle.push(raw(speed, SPEED_DEG_S)?);
                gentle.push(raw(acceleration, ACCELERATION_DEG_S2)?);
            }
            let limits = [("Goal PWM", "PWM Limit"), ("Goal Current", "Current Limit")];
            for (goal, limit) in limits.into_iter().filter(|_| !was_on) {
                if let (Ok(goal), Ok(limit)) = (table.register(goal), table.register(limit)) {
                    let most = client.read(servo, &limit)?;
                    gentle.push((goal, most.min(share(&limit))));
                }
            }
        }
        Table::Feetech(_) => {
            if let Ok(time) = table.register("Running Time") {
                gentle.push((time, 500));
            } else {
                gentle.push(raw("Acceleration", ACCELERATION_DEG_S2)?);
                let is_fine = client.read(servo, &table.register("Phase")?)? & 4 != 0;
                let (item, speed) = raw("Goal Velocity", SPEED_DEG_S)?;
                // With this bit a count of speed is a fiftieth.
                gentle.push((item, if is_fine { speed * 50 } else { speed }));
            }
            if let Ok(limit) = table.register("Torque Limit")
                && !was_on
            {
                let most = client.read(servo, &limit)?;
                gentle.push((limit, most.min(share(&limit))));
            }
        }
    }
    Ok(gentle)
}

/// A share of the most that a limit can be.
fn share(limit: &Item) -> i32 {
    let most = match limit.range {
        Range::Between(_, most) => most,
        _ => 0,
    };
    #[expect(clippy::cast_possible_truncation, reason = "a share of a number of counts")]
    let share = (f64::from(most) * SHARE) as i32;
    share
}

/// Writes all of them, also where one fails; gives the first failure.
pub(crate) fn set_all<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    values: &[(Item, i32)],
) -> Result<(), ServiceError> {
    let mut result = Ok(());
    for (item, raw) in values {
        // One that fails does not keep the others from what they were.
        let stored = store(client, servo, item, *raw);
        result = result.and(stored);
    }
    result
}

/// Goes to both ends and back, and says how far apart it was, in counts.
fn wiggle<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    held: i32,
    [least, most]: [i32; 2],
    was_on: bool,
) -> Result<i32, ServiceError> {
    let [goal, present] =
        [Role::GoalPosition, Role::PresentPosition].map(|role| servo.table.role(role));
    let (goal, present) = (goal?, present?);
    // Its goal is where it stands before torque comes; a Feetech's comes with the goal.
    store(client, servo, &goal, held)?;
    if !was_on {
        set_torque(client, servo, true)?;
    }
    let start = client.read(servo, &present)?;
    let jump = Scale::of(&goal).quantity(start - held);
    if jump.value.abs() > REBASED_DEG {
        let what = format!(
            "its position changed by {jump} when its torque came on: it counts turns anew. Try again"
        );
        return Err(ServiceError::State { id: servo.id, what });
    }
    let mut seen = [start; 2];
    for target in [most, least, most, held] {
        store(client, servo, &goal, target)?;
        let mut time = Duration::ZERO;
        while time < WAY {
            client.pause(LOOK);
            time += LOOK;
            let now = client.read(servo, &present)?;
            seen = [seen[0].min(now), seen[1].max(now)];
        }
    }
    Ok(seen[1] - seen[0])
}

/// In words: how far it moved, or that it hardly did.
impl std::fmt::Display for Identified {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let light = if self.has_light { ", with its light on" } else { "" };
        if self.moved_deg < 0.25 * self.asked_deg {
            write!(
                f,
                "it hardly moved ({:.1} deg){light}: blocked, or too weak for what hangs on it",
                self.moved_deg
            )
        } else {
            write!(f, "it moved by {:.1} deg to and fro{light}", self.moved_deg)
        }
    }
}
