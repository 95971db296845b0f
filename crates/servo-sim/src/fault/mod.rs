//! Injects faults into simulated servos.

mod order;

use sinew_servo_bus::dynamixel::{HEADER, crc::Crc};

use crate::random::Random;
pub use order::{FaultOrder, FaultOrderError};

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaultKind {
    /// It hears, and does not answer.
    Silent,
    /// It answers later by so many us.
    Late(u32),
    /// The check at the end of its replies is wrong.
    WrongCheck,
    /// Its replies end after so many bytes.
    Short(usize),
    /// Its replies have another id, and the right check.
    WrongId(u8),
    /// Its gear is jammed.
    Stuck,
    /// Its case is at this temperature, °C.
    Hot(f64),
    /// Its supply is cut.
    BrownOut,
    /// It starts anew, once.
    Reboot,
    /// Its torque goes off, once, without a word.
    TorqueLost,
    /// Its encoder reads so much more, rad.
    EncoderJump(f64),
    /// Its torque is on, whatever it is told.
    TorqueStuck,
}

impl FaultKind {
    /// Whether it is the replies alone that suffer: then a servo without physics can have it too.
    pub fn is_of_replies(self) -> bool {
        matches!(
            self,
            Self::Silent | Self::Late(_) | Self::WrongCheck | Self::Short(_) | Self::WrongId(_)
        )
    }
}

/// What goes wrong, where and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// Index of the servo.
    pub servo: usize,
    /// When it begins, s.
    pub at_s: f64,
    /// How long it lasts, s; infinite for ever.
    pub for_s: f64,
    /// What.
    pub kind: FaultKind,
}

impl Fault {
    /// Whether it is there at a time.
    pub fn is_on(&self, time_s: f64) -> bool {
        (self.at_s..self.at_s + self.for_s).contains(&time_s)
    }
}

/// So many faults of all kinds but torque that is stuck, spread over servos and over a time; the same for a seed.
pub fn random(seed: u64, count: usize, servos: usize, duration_s: f64) -> Vec<Fault> {
    let mut random = Random::new(seed);
    let mut fault = || {
        let kind = match random.below(11) {
            0 => FaultKind::Silent,
            1 => FaultKind::Late(u32::try_from(200 + random.below(20_000)).unwrap_or(200)),
            2 => FaultKind::WrongCheck,
            3 => FaultKind::Short(random.below(12)),
            4 => FaultKind::WrongId(u8::try_from(random.below(253)).unwrap_or(0)),
            5 => FaultKind::Stuck,
            6 => FaultKind::Hot(random.between(60.0, 100.0)),
            7 => FaultKind::BrownOut,
            8 => FaultKind::Reboot,
            9 => FaultKind::TorqueLost,
            _ => FaultKind::EncoderJump(random.between(-3.0, 3.0)),
        };
        let at_s = random.between(0.0, duration_s);
        Fault { servo: random.below(servos), at_s, for_s: random.between(0.01, 0.5), kind }
    };
    (0..count).map(|_| fault()).collect()
}

/// What faults do to a reply, and by how much later it comes, us. None: it does not come.
pub(crate) fn damage(kinds: impl Iterator<Item = FaultKind>, reply: &mut Vec<u8>) -> Option<u32> {
    let mut late_us = 0;
    for kind in kinds {
        match kind {
            FaultKind::Silent => return None,
            FaultKind::Late(us) => late_us += us,
            FaultKind::WrongCheck => {
                if let Some(last) = reply.last_mut() {
                    *last ^= 0x55;
                }
            }
            FaultKind::Short(len) => reply.truncate(len),
            FaultKind::WrongId(id) => change_id(reply, id),
            _ => {}
        }
    }
    Some(late_us)
}

/// Another id, and the check that goes with it. Parts of a fast reply have only the id changed.
fn change_id(reply: &mut [u8], id: u8) {
    let is_dynamixel = reply.starts_with(&HEADER);
    if is_dynamixel && reply.len() > 6 {
        reply[4] = id;
        let (body, check) = reply.split_at_mut(reply.len() - 2);
        check.copy_from_slice(&Crc::of(body).to_le_bytes());
    } else if !is_dynamixel && reply.starts_with(&[0xFF, 0xFF]) && reply.len() > 4 {
        reply[2] = id;
        let (body, check) = reply.split_at_mut(reply.len() - 1);
        check[0] = !body[2..].iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    } else if reply.len() > 1 {
        reply[1] = id;
    }
}
