//! Verified writes: sends, reads back and repeats. EEPROM is written only with torque off, and the lock of a Feetech is
//! always shut afterwards.

use sinew_servo_bus::feetech::{self, Instruction};
use sinew_servo_bus::table::{Area, Item};

use crate::client::packet;
use crate::quantity::quantity;
use crate::table::Role;
use crate::{Client, Exchange, Registers, ServiceError, Servo, Table};

/// Maximum number of attempts to write a value.
const WRITES: u32 = 3;

/// Refuses if torque is on: EEPROM can be written only with torque off.
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

/// Returns whether a servo's torque is on.
///
/// # Errors
/// The errors of [`Client::read_bytes`].
pub fn torque_is_on<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
) -> Result<bool, ServiceError> {
    Ok(client.read(servo, &servo.table.role(Role::Torque)?)? != 0)
}

/// Switches a servo's torque on or off.
///
/// # Errors
/// The errors of [`Client::read_bytes`], and [`Registers::NotKept`].
pub fn set_torque<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    on: bool,
) -> Result<(), ServiceError> {
    store(client, servo, &servo.table.role(Role::Torque)?, on.into())
}

/// Writes a checked value, and verifies it. The EEPROM of a Feetech is opened before, and always shut afterwards.
pub(crate) fn store<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    item: &Item,
    raw: i32,
) -> Result<(), ServiceError> {
    client.ensure_going()?;
    client.whole(|client| store_whole(client, servo, item, raw))
}

/// Writes and verifies a value. A signal does not interrupt this.
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

/// Returns the EEPROM lock register of a Feetech, `None` for a Dynamixel.
pub(crate) fn lock_of(servo: &Servo) -> Option<Item> {
    match &servo.table {
        Table::Dynamixel(_) => None,
        Table::Feetech(table) => table.at(table.model.family.lock()),
    }
}

/// Opens the EEPROM of a Feetech. The EEPROM of a Dynamixel is open while torque is off.
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

/// Shuts the EEPROM of a Feetech. `id` is the servo's present id, which may have just changed.
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
