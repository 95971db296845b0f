//! Control tables as data: what a servo keeps at which address.

/// The makers' name, all of them, for the register that switches torque.
pub(crate) const TORQUE_ENABLE: &str = "Torque Enable";

/// Returns whether a kind of servo has the registers of a model: its name is the model's, perhaps with an ending that
/// tells plugs or voltages apart (`XL330-M288-T`, `STS3215-12V`). Case does not matter.
pub(crate) fn is_kind_of(model: &str, kind: &str) -> bool {
    kind.split_at_checked(model.len()).is_some_and(|(name, ending)| {
        name.eq_ignore_ascii_case(model) && (ending.is_empty() || ending.starts_with('-'))
    })
}

/// One item of a control table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Item {
    /// Its first address.
    pub address: u16,
    /// Bytes: 1, 2 or 4.
    pub size: u8,
    /// The maker's name for it.
    pub name: &'static str,
    /// What may be done with it.
    pub access: Access,
    /// Whether it survives a loss of power.
    pub area: Area,
    /// How its bytes make a number.
    pub sign: Sign,
    /// What one count is.
    pub unit: Unit,
    /// What may be written.
    pub range: Range,
    /// What the factory sets, or what it is after power-up; 0 where the maker gives nothing.
    pub initial: i32,
}

/// What may be done with an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// It can only be read.
    Read,
    /// It can be read and written.
    ReadWrite,
}

/// Where an item is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Area {
    /// Survives a loss of power. It wears out, and is written only at rest: with torque off, or with the lock open.
    Eeprom,
    /// Lost at power-off.
    Ram,
}

/// How bytes make a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// Never negative.
    Unsigned,
    /// Two's complement.
    TwosComplement,
    /// This bit is the sign, the bits below it are the magnitude.
    Magnitude(u8),
}

/// Which byte of a number comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByteOrder {
    /// Low byte first: Dynamixel, STS, SMS.
    Little,
    /// High byte first: SCS.
    Big,
}

/// What may be written. Addresses are those of other items.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Anything.
    Any,
    /// From the first number to the second.
    Between(i32, i32),
    /// As far either way as the item at this address says.
    PlusMinus(u16),
    /// From the item at the first address to that at the second.
    Within(u16, u16),
}

/// What one count is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// The SI unit, or what comes nearest: `degC`, `1` for a ratio; empty for a mere number.
    pub symbol: &'static str,
    /// How much of it one count is.
    pub scale: f32,
}

impl Unit {
    /// A mere number: a mode, a mask, a gain.
    pub const NONE: Self = Self { symbol: "", scale: 1.0 };
    /// 1 degC.
    pub const CELSIUS: Self = Self { symbol: "degC", scale: 1.0 };
    /// 0.1 V.
    pub const DECIVOLT: Self = Self { symbol: "V", scale: 0.1 };
    /// 0.1 % of the most.
    pub const PER_MILLE: Self = Self { symbol: "1", scale: 0.001 };
    /// 1 % of the most.
    pub const PER_CENT: Self = Self { symbol: "1", scale: 0.01 };
}

/// How a servo's memory is divided: it makes the items of a table.
pub(crate) struct MemoryMap {
    /// Where RAM begins; all below is EEPROM.
    pub(crate) ram_from: u16,
}

impl MemoryMap {
    /// An item that can only be read: unsigned, as [`Self::write`] makes them too.
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

    /// An item that can be read and written.
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

/// rad for each rev/min: 2 pi / 60, per second.
pub(crate) const RAD_S_PER_RPM: f32 = core::f32::consts::TAU / 60.0;

impl Item {
    /// The address behind its last byte.
    pub const fn end(&self) -> u16 {
        self.address.saturating_add(self.size as u16)
    }

    /// Whether it has this address.
    pub const fn contains(&self, address: u16) -> bool {
        self.address <= address && address < self.end()
    }

    /// Whether this is its name; case and what separates words do not matter.
    pub(crate) fn is_named(&self, name: &str) -> bool {
        let letters = |byte: &u8| byte.is_ascii_alphanumeric();
        let own = self.name.bytes().filter(letters).map(|byte| byte.to_ascii_lowercase());
        own.eq(name.bytes().filter(letters).map(|byte| byte.to_ascii_lowercase()))
    }

    /// The number that its bytes make; bytes that are missing count as 0.
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

    /// Its bytes for a number: the first [`Self::size`] of what is returned.
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

    /// A magnitude that is too large becomes the largest: it must not reach into the sign.
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
