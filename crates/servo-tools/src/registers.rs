//! Reads and writes registers by name. A write is checked before, and verified after.

use sinew_servo_bus::dynamixel::table::address as dxl;
use sinew_servo_bus::table::{Access, Area, Item, Range, Sign};

use crate::quantity::{Quantity, Scale, quantity};
use crate::store::{ensure_at_rest, store};
pub use crate::store::{set_torque, torque_is_on};
use crate::table::Role;
use crate::{Client, Exchange, Registers, ServiceError, Servo, Table};

/// A register with its present value.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Reading {
    /// The maker's name for the register.
    pub name: &'static str,
    /// Address of the register.
    pub address: u16,
    /// Whether the value survives a loss of power.
    pub is_kept: bool,
    /// Present value.
    #[serde(flatten)]
    pub quantity: Quantity,
}

/// A number that a person gives for a register.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Number {
    /// A value in the unit of [`Scale::of`].
    Value(f64),
    /// A value in counts of the servo.
    Raw(i32),
}

/// Maximum position either way in the modes of several turns, counts. Source: e-manual, Goal Position.
const TURNS: i32 = 1_048_575;

/// Reads registers by name, or all registers if `names` is empty.
///
/// # Errors
/// [`Registers::Unknown`], and the errors of [`Client::read_bytes`].
pub fn read<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    names: &[String],
) -> Result<Vec<Reading>, ServiceError> {
    let items = if names.is_empty() {
        servo.table.items()
    } else {
        names.iter().map(|name| servo.table.register(name)).collect::<Result<_, _>>()?
    };
    items.iter().map(|item| Ok(reading(item, client.read(servo, item)?))).collect()
}

fn reading(item: &Item, raw: i32) -> Reading {
    Reading {
        name: item.name,
        address: item.address,
        is_kept: item.area == Area::Eeprom,
        quantity: quantity(item, raw),
    }
}

/// Writes a register by name, and returns its value afterwards. Refuses if the number is out of range, the register is
/// read-only or has its own command, or the register is in EEPROM and torque is on; refuses a goal position of a
/// Feetech while its torque is off.
///
/// # Errors
/// [`Registers`] contains cause and remedy; [`Registers::NotKept`] if the servo stored another number;
/// [`ServiceError::State`] for the goal position of a Feetech without torque; the errors of [`Client::read_bytes`].
pub fn write<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    name: &str,
    number: Number,
) -> Result<Reading, ServiceError> {
    let item = servo.table.register(name)?;
    if let Some(instead) = elsewhere(servo, &item) {
        return Err(Registers::Elsewhere { name: item.name, instead }.into());
    }
    if item.access == Access::Read {
        return Err(Registers::ReadOnly(item.name).into());
    }
    let raw = counts(client, servo, &item, number)?;
    if item.area == Area::Eeprom {
        ensure_at_rest(client, servo, item.name)?;
    }
    let is_goal = item.address == servo.table.address(Role::GoalPosition);
    if is_goal && matches!(servo.table, Table::Feetech(_)) && !torque_is_on(client, servo)? {
        let what = "a goal position switches the torque of a Feetech on by itself; write torque-enable 1 first";
        return Err(ServiceError::State { id: servo.id, what: what.to_owned() });
    }
    store(client, servo, &item, raw)?;
    Ok(reading(&item, raw))
}

/// Returns the command to use instead of a plain write, or the reason why there is none, for registers whose change
/// could make the servo unreachable or lose its settings. Returns `None` for other registers.
fn elsewhere(servo: &Servo, item: &Item) -> Option<String> {
    let id = servo.id;
    if item.address == servo.table.address(Role::Id) {
        return Some(format!(
            "`sinew servo set-id {id} NEW` looks first whether the new id is free"
        ));
    }
    if item.address == servo.table.address(Role::Baud) {
        return Some(format!("`sinew servo set-baud {id} BAUD` follows the servo to its new rate"));
    }
    match &servo.table {
        Table::Dynamixel(_) => (item.name == "Protocol Type")
            .then(|| "in another protocol Sinew could not reach the servo any more".to_owned()),
        Table::Feetech(table) => (item.address == u16::from(table.model.family.lock())).then(|| {
            "EEPROM is opened by each write that needs it, and shut again: open, it is lost sooner or later".to_owned()
        }),
    }
}

/// Converts a person's number to counts, and checks the range of the register.
fn counts<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    item: &Item,
    number: Number,
) -> Result<i32, ServiceError> {
    let scale = Scale::of(item);
    let refused = |takes: String, found: String| {
        ServiceError::from(Registers::Value { name: item.name, takes, found })
    };
    let [least, most] = range(client, servo, item)?;
    let takes = || {
        let [from, to] = [least, most].map(|raw| scale.quantity(raw));
        format!("{from} to {to} ({least} to {most} raw)")
    };
    let raw = match number {
        Number::Raw(raw) => raw,
        Number::Value(value) => scale
            .raw(value)
            .filter(|_| value.is_finite())
            .ok_or_else(|| refused(takes(), format!("{value}")))?,
    };
    let found = || format!("{} ({raw} raw)", scale.quantity(raw));
    if !(least..=most).contains(&raw) {
        return Err(refused(takes(), found()));
    }
    match choices(servo, item) {
        Some(choices) if !choices.contains(&raw) => {
            let list: Vec<_> = choices.iter().map(ToString::to_string).collect();
            Err(refused(format!("one of {}", list.join(", ")), found()))
        }
        _ => Ok(raw),
    }
}

/// Returns the allowed values of a register whose range contains invalid or harmful values. Returns `None` if the whole
/// range is allowed.
fn choices(servo: &Servo, item: &Item) -> Option<&'static [i32]> {
    match &servo.table {
        Table::Dynamixel(_) if item.address == dxl::OPERATING_MODE => {
            Some(if servo.table.has_current() { &[0, 1, 3, 4, 5, 16] } else { &[1, 3, 4, 16] })
        }
        // The bit of a slave, of a dual joint, would make the servo deaf to goals.
        Table::Dynamixel(_) if item.address == dxl::DRIVE_MODE => Some(&[0, 1, 4, 5, 8, 9, 12, 13]),
        // 128 would move the middle of the servo.
        Table::Feetech(_) if item.address == servo.table.address(Role::Torque) => Some(&[0, 1, 2]),
        _ => None,
    }
}

/// Returns the range of a register, in counts.
fn range<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    item: &Item,
) -> Result<[i32; 2], ServiceError> {
    let mut at = |address: u16| {
        let item = servo.table.register_at(address)?;
        client.read(servo, &item)
    };
    Ok(match item.range {
        Range::Any => whole(item),
        Range::Between(least, most) => [least, most],
        Range::PlusMinus(limit) => {
            let most = at(limit)?;
            [-most, most]
        }
        Range::Within(..) if at(dxl::OPERATING_MODE)? != 3 => [-TURNS, TURNS],
        Range::Within(least, most) => [at(least)?, at(most)?],
    })
}

/// Returns the range that fits into the bytes of a register.
fn whole(item: &Item) -> [i32; 2] {
    let bits = u32::from(item.size) * 8;
    let most = |bits: u32| i32::try_from((1_i64 << bits) - 1).unwrap_or(i32::MAX);
    match item.sign {
        Sign::Unsigned => [0, most(bits)],
        Sign::TwosComplement => [-most(bits - 1) - 1, most(bits - 1)],
        Sign::Magnitude(bit) => [-most(bit.into()), most(bit.into())],
    }
}
