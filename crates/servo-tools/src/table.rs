//! The registers of a servo of either protocol.

use sinew_servo_bus::dynamixel::table::address as dxl;
use sinew_servo_bus::feetech::table::address as feetech_address;
use sinew_servo_bus::table::{ByteOrder, Item};
use sinew_servo_bus::{dynamixel, feetech};

use crate::{Protocol, Registers, ServiceError};

/// The registers of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Table {
    /// Of a Dynamixel.
    Dynamixel(dynamixel::table::Table),
    /// Of a Feetech.
    Feetech(feetech::Table),
}

impl Table {
    /// The model of this name. Endings of rig files' kinds do not matter: `XL330-M288-T`, `STS3215-12V`.
    pub fn named_model(name: &str, firmware: u8) -> Option<Self> {
        let dynamixel = dynamixel::table::Model::of_kind(name)
            .map(|model| Self::Dynamixel(dynamixel::table::Table { model, firmware }));
        let feetech = || feetech::table::Model::of_kind(name);
        dynamixel.or_else(|| feetech().map(|model| Self::Feetech(feetech::Table { model })))
    }

    /// The model whose name a person gives for a servo of a protocol.
    pub(crate) fn told(protocol: Protocol, name: &str, firmware: u8) -> Result<Self, ServiceError> {
        Self::named_model(name, firmware)
            .filter(|table| table.protocol() == protocol)
            .ok_or_else(|| ServiceError::NoModel { name: name.to_owned(), known: known(protocol) })
    }

    /// The model of a Feetech by the two bytes at address 3: which comes first depends on the family.
    pub(crate) fn of_feetech(number: [u8; 2]) -> Option<Self> {
        let [sts, scs] = [u16::from_le_bytes(number), u16::from_be_bytes(number)];
        let model = feetech::table::MODELS.iter().find(|model| {
            // 0 stands where nobody knows the number.
            let number = match model.family {
                feetech::Family::Sts => sts,
                feetech::Family::Scs => scs,
            };
            model.number != 0 && model.number == number
        })?;
        Some(Self::Feetech(feetech::Table { model }))
    }

    /// Its protocol.
    pub const fn protocol(&self) -> Protocol {
        match self {
            Self::Dynamixel(_) => Protocol::Dynamixel,
            Self::Feetech(_) => Protocol::Feetech,
        }
    }

    /// The maker's name of the model.
    pub const fn model(&self) -> &'static str {
        match self {
            Self::Dynamixel(table) => table.model.name,
            Self::Feetech(table) => table.model.name,
        }
    }

    /// Whether it measures and limits current: Dynamixels of which the list says so.
    pub const fn has_current(&self) -> bool {
        matches!(self, Self::Dynamixel(table) if table.model.current.is_some())
    }

    /// All registers by address.
    pub fn items(&self) -> Vec<Item> {
        match self {
            Self::Dynamixel(table) => table.items().collect(),
            Self::Feetech(table) => table.items().collect(),
        }
    }

    /// The register at an address.
    pub fn at(&self, address: u16) -> Option<Item> {
        match self {
            Self::Dynamixel(table) => table.at(address),
            Self::Feetech(table) => u8::try_from(address).ok().and_then(|at| table.at(at)),
        }
    }

    /// The register of a name; case and what separates words do not matter.
    pub fn named(&self, name: &str) -> Option<Item> {
        match self {
            Self::Dynamixel(table) => table.named(name),
            Self::Feetech(table) => table.named(name),
        }
    }

    /// The register of a name, or which ones come near.
    ///
    /// # Errors
    /// [`Registers::Unknown`].
    pub fn register(&self, name: &str) -> Result<Item, ServiceError> {
        self.named(name).ok_or_else(|| {
            let (name, near) = (name.to_owned(), self.near(&name.to_lowercase()));
            Registers::Unknown { model: self.model(), name, near }.into()
        })
    }

    /// Names that have a word of this one.
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

    /// The register that every servo has, wherever it is.
    pub(crate) fn role(&self, role: Role) -> Result<Item, ServiceError> {
        self.register_at(self.address(role))
    }

    /// The register at an address, or an error that names it.
    pub(crate) fn register_at(&self, address: u16) -> Result<Item, ServiceError> {
        self.at(address).ok_or_else(|| {
            let (name, near) = (format!("at {address}"), "none is there".to_owned());
            Registers::Unknown { model: self.model(), name, near }.into()
        })
    }

    /// Which byte of a number comes first.
    pub const fn order(&self) -> ByteOrder {
        match self {
            Self::Dynamixel(_) => ByteOrder::Little,
            Self::Feetech(table) => table.model.family.order(),
        }
    }

    /// Counts of a turn of the encoder, or of its range; the middle is half of it.
    pub const fn counts(&self) -> i32 {
        match self {
            Self::Dynamixel(_) => 4096,
            Self::Feetech(table) => table.model.family.most_count() + 1,
        }
    }

    /// One count of position, rad.
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

/// Registers that every servo has, wherever they are.
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

/// Names of all models of a protocol.
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
