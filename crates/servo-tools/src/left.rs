//! Finds servos that a program left in the middle of its work: it was killed, or its cable was pulled.
//!
//! A tool marks a servo before it changes anything: it sets the bus watchdog of a Dynamixel, or lowers the torque limit
//! of an STS. It restores these registers last. Any program on any machine can thus recognize an abandoned servo by its
//! registers.

use std::time::Duration;

use sinew_servo_bus::dynamixel::table::address as dxl;
use sinew_servo_bus::feetech::Family;
use sinew_servo_bus::feetech::table::address as feetech_address;

use crate::guard::WATCHDOG;
use crate::identify::RUNNING_TIME_MS;
use crate::quantity::Scale;
use crate::store::{lock_of, torque_is_on};
use crate::{Client, Exchange, Protocol, ServiceError, Servo, Table, scan};

/// Maximum id of a Feetech that is checked: each id must be asked alone, and a silent id costs the whole wait.
const FEETECH_MOST: u8 = 12;
const FEETECH_ANSWER: Duration = Duration::from_millis(34);

/// A servo that a program left in the middle of its work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Left {
    /// Description of the trace, and the command that helps.
    pub what: String,
    /// Whether torque is on.
    pub is_on: bool,
}

/// Checks whether a program that was ended left traces on a servo. Returns `None` if there are none.
///
/// # Errors
/// The errors of [`Client::read_bytes`].
pub fn look<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
) -> Result<Option<Left>, ServiceError> {
    let is_on = torque_is_on(client, servo)?;
    let id = servo.id;
    let marks = match servo.table {
        Table::Dynamixel(_) => of_dynamixel(client, servo, is_on)?,
        Table::Feetech(table) => of_feetech(client, servo, table.model.family, is_on)?,
    };
    let mut words = Vec::new();
    if let Some(marks) = marks {
        let (torque, helps) =
            if is_on { ("on", "switches torque off and sets") } else { ("off", "sets") };
        words.push(format!(
            "a program that was ended left it in this state: its torque is {torque}, and {marks}. `sinew servo reboot \
             {id}` {helps} back what it has in RAM"
        ));
    }
    if let Some(lock) = lock_of(servo)
        && client.read(servo, &lock)? == 0
    {
        words.push(
            "its EEPROM is unlocked: a program left it in this state. The next `sinew servo write` locks it"
                .to_owned(),
        );
    }
    Ok((!words.is_empty()).then(|| Left { what: words.join("; "), is_on }))
}

/// Checks all servos on a line except `known`, at the present protocol and rate: Dynamixels that answer a common ping,
/// and Feetechs with ids up to 12. Takes up to a second.
///
/// # Errors
/// An error if the line failed; [`ServiceError::Stopped`] after a signal.
pub fn on_line<E: Exchange>(
    client: &mut Client<E>,
    known: u8,
) -> Result<Vec<(u8, Left)>, ServiceError> {
    let ids: Vec<u8> = match client.protocol() {
        Protocol::Dynamixel => {
            scan::answer_together(client)?.iter().map(|reply| reply.id).collect()
        }
        Protocol::Feetech => (0..=FEETECH_MOST).collect(),
    };
    let mut found = Vec::new();
    for id in ids.into_iter().filter(|id| *id != known) {
        // A servo that does not answer alone is skipped: it is not set up yet.
        if client.with_patience(FEETECH_ANSWER, |client| client.ping(id, 1))?.is_ok()
            && let Ok(servo) = client.open(id, None)
            && let Ok(Some(left)) = look(client, &servo)
        {
            found.push((id, left));
        }
    }
    client.ensure_going()?;
    Ok(found)
}

fn of_dynamixel<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    is_on: bool,
) -> Result<Option<String>, ServiceError> {
    let watchdog = servo.table.register_at(dxl::BUS_WATCHDOG)?;
    Ok(match client.read(servo, &watchdog)? {
        ran_out if ran_out < 0 && is_on => Some(
            "its Bus Watchdog has run out, so it holds the position that it had then".to_owned(),
        ),
        set if set == WATCHDOG => Some(format!(
            "its Bus Watchdog is {}, as for a move",
            Scale::of(&watchdog).quantity(set)
        )),
        _ => None,
    })
}

fn of_feetech<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    family: Family,
    is_on: bool,
) -> Result<Option<String>, ServiceError> {
    let table = &servo.table;
    if family == Family::Scs {
        // This family cannot limit torque or speed: its moves have a fixed time instead.
        let time = client.read(servo, &table.register("Running Time")?)?;
        let is_left = is_on && time == RUNNING_TIME_MS;
        return Ok(is_left.then(|| format!("its Running Time is {time} ms, as for a move")));
    }
    let limit = table.register_at(feetech_address::TORQUE_LIMIT.into())?;
    let most = table.register_at(feetech_address::MAX_TORQUE.into())?;
    let [has, starts] = [client.read(servo, &limit)?, client.read(servo, &most)?];
    let [shown, after] = [has, starts].map(|raw| Scale::of(&limit).quantity(raw));
    Ok((has != starts)
        .then(|| format!("its Torque Limit is {shown}, where a start makes it {after}")))
}
