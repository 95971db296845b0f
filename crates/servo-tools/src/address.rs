//! Changes ids and baud rates of servos.

use std::time::Duration;

use sinew_servo_bus::table::Item;

use crate::ping_reply::Miss;
use crate::store::{ensure_at_rest, open_eeprom, shut_eeprom};
use crate::table::Role;
use crate::{Client, Exchange, ServiceError, Servo};

/// Maximum id. 253 and 254 are reserved for the bus, 255 begins a packet.
const MOST_ID: u8 = 252;
/// Wait after a change of the baud rate: a servo needs a moment before it answers at its new rate.
const SETTLE: Duration = Duration::from_millis(50);
const TRIES: u32 = 3;

/// Changes the id of a servo. Refuses if another servo has the new id, or if torque is on.
///
/// # Errors
/// [`ServiceError::BadId`]; [`ServiceError::IdTaken`], or [`ServiceError::Noise`] if several servos have the new id;
/// [`ServiceError::Register`] if torque is on; [`ServiceError::State`] if the servo keeps its old id;
/// [`ServiceError::Lost`] if the servo then answers with neither id; the errors of [`Client::read_bytes`].
pub fn set_id<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    new: u8,
) -> Result<Servo, ServiceError> {
    if new > MOST_ID {
        return Err(ServiceError::BadId(new));
    }
    match client.ping(new, TRIES)? {
        Ok(pong) => {
            let model = pong
                .table
                .map_or_else(|| format!("model {}", pong.number), |table| table.model().to_owned());
            return Err(ServiceError::IdTaken { id: new, model });
        }
        // Two servos have this id.
        Err(Miss::Noise) => return Err(ServiceError::Noise { id: new }),
        Err(Miss::Silence) => {}
    }
    let item = servo.table.role(Role::Id)?;
    ensure_at_rest(client, servo, item.name)?;
    client.whole(|client| write_id(client, servo, &item, new))
}

/// Writes the id. A signal does not interrupt this.
fn write_id<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    item: &Item,
    new: u8,
) -> Result<Servo, ServiceError> {
    for _ in 0..TRIES {
        open_eeprom(client, servo)?;
        let request = Client::<E>::write_request(servo, item, new.into())?;
        client.send(servo.id, &request)?;
        if client.ping(new, TRIES)?.is_ok() {
            shut_eeprom(client, servo, new)?;
            return Ok(Servo { id: new, ..servo.clone() });
        }
        if client.ping(servo.id, TRIES)?.is_err() {
            return Err(ServiceError::Lost { id: servo.id, what: format!("id {new}") });
        }
        // The write did not reach the servo.
        shut_eeprom(client, servo, servo.id)?;
    }
    let what = format!("id {new} was written {TRIES} times, and it keeps its own");
    Err(ServiceError::State { id: servo.id, what })
}

/// Sets a servo's baud rate, and continues at the new rate. The rate of the other servos on the line does not change.
///
/// # Errors
/// [`ServiceError::NoBaud`]; [`ServiceError::Baud`] if the line does not support the rate: nothing is written then;
/// [`ServiceError::Register`] if torque is on; [`ServiceError::State`] if the servo keeps its rate;
/// [`ServiceError::Lost`] if the servo then answers at neither rate; the errors of [`Client::read_bytes`].
pub fn set_baud<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    baud: u32,
) -> Result<(), ServiceError> {
    let before = client.baud();
    let item = servo.table.role(Role::Baud)?;
    let most = match item.range {
        sinew_servo_bus::table::Range::Between(_, most) => usize::try_from(most).unwrap_or(0),
        _ => 0,
    };
    let codes = servo.table.protocol().baud_codes();
    let known = codes.get(..=most).unwrap_or(&codes);
    let Some(code) = known.iter().position(|known| *known == baud) else {
        let mut known = known.to_vec();
        known.sort_unstable();
        let known: Vec<_> = known.iter().map(ToString::to_string).collect();
        let model = servo.table.model().to_owned();
        return Err(ServiceError::NoBaud { model, baud, known: known.join(", ") });
    };
    // Tested first, because a servo at a rate that the adapter does not support could no longer be reached.
    client.set_baud(baud)?;
    client.set_baud(before)?;
    ensure_at_rest(client, servo, item.name)?;
    let request = Client::<E>::write_request(servo, &item, i32::try_from(code).unwrap_or(0))?;
    client.whole(|client| write_baud(client, servo, &request, baud))
}

/// Writes the baud rate and switches the line to it. A signal does not interrupt this.
fn write_baud<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    request: &[u8],
    baud: u32,
) -> Result<(), ServiceError> {
    let before = client.baud();
    for _ in 0..TRIES {
        open_eeprom(client, servo)?;
        client.send(servo.id, request)?;
        client.pause(SETTLE);
        client.set_baud(baud)?;
        if client.ping(servo.id, TRIES)?.is_ok() {
            return shut_eeprom(client, servo, servo.id);
        }
        client.set_baud(before)?;
        if client.ping(servo.id, TRIES)?.is_err() {
            return Err(ServiceError::Lost { id: servo.id, what: format!("{baud} baud") });
        }
        shut_eeprom(client, servo, servo.id)?;
    }
    let what = format!("{baud} baud was written {TRIES} times, and it stays at {before}");
    Err(ServiceError::State { id: servo.id, what })
}
