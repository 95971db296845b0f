//! Creates damage that is the same in every run.

use sinew_servo_bus::Command;

/// A pseudo-random generator: `SplitMix64`.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        usize::try_from(self.next() % count as u64).unwrap()
    }

    /// Returns a random number from `-most` to `most`.
    pub(crate) fn within(&mut self, most: i32) -> i32 {
        i32::try_from(self.below(usize::try_from(2 * most + 1).unwrap())).unwrap() - most
    }

    fn byte(&mut self) -> u8 {
        self.next().to_le_bytes()[0]
    }

    /// Returns a number that a program may command: near the limits, far outside, or NaN.
    fn number(&mut self) -> f32 {
        let [a, b, c, d, ..] = self.next().to_le_bytes();
        match self.below(4) {
            0 => f32::from_le_bytes([a, b, c, d]),
            1 => f32::from(i16::from_le_bytes([a, b])),
            _ => f32::from(i16::from_le_bytes([a, b])) / 4096.0,
        }
    }

    pub(crate) fn command(&mut self) -> Command {
        match self.below(10) {
            0 => Command::Torque(self.below(4) > 0),
            1 => Command::Current(self.number()),
            2 => Command::Pwm(self.number()),
            3 => Command::Stiffness(u16::from_le_bytes([self.byte(), self.byte()])),
            4 => Command::PositionWithin { position_rad: self.number(), current_a: self.number() },
            5 | 6 => {
                Command::PositionAt { position_rad: self.number(), speed_rad_s: self.number() }
            }
            _ => Command::Position(self.number()),
        }
    }

    /// Applies one kind of damage to a reply: loss, duplication, insertion, changed bytes or bits.
    pub(crate) fn damage(&mut self, reply: &mut Vec<u8>) {
        let at = self.below(reply.len());
        match self.below(7) {
            0 => {
                reply.remove(at);
            }
            1 => reply.insert(at, reply[at]),
            2 => reply.insert(at, self.byte()),
            3 => reply.truncate(at),
            4 => reply[at] = self.byte(),
            5 => {
                for _ in 0..=self.below(8) {
                    let bit = self.below(reply.len() * 8);
                    reply[bit / 8] ^= 1 << (bit % 8);
                }
            }
            _ => reply.extend_from_within(at..),
        }
    }
}
