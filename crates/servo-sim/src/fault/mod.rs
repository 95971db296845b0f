//! Injects faults into simulated servos.

mod order;

use sinew_servo_bus::dynamixel::{HEADER, crc::Crc};

use crate::random::Random;
pub use order::{FaultOrder, FaultOrderError};

/// A kind of fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaultKind {
    /// The servo receives, but does not answer.
    Silent,
    /// The servo answers later by this time, us.
    Late(u32),
    /// The check at the end of replies is wrong.
    WrongCheck,
    /// Replies end after this number of bytes.
    Short(usize),
    /// Replies have this wrong id, with a matching check.
    WrongId(u8),
    /// The gear is jammed.
    Stuck,
    /// The case has this temperature, °C.
    Hot(f64),
    /// The supply is cut.
    BrownOut,
    /// The servo restarts, once.
    Reboot,
    /// Torque goes off without a report, once.
    TorqueLost,
    /// The encoder's reading is too large by this angle, rad.
    EncoderJump(f64),
    /// Torque stays on despite all commands.
    TorqueStuck,
}

impl FaultKind {
    /// Returns whether the fault concerns only replies. A servo without physics can have these faults too.
    pub fn is_of_replies(self) -> bool {
        matches!(
            self,
            Self::Silent | Self::Late(_) | Self::WrongCheck | Self::Short(_) | Self::WrongId(_)
        )
    }
}

/// A fault of one servo, with its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// Index of the servo.
    pub servo: usize,
    /// Time at which the fault begins, s.
    pub at_s: f64,
    /// Duration of the fault, s; infinite if it does not end.
    pub for_s: f64,
    /// Kind of the fault.
    pub kind: FaultKind,
}

impl Fault {
    /// Returns whether the fault is active at a time.
    pub fn is_on(&self, time_s: f64) -> bool {
        (self.at_s..self.at_s + self.for_s).contains(&time_s)
    }
}

/// Returns `count` random faults of all kinds except stuck torque, spread over servos and time. Equal seeds give equal
/// faults.
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

/// Applies faults to a reply. Returns its additional delay, us, or `None` if the reply is lost.
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

/// Sets another id, and adapts the check. In a part of a fast reply, only the id changes.
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
