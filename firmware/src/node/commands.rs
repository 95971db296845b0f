//! What becomes of a command: done here, or given to the loop, whose answer comes later.

use embedded_storage::nor_flash::NorFlash;
use sinew_link::message::{
    Applied, Command, Health, Limit, Outcome, PASS_WAIT_US, Parts, Pass, Refusal, TelemetrySetting,
};
use sinew_link::rate::{RigSize, telemetry_hz};

use super::board::Port;
use super::desk::Desk;
use super::mail::{Mail, Order, Said, Shared, Ticket};
use super::service::cycles;
use super::words;
use crate::supervisor::{self, Fault};

/// What is done when the loop has answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wait {
    Supervisor,
    Load { slot: usize },
    Unload { slot: usize },
    Service,
}

impl<'a, F: NorFlash, const B: usize, const V: usize, const S: usize, const C: usize>
    Desk<'a, F, B, V, S, C>
{
    /// Carries a command out, or gives it to the loop: then its answer comes later.
    #[inline(never)]
    pub(super) fn execute(
        &mut self,
        command: Command,
        ticket: Ticket,
        port: &mut impl Port<'a>,
        mail: &impl Shared<Mail<'a, V, S, C>>,
    ) -> Option<Outcome> {
        if let Some(order) = words::command(&command) {
            return self.order(order, ticket, mail);
        }
        let result = match command {
            // Before the loop has answered, nobody knows which show it reads, or whether it arms.
            Command::LoadShow { .. } | Command::DeleteShow { .. } | Command::BeginUpload(_)
                if self.waiting.is_some() =>
            {
                Err(Refusal::Busy)
            }
            Command::LoadShow { slot } => return self.load(slot.into(), ticket, port, mail),
            Command::DeleteShow { slot } if self.lent == Some(slot.into()) => {
                let state = mail.with(|mail| mail.state);
                if !state.is_on() {
                    return self.give(
                        Order::Show(None),
                        ticket,
                        Wait::Unload { slot: slot.into() },
                        mail,
                    );
                }
                // It may play.
                Err(Refusal::State(words::state(state)))
            }
            Command::DeleteShow { slot } => self.delete(slot.into(), mail),
            Command::SetTelemetry(setting) => return Some(self.set_telemetry(setting)),
            Command::ReadSetting { key } => self.read_setting(key),
            Command::WriteSetting { key, value } => self.write_setting(key, &value, mail),
            Command::ReadFault { index } => self.read_fault(index),
            Command::AskStored(place) => self.ask(place),
            Command::BeginUpload(item) => self.begin(&item, mail),
            Command::UploadBlock(block) => self.block(&block, mail),
            Command::EndUpload => self.end(port, mail),
            Command::PassOn(Pass { wait_us, .. }) if wait_us > PASS_WAIT_US => Err(Refusal::Value),
            Command::PassOn(pass) => return self.serve(Order::Pass(pass), ticket, mail),
            Command::ReadPassed { offset } => mail.with(|mail| mail.of_servos(offset)),
            Command::ReadHealth => return self.serve(Order::Health, ticket, mail),
            // The supervisor's were given to it.
            _ => Err(Refusal::Unsupported),
        };
        Some(outcome(result))
    }

    /// A show for the loop. Apart: shows take much of the stack.
    #[inline(never)]
    fn load(
        &mut self,
        slot: usize,
        ticket: Ticket,
        port: &mut impl Port<'a>,
        mail: &impl Shared<Mail<'a, V, S, C>>,
    ) -> Option<Outcome> {
        match self.open(slot, port) {
            Ok(show) => self.give(Order::Show(Some(show)), ticket, Wait::Load { slot }, mail),
            Err(refusal) => Some(Outcome::Refused(refusal)),
        }
    }

    /// For the supervisor.
    fn order(
        &mut self,
        order: supervisor::Command,
        ticket: Ticket,
        mail: &impl Shared<Mail<'a, V, S, C>>,
    ) -> Option<Outcome> {
        if self.setup.rig.is_none() {
            // There is no loop, and no torque.
            return Some(Outcome::Refused(Refusal::Fault(Fault::SettingsBad.number())));
        }
        if order == supervisor::Command::EStop {
            mail.with(|mail| mail.stop = Some(ticket));
            return None;
        }
        self.give(Order::Supervise(order), ticket, Wait::Supervisor, mail)
    }

    /// For the loop behind its tick.
    fn serve(
        &mut self,
        order: Order<'a, C>,
        ticket: Ticket,
        mail: &impl Shared<Mail<'a, V, S, C>>,
    ) -> Option<Outcome> {
        if self.setup.rig.is_none() {
            // There is no loop.
            return Some(Outcome::Refused(Refusal::Fault(Fault::SettingsBad.number())));
        }
        self.give(order, ticket, Wait::Service, mail)
    }

    /// Gives an order to the loop, if it has none.
    fn give(
        &mut self,
        order: Order<'a, C>,
        ticket: Ticket,
        wait: Wait,
        mail: &impl Shared<Mail<'a, V, S, C>>,
    ) -> Option<Outcome> {
        if self.waiting.is_some() {
            return Some(Outcome::Refused(Refusal::Busy));
        }
        self.waiting = Some((ticket, wait));
        mail.with(|mail| mail.order = Some((ticket, order)));
        None
    }

    /// The loop has answered.
    pub(super) fn said(
        &mut self,
        ticket: Ticket,
        said: Said,
        mail: &impl Shared<Mail<'a, V, S, C>>,
    ) {
        // An emergency stop is not waited for.
        let wait = self.waiting.take_if(|(of, _)| *of == ticket).map(|(_, wait)| wait);
        let outcome = match (said, wait) {
            (Said::Supervised(Ok(state)), _) => {
                Outcome::Applied(Applied::State(words::state(state)))
            }
            (Said::Supervised(Err(why)), _) => Outcome::Refused(words::refused(why)),
            (Said::Busy, _) => Outcome::Refused(Refusal::Busy),
            (Said::Shown, Some(Wait::Load { slot })) => {
                self.lent = Some(slot);
                Outcome::Applied(Applied::Done)
            }
            (Said::Shown, Some(Wait::Unload { slot })) => {
                self.lent = None;
                outcome(self.delete(slot, mail))
            }
            (Said::Shown, _) => Outcome::Applied(Applied::Done),
            (Said::Passed, _) => outcome(mail.with(|mail| mail.of_servos(0))),
            (Said::NotPassed(state), _) => Outcome::Refused(Refusal::State(words::state(state))),
            (Said::NoLine, _) => Outcome::Refused(Refusal::Unsupported),
            (Said::TooLong, _) => Outcome::Refused(Refusal::Value),
            (Said::Measured, _) => {
                let link = cycles(core::mem::take(&mut self.steps).read());
                let health = mail.with(|mail| mail.health);
                Outcome::Applied(Applied::Health(Health { link, ..health }))
            }
        };
        self.answer(ticket, outcome);
    }

    fn set_telemetry(&mut self, setting: TelemetrySetting) -> Outcome {
        let size = self.setup.rig.map(|(rig, _)| RigSize {
            coordinates: rig.tree().coordinate_count(),
            dofs: rig.freedoms().len(),
            servos: rig.servos().len(),
        });
        let Some(size) = size else {
            return Outcome::Refused(Refusal::Fault(Fault::SettingsBad.number()));
        };
        let parts = Parts(setting.parts.0 & Parts::ALL.0);
        let most = telemetry_hz(self.setup.line_bps, size, parts) as f32;
        let most = most.min(1.0 / self.setup.tick_s);
        let rate_hz = setting.rate_hz.max(0.0).min(most);
        let set = TelemetrySetting { rate_hz, parts };
        self.telemeter.set(set);
        let applied = Applied::Telemetry(set);
        if set == setting {
            Outcome::Applied(applied)
        } else {
            Outcome::Limited(applied, Limit::Link)
        }
    }
}

fn outcome(result: Result<Applied, Refusal>) -> Outcome {
    match result {
        Ok(applied) => Outcome::Applied(applied),
        Err(refusal) => Outcome::Refused(refusal),
    }
}
