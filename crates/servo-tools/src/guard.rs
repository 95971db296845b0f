//! The one guard of all tools that change servos: whatever ends a tool, the servo is as it was, or that is said.
//!
//! A tool changes registers through its [`Guard`], which knows what they held. At its end, at an error and at a signal
//! the guard puts all of them back, with torque off first where it was off. A servo that moves is looked at meanwhile:
//! heat, errors, torque, and whether it can have come where it says that it is.
//!
//! Nothing runs any more in a program that was killed. So a servo with a bus watchdog has it set for a move, and stops
//! by itself; all that can limit their torque have it limited. [`left`](crate::left) finds what is left then.

use std::time::Duration;

use sinew_servo_bus::dynamixel::table::address as dxl;
use sinew_servo_bus::feetech::table::address as feetech_address;
use sinew_servo_bus::table::{Access, Area, Item};

use crate::follow::Follow;
use crate::left;
use crate::quantity::Scale;
use crate::store::{set_torque, store, torque_is_on};
use crate::table::Role;
use crate::{Client, Exchange, ServiceError, Servo, Table, watch};

/// A servo stops by itself when it hears nothing for so long, in its unit of 20 ms. A PC lets a program wait for less,
/// and a board sets another number.
pub(crate) const WATCHDOG: i32 = 15;
const WATCHDOG_MS: i32 = 20 * WATCHDOG;
/// Registers of a Dynamixel that a change of its mode sets back: gains, goals and profile.
const SET_BACK: std::ops::RangeInclusive<u16> = 76..=112;
/// A servo that does not let go is told so again, as often and after so long: a bad line gets better, perhaps.
const AGAIN: (u32, Duration) = (5, Duration::from_millis(200));

/// Slow enough to be let go of, after this time at most.
const SLOW_DEG_S: f64 = 30.0;
const MOST_BRAKE: Duration = Duration::from_secs(1);

/// A servo that a tool changes, and what it was before.
pub(crate) struct Guard<'c, E: Exchange> {
    client: &'c mut Client<E>,
    servo: &'c Servo,
    was_on: bool,
    /// In the order in which they were changed.
    before: Vec<(Item, i32)>,
    motion: Option<Motion>,
    is_over: bool,
}

/// A servo that moves.
struct Motion {
    goal: Item,
    /// Where it stood, or what it held.
    held: i32,
    most_c: f64,
    follow: Follow,
    /// Whether its encoder tells something else than before: then no goal of before means what it meant.
    has_jumped: bool,
}

impl<'c, E: Exchange> Guard<'c, E> {
    /// Guards a servo whose registers change. It is not moved.
    pub(crate) fn begin(client: &'c mut Client<E>, servo: &'c Servo) -> Result<Self, ServiceError> {
        let was_on = torque_is_on(client, servo)?;
        Ok(Self { client, servo, was_on, before: Vec::new(), motion: None, is_over: false })
    }

    /// Guards a servo that moves, no faster than by so many deg/s: refused where it is in trouble, moves, or was left
    /// by a program that was killed. Its watchdog is set, where it has one.
    pub(crate) fn begin_move(
        client: &'c mut Client<E>,
        servo: &'c Servo,
        most_deg_s: f64,
    ) -> Result<Self, ServiceError> {
        let state = ensure_no_fault(client, servo)?;
        if let Some(left) = left::look(client, servo)?.filter(|left| left.is_on) {
            return Err(ServiceError::State { id: servo.id, what: left.what });
        }
        let mut guard = Self::begin(client, servo)?;
        let [goal, present] =
            [Role::GoalPosition, Role::PresentPosition].map(|role| servo.table.role(role));
        let (goal, present) = (goal?, present?);
        let held = if guard.was_on { guard.client.read(servo, &goal)? } else { state.position.raw };
        let most = servo.table.register_at(match servo.table {
            Table::Dynamixel(_) => dxl::TEMPERATURE_LIMIT,
            Table::Feetech(_) => feetech_address::MAX_TEMPERATURE.into(),
        })?;
        let most_c = f64::from(guard.client.read(servo, &most)?);
        let follow = Follow::new(&present, most_deg_s);
        guard.motion = Some(Motion { goal, held, most_c, follow, has_jumped: false });
        // First of all changes, so that it is put back last: it marks a servo that a tool has changed.
        if let Ok(watchdog) = servo.table.register("Bus Watchdog") {
            guard.change(&watchdog, WATCHDOG)?;
        }
        Ok(guard)
    }

    /// The client and the servo, for what changes nothing.
    pub(crate) fn parts(&mut self) -> (&mut Client<E>, &'c Servo) {
        (self.client, self.servo)
    }

    pub(crate) fn client(&mut self) -> &mut Client<E> {
        self.client
    }

    pub(crate) fn servo(&self) -> &'c Servo {
        self.servo
    }

    /// Whether its torque was on.
    pub(crate) fn was_on(&self) -> bool {
        self.was_on
    }

    /// Where it stood, or what it held, counts; 0 of a servo that is not moved.
    pub(crate) fn held(&self) -> i32 {
        self.motion.as_ref().map_or(0, |motion| motion.held)
    }

    /// Notes what a register holds, unless that is known.
    pub(crate) fn note(&mut self, item: &Item) -> Result<(), ServiceError> {
        if self.before.iter().all(|(known, _)| known.address != item.address) {
            let raw = self.client.read(self.servo, item)?;
            self.before.push((*item, raw));
        }
        Ok(())
    }

    /// Writes a register, and looks whether the servo has it.
    pub(crate) fn change(&mut self, item: &Item, raw: i32) -> Result<(), ServiceError> {
        let is_mode =
            matches!(self.servo.table, Table::Dynamixel(_)) && item.address == dxl::OPERATING_MODE;
        if is_mode {
            for other in self.servo.table.items() {
                if SET_BACK.contains(&other.address) && other.access == Access::ReadWrite {
                    self.note(&other)?;
                }
            }
        }
        self.note(item)?;
        store(self.client, self.servo, item, raw)
    }

    /// Sends the servo to a goal.
    pub(crate) fn go_to(&mut self, counts: i32) -> Result<(), ServiceError> {
        let Some(goal) = self.motion.as_ref().map(|motion| motion.goal) else { return Ok(()) };
        let gone = store(self.client, self.servo, &goal, counts);
        let Err(ServiceError::Refused { .. }) = gone else { return gone };
        if let Ok(watchdog) = self.servo.table.register("Bus Watchdog")
            && self.client.read(self.servo, &watchdog)? < 0
        {
            let what = format!(
                "it heard nothing for {WATCHDOG_MS} ms and stopped by itself: this machine or the line is too slow \
                 for a move"
            );
            return Err(ServiceError::State { id: self.servo.id, what });
        }
        gone
    }

    /// Switches its torque on.
    pub(crate) fn hold(&mut self) -> Result<(), ServiceError> {
        set_torque(self.client, self.servo, true)
    }

    /// Looks at a servo that moves; returns its position, counts. Refuses to go on where it is in trouble, too hot,
    /// limp, or where it cannot be.
    pub(crate) fn look(&mut self) -> Result<i32, ServiceError> {
        let refused = |what: String| Err(ServiceError::State { id: self.servo.id, what });
        let state = ensure_no_fault(self.client, self.servo)?;
        let most_c = self.motion.as_ref().map_or(f64::INFINITY, |motion| motion.most_c);
        if state.temperature.value >= most_c {
            let found = state.temperature;
            return refused(format!("it is {found} hot, and its limit is {most_c} degC"));
        }
        if !torque_is_on(self.client, self.servo)? {
            return refused(
                "its torque went off by itself while it moved: it started anew, or something else switched it off"
                    .to_owned(),
            );
        }
        self.follow(state.position.raw)?;
        Ok(state.position.raw)
    }

    /// Takes a position that was read by itself, counts; refuses where the servo cannot be.
    pub(crate) fn follow(&mut self, counts: i32) -> Result<(), ServiceError> {
        let now = self.client.now();
        self.follow_at(now, counts)
    }

    /// Takes a position that was read at a time of the line, counts.
    pub(crate) fn follow_at(&mut self, time: Duration, counts: i32) -> Result<(), ServiceError> {
        let Some(motion) = &mut self.motion else { return Ok(()) };
        motion.follow.take(time, counts).map_err(|what| {
            motion.has_jumped = true;
            ServiceError::State { id: self.servo.id, what }
        })
    }

    /// Ends: all is put back, whatever the tool came to.
    pub(crate) fn end<T>(mut self, result: Result<T, ServiceError>) -> Result<T, ServiceError> {
        let restored = self.restore();
        joined(self.servo.id, result, restored)
    }

    /// Ends: what was changed stays if the tool did all of it, else all is put back.
    pub(crate) fn keep<T>(mut self, result: Result<T, ServiceError>) -> Result<T, ServiceError> {
        if result.is_ok() {
            self.is_over = true;
            return result;
        }
        self.end(result)
    }

    /// Puts all back, also where one thing fails; gives the first failure. No signal ends this.
    fn restore(&mut self) -> Result<(), ServiceError> {
        self.is_over = true;
        let (servo, was_on) = (self.servo, self.was_on);
        let (motion, before) = (self.motion.take(), std::mem::take(&mut self.before));
        self.client.whole(|client| {
            let calm = |client: &mut Client<E>| match &motion {
                Some(motion) => motion.calm(client, servo, was_on),
                None => Ok(()),
            };
            let mut calmed = calm(client);
            // A change of mode sets other registers back: EEPROM first. The rest as it came, the last one first.
            let (kept, lost): (Vec<(Item, i32)>, Vec<_>) =
                before.iter().rev().partition(|(item, _)| item.area == Area::Eeprom);
            let mut restored = Ok(());
            for (item, raw) in kept.iter().chain(&lost) {
                restored = restored.and(store(client, servo, item, *raw));
            }
            for _ in 0..AGAIN.0 {
                if calmed.is_ok() {
                    break;
                }
                client.pause(AGAIN.1);
                calmed = calm(client);
            }
            calmed.and(restored)
        })
    }
}

impl<E: Exchange> Drop for Guard<'_, E> {
    fn drop(&mut self) {
        if !self.is_over {
            // Nobody can be told here.
            let _ = self.restore();
        }
    }
}

impl Motion {
    /// Lets a servo that was limp go; sends one that held something back to that. A servo that does not take its goal
    /// would go on to where it was sent, and with all of its torque: it is limp then, even if it held something.
    fn calm<E: Exchange>(
        &self,
        client: &mut Client<E>,
        servo: &Servo,
        was_on: bool,
    ) -> Result<(), ServiceError> {
        if !was_on {
            if !self.has_jumped {
                // Where it cannot brake, it is limp all the same.
                let _ = self.brake(client, servo);
            }
            return set_torque(client, servo, false);
        }
        // One that has run out takes no goals.
        if let Ok(watchdog) = servo.table.register("Bus Watchdog") {
            store(client, servo, &watchdog, 0)?;
        }
        let back = if self.has_jumped {
            let present = servo.table.role(Role::PresentPosition);
            present.and_then(|present| client.read(servo, &present))
        } else {
            Ok(self.held)
        };
        let back = back.and_then(|counts| store(client, servo, &self.goal, counts));
        if back.is_err() {
            set_torque(client, servo, false)?;
        }
        back
    }

    /// Brakes a servo that is on its way: let go at speed, one with little friction turns on for far.
    fn brake<E: Exchange>(
        &self,
        client: &mut Client<E>,
        servo: &Servo,
    ) -> Result<(), ServiceError> {
        if !torque_is_on(client, servo)? {
            return Ok(());
        }
        let (present, scale) = (servo.table.role(Role::PresentPosition)?, Scale::of(&self.goal));
        store(client, servo, &self.goal, self.held)?;
        let (begin, mut before) = (client.now(), client.read(servo, &present)?);
        let mut then = begin;
        while then < begin + MOST_BRAKE {
            client.pause(Duration::from_millis(2));
            let (now, counts) = (client.now(), client.read(servo, &present)?);
            let passed_s = now.saturating_sub(then).as_secs_f64();
            if scale.quantity(counts - before).value.abs() <= SLOW_DEG_S * passed_s {
                break;
            }
            (then, before) = (now, counts);
        }
        Ok(())
    }
}

/// Joins what a tool came to with what putting back came to.
fn joined<T>(
    id: u8,
    result: Result<T, ServiceError>,
    restored: Result<(), ServiceError>,
) -> Result<T, ServiceError> {
    match (result, restored) {
        (Err(why), Err(left)) => {
            Err(ServiceError::NotRestored { id, why: why.into(), left: left.into() })
        }
        (result, restored) => restored.and(result),
    }
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
