//! One tick of the bus: sends commands, asks for readings, processes replies.

use heapless::Vec;

use super::servo::Servo;
use super::{Bus, Registers, Settings};
use crate::compare::Comparison;
use crate::feetech::frame::{BROADCAST, Packet};
use crate::feetech::instruction::Instruction;
use crate::feetech::status::Status;
use crate::feetech::table::{Family, address};
use crate::servo_state::check_finite;
use crate::settings::{self, ServoRequirements};
use crate::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
};

impl<const SERVOS: usize> ServoBus for Bus<SERVOS> {
    fn len(&self) -> usize {
        self.servos.len()
    }

    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        let (count, settings) = (self.servos.len(), self.settings);
        let servo =
            self.servos.get_mut(servo).ok_or(CommandError::Servo { index: servo, count })?;
        check_finite(&command)?;
        servo.command(command, settings)
    }

    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        let written = self.write_all_goals(out)?;
        let rest = out.get_mut(written..).unwrap_or_default();
        let mut ids: Vec<u8, SERVOS> = Vec::new();
        let mut first = None;
        for (index, servo) in self.servos.iter().enumerate() {
            if self.schedule.reads(self.tick, index)
                && ids.push(servo.setup.id).is_ok()
                && first.is_none()
            {
                first = Some(index);
            }
        }
        let sync = self.settings.family == Family::Sts;
        let asked = match first {
            None => 0,
            Some(first) if !sync => self.ask_one(first, rest)?,
            Some(_) => {
                let length = self.settings.family.block_len();
                let read =
                    Instruction::SyncRead { address: address::PRESENT_POSITION, length, ids: &ids };
                read.encode(self.settings.family, BROADCAST, rest)?
            }
        };
        // Nothing can fail after this line, so the state may change.
        for (index, servo) in self.servos.iter_mut().enumerate() {
            servo.state.age();
            (servo.torque, servo.position, servo.speed, servo.pwm) = (None, None, None, None);
            servo.state.is_awaited = self.schedule.reads(self.tick, index);
            servo.was_asked = sync || first == Some(index);
        }
        self.asked = first.filter(|_| !sync);
        self.tick = self.tick.wrapping_add(1);
        self.retries_left = self.settings.retries;
        self.registers.is_due = self.registers.comparison.is_some();
        self.registers.awaited = None;
        let len = written.saturating_add(asked);
        self.begin(len);
        let answers = if sync { ids.len() } else { usize::from(first.is_some()) };
        Ok(self.request(len, answers))
    }

    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        // The parser may still hold whole replies, if a damaged length made it wait for bytes that do not arrive.
        while let Some(packet) = self.parser.flush() {
            let Self { servos, registers, asked, settings, .. } = self;
            take_packet(servos, registers, *asked, *settings, packet);
        }
        let awaited =
            |servo: &Servo, was_asked| servo.state.is_awaited && servo.was_asked == was_asked;
        let fresh = self.servos.iter().position(|servo| awaited(servo, false));
        let again = self
            .servos
            .iter()
            .position(|servo| awaited(servo, true))
            .filter(|_| self.retries_left > 0);
        let Some(index) = fresh.or(again) else {
            let is_due = core::mem::take(&mut self.registers.is_due);
            return if is_due { self.ask_registers(left_us, out) } else { Ok(None) };
        };
        let len = self.ask_one(index, out)?;
        let request = self.request(len, 1);
        if request.time_us > left_us {
            return Ok(None);
        }
        if fresh.is_none() {
            self.retries_left = self.retries_left.saturating_sub(1);
        }
        if let Some(servo) = self.servos.get_mut(index) {
            servo.was_asked = true;
        }
        self.asked = Some(index);
        self.begin(len);
        Ok(Some(request))
    }

    fn reply(&mut self, bytes: &[u8]) -> bool {
        let skipped = self.echo_left.min(bytes.len());
        self.echo_left = self.echo_left.saturating_sub(skipped);
        let mut input = bytes.get(skipped..).unwrap_or_default();
        let of_registers = self.registers.awaited.is_some();
        while let Some(packet) = self.parser.next(&mut input) {
            let Self { servos, registers, asked, settings, .. } = self;
            take_packet(servos, registers, *asked, *settings, packet);
        }
        if of_registers {
            return self.registers.awaited.is_none();
        }
        let is_asked = |index: usize| self.asked.is_none_or(|asked| asked == index);
        !self
            .servos
            .iter()
            .enumerate()
            .any(|(index, servo)| is_asked(index) && servo.state.is_awaited)
    }

    fn compare(&mut self, asked: Option<(usize, ServoRequirements)>) {
        self.registers.comparison =
            asked.map(|(servo, requirements)| Comparison::new(servo, requirements));
    }

    fn compared(&self) -> Compared {
        let comparison = self.registers.comparison.as_ref();
        comparison.map_or(Compared::Nothing, |comparison| comparison.result)
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
    registers: &mut Registers,
    asked: Option<usize>,
    settings: Settings,
    packet: Packet<'_>,
) {
    let Some(status) = Status::of(packet) else { return };
    if registers.awaited.is_some() {
        let id_of = |servo: usize| servos.get(servo).map(|servo| servo.setup.id);
        return registers.take(&status, id_of, settings.family);
    }
    let len = usize::from(settings.family.block_len());
    for (index, servo) in servos.iter_mut().enumerate() {
        let is_asked = servo.state.is_awaited && asked.is_none_or(|asked| asked == index);
        if is_asked && status.answers(servo.setup.id, len) {
            servo.take(&status, settings);
        }
    }
}

impl Registers {
    fn take(&mut self, status: &Status<'_>, id_of: impl Fn(usize) -> Option<u8>, family: Family) {
        let (Some((address, length)), Some(comparison)) = (self.awaited, &mut self.comparison)
        else {
            return;
        };
        if id_of(comparison.servo).is_some_and(|id| status.answers(id, length.into())) {
            self.awaited = None;
            let settings = settings::feetech_limp(family, comparison.requirements);
            comparison.take(settings, family.order(), address, status.data);
        }
    }
}
