//! Execution of a command: by the background task, or by the control loop, which answers later.

use embedded_storage::nor_flash::NorFlash;
use sinew_link::message::{
    Applied, Command, Health, Limit, Outcome, PASS_WAIT_US, Pass, Refusal, TelemetryParts,
    TelemetrySetting,
};
use sinew_link::rate::{RigSize, telemetry_hz};

use super::background_task::BackgroundTask;
use super::board::Port;
use super::mail::{CommandId, LoopReply, LoopRequest, Mail, Shared};
use super::pending::Pending;
use super::service::cycles;
use super::text;
use crate::supervisor::{self, Fault};

/// Parts of telemetry that this version sends.
const PARTS: TelemetryParts =
    TelemetryParts::ALL.and(TelemetryParts::TARGETS).and(TelemetryParts::SUPPLIES);

impl<
    'a,
    F: NorFlash,
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
> BackgroundTask<'a, F, BODIES, DOFS, SERVOS, COORDS>
{
    /// Executes a command, and returns its outcome. Returns `None` if the command was passed to the loop: then the
    /// answer is sent later.
    #[inline(never)]
    pub(super) fn execute(
        &mut self,
        command: Command,
        id: CommandId,
        port: &mut impl Port<'a>,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Option<Outcome> {
        if let Some(order) = text::command(&command) {
            return self.order(order, id, mail);
        }
        let result = match command {
            // Until the loop has answered, it is not known which show it reads, or whether it arms.
            Command::LoadShow { .. } | Command::DeleteShow { .. } | Command::BeginUpload(_)
                if self.waiting.is_some() =>
            {
                Err(Refusal::Busy)
            }
            Command::LoadShow { slot } => return self.load(slot.into(), id, port, mail),
            Command::DeleteShow { slot } if self.lent == Some(slot.into()) => {
                let state = mail.with(|mail| mail.state);
                if !state.is_on() {
                    return self.give(
                        LoopRequest::Show(None),
                        id,
                        Pending::Unload { slot: slot.into() },
                        mail,
                    );
                }
                // The loop may be playing this show.
                Err(Refusal::State(text::state(state)))
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
            Command::PassOn(pass) => return self.serve(LoopRequest::Pass(pass), id, mail),
            Command::ReadPassed { offset } => mail.with(|mail| mail.of_servos(offset)),
            Command::ReadHealth => return self.serve(LoopRequest::Health, id, mail),
            // The supervisor's commands were passed on above.
            _ => Err(Refusal::Unsupported),
        };
        Some(outcome(result))
    }

    /// Passes a show to the loop and returns `None`, or returns the refusal. Not inlined: shows need much stack.
    #[inline(never)]
    fn load(
        &mut self,
        slot: usize,
        id: CommandId,
        port: &mut impl Port<'a>,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Option<Outcome> {
        match self.open(slot, port) {
            Ok(show) => self.give(LoopRequest::Show(Some(show)), id, Pending::Load { slot }, mail),
            Err(refusal) => Some(Outcome::Refused(refusal)),
        }
    }

    /// Passes a command to the supervisor and returns `None`, or returns the refusal.
    fn order(
        &mut self,
        order: supervisor::Command,
        id: CommandId,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Option<Outcome> {
        if self.setup.rig.is_none() {
            // Without a rig there is no loop, and no torque.
            return Some(Outcome::Refused(Refusal::Fault(Fault::SettingsBad.number())));
        }
        if order == supervisor::Command::EStop {
            mail.with(|mail| mail.stop = Some(id));
            return None;
        }
        self.give(LoopRequest::Supervise(order), id, Pending::Supervisor, mail)
    }

    /// Passes a request to the loop, which serves it after its tick, and returns `None`; or returns the refusal.
    fn serve(
        &mut self,
        order: LoopRequest<'a, COORDS>,
        id: CommandId,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Option<Outcome> {
        if self.setup.rig.is_none() {
            // Without a rig there is no loop.
            return Some(Outcome::Refused(Refusal::Fault(Fault::SettingsBad.number())));
        }
        self.give(order, id, Pending::Service, mail)
    }

    /// Gives an order to the loop and returns `None`. If the loop has not answered the previous order, returns the
    /// refusal.
    fn give(
        &mut self,
        order: LoopRequest<'a, COORDS>,
        id: CommandId,
        wait: Pending,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Option<Outcome> {
        if self.waiting.is_some() {
            return Some(Outcome::Refused(Refusal::Busy));
        }
        self.waiting = Some((id, wait));
        mail.with(|mail| mail.order = Some((id, order)));
        None
    }

    /// Handles an answer of the loop.
    pub(super) fn said(
        &mut self,
        id: CommandId,
        said: LoopReply,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) {
        // An emergency stop is not in `waiting`.
        let wait = self.waiting.take_if(|(of, _)| *of == id).map(|(_, wait)| wait);
        let outcome = match (said, wait) {
            (LoopReply::Supervised(Ok(state)), _) => {
                Outcome::Applied(Applied::State(text::state(state)))
            }
            (LoopReply::Supervised(Err(why)), _) => Outcome::Refused(text::refused(why)),
            (LoopReply::Busy, _) => Outcome::Refused(Refusal::Busy),
            (LoopReply::Shown, Some(Pending::Load { slot })) => {
                self.lent = Some(slot);
                Outcome::Applied(Applied::Done)
            }
            (LoopReply::Shown, Some(Pending::Unload { slot })) => {
                self.lent = None;
                outcome(self.delete(slot, mail))
            }
            (LoopReply::Shown, _) => Outcome::Applied(Applied::Done),
            (LoopReply::Passed, _) => outcome(mail.with(|mail| mail.of_servos(0))),
            (LoopReply::NotPassed(state), _) => {
                Outcome::Refused(Refusal::State(text::state(state)))
            }
            (LoopReply::NoLine, _) => Outcome::Refused(Refusal::Unsupported),
            (LoopReply::TooLong, _) => Outcome::Refused(Refusal::Value),
            (LoopReply::Measured, _) => {
                let link = cycles(core::mem::take(&mut self.steps).read());
                let health = mail.with(|mail| mail.health);
                Outcome::Applied(Applied::Health(Health { link, ..health }))
            }
        };
        self.answer(id, outcome);
    }

    fn set_telemetry(&mut self, setting: TelemetrySetting) -> Outcome {
        let size = self.setup.rig.map(|(rig, _)| RigSize {
            coordinates: rig.tree().coordinate_count(),
            dofs: rig.dofs().len(),
            servos: rig.servos().len(),
        });
        let Some(size) = size else {
            return Outcome::Refused(Refusal::Fault(Fault::SettingsBad.number()));
        };
        let parts = TelemetryParts(setting.parts.0 & PARTS.0);
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
