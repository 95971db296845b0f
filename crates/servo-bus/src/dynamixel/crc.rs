//! The checksum of the protocol: CRC-16 with polynomial 0x8005, start 0, nothing reflected.
//!
//! Source: e-manual, "CRC calculation"; the parameter set is known as CRC-16/UMTS.

/// A CRC that is computed byte by byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Crc(u16);

impl Crc {
    /// Returns the CRC of `bytes`.
    pub fn of(bytes: &[u8]) -> u16 {
        let mut crc = Self::default();
        crc.extend(bytes);
        crc.value()
    }

    /// Adds one byte.
    pub fn push(&mut self, byte: u8) {
        let [high, low] = self.0.to_be_bytes();
        let row = TABLE.get(usize::from(high ^ byte)).copied().unwrap_or(0);
        self.0 = u16::from_be_bytes([low, 0]) ^ row;
    }

    /// Adds several bytes.
    pub fn extend(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.push(*byte);
        }
    }

    /// Returns the CRC of all bytes so far. On the wire, its low byte is first.
    pub fn value(self) -> u16 {
        self.0
    }
}

const TABLE: [u16; 256] = table();

#[expect(
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects,
    clippy::cast_possible_truncation,
    reason = "runs at compile time, where a wrong index is an error of the build"
)]
const fn table() -> [u16; 256] {
    let mut table = [0; 256];
    let mut index = 0;
    while index < table.len() {
        let mut crc = (index as u16) << 8;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 0x8000 != 0 { (crc << 1) ^ 0x8005 } else { crc << 1 };
            bit += 1;
        }
        table[index] = crc;
        index += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_value() {
        assert_eq!(Crc::of(b"123456789"), 0xFEE8);
    }
}
