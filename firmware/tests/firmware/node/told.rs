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
    /// Two positions between which the encoder swings, once in 16 answers.
    pub(crate) positions: Option<[i32; 2]>,
    /// Position to which the reading runs away, as fast as a servo that is pushed may move.
    pub(crate) runs_to: Option<i32>,
    /// Offset of the position, counts.
    pub(crate) off: i32,
}

#[derive(Default)]
pub(crate) struct Told {
    pub(crate) lie: Lie,
    /// Address that a single servo was asked for.
    asked: Option<u16>,
    /// Number of answers of servo 0 since its position became false.
    answers: usize,
    /// Position that a runaway encoder reports, and its change since the previous answer, steps.
    runs: Option<[i32; 2]>,
    /// Checksum of the answer of all servos in one packet, as far as it has arrived.
    fast: Option<Crc>,
}

const READ: u8 = 0x02;
/// Bus ID of servo 0.
const ID: u8 = 1;
/// Number of bytes before error and data of a status packet.
const HEAD: usize = 8;
/// Number of answers in half a swing.
const EACH: usize = 8;
/// Maximum movement of a running position between two answers, and its maximum increase.
const RUNS: [i32; 2] = [40, 5];
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
        if self.lie == Lie::default() {
            (self.runs, self.answers) = (None, 0);
        }
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
                self.change(address, &mut said[data..end]);
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

    fn change(&mut self, from: u16, data: &mut [u8]) {
        let lie = self.lie;
        match (from, data) {
            (address::PRESENT_CURRENT, [c0, c1, _, _, _, _, position @ ..]) => {
                if let Some(current) = lie.milliamps {
                    [*c0, *c1] = current[self.answers / EACH % 2].to_le_bytes();
                }
                let Ok(bytes) = <[u8; 4]>::try_from(&*position) else { return };
                let mut is = i32::from_le_bytes(bytes) + lie.off;
                if let Some([one, other]) = lie.positions {
                    let phase = (self.answers % (2 * EACH)) as f64 / EACH as f64;
                    let half = 0.5 * f64::from(other - one) * (std::f64::consts::PI * phase).sin();
                    is = i32::midpoint(one, other) + half.round() as i32;
                }
                self.runs = lie.runs_to.map(|to| {
                    let [from, way] = self.runs.unwrap_or([is, 0]);
                    let most = (way.abs() + RUNS[1]).min(RUNS[0]);
                    let way = (to - from).clamp(-most, most);
                    [from + way, way]
                });
                is = self.runs.map_or(is, |[runs, _]| runs);
                position.copy_from_slice(&is.to_le_bytes());
            }
            (address::PRESENT_VOLTAGE, [low, high, celsius]) => {
                if let Some(decivolts) = lie.decivolts {
                    [*low, *high] = decivolts.to_le_bytes();
                }
                *celsius = lie.celsius.unwrap_or(*celsius);
            }
            (address::HARDWARE_ERROR, [bits]) if lie.alert => *bits = OVERLOAD,
            _ => {}
        }
    }
}
