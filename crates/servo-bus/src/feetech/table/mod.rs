//! Memory tables of STS, SMS and SCS servos.
//!
//! Sources: `sts_memory_table.md` of vassar-robotics/feetech-servo-sdk; the tables of `lerobot` 0.4.4 for SCS.
//! Community tables disagree in places: read back once what was written. The range of SCS items is not known: any
//! value goes.

pub mod address;
mod items;

use crate::table::{ByteOrder, Item, is_kind_of};
pub(super) use items::CURRENT;
use items::{SCS, SCS_POSITION, STS, STS_POSITION};

/// Which table, and which byte comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// STS and SMS: magnetic encoder, low byte first.
    Sts,
    /// SCS: potentiometer, high byte first.
    Scs,
}

impl Family {
    /// Which byte of a number comes first.
    pub const fn order(self) -> ByteOrder {
        match self {
            Self::Sts => ByteOrder::Little,
            Self::Scs => ByteOrder::Big,
        }
    }

    /// Where the EEPROM lock is: 1 keeps, 0 stores.
    pub const fn lock(self) -> u8 {
        match self {
            Self::Sts => 55,
            Self::Scs => 48,
        }
    }

    /// The highest count of its encoder.
    pub const fn most_count(self) -> i32 {
        match self {
            Self::Sts => 4095,
            Self::Scs => 1023,
        }
    }

    /// Its items, by address.
    const fn items(self) -> &'static [Item] {
        match self {
            Self::Sts => STS,
            Self::Scs => SCS,
        }
    }

    /// The item at an address, at build time; what models have of their own is left out.
    #[expect(
        clippy::indexing_slicing,
        clippy::arithmetic_side_effects,
        clippy::panic,
        reason = "at build time"
    )]
    pub(crate) const fn item(self, address: u8) -> Item {
        let items = self.items();
        let mut index = 0;
        while index < items.len() {
            if items[index].address == address as u16 {
                return items[index];
            }
            index += 1;
        }
        panic!("no item begins at this address");
    }

    /// One count of its encoder, rad.
    pub const fn rad_per_count(self) -> f32 {
        match self {
            Self::Sts => STS_POSITION.scale,
            Self::Scs => SCS_POSITION.scale,
        }
    }
}

/// A model of servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Model {
    /// The maker's name.
    pub name: &'static str,
    /// The number at address 3; 0 where no source gives it.
    pub number: u16,
    /// Its table.
    pub family: Family,
    /// The factory's code of the baud rate.
    pub baud: u8,
}

impl Model {
    /// Returns the model of a kind of servo, by the name that rig files have for it: `STS3215-12V`.
    pub fn of_kind(kind: &str) -> Option<&'static Self> {
        MODELS.iter().find(|model| is_kind_of(model.name, kind))
    }
}

/// All models that this crate knows. Model numbers: `lerobot` 0.4.4, `feetech-cli` 0.1.8.
pub const MODELS: &[Model] = &[
    Model { name: "STS3215", number: 777, family: Family::Sts, baud: 0 },
    Model { name: "STS3250", number: 2825, family: Family::Sts, baud: 0 },
    Model { name: "STS3032", number: 0, family: Family::Sts, baud: 0 },
    Model { name: "SMS", number: 0, family: Family::Sts, baud: 4 },
    Model { name: "SCS0009", number: 1284, family: Family::Scs, baud: 0 },
];

/// Bits per second by the code at [`address::BAUD`]. That of `lerobot` differs from code 5 on;
/// Feetech's own tools have this.
pub const BAUDS: [u32; 8] = [1_000_000, 500_000, 250_000, 128_000, 115_200, 76_800, 57_600, 38_400];

/// The memory table of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Table {
    /// The model.
    pub model: &'static Model,
}

impl Table {
    /// Looks up a model's register table by name, ignoring case.
    pub fn of(name: &str) -> Option<Self> {
        MODELS
            .iter()
            .find(|model| model.name.eq_ignore_ascii_case(name))
            .map(|model| Self { model })
    }

    /// How many bytes it spans.
    pub const LEN: usize = 87;

    /// All items, by address.
    pub fn items(&self) -> impl Iterator<Item = Item> + '_ {
        let table = *self;
        self.model.family.items().iter().map(move |item| table.adapted(*item))
    }

    /// The item that has this address.
    pub fn at(&self, address: u8) -> Option<Item> {
        let items = self.model.family.items().iter();
        let found = items.copied().find(|item| item.contains(address.into()));
        found.map(|item| self.adapted(item))
    }

    /// The item of this name; case and what separates words do not matter.
    pub fn named(&self, name: &str) -> Option<Item> {
        self.items().find(|item| item.is_named(name))
    }

    fn adapted(self, mut item: Item) -> Item {
        if item.address == u16::from(address::MODEL) {
            item.initial = self.model.number.into();
        }
        if item.address == u16::from(address::BAUD) {
            item.initial = self.model.baud.into();
        }
        item
    }
}
