//! The registers of a servo, for both protocols.

use sinew_servo_bus::dynamixel::table::address as dxl;
use sinew_servo_bus::feetech::table::address as feetech_address;
use sinew_servo_bus::table::{ByteOrder, Item};
use sinew_servo_bus::{dynamixel, feetech};

use crate::{Protocol, Registers, ServiceError};

/// The registers of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Table {
    /// Table of a Dynamixel.
    Dynamixel(dynamixel::table::Table),
    /// Table of a Feetech.
    Feetech(feetech::Table),
}

impl Table {
    /// Looks up a model by name. Ignores the suffixes of kinds in rig files: `XL330-M288-T`, `STS3215-12V`. Returns
    /// `None` if no model has this name.
    pub fn named_model(name: &str, firmware: u8) -> Option<Self> {
        let dynamixel = dynamixel::table::Model::of_kind(name)
            .map(|model| Self::Dynamixel(dynamixel::table::Table { model, firmware }));
        let feetech = || feetech::table::Model::of_kind(name);
        dynamixel.or_else(|| feetech().map(|model| Self::Feetech(feetech::Table::new(model))))
    }

    /// Looks up the model that a person names for a servo of a protocol.
    pub(crate) fn told(protocol: Protocol, name: &str, firmware: u8) -> Result<Self, ServiceError> {
        Self::named_model(name, firmware)
            .filter(|table| table.protocol() == protocol)
            .ok_or_else(|| ServiceError::NoModel { name: name.to_owned(), known: known(protocol) })
    }

    /// Looks up a Feetech model by the two bytes at address 3, whose order depends on the family. Returns `None` if no
    /// model has this number.
    pub(crate) fn of_feetech(number: [u8; 2]) -> Option<Self> {
        let [sts, scs] = [u16::from_le_bytes(number), u16::from_be_bytes(number)];
        let model = feetech::table::MODELS.iter().find(|model| {
            // 0 means that the number is unknown.
            let number = match model.family {
                feetech::Family::Sts => sts,
                feetech::Family::Scs => scs,
            };
            model.number != 0 && model.number == number
        })?;
        Some(Self::Feetech(feetech::Table::new(model)))
    }

    /// Returns the protocol.
    pub const fn protocol(&self) -> Protocol {
        match self {
            Self::Dynamixel(_) => Protocol::Dynamixel,
            Self::Feetech(_) => Protocol::Feetech,
        }
    }

    /// Returns the maker's name of the model.
    pub const fn model(&self) -> &'static str {
        match self {
            Self::Dynamixel(table) => table.model.name,
            Self::Feetech(table) => table.model.name,
        }
    }

    /// Returns whether the servo measures and limits current: some Dynamixels do.
    pub const fn has_current(&self) -> bool {
        matches!(self, Self::Dynamixel(table) if table.model.current.is_some())
    }

    /// Returns all registers, by address.
    pub fn items(&self) -> Vec<Item> {
        match self {
            Self::Dynamixel(table) => table.items().collect(),
            Self::Feetech(table) => table.items().collect(),
        }
    }

    /// Returns the register that contains an address, if there is one.
    pub fn at(&self, address: u16) -> Option<Item> {
        match self {
            Self::Dynamixel(table) => table.at(address),
            Self::Feetech(table) => u8::try_from(address).ok().and_then(|at| table.at(at)),
        }
    }

    /// Returns the register with a name, if there is one. Ignores case and separators between words.
    pub fn named(&self, name: &str) -> Option<Item> {
        match self {
            Self::Dynamixel(table) => table.named(name),
            Self::Feetech(table) => table.named(name),
        }
    }

    /// Returns the register with a name, or an error with similar names.
    ///
    /// # Errors
    /// [`Registers::Unknown`] if no register has this name.
    pub fn register(&self, name: &str) -> Result<Item, ServiceError> {
        self.named(name).ok_or_else(|| {
            let (name, near) = (name.to_owned(), self.near(&name.to_lowercase()));
            Registers::Unknown { model: self.model(), name, near }.into()
        })
    }

    /// Lists the register names that share a word with this name.
    fn near(&self, name: &str) -> String {
        let words = || name.split(|letter: char| !letter.is_alphanumeric());
        let is_near = |known: &&str| {
            let known = known.to_lowercase();
            words().any(|word| word.len() > 1 && known.contains(word))
        };
        let near: Vec<&str> = self.items().iter().map(|item| item.name).filter(is_near).collect();
        if near.is_empty() {
            return "`sinew servo read ID` shows all of them".to_owned();
        }
        format!("there are: {}", near.join(", "))
    }

    /// Returns a register that every servo has, by its role.
    pub(crate) fn role(&self, role: Role) -> Result<Item, ServiceError> {
        self.register_at(self.address(role))
    }

    /// Returns the register at an address, or an error that contains the address.
    pub(crate) fn register_at(&self, address: u16) -> Result<Item, ServiceError> {
        self.at(address).ok_or_else(|| {
            let (name, near) = (format!("at {address}"), "none is there".to_owned());
            Registers::Unknown { model: self.model(), name, near }.into()
        })
    }

    /// Returns the byte order of numbers.
    pub const fn order(&self) -> ByteOrder {
        match self {
            Self::Dynamixel(_) => ByteOrder::Little,
            Self::Feetech(table) => table.model.family.order(),
        }
    }

    /// Returns the counts of a turn of the encoder, or of its whole range. The middle is half of them.
    pub const fn counts(&self) -> i32 {
        match self {
            Self::Dynamixel(_) => 4096,
            Self::Feetech(table) => table.model.family.most_count() + 1,
        }
    }

    /// Returns the angle of one count of position, rad.
    pub fn rad_per_count(&self) -> f64 {
        self.at(self.address(Role::PresentPosition)).map_or(0.0, |item| item.unit.scale.into())
    }

    pub(crate) const fn address(&self, role: Role) -> u16 {
        match self {
            Self::Dynamixel(_) => match role {
                Role::Id => dxl::ID,
                Role::Baud => dxl::BAUD,
                Role::Torque => dxl::TORQUE_ENABLE,
                Role::PresentPosition => dxl::PRESENT_POSITION,
                Role::GoalPosition => dxl::GOAL_POSITION,
                Role::MinPosition => dxl::MIN_POSITION,
                Role::MaxPosition => dxl::MAX_POSITION,
                Role::PositionP => dxl::POSITION_P,
            },
            Self::Feetech(_) => {
                (match role {
                    Role::Id => feetech_address::ID,
                    Role::Baud => feetech_address::BAUD,
                    Role::Torque => feetech_address::TORQUE_ENABLE,
                    Role::PresentPosition => feetech_address::PRESENT_POSITION,
                    Role::GoalPosition => feetech_address::GOAL_POSITION,
                    Role::MinPosition => feetech_address::MIN_POSITION,
                    Role::MaxPosition => feetech_address::MAX_POSITION,
                    Role::PositionP => feetech_address::POSITION_P,
                }) as u16
            }
        }
    }
}

/// Registers that every servo has, at addresses that depend on the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    Id,
    Baud,
    Torque,
    PresentPosition,
    GoalPosition,
    MinPosition,
    MaxPosition,
    PositionP,
}

/// Lists the names of all models of a protocol.
pub(crate) fn known(protocol: Protocol) -> String {
    let names: Vec<&str> = match protocol {
        Protocol::Dynamixel => dynamixel::table::MODELS.iter().map(|model| model.name).collect(),
        Protocol::Feetech => feetech::table::MODELS.iter().map(|model| model.name).collect(),
    };
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_of_rig_files_are_found() {
        for (kind, model) in [
            ("XL330-M288-T", "XL330-M288"),
            ("xl430-w250-t", "XL430-W250"),
            ("MX-64", "MX-64"),
            ("STS3215-7.4V", "STS3215"),
            ("SCS0009", "SCS0009"),
        ] {
            assert_eq!(Table::named_model(kind, 52).map(|table| table.model()), Some(model));
        }
        for kind in ["MG90S", "XL330", "STS32150", ""] {
            assert_eq!(Table::named_model(kind, 52), None, "{kind}");
        }
    }

    #[test]
    fn a_feetech_is_known_by_its_number_in_its_own_order() {
        let model = |bytes| Table::of_feetech(bytes).map(|table| table.model());
        assert_eq!(model(777_u16.to_le_bytes()), Some("STS3215"));
        assert_eq!(model(1284_u16.to_be_bytes()), Some("SCS0009"));
        assert_eq!(model([0, 0]), None);
    }
}
