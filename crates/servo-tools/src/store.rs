//! Writes that were checked: sent, read back, sent again; EEPROM at rest, and the lock of a Feetech shut come what may.

use sinew_servo_bus::feetech::{self, Instruction};
use sinew_servo_bus::table::{Area, Item};

use crate::client::packet;
use crate::quantity::quantity;
use crate::table::Role;
use crate::{Client, Exchange, Registers, ServiceError, Servo, Table};

/// How often a write is repeated where the servo does not have it afterwards.
const WRITES: u32 = 3;

/// Refuses to go on where torque is on: EEPROM is written only at rest.
pub(crate) fn ensure_at_rest<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    name: &'static str,
) -> Result<(), ServiceError> {
    if torque_is_on(client, servo)? {
        return Err(Registers::TorqueOn { id: servo.id, name }.into());
    }
    Ok(())
}

/// Whether a servo's torque is on.
///
/// # Errors
/// Those of [`Client::read_bytes`].
pub fn torque_is_on<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
) -> Result<bool, ServiceError> {
    Ok(client.read(servo, &servo.table.role(Role::Torque)?)? != 0)
}

/// Switches a servo's torque.
///
/// # Errors
/// Those of [`Client::read_bytes`], and [`Registers::NotKept`].
pub fn set_torque<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    on: bool,
) -> Result<(), ServiceError> {
    store(client, servo, &servo.table.role(Role::Torque)?, on.into())
}

/// Writes a number that was checked, and looks whether the servo has it. EEPROM of a Feetech is opened before and shut
/// afterwards, come what may.
pub(crate) fn store<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    item: &Item,
    raw: i32,
) -> Result<(), ServiceError> {
    client.ensure_going()?;
    client.whole(|client| store_whole(client, servo, item, raw))
}

/// Writes and looks, and does not end half-way.
fn store_whole<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    item: &Item,
    raw: i32,
) -> Result<(), ServiceError> {
    let mut reads = raw;
    for _ in 0..WRITES {
        let lock = lock_of(servo).filter(|_| item.area == Area::Eeprom);
        if lock.is_some() {
            open_eeprom(client, servo)?;
        }
        let written = Client::<E>::write_request(servo, item, raw)
            .and_then(|request| client.send(servo.id, &request));
        if let Some(lock) = lock {
            store(client, servo, &lock, 1)?;
        }
        written?;
        reads = client.read(servo, item)?;
        if reads == raw {
            return Ok(());
        }
    }
    let [wrote, reads] = [raw, reads].map(|raw| quantity(item, raw).to_string());
    Err(Registers::NotKept { id: servo.id, name: item.name, wrote, reads }.into())
}

/// The EEPROM lock of a Feetech.
pub(crate) fn lock_of(servo: &Servo) -> Option<Item> {
    match &servo.table {
        Table::Dynamixel(_) => None,
        Table::Feetech(table) => table.at(table.model.family.lock()),
    }
}

/// Opens the EEPROM of a Feetech; of a Dynamixel it is open while torque is off.
pub(crate) fn open_eeprom<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
) -> Result<(), ServiceError> {
    if let Table::Feetech(table) = &servo.table {
        let request = packet(|out| feetech::open_eeprom(table.model.family, servo.id, out))?;
        client.send(servo.id, &request)?;
    }
    Ok(())
}

/// Shuts it again; `id` is the servo's own by now.
pub(crate) fn shut_eeprom<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    id: u8,
) -> Result<(), ServiceError> {
    if let Table::Feetech(table) = &servo.table {
        let family = table.model.family;
        let shut = Instruction::Write { address: family.lock(), data: &[1] };
        client.send(id, &packet(|out| shut.encode(family, id, out))?)?;
    }
    Ok(())
}
