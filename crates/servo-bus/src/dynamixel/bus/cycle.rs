//! One tick of the bus: sends commands, asks for readings, processes replies.

use heapless::Vec;

use super::lengths::MOTION_LEN;
use super::servo::Servo;
use super::{Awaits, Bus, gain_of, settings_of};
use crate::compare::Comparison;
use crate::dynamixel::fast::{FastReader, answer_len};
use crate::dynamixel::frame::{BROADCAST, Packet};
use crate::dynamixel::instruction::{Instruction, Span};
use crate::dynamixel::status::Status;
use crate::dynamixel::table::address;
use crate::servo_state::check_finite;
use crate::settings::ServoRequirements;
use crate::table::ByteOrder;
use crate::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
};

impl<const SERVOS: usize> ServoBus for Bus<SERVOS> {
    fn len(&self) -> usize {
        self.servos.len()
    }

    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        let count = self.servos.len();
        let servo =
            self.servos.get_mut(servo).ok_or(CommandError::Servo { index: servo, count })?;
        check_finite(&command)?;
        servo.command(command)
    }

    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        self.note_silence();
        let written = self.write_all_goals(out)?;
        let rest = out.get_mut(written..).unwrap_or_default();
        let mut ids: Vec<u8, SERVOS> = Vec::new();
        for (index, servo) in self.servos.iter().enumerate() {
            let is_asked = self.schedule.reads(self.tick, index) && !servo.is_left_out;
            if is_asked && ids.push(servo.setup.id).is_err() {
                break;
            }
        }
        let span = Span { address: address::PRESENT_CURRENT, length: MOTION_LEN, ids: &ids };
        let ask = if self.settings.fast {
            Instruction::FastSyncRead(span)
        } else {
            Instruction::SyncRead(span)
        };
        let asked = if ids.is_empty() { 0 } else { ask.encode(BROADCAST, rest)? };
        // Nothing can fail after this line, so the state may change.
        let mut group = ids.iter().peekable();
        for (index, servo) in self.servos.iter_mut().enumerate() {
            servo.is_in_group = group.next_if_eq(&&servo.setup.id).is_some();
            servo.state.age();
            servo.planned();
            servo.state.is_awaited = self.schedule.reads(self.tick, index);
        }
        let fast_len = answer_len(ids.iter().map(|_| MOTION_LEN));
        let (awaits, reply_len) = match (ids.len(), self.settings.fast) {
            (0, _) => (Awaits::Nothing, 0),
            (_, true) => (Awaits::Fast(FastReader::new(fast_len)), fast_len),
            (count, false) => {
                (Awaits::Each, count.saturating_mul(usize::from(MOTION_LEN).saturating_add(11)))
            }
        };
        self.awaits = awaits;
        self.parser.clear();
        self.tick = self.tick.wrapping_add(1);
        self.retries_left = self.settings.retries;
        self.slow_is_due = !core::mem::take(&mut self.slow_waits) && !self.servos.is_empty();
        self.registers_are_due = true;
        Ok(self.request(written.saturating_add(asked), reply_len))
    }

    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        // The parser may still hold whole replies, if a damaged length made it wait for bytes that do not arrive.
        while let Some(packet) = self.parser.flush() {
            take_packet(&mut self.servos, &mut self.awaits, &mut self.comparison, packet);
        }
        self.note_silence();
        if let (Some(missing), Some(left)) = (self.next_missing(), self.retries_left.checked_sub(1))
        {
            let request =
                self.ask_one(missing, (address::PRESENT_CURRENT, MOTION_LEN), left_us, out)?;
            if request.is_some() {
                (self.retried, self.retries_left) = (missing, left);
                return Ok(request);
            }
        }
        if core::mem::take(&mut self.slow_is_due) {
            let request = self.ask_slow(left_us, out)?;
            if request.is_some() {
                return Ok(request);
            }
        }
        if !core::mem::take(&mut self.registers_are_due) {
            return Ok(None);
        }
        if self.comparison.is_some() {
            return self.ask_registers(left_us, out);
        }
        self.ask_watchdog(left_us, out)
    }

    fn reply(&mut self, bytes: &[u8]) -> bool {
        let Self { servos, parser, awaits, comparison, .. } = self;
        let mut input = bytes;
        if let Awaits::Fast(reader) = awaits {
            for servo in
                servos.iter_mut().filter(|servo| servo.is_in_group && servo.state.is_awaited)
            {
                let Some(status) = reader.next(servo.setup.id, MOTION_LEN, &mut input) else {
                    return false;
                };
                servo.take(&status, address::PRESENT_CURRENT, MOTION_LEN);
            }
            *awaits = Awaits::Nothing;
        }
        while let Some(packet) = parser.next(&mut input) {
            take_packet(servos, awaits, comparison, packet);
        }
        match awaits {
            Awaits::Nothing => true,
            Awaits::Fast(_) | Awaits::One { .. } => false,
            Awaits::Each => !servos.iter().any(|servo| servo.is_in_group && servo.state.is_awaited),
        }
    }

    fn compare(&mut self, asked: Option<(usize, ServoRequirements)>) {
        if let Some((servo, requirements)) = asked
            && let Some(servo) = self.servos.get_mut(servo)
        {
            servo.goals.gain = gain_of(servo, requirements);
        }
        self.comparison = asked.map(|(servo, requirements)| Comparison::new(servo, requirements));
    }

    fn compared(&self) -> Compared {
        self.comparison.as_ref().map_or(Compared::Nothing, |comparison| comparison.result)
    }

    fn feedback(&self, servo: usize) -> Option<Feedback> {
        self.servos.get(servo)?.state.feedback
    }

    fn health(&self, servo: usize) -> Option<Health> {
        self.servos.get(servo).map(|servo| servo.state.health)
    }
}

/// Passes a reply to the servo that was asked for it. Ignores any other reply.
fn take_packet(
    servos: &mut [Servo],
    awaits: &mut Awaits,
    comparison: &mut Option<Comparison>,
    packet: Packet<'_>,
) {
    let Some(status) = Status::of(packet) else { return };
    match *awaits {
        Awaits::Nothing | Awaits::Fast(_) => {}
        Awaits::Each => {
            let mut awaited = servos.iter_mut().filter(|servo| servo.state.is_awaited);
            if let Some(servo) = awaited.find(|servo| servo.setup.id == status.id) {
                servo.take(&status, address::PRESENT_CURRENT, MOTION_LEN);
            }
        }
        Awaits::One { servo, address, length } => {
            let index = servo;
            if let Some(servo) =
                servos.get_mut(index).filter(|servo| status.answers(servo.setup.id, length.into()))
            {
                servo.take(&status, address, length);
                *awaits = Awaits::Nothing;
                let Some(comparison) = comparison.as_mut() else { return };
                let settings = settings_of(servo, comparison.requirements);
                let is_asked = comparison.servo == index
                    && comparison.next(settings.clone()) == Some((address, length));
                // With an error, the data are not the value of a register.
                if is_asked && status.error.code().is_none() {
                    comparison.take(settings, ByteOrder::Little, address, status.data);
                }
            }
        }
    }
}
