//! Control tables as data: the registers of a servo by address.

/// Name of the torque switch register, which is the same for all makers.
pub(crate) const TORQUE_ENABLE: &str = "Torque Enable";

/// Returns whether a servo kind has the registers of a model: its name is the model's name, perhaps with a suffix for a
/// plug or voltage (`XL330-M288-T`, `STS3215-12V`). Ignores case.
pub(crate) fn is_kind_of(model: &str, kind: &str) -> bool {
    kind.split_at_checked(model.len()).is_some_and(|(name, ending)| {
        name.eq_ignore_ascii_case(model) && (ending.is_empty() || ending.starts_with('-'))
    })
}

/// One register of a control table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Item {
    /// First address of the register.
    pub address: u16,
    /// Size in bytes: 1, 2 or 4.
    pub size: u8,
    /// The maker's name for this register.
    pub name: &'static str,
    /// Whether a controller can write it.
    pub access: Access,
    /// Memory area: whether it survives a loss of power.
    pub area: Area,
    /// Encoding of negative numbers.
    pub sign: Sign,
    /// Unit of one count.
    pub unit: Unit,
    /// Values that may be written.
    pub range: Range,
    /// Factory value, or value after power-up; 0 if the maker gives none.
    pub initial: i32,
}

/// The access that a controller has to a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// The register can only be read.
    Read,
    /// The register can be read and written.
    ReadWrite,
}

/// The memory area of a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Area {
    /// Survives a loss of power. EEPROM wears out, and can be written only with torque off, or with the lock open.
    Eeprom,
    /// Loses its contents at power-off.
    Ram,
}

/// The encoding of negative numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// No negative numbers.
    Unsigned,
    /// Two's complement of the register's size.
    TwosComplement,
    /// The given bit is the sign; the bits below it are the magnitude.
    Magnitude(u8),
}

/// The byte order of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByteOrder {
    /// Low byte first: Dynamixel, STS, SMS.
    Little,
    /// High byte first: SCS.
    Big,
}

/// The values that may be written. The addresses refer to other registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Any value.
    Any,
    /// Values from the first number to the second.
    Between(i32, i32),
    /// At most the value of the register at this address, either way.
    PlusMinus(u16),
    /// From the register at the first address to the register at the second.
    Within(u16, u16),
}

/// A register of which a simulated servo obeys only some values. It refuses the others: a program could otherwise
/// believe that they have an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Restriction {
    /// First address of the register.
    pub address: u16,
    /// Values that the simulated servo obeys.
    pub obeys: Obeys,
}

/// The values of a register that a simulated servo obeys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obeys {
    /// This value only.
    Only(i32),
    /// Every value except this one.
    AllBut(i32),
}

impl Restriction {
    /// Returns whether one of `restrictions` refuses this value of the register at `address`. The restrictions are a
    /// list instead of a callback, so that a board's image has no indirect call.
    pub(crate) fn refuse(restrictions: &[Self], address: u16, value: i32) -> bool {
        restrictions.iter().filter(|restriction| restriction.address == address).any(
            |restriction| match restriction.obeys {
                Obeys::Only(only) => value != only,
                Obeys::AllBut(refused) => value == refused,
            },
        )
    }
}

/// The unit of one count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// SI unit, or the nearest to it: `degC`, `1` for a ratio; empty for a plain number.
    pub symbol: &'static str,
    /// Size of one count in this unit.
    pub scale: f32,
}

impl Unit {
    /// No unit: a mode, a mask, a gain.
    pub const NONE: Self = Self { symbol: "", scale: 1.0 };
    /// A unit of 1 degC.
    pub const CELSIUS: Self = Self { symbol: "degC", scale: 1.0 };
    /// A unit of 0.1 V.
    pub const DECIVOLT: Self = Self { symbol: "V", scale: 0.1 };
    /// A unit of 0.1 % of the maximum.
    pub const PER_MILLE: Self = Self { symbol: "1", scale: 0.001 };
    /// A unit of 1 % of the maximum.
    pub const PER_CENT: Self = Self { symbol: "1", scale: 0.01 };
}

/// The division of a servo's memory into EEPROM and RAM. It creates the registers of a table.
pub(crate) struct MemoryMap {
    /// First address of RAM; all lower addresses are EEPROM.
    pub(crate) ram_from: u16,
}

impl MemoryMap {
    /// Creates a register that can only be read. It is unsigned, like those of [`Self::write`].
    pub(crate) const fn read(
        &self,
        address: u16,
        size: u8,
        name: &'static str,
        unit: Unit,
    ) -> Item {
        let area = if address < self.ram_from { Area::Eeprom } else { Area::Ram };
        let (access, sign, range) = (Access::Read, Sign::Unsigned, Range::Any);
        Item { address, size, name, access, area, sign, unit, range, initial: 0 }
    }

    /// Creates a register that can be read and written.
    pub(crate) const fn write(
        &self,
        address: u16,
        size: u8,
        name: &'static str,
        unit: Unit,
        range: Range,
        initial: i32,
    ) -> Item {
        let item = self.read(address, size, name, unit);
        Item { access: Access::ReadWrite, range, initial, ..item }
    }
}

/// Speed of 1 rev/min in rad/s: 2 pi / 60.
pub(crate) const RAD_S_PER_RPM: f32 = core::f32::consts::TAU / 60.0;

impl Item {
    /// Returns the address after the last byte.
    pub const fn end(&self) -> u16 {
        self.address.saturating_add(self.size as u16)
    }

    /// Returns whether the register contains this address.
    pub const fn contains(&self, address: u16) -> bool {
        self.address <= address && address < self.end()
    }

    /// Returns whether this is the register's name. Ignores case and separators between words.
    pub(crate) fn is_named(&self, name: &str) -> bool {
        let letters = |byte: &u8| byte.is_ascii_alphanumeric();
        let own = self.name.bytes().filter(letters).map(|byte| byte.to_ascii_lowercase());
        own.eq(name.bytes().filter(letters).map(|byte| byte.to_ascii_lowercase()))
    }

    /// Decodes the number from its bytes. Missing bytes count as 0.
    pub fn value(&self, bytes: &[u8], order: ByteOrder) -> i32 {
        let bytes = bytes.get(..usize::from(self.size)).unwrap_or(bytes);
        let mut raw = 0_u32;
        let mut add = |byte: &u8| raw = (raw << 8) | u32::from(*byte);
        match order {
            ByteOrder::Little => bytes.iter().rev().for_each(&mut add),
            ByteOrder::Big => bytes.iter().for_each(&mut add),
        }
        self.sign.decode(raw, self.size)
    }

    /// Encodes a number. Only the first [`Self::size`] bytes of the result are used.
    pub fn bytes(&self, value: i32, order: ByteOrder) -> [u8; 4] {
        let [a, b, c, d] = self.sign.encode(value).to_le_bytes();
        match (order, self.size) {
            (ByteOrder::Little, _) | (ByteOrder::Big, 1) => [a, b, c, d],
            (ByteOrder::Big, 2) => [b, a, 0, 0],
            (ByteOrder::Big, _) => [d, c, b, a],
        }
    }
}

impl Sign {
    pub(crate) fn decode(self, raw: u32, size: u8) -> i32 {
        match self {
            Self::Unsigned => raw.cast_signed(),
            Self::TwosComplement => {
                let unused = 32_u32.saturating_sub(u32::from(size).saturating_mul(8));
                raw.wrapping_shl(unused).cast_signed().wrapping_shr(unused)
            }
            Self::Magnitude(bit) => {
                let flag = 1_u32.wrapping_shl(bit.into());
                let magnitude = (raw & flag.wrapping_sub(1)).cast_signed();
                if raw & flag == 0 { magnitude } else { magnitude.wrapping_neg() }
            }
        }
    }

    /// Encodes a number. A magnitude that is too large is limited, so that it does not change the sign bit.
    pub(crate) fn encode(self, value: i32) -> u32 {
        match self {
            Self::Unsigned | Self::TwosComplement => value.cast_unsigned(),
            Self::Magnitude(bit) => {
                let flag = 1_u32.wrapping_shl(bit.into());
                let magnitude = value.unsigned_abs().min(flag.wrapping_sub(1));
                if value < 0 { magnitude | flag } else { magnitude }
            }
        }
    }
}
