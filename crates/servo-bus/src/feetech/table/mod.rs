//! Memory tables of STS, SMS and SCS servos.
//!
//! Sources: `sts_memory_table.md` of vassar-robotics/feetech-servo-sdk; the tables of `lerobot` 0.4.4 for SCS.
//! Community tables disagree in places: read each written value back once. The ranges of some SCS registers are not
//! known: those accept any value.

pub mod address;
mod items;
pub mod phase;

use crate::table::{ByteOrder, Item, is_kind_of};
pub(super) use items::CURRENT;
use items::{SCS, SCS_POSITION, STS, STS_POSITION};

/// A family of servos: it decides the memory table and the byte order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// STS and SMS: magnetic encoder, low byte first.
    Sts,
    /// SCS: potentiometer, high byte first.
    Scs,
}

impl Family {
    /// Returns the byte order of numbers.
    pub const fn order(self) -> ByteOrder {
        match self {
            Self::Sts => ByteOrder::Little,
            Self::Scs => ByteOrder::Big,
        }
    }

    /// Returns the address of the EEPROM lock: 1 locks, 0 makes writes permanent.
    pub const fn lock(self) -> u8 {
        match self {
            Self::Sts => 55,
            Self::Scs => 48,
        }
    }

    /// Returns the highest count of the encoder.
    pub const fn most_count(self) -> i32 {
        match self {
            Self::Sts => 4095,
            Self::Scs => 1023,
        }
    }

    /// Returns the registers of the family, by address.
    const fn items(self) -> &'static [Item] {
        match self {
            Self::Sts => STS,
            Self::Scs => SCS,
        }
    }

    /// Returns the register at an address. It is for use at build time, and leaves out the values that differ by model.
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

    /// Returns the angle of one count of the encoder, rad.
    pub const fn rad_per_count(self) -> f32 {
        match self {
            Self::Sts => STS_POSITION.scale,
            Self::Scs => SCS_POSITION.scale,
        }
    }
}

/// A servo model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Model {
    /// The maker's name for this model, such as `STS3215`.
    pub name: &'static str,
    /// Model number at address 3; 0 if no source gives it.
    pub number: u16,
    /// Family of the model, which decides its table.
    pub family: Family,
    /// Factory code of the baud rate.
    pub baud: u8,
}

impl Model {
    /// Looks up a model by a servo kind as named in rig files, such as `STS3215-12V`. Returns `None` if no model has
    /// this name.
    pub fn of_kind(kind: &str) -> Option<&'static Self> {
        MODELS.iter().find(|model| is_kind_of(model.name, kind))
    }
}

/// All models that this crate knows. Source of the model numbers: `lerobot` 0.4.4, `feetech-cli` 0.1.8.
pub const MODELS: &[Model] = &[
    Model { name: "STS3215", number: 777, family: Family::Sts, baud: 0 },
    Model { name: "STS3250", number: 2825, family: Family::Sts, baud: 0 },
    Model { name: "STS3032", number: 0, family: Family::Sts, baud: 0 },
    Model { name: "SMS", number: 0, family: Family::Sts, baud: 4 },
    Model { name: "SCS0009", number: 1284, family: Family::Scs, baud: 0 },
];

/// Baud rates, bits per second, by the code in [`address::BAUD`]. The list of `lerobot` differs from code 5 on; this
/// list is that of Feetech's own tools.
pub const BAUDS: [u32; 8] = [1_000_000, 500_000, 250_000, 128_000, 115_200, 76_800, 57_600, 38_400];

/// The memory table of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Table {
    /// Model of the servo.
    pub model: &'static Model,
    /// Speed of one count of the speed registers of an STS, in counts of position per second: 1 as shipped, 50 if
    /// Phase has no [`phase::FINE_SPEED`].
    pub speed_counts: u8,
}

impl Table {
    /// Returns the table of a servo as shipped.
    pub const fn new(model: &'static Model) -> Self {
        Self { model, speed_counts: 1 }
    }

    /// Returns the table of the same servo with this value of Phase. SCS servos have no unit of speed.
    #[must_use]
    pub const fn with_phase(self, phase: i32) -> Self {
        let is_fine = phase & phase::FINE_SPEED as i32 != 0;
        Self { speed_counts: if is_fine { 1 } else { 50 }, ..self }
    }

    /// Looks up the register table of a model by its name, ignoring case. Returns `None` if no model has this name.
    pub fn of(name: &str) -> Option<Self> {
        MODELS.iter().find(|model| model.name.eq_ignore_ascii_case(name)).map(Self::new)
    }

    /// Number of bytes that the table spans.
    pub const LEN: usize = 87;

    /// Returns all registers, by address.
    pub fn items(&self) -> impl Iterator<Item = Item> + '_ {
        let table = *self;
        self.model.family.items().iter().map(move |item| table.adapted(*item))
    }

    /// Returns the register that contains this address, if there is one.
    pub fn at(&self, address: u8) -> Option<Item> {
        let items = self.model.family.items().iter();
        let found = items.copied().find(|item| item.contains(address.into()));
        found.map(|item| self.adapted(item))
    }

    /// Returns the register with this name, if there is one. Ignores case and separators between words.
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
        let is_speed = |at: u8| item.address == u16::from(at);
        if is_speed(address::GOAL_SPEED) || is_speed(address::PRESENT_SPEED) {
            item.unit.scale *= f32::from(self.speed_counts);
        }
        item
    }
}
