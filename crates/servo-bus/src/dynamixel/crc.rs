//! The checksum of the protocol: CRC-16 with polynomial 0x8005, start 0, nothing reflected.
//!
//! Source: e-manual, "CRC calculation"; the parameter set is known as CRC-16/UMTS.

/// A CRC that grows byte by byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Crc(u16);

impl Crc {
    /// The CRC of these bytes.
    pub fn of(bytes: &[u8]) -> u16 {
        let mut crc = Self::default();
        crc.extend(bytes);
        crc.value()
    }

    /// Takes one byte in.
    pub fn push(&mut self, byte: u8) {
        let [high, low] = self.0.to_be_bytes();
        let row = TABLE.get(usize::from(high ^ byte)).copied().unwrap_or(0);
        self.0 = u16::from_be_bytes([low, 0]) ^ row;
    }

    /// Takes bytes in.
    pub fn extend(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.push(*byte);
        }
    }

    /// The CRC so far; the wire has its low byte first.
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
