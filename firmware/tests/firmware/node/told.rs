//! False readings of servo 0: its bytes are changed in transit, together with their checksum.

use sinew_servo_bus::dynamixel::crc::Crc;
use sinew_servo_bus::dynamixel::table::address;
use sinew_servo_bus::dynamixel::{BROADCAST, HEADER};

/// False readings of an XL330, in its units: 0.1 V, 1 mA, 4096 counts per turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Lie {
    /// Whether the servo reports an overload.
    pub(crate) alert: bool,
    pub(crate) celsius: Option<u8>,
    pub(crate) decivolts: Option<u16>,
    pub(crate) milliamps: Option<[i16; 2]>,
    /// Two positions that alternate, each for several answers.
    pub(crate) positions: Option<[i32; 2]>,
}

#[derive(Default)]
pub(crate) struct Told {
    pub(crate) lie: Lie,
    /// Address that a single servo was asked for.
    asked: Option<u16>,
    /// Number of answers of servo 0.
    answers: usize,
    /// Checksum of the answer of all servos in one packet, as far as it has arrived.
    fast: Option<Crc>,
}

const READ: u8 = 0x02;
/// Bus ID of servo 0.
const ID: u8 = 1;
/// Number of bytes before error and data of a status packet.
const HEAD: usize = 8;
/// Number of answers with the same false position: a jump is believed when it is read again.
const EACH: usize = 8;
const OVERLOAD: u8 = 1 << 5;

impl Told {
    /// Records the board's bytes: their last packet is its question.
    pub(crate) fn asked(&mut self, bytes: &[u8]) {
        self.fast = None;
        let is_read = bytes.len() == 14 && bytes[7] == READ;
        self.asked = is_read.then(|| u16::from_le_bytes([bytes[8], bytes[9]]));
    }

    /// Returns the changed bytes of a servo's answer.
    pub(crate) fn told(&mut self, said: &[u8]) -> Vec<u8> {
        let mut said = said.to_vec();
        if self.lie == Lie::default() || said.len() < 5 {
            return said;
        }
        let is_first = said.starts_with(&HEADER);
        let is_fast = self.asked.is_none();
        if is_first && said[4] == if is_fast { BROADCAST } else { ID } {
            // In the answer of all servos, the id is between error and data.
            let data = HEAD + 1 + usize::from(is_fast);
            let is_mine = !is_fast || said[HEAD + 1] == ID;
            if is_mine {
                said[HEAD] |= u8::from(self.lie.alert) << 7;
                let end = said.len() - 2;
                let address = self.asked.unwrap_or(address::PRESENT_CURRENT);
                self.lie.change(address, self.answers / EACH % 2, &mut said[data..end]);
                self.answers += 1;
            }
            self.fast = is_fast.then(Crc::default);
        } else if is_first || self.fast.is_none() {
            return said;
        }
        let mut crc = self.fast.unwrap_or_default();
        let end = said.len() - 2;
        let (body, check) = said.split_at_mut(end);
        crc.extend(body);
        check.copy_from_slice(&crc.value().to_le_bytes());
        crc.extend(check);
        self.fast = self.fast.map(|_| crc);
        said
    }
}

impl Lie {
    fn change(self, from: u16, phase: usize, data: &mut [u8]) {
        match (from, data) {
            (address::PRESENT_CURRENT, [c0, c1, _, _, _, _, position @ ..]) => {
                if let Some(current) = self.milliamps {
                    [*c0, *c1] = current[phase].to_le_bytes();
                }
                if let Some(positions) = self.positions {
                    position.copy_from_slice(&positions[phase].to_le_bytes());
                }
            }
            (address::PRESENT_VOLTAGE, [low, high, celsius]) => {
                if let Some(decivolts) = self.decivolts {
                    [*low, *high] = decivolts.to_le_bytes();
                }
                *celsius = self.celsius.unwrap_or(*celsius);
            }
            (address::HARDWARE_ERROR, [bits]) if self.alert => *bits = OVERLOAD,
            _ => {}
        }
    }
}
