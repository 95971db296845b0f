//! Compares the registers of servos with their required values, and corrects them.

use sinew_servo_bus::dynamixel::table::drive_mode;
use sinew_servo_bus::feetech::table::phase;
use sinew_servo_bus::table::{Area, ByteOrder};

use crate::desired::Setting;
use crate::guard::Guard;
use crate::quantity::{Quantity, quantity};
use crate::store::{set_torque, torque_is_on};
use crate::{Client, Exchange, Registers, ServiceError, Servo};

/// A register whose value differs from the required value.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Difference {
    /// Name of the register.
    pub name: &'static str,
    /// Address of the register.
    pub address: u16,
    /// Present value.
    pub has: Quantity,
    /// Required value.
    pub should: Quantity,
    /// Whether the value survives a loss of power. A register in RAM may differ again after each reboot.
    pub is_kept: bool,
}

impl Difference {
    /// Returns the consequence for the rig, as text, if this difference reverses the servo or its motor, or lets a goal
    /// switch torque on. Returns `None` for all other differences.
    pub fn consequence(&self) -> Option<&'static str> {
        let changed = self.has.raw ^ self.should.raw;
        let [is_drive_mode, is_phase] = ["Drive Mode", "Phase"].map(|name| self.name == name);
        let is_reversed = (is_drive_mode && changed & drive_mode::REVERSE != 0)
            || (is_phase && changed & i32::from(phase::REVERSED_ENCODER) != 0);
        if is_reversed {
            return Some(
                "the servo reverses itself, and the rig's `direction` is there for that. After `sinew servo apply` it \
                 counts the other way round its middle: if its `direction`, `offset_deg` and `range_deg` were found \
                 while it was reversed, negate them (the range becomes [-most, -least]), or calibrate again",
            );
        }
        if is_phase && changed & i32::from(phase::REVERSED_MOTOR) != 0 {
            return Some("its motor turns against its encoder: with torque on it runs to an end");
        }
        (is_drive_mode && changed & drive_mode::ON_BY_GOAL != 0)
            .then_some("any goal switches its torque on: a controller arms, goals do not")
    }
}

/// Returns the registers that differ. `bytes` are the servo's registers from address `first` on, as many as [`span`]
/// returns.
///
/// A board makes the same comparison before it arms, and refuses if there is a difference.
pub fn differences(
    settings: &[Setting],
    order: ByteOrder,
    first: u16,
    bytes: &[u8],
) -> Vec<Difference> {
    let difference = |setting: &Setting| {
        let item = &setting.item;
        let at = item.address.checked_sub(first).map(usize::from)?;
        let has = item.value(bytes.get(at..)?, order);
        let should = setting.wanted(has);
        (has != should).then(|| Difference {
            name: item.name,
            address: item.address,
            has: quantity(item, has),
            should: quantity(item, should),
            is_kept: item.area == Area::Eeprom,
        })
    };
    settings.iter().filter_map(difference).collect()
}

/// Returns address and length of one read that covers all of these registers.
pub fn span(settings: &[Setting]) -> (u16, u16) {
    let first = settings.iter().map(|setting| setting.item.address).min().unwrap_or(0);
    let end = settings.iter().map(|setting| setting.item.end()).max().unwrap_or(first);
    (first, end - first)
}

/// Reads the registers and returns those that differ.
///
/// # Errors
/// The errors of [`Client::read_bytes`].
pub fn diff<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    settings: &[Setting],
) -> Result<Vec<Difference>, ServiceError> {
    let (first, length) = span(settings);
    let (bytes, _) = client.read_bytes(servo.id, first, length)?;
    Ok(differences(settings, servo.table.order(), first, &bytes))
}

/// The changes that [`apply`] made to a servo.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Applied {
    /// Differences that were corrected.
    pub written: Vec<Difference>,
    /// Whether torque was switched off for the correction.
    pub let_go: bool,
}

/// Writes the registers that differ, EEPROM first because a change of mode resets gains. Reads them back and compares
/// again. After an error or a signal, all registers are as before.
///
/// EEPROM can be written only with torque off. With `release`, this function may switch torque off; torque then stays
/// off.
///
/// # Errors
/// [`Registers::TorqueOn`] if torque is on and may not be switched off; [`Registers::NotKept`] if a difference is left;
/// [`ServiceError::NotRestored`] if the registers could not be restored after an error; the errors of
/// [`Client::read_bytes`].
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
            if let Some(setting) = setting.filter(|setting| setting.item.area == area) {
                guard.change(&setting.item, difference.should.raw)?;
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
