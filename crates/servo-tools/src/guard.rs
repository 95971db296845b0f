//! Guards servos that a tool changes: whatever ends the tool, the servo's previous state is restored, or the tool
//! reports that it is not.
//!
//! A tool changes registers through its [`Guard`], which stores the previous values. The guard restores all of them
//! after an error or a signal, and at the end of each tool whose changes are only temporary. If torque was off before,
//! it is switched off first. While a servo moves, the guard checks temperature, errors, torque, and whether the
//! reported position is possible.
//!
//! A program that was killed cannot restore anything. For this case, a servo with a bus watchdog has its watchdog set
//! during a move, and stops by itself; and every servo that can limit its torque has it limited. [`left`](crate::left)
//! then finds the traces.

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

/// Bus watchdog during a move, in 20 ms: the servo stops by itself if it receives nothing for this time. It is long
/// enough for a PC, which may pause a program, and differs from the value that a board sets.
pub(crate) const WATCHDOG: i32 = 15;
const WATCHDOG_MS: i32 = 20 * WATCHDOG;
/// Registers of a Dynamixel that a change of its mode resets: gains, goals and profile.
const SET_BACK: std::ops::RangeInclusive<u16> = 76..=112;
/// Number and interval of further attempts if a servo's torque does not switch off: the line may get better.
const AGAIN: (u32, Duration) = (5, Duration::from_millis(200));

/// Maximum speed at which torque is switched off. The servo brakes to it first, for at most [`MOST_BRAKE`].
const SLOW_DEG_S: f64 = 30.0;
const MOST_BRAKE: Duration = Duration::from_secs(1);

/// A servo that a tool changes, with its previous state.
pub(crate) struct Guard<'c, E: Exchange> {
    client: &'c mut Client<E>,
    servo: &'c Servo,
    was_on: bool,
    /// Previous values of the changed registers, in the order of the changes.
    before: Vec<(Item, i32)>,
    motion: Option<Motion>,
    is_over: bool,
}

/// A servo that the tool moves.
struct Motion {
    goal: Item,
    /// Position at the start if torque was off, or the goal that the servo held if torque was on; in counts.
    held: i32,
    most_c: f64,
    follow: Follow,
    /// Whether the encoder counts differently than before: then an earlier goal has lost its meaning.
    has_jumped: bool,
}

impl<'c, E: Exchange> Guard<'c, E> {
    /// Guards a servo whose registers change but that is not moved.
    pub(crate) fn begin(client: &'c mut Client<E>, servo: &'c Servo) -> Result<Self, ServiceError> {
        let was_on = torque_is_on(client, servo)?;
        Ok(Self { client, servo, was_on, before: Vec::new(), motion: None, is_over: false })
    }

    /// Guards a servo that is moved by at most `most_deg_s`, deg/s. Refuses if the servo has a fault, or a program that
    /// was killed has left its torque on. Sets its watchdog, if it has one.
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
        // The first of all changes, so that it is restored last: it marks a servo that a tool has changed.
        if let Ok(watchdog) = servo.table.register("Bus Watchdog") {
            guard.change(&watchdog, WATCHDOG)?;
        }
        Ok(guard)
    }

    /// Returns client and servo, for operations that change nothing.
    pub(crate) fn parts(&mut self) -> (&mut Client<E>, &'c Servo) {
        (self.client, self.servo)
    }

    pub(crate) fn client(&mut self) -> &mut Client<E> {
        self.client
    }

    pub(crate) fn servo(&self) -> &'c Servo {
        self.servo
    }

    /// Returns whether torque was on before.
    pub(crate) fn was_on(&self) -> bool {
        self.was_on
    }

    /// Returns the position or goal at the start, in counts; 0 for a servo that is not moved.
    pub(crate) fn held(&self) -> i32 {
        self.motion.as_ref().map_or(0, |motion| motion.held)
    }

    /// Stores the present value of a register, unless it is already stored.
    pub(crate) fn note(&mut self, item: &Item) -> Result<(), ServiceError> {
        if self.before.iter().all(|(known, _)| known.address != item.address) {
            let raw = self.client.read(self.servo, item)?;
            self.before.push((*item, raw));
        }
        Ok(())
    }

    /// Stores the present value of a register, then writes the register and verifies the new value. Before a change of
    /// mode, also stores the registers that it resets.
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

    /// Sends the servo to a goal, in counts.
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

    /// Switches torque on.
    pub(crate) fn hold(&mut self) -> Result<(), ServiceError> {
        set_torque(self.client, self.servo, true)
    }

    /// Checks a servo that moves, and returns its position in counts. Refuses to continue if the servo has a fault, is
    /// too hot, has torque off, or reports an impossible position.
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
                "its torque went off by itself while it moved: it restarted, or something else switched it off"
                    .to_owned(),
            );
        }
        self.follow(state.position.raw)?;
        Ok(state.position.raw)
    }

    /// Checks a position that was read separately, in counts. Refuses if the servo cannot be there.
    pub(crate) fn follow(&mut self, counts: i32) -> Result<(), ServiceError> {
        let now = self.client.now();
        self.follow_at(now, counts)
    }

    /// Checks a position that was read at a time of the line, in counts.
    pub(crate) fn follow_at(&mut self, time: Duration, counts: i32) -> Result<(), ServiceError> {
        let Some(motion) = &mut self.motion else { return Ok(()) };
        motion.follow.take(time, counts).map_err(|what| {
            motion.has_jumped = true;
            ServiceError::State { id: self.servo.id, what }
        })
    }

    /// Ends the guard and restores all registers, whatever the result of the tool.
    pub(crate) fn end<T>(mut self, result: Result<T, ServiceError>) -> Result<T, ServiceError> {
        let restored = self.restore();
        joined(self.servo.id, result, restored)
    }

    /// Ends the guard. Keeps the changes if the tool succeeded, otherwise restores all registers.
    pub(crate) fn keep<T>(mut self, result: Result<T, ServiceError>) -> Result<T, ServiceError> {
        if result.is_ok() {
            self.is_over = true;
            return result;
        }
        self.end(result)
    }

    /// Restores everything that can be restored, and returns the first error. A signal does not interrupt this.
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
            // EEPROM first, because a change of mode resets other registers. The others in reverse order of the
            // changes.
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
            // A drop cannot report an error.
            let _ = self.restore();
        }
    }
}

impl Motion {
    /// Returns the servo to its state before the move: with torque off if it was off, otherwise at the position that it
    /// held, or at its present position if its encoder has jumped. A servo that refuses its goal would continue with
    /// full torque: its torque is switched off, even if it held something.
    fn calm<E: Exchange>(
        &self,
        client: &mut Client<E>,
        servo: &Servo,
        was_on: bool,
    ) -> Result<(), ServiceError> {
        if !was_on {
            if !self.has_jumped {
                // If braking fails, torque is switched off nevertheless.
                let _ = self.brake(client, servo);
            }
            return set_torque(client, servo, false);
        }
        // A servo whose watchdog expired accepts no goals.
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

    /// Brakes a servo that moves: without torque at speed, a servo with little friction would turn much further.
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

/// Combines the result of the tool with the result of the restoration.
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

/// Returns the measurements of a servo. Refuses if it reports a fault.
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
