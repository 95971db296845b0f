//! Control tables of the X and MX series.
//!
//! Source: e-manual, the page of each servo. Addresses and sizes were compared with the tables inside ROBOTIS's
//! `dynamixel-sdk` 4.1.0: see `tests/servo_bus/dynamixel_tables.rs`. A comment marks each place where the two differ.

mod items;
mod models;

pub(crate) use items::{FULL_PWM, Only};
pub(super) use items::{POSITION, PWM_COUNTS, VELOCITY};
pub use items::{address, drive_mode};
pub use models::{Current, Family, MODELS, Model};

use crate::table::{Access, Area, Item, Range, Sign, Unit};
use items::ITEMS;

/// Returns the register that begins at an address, and the models that have it. It is for use at build time, and leaves
/// out the values that differ by model.
#[expect(
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects,
    clippy::panic,
    reason = "at build time"
)]
pub(crate) const fn of_all(address: u16) -> (Only, Item) {
    let mut index = 0;
    while index < ITEMS.len() {
        if ITEMS[index].1.address == address {
            return ITEMS[index];
        }
        index += 1;
    }
    panic!("no item begins at this address");
}

/// First address after the last register.
const END: usize = match ITEMS {
    [.., (_, last)] => last.end() as usize,
    [] => 0,
};

/// For each address, the number of registers that end at or before it. Computed at build time: without it, a simulated
/// servo would search the table each time it reads one of its own registers.
#[expect(clippy::indexing_slicing, reason = "at build time")]
const BEFORE: [u8; END] = {
    let mut before = [0; END];
    let (mut address, mut items) = (0, 0_u8);
    while address < END {
        while ITEMS[items as usize].1.end() as usize <= address {
            items += 1;
        }
        before[address] = items;
        address += 1;
    }
    before
};

/// The control table of a model with a firmware version.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table {
    /// Model of the servo.
    pub model: &'static Model,
    /// Firmware version. Version 52 moved the indirect data of small servos.
    pub firmware: u8,
}

/// A run of indirect addresses, and of the data that they point to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Indirect {
    /// Address of the first indirect address; each has 2 bytes.
    pub addresses: u16,
    /// Address of the first byte of indirect data.
    pub data: u16,
    /// Number of indirect addresses.
    pub count: u16,
}

impl Table {
    /// Returns the table of the model with this number, or `None` if the model is unknown.
    pub fn of(model_number: u16, firmware: u8) -> Option<Self> {
        MODELS
            .iter()
            .find(|model| model.number == model_number)
            .map(|model| Self { model, firmware })
    }

    /// Returns the number of bytes that the table spans.
    pub fn size(&self) -> usize {
        let ends =
            self.indirect().into_iter().flatten().map(|run| run.data.saturating_add(run.count));
        usize::from(ends.max().unwrap_or(0))
    }

    /// Returns all registers except the indirect ones, by address.
    pub fn items(&self) -> impl Iterator<Item = Item> + '_ {
        ITEMS.iter().filter_map(|(only, item)| self.own(*only, item))
    }

    /// Returns the register that contains this address, if there is one.
    pub fn at(&self, address: u16) -> Option<Item> {
        // A simulated servo calls this very often, for its own registers. The search is therefore limited to registers
        // that can contain the address.
        let before = BEFORE.get(usize::from(address)).map_or(ITEMS.len(), |count| (*count).into());
        ITEMS
            .iter()
            .skip(before)
            .take_while(|(_, item)| item.address <= address)
            .find_map(|(only, item)| self.own(*only, item))
            .or_else(|| self.indirect_item(address))
    }

    /// Returns the register with this name of the maker, if there is one. Ignores case and separators between words.
    pub fn named(&self, name: &str) -> Option<Item> {
        self.items().find(|item| item.is_named(name))
    }

    /// Returns the runs of indirect addresses of this model: none, one or two.
    pub fn indirect(&self) -> [Option<Indirect>; 2] {
        match self.model.family {
            Family::X330 => {
                let data = if self.firmware < 52 { 224 } else { 208 };
                [Some(Indirect { addresses: 168, data, count: 20 }), None]
            }
            Family::X430 | Family::X540 | Family::Mx => [
                Some(Indirect { addresses: 168, data: 224, count: 28 }),
                Some(Indirect { addresses: 578, data: 634, count: 28 }),
            ],
        }
    }

    /// Returns this model's variant of a register, or `None` if the model lacks it.
    pub(crate) fn own(&self, only: Only, item: &Item) -> Option<Item> {
        self.has(only).then(|| self.adapted(*item))
    }

    fn has(&self, only: Only) -> bool {
        let family = self.model.family;
        match only {
            Only::All => true,
            Only::Current => self.model.current.is_some(),
            Only::Load => self.model.current.is_none(),
            Only::X330 => family == Family::X330,
            Only::X540 => family == Family::X540,
            Only::X => family != Family::Mx,
            Only::Mx => family == Family::Mx,
        }
    }

    /// Returns the register with the values of this model.
    fn adapted(&self, mut item: Item) -> Item {
        let model = self.model;
        match item.address {
            address::MODEL_NUMBER => item.initial = model.number.into(),
            address::FIRMWARE => item.initial = self.firmware.into(),
            address::BAUD => {
                item.range = Range::Between(0, if model.family == Family::X330 { 6 } else { 7 });
            }
            address::TEMPERATURE_LIMIT => item.initial = model.temperature_limit.into(),
            address::MAX_VOLTAGE | address::MIN_VOLTAGE => {
                let [least, most] = model.voltage_limits.map(i32::from);
                item.range = Range::Between(least, most);
                item.initial = if item.address == address::MAX_VOLTAGE { most } else { least };
            }
            address::VELOCITY_LIMIT => {
                item.initial = model.velocity_limit.into();
                item.range =
                    Range::Between(0, if model.family == Family::X330 { 2047 } else { 1023 });
            }
            address::SHUTDOWN => item.initial = model.shutdown.into(),
            address::POSITION_P => item.initial = model.position_p.into(),
            address::CURRENT_LIMIT | address::GOAL_CURRENT | address::PRESENT_CURRENT => {
                if let Some(current) = model.current {
                    item.unit = Unit { symbol: "A", scale: current.unit_a };
                    if item.address == address::CURRENT_LIMIT {
                        item.initial = current.limit.into();
                        item.range = Range::Between(0, current.limit.into());
                    }
                }
            }
            _ => {}
        }
        item
    }

    fn indirect_item(&self, address: u16) -> Option<Item> {
        let item = |address, size, name, range, initial| Item {
            address,
            size,
            name,
            access: Access::ReadWrite,
            area: Area::Ram,
            sign: Sign::Unsigned,
            unit: Unit::NONE,
            range,
            initial,
        };
        let last = i32::try_from(self.size().saturating_sub(1)).unwrap_or(i32::MAX);
        self.indirect().into_iter().flatten().find_map(|run| {
            let slot = |first: u16, size: u16| {
                let index = address.checked_sub(first)?.checked_div(size)?;
                (index < run.count)
                    .then_some((index, first.saturating_add(index.saturating_mul(size))))
            };
            if let Some((index, start)) = slot(run.addresses, 2) {
                let initial = run.data.saturating_add(index).into();
                return Some(item(start, 2, "Indirect Address", Range::Between(64, last), initial));
            }
            slot(run.data, 1).map(|(_, start)| item(start, 1, "Indirect Data", Range::Any, 0))
        })
    }
}

/// Baud rates, bits per second, by the code in [`address::BAUD`].
pub const BAUDS: [u32; 8] =
    [9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000];
