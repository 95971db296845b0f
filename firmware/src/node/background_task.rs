//! The background task: host link and storage. `main` calls it in a loop; the control loop may interrupt it anywhere.

use embedded_storage::nor_flash::NorFlash;
use heapless::Deque;
use sinew_link::message::{
    ACKNOWLEDGED_SINCE, About, Command, FaultRecord, Hello, Misfit, Numbered, Outcome, Stream,
    ToController, ToHost,
};
use sinew_link::{Decoder, Intake, Order as Sequence, Session};
use sinew_rig::board::BoardRig;
use sinew_storage::{Disarmed, Store, Upload};

use super::board::Port;
use super::mail::{CommandId, FAULTS_WAITING, Mail, Shared};
use super::outbox::Outbox;
use super::pending::Pending;
use super::settings::NodeSettings;
use super::telemetry::Telemeter;
use super::text;
use super::timing::Sum;
use crate::controller::Jog;
use crate::supervisor::FaultNews;

/// Maximum number of bytes that a step reads from the line.
const AT_ONCE: usize = 64;

/// The board's action after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use = "new settings count after a restart"]
pub enum Next {
    /// Continue with the next step.
    Step,
    /// Reset the board: another rig or other settings are stored, and they are read at the start. Torque is off.
    Restart,
}

/// The parts of a node, except its storage.
#[derive(Debug)]
pub struct Setup<'a, const BODIES: usize, const DOFS: usize, const SERVOS: usize> {
    /// The description that the host receives. The node fills in rig and counts.
    pub about: About,
    /// The current settings.
    pub settings: NodeSettings,
    /// Whether the stored settings or rig are [bad](super::Found::is_bad).
    pub is_bad: bool,
    /// The rig of the loop, and its CRC; `None` if there is no loop.
    pub rig: Option<(&'a BoardRig<BODIES, DOFS, SERVOS>, u32)>,
    /// Duration of a tick, s.
    pub tick_s: f32,
    /// Bit rate of the host link, bit/s.
    pub line_bps: u32,
}

/// A node's host link and storage. The control loop may interrupt this task anywhere.
pub struct BackgroundTask<
    'a,
    F,
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
> {
    pub(super) setup: Setup<'a, BODIES, DOFS, SERVOS>,
    pub(super) store: Store<F>,
    session: Session,
    decoder: Decoder<ToController>,
    pub(super) outbox: Outbox,
    /// The command that the loop is processing.
    pub(super) waiting: Option<(CommandId, Pending)>,
    /// The slot of the show that the loop reads.
    pub(super) lent: Option<usize>,
    pub(super) upload: Option<Upload>,
    pub(super) telemeter: Telemeter<DOFS, SERVOS, COORDS>,
    /// Processor cycles of the task's steps, including the ticks that interrupted them.
    pub(super) steps: Sum,
    /// Faults that are not stored yet.
    pub(super) faults: Deque<FaultNews, FAULTS_WAITING>,
    /// The last warning since faults were cleared.
    pub(super) warning: Option<FaultRecord>,
    /// Set when new data was stored. The data takes effect after a restart, and the rig cannot be armed before it.
    pub(super) kept: Option<Disarmed>,
}

impl<
    'a,
    F: NorFlash,
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
> BackgroundTask<'a, F, BODIES, DOFS, SERVOS, COORDS>
{
    /// Creates a task before any host has connected. Sessions are numbered from the number after `first_session`,
    /// which must differ at each start.
    pub fn new(
        store: Store<F>,
        mut setup: Setup<'a, BODIES, DOFS, SERVOS>,
        first_session: u16,
    ) -> Self {
        setup.about.rig = setup.rig.map_or(0, |(_, crc)| crc);
        Self {
            setup,
            store,
            session: Session::new(first_session),
            decoder: Decoder::new(),
            outbox: Outbox::new(),
            waiting: None,
            lent: None,
            upload: None,
            telemeter: Telemeter::new(),
            steps: Sum::default(),
            faults: Deque::new(),
            warning: None,
            kept: None,
        }
    }

    /// Returns the storage.
    pub fn store(&mut self) -> &mut Store<F> {
        &mut self.store
    }

    /// Receives bytes, sends bytes, and does the work between them: at most one operation that writes flash. Such an
    /// operation may take as long as the erase of a sector, and happens only while torque is off. The loop continues
    /// meanwhile if its code is not in that flash.
    pub fn step(
        &mut self,
        port: &mut impl Port<'a>,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Next {
        let begun_at = port.cycles();
        while let Some((id, said)) = mail.with(|mail| mail.answers.pop_front()) {
            self.said(id, said, mail);
        }
        self.keep_faults(mail);
        // Bytes are read even if the host does not read and there is no room for an answer: a stop must be received.
        // Before a restart torque is off.
        if self.kept.is_none() {
            let mut bytes = [0; AT_ONCE];
            let came = port.receive(&mut bytes).min(AT_ONCE);
            for byte in bytes.get(..came).unwrap_or_default() {
                if let Some(message) = self.decoder.push(*byte) {
                    self.take(message, port, mail);
                }
            }
        }
        let counts = (self.decoder.damage().total(), self.session.counts().1.lost);
        let (now_us, acknowledges) = (port.now_us(), self.session.speaks(ACKNOWLEDGED_SINCE));
        self.telemeter.step(now_us, mail, counts, acknowledges, &mut self.outbox);
        self.outbox.send(|bytes| port.send(bytes));
        self.steps.add(begun_at, port.cycles());
        if self.kept.is_some() && self.outbox.is_empty() { Next::Restart } else { Next::Step }
    }

    #[inline(never)]
    fn take(
        &mut self,
        message: ToController,
        port: &mut impl Port<'a>,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) {
        match message {
            ToController::Hello(hello) => self.welcome(hello, mail),
            ToController::Command(command) => match self.session.command(&command) {
                Intake::Answer(answer) => self.outbox.put(&ToHost::Answer(answer)),
                Intake::Execute => {
                    let id = (command.session, command.seq);
                    let is_ours = self.session.id() == Some(command.session);
                    if is_ours && command.item != Command::EStop {
                        mail.with(|mail| mail.heard = true);
                    }
                    if let Some(outcome) = self.execute(command.item, id, port, mail) {
                        self.answer(id, outcome);
                    }
                }
            },
            ToController::Stream(item) => self.stream(item, port.now_us(), mail),
        }
    }

    // Not inlined, like all functions of this file that need much stack: their stack is free again before the rest.
    #[inline(never)]
    fn welcome(&mut self, hello: Hello, mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>) {
        let busy = mail.with(|mail| mail.state.is_on());
        let before = self.session.id();
        let welcome = self.session.hello(hello, self.setup.about, busy);
        if welcome.verdict != Err(Misfit::Busy) && self.session.id() != before {
            self.telemeter = Telemeter::new();
            mail.with(|mail| mail.is_deaf = false);
        }
        self.outbox.put(&ToHost::Welcome(welcome));
    }

    /// Handles an item that is useful only while it is fresh.
    #[inline(never)]
    fn stream(
        &mut self,
        item: Numbered<Stream>,
        now_us: u64,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) {
        let Some(order) = self.session.stream(&item) else { return };
        let is_fresh = matches!(order, Sequence::Fresh { .. });
        let is_late = order == Sequence::Late;
        let is_deaf = is_fresh && self.is_deaf(&item.item, now_us);
        mail.with(|mail| {
            mail.heard |= is_fresh;
            if is_fresh {
                mail.is_deaf = is_deaf;
            }
            match item.item {
                Stream::Live(frame) if is_fresh || is_late => {
                    if mail.live.is_full() {
                        mail.live.pop_front();
                    }
                    // There is room now.
                    let _ = mail.live.push_back(frame);
                }
                Stream::Jog { dof, velocity } if is_fresh => {
                    mail.jog = Some(Jog { dof: dof.into(), speed: velocity });
                }
                Stream::HoldToRun(operator) if is_fresh => {
                    mail.enable = Some(text::operator(operator));
                }
                _ => {}
            }
        });
    }

    /// Returns whether the host sends but no longer receives, judged by a fresh message from it.
    fn is_deaf(&mut self, item: &Stream, now_us: u64) -> bool {
        let heard = if let Stream::Heard(number) = item { Some(*number) } else { None };
        let limit_s = self.setup.settings.controller.supervisor.link_limp_s;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 60 s")]
        let limit_us = (limit_s * 1e6) as u32;
        self.telemeter.hear(heard, now_us, limit_us) && self.session.speaks(ACKNOWLEDGED_SINCE)
    }

    pub(super) fn answer(&mut self, id: CommandId, outcome: Outcome) {
        let answer = self.session.answer(id.0, id.1, outcome);
        self.outbox.put(&ToHost::Answer(answer));
    }
}
