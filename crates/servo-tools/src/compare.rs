//! What servos have against what they should have: the difference, and its end.

use sinew_servo_bus::table::{Area, ByteOrder};

use crate::desired::Setting;
use crate::guard::Guard;
use crate::quantity::{Quantity, quantity};
use crate::store::{set_torque, torque_is_on};
use crate::{Client, Exchange, Registers, ServiceError, Servo};

/// A register that holds something else than it should.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Difference {
    /// The register.
    pub name: &'static str,
    /// Its address.
    pub address: u16,
    /// What it holds.
    pub has: Quantity,
    /// What it should hold.
    pub should: Quantity,
    /// Whether it survives a loss of power. What does not is another one after each reboot.
    pub is_kept: bool,
}

/// Compares. `bytes` are what the servo holds from an address on: as many as [`span`] says.
///
/// This is what arming asks, too: a difference refuses.
pub fn differences(
    settings: &[Setting],
    order: ByteOrder,
    first: u16,
    bytes: &[u8],
) -> Vec<Difference> {
    let difference = |setting: &Setting| {
        let Setting { item, raw } = setting;
        let at = item.address.checked_sub(first).map(usize::from)?;
        let has = item.value(bytes.get(at..)?, order);
        (has != *raw).then(|| Difference {
            name: item.name,
            address: item.address,
            has: quantity(item, has),
            should: quantity(item, *raw),
            is_kept: item.area == Area::Eeprom,
        })
    };
    settings.iter().filter_map(difference).collect()
}

/// Address and length of one read that has all of these registers.
pub fn span(settings: &[Setting]) -> (u16, u16) {
    let first = settings.iter().map(|setting| setting.item.address).min().unwrap_or(0);
    let end = settings.iter().map(|setting| setting.item.end()).max().unwrap_or(first);
    (first, end - first)
}

/// Reads and compares.
///
/// # Errors
/// Those of [`Client::read_bytes`].
pub fn diff<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    settings: &[Setting],
) -> Result<Vec<Difference>, ServiceError> {
    let (first, length) = span(settings);
    let (bytes, _) = client.read_bytes(servo.id, first, length)?;
    Ok(differences(settings, servo.table.order(), first, &bytes))
}

/// What was done to a servo.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Applied {
    /// What was different, and no longer is.
    pub written: Vec<Difference>,
    /// Whether its torque was switched off for that.
    pub let_go: bool,
}

/// Writes what is different, EEPROM first: a change of mode sets gains back. Reads back, and compares again. Where
/// something fails or a signal ends it, all registers are as before.
///
/// `release`: EEPROM is written only at rest, and the torque of the servo may be switched off for it. It stays off.
///
/// # Errors
/// [`Registers::TorqueOn`] if torque is on and may not be switched off; [`Registers::NotKept`] if a difference is left.
pub fn apply<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    settings: &[Setting],
    release: bool,
) -> Result<Applied, ServiceError> {
    let mut guard = Guard::begin(client, servo)?;
    let applied = apply_all(&mut guard, settings, release);
    guard.keep(applied)
}

fn apply_all<E: Exchange>(
    guard: &mut Guard<'_, E>,
    settings: &[Setting],
    release: bool,
) -> Result<Applied, ServiceError> {
    let (client, servo) = guard.parts();
    let mut applied = Applied { written: diff(client, servo, settings)?, let_go: false };
    if let Some(kept) = applied.written.iter().find(|difference| difference.is_kept)
        && torque_is_on(client, servo)?
    {
        if !release {
            return Err(Registers::TorqueOn { id: servo.id, name: kept.name }.into());
        }
        set_torque(client, servo, false)?;
        applied.let_go = true;
    }
    for area in [Area::Eeprom, Area::Ram] {
        for difference in diff(guard.client(), servo, settings)? {
            let setting =
                settings.iter().find(|setting| setting.item.address == difference.address);
            if let Some(Setting { item, raw }) = setting.filter(|setting| setting.item.area == area)
            {
                guard.change(item, *raw)?;
            }
        }
    }
    match diff(guard.client(), servo, settings)?.first() {
        None => Ok(applied),
        Some(left) => Err(Registers::NotKept {
            id: servo.id,
            name: left.name,
            wrote: left.should.to_string(),
            reads: left.has.to_string(),
        }
        .into()),
    }
}
