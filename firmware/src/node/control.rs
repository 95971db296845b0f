//! The control loop. Runs in the timer interrupt, once per tick.

use core::fmt;

use sinew_link::{LiveSettings, LiveSetupError};
use sinew_rig::board::BoardRig;
use sinew_servo_bus::{Schedule, ServoBus};
use sinew_storage::Disarmed;

use super::board::Safety;
use super::live::Live;
use super::mail::{CommandId, LoopReply, LoopRequest, Mail, Shared, Tick};
use super::min_supply::MinSupply;
use super::pending::ServiceRequest;
use super::settings::NodeSettings;
use super::snapshot::{self, Times};
use super::timing::Timing;
use crate::controller::{
    ControllerError, Incomplete, Inputs, Jog, MotionController, ServoSetup, Start, Wire, exchange,
};
use crate::supervisor::{Command, Fault, FaultLog, FaultSet, LOGGED};

/// A reason why a control loop cannot be created.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ControlError {
    /// The controller cannot be created.
    Controller(ControllerError),
    /// A setting of the live stream is invalid.
    Live(LiveSetupError),
}

impl fmt::Display for ControlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Controller(why) => why.fmt(f),
            Self::Live(why) => why.fmt(f),
        }
    }
}

impl core::error::Error for ControlError {}

/// The control loop of a node. It runs in its own context, which only the bus may interrupt.
#[derive(Debug)]
pub struct ControlLoop<
    'a,
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
> {
    rig: &'a BoardRig<BODIES, DOFS, SERVOS>,
    pub(super) controller: MotionController<'a, BODIES, DOFS, SERVOS, COORDS>,
    /// The live stream; `None` before [`init`](Self::init).
    live: Option<Live<COORDS>>,
    /// The permission to erase flash. The loop has it while torque may be on.
    disarmed: Option<Disarmed>,
    /// The command that this tick executes.
    asked: Option<CommandId>,
    busy: Option<CommandId>,
    /// The request that is served after this tick.
    pub(super) service: Option<(CommandId, ServiceRequest)>,
    pub(super) supply: MinSupply,
    jog: Option<(Jog, u64)>,
    /// Faults already reported to the background task.
    reported_faults: FaultLog<LOGGED>,
    show_hz: Option<f32>,
    times: Times,
    timing: Timing,
    wants_snapshot: bool,
}

impl<'a, const BODIES: usize, const DOFS: usize, const SERVOS: usize, const COORDS: usize>
    ControlLoop<'a, BODIES, DOFS, SERVOS, COORDS>
{
    /// Creates the loop of a rig, with a [controller](MotionController::new) of these settings, servos and schedule.
    ///
    /// # Errors
    /// [`ControlError`] names the invalid setting.
    pub fn new(
        rig: &'a BoardRig<BODIES, DOFS, SERVOS>,
        settings: &NodeSettings,
        servos: &[ServoSetup],
        schedule: &Schedule,
        start: Start,
    ) -> Result<Self, ControlError> {
        let mut control = Self::uninit(rig);
        control.init(settings, servos, schedule, start)?;
        Ok(control)
    }

    /// Creates the loop on the stack, where it stays while `act` runs. A loop takes half of a board's RAM. As a
    /// return value it would be moved, and the board has no room for two.
    pub fn with<R>(
        rig: &'a BoardRig<BODIES, DOFS, SERVOS>,
        settings: &NodeSettings,
        servos: &[ServoSetup],
        schedule: &Schedule,
        start: Start,
        act: impl FnOnce(Result<&mut Self, ControlError>) -> R,
    ) -> R {
        let mut control = Self::uninit(rig);
        let made = control.init(settings, servos, schedule, start);
        act(made.map(|()| &mut control))
    }

    /// Creates an unconfigured loop in place. Private: `init` must follow.
    // Not inlined into its caller, like all functions that create a large part: the compiler then creates it in
    // place.
    #[inline(never)]
    fn uninit(rig: &'a BoardRig<BODIES, DOFS, SERVOS>) -> Self {
        Self {
            rig,
            reported_faults: FaultLog::default(),
            controller: MotionController::uninit(rig),
            live: None,
            disarmed: None,
            asked: None,
            busy: None,
            service: None,
            supply: MinSupply::default(),
            jog: None,
            show_hz: None,
            times: Times::default(),
            timing: Timing::default(),
            wants_snapshot: false,
        }
    }

    #[inline(never)]
    fn init(
        &mut self,
        settings: &NodeSettings,
        servos: &[ServoSetup],
        schedule: &Schedule,
        start: Start,
    ) -> Result<(), ControlError> {
        self.reported_faults = start.log;
        self.controller
            .init(&settings.controller, servos, schedule, start)
            .map_err(ControlError::Controller)?;
        self.set_live(settings.live())
    }

    #[inline(never)]
    fn set_live(&mut self, live: LiveSettings) -> Result<(), ControlError> {
        let live = LiveSettings { tick_s: self.controller.dt_s(), ..live };
        self.live = Some(Live::new(self.rig, live).map_err(ControlError::Live)?);
        Ok(())
    }

    /// Returns the controller.
    pub fn controller(&self) -> &MotionController<'a, BODIES, DOFS, SERVOS, COORDS> {
        &self.controller
    }

    /// Returns the durations of ticks, of their exchanges and of the loop's periods, in [`Safety::cycles`].
    pub fn timing(&mut self) -> &mut Timing {
        &mut self.timing
    }

    /// Runs a tick: reads requests, makes one exchange on the bus, and writes answers. The watchdog is fed if and
    /// only if the tick was complete. After the tick a host's packets to servos are served if torque is off, which
    /// makes the tick longer. `out` is room for the longest packets. O(dofs).
    ///
    /// # Errors
    /// [`Incomplete`] is the reason why the watchdog was not fed.
    pub fn tick(
        &mut self,
        board: &mut impl Safety,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
        bus: &mut impl ServoBus,
        wire: &mut impl Wire,
        out: &mut [u8],
    ) -> Result<(), Incomplete> {
        let (now_us, begun_at) = (board.now_us(), board.cycles());
        self.timing.begins(begun_at);
        let mut inputs = mail.with(|mail| self.take(mail, now_us));
        if board.is_stopped() {
            inputs.found = inputs.found.with(Fault::EStop);
        }
        let begun = self.controller.begin(&inputs, &mut self.live, bus);
        board.enable_outputs(self.controller.permission().torque);
        let asked_at = board.cycles();
        let exchanged = exchange(bus, wire, out);
        self.timing.bus(asked_at, board.cycles());
        // The snapshot is taken within the measured time, and outside of the mail's critical section.
        let snapshot = self.snapshot(board);
        let took_us = u32::try_from(board.now_us().saturating_sub(now_us)).unwrap_or(u32::MAX);
        self.times.add(took_us);
        let ended = self.controller.end(begun, exchanged, took_us);
        mail.with(|mail| self.put(mail, snapshot));
        self.timing.tick(begun_at, board.cycles());
        self.supply.note(&self.controller);
        let ended = ended.map(|tick| board.feed(tick));
        self.serve(board, mail, bus, wire);
        ended
    }

    fn take(&mut self, mail: &mut Mail<'a, DOFS, SERVOS, COORDS>, now_us: u64) -> Inputs {
        while let Some(frame) = mail.live.pop_front() {
            if let Some(live) = &mut self.live {
                live.push(&frame, now_us);
            }
        }
        self.wants_snapshot |= core::mem::take(&mut mail.wants_snapshot);
        if let Some(jog) = mail.jog.take() {
            self.jog = Some((jog, now_us));
        }
        let held_s = self.controller.supervisor().settings().enable_s;
        self.jog = self.jog.filter(|(_, at)| now_us.saturating_sub(*at) as f32 * 1e-6 < held_s);
        Inputs {
            now_us,
            heard: core::mem::take(&mut mail.heard),
            command: self.command(mail),
            found: if mail.is_deaf { FaultSet::of(Fault::HostDeaf) } else { FaultSet::EMPTY },
            jog: self.jog.map(|(jog, _)| jog),
        }
    }

    /// Takes the next request of the background task. Returns it if it is a supervisor's command, or else `None`: a
    /// show is then loaded at once, and a service waits for the end of the tick. An emergency stop goes before all
    /// others.
    fn command(&mut self, mail: &mut Mail<'a, DOFS, SERVOS, COORDS>) -> Option<Command> {
        if let Some(id) = mail.stop.take() {
            self.asked = Some(id);
            return Some(Command::EStop);
        }
        match mail.order.take() {
            Some((id, LoopRequest::Supervise(command))) => {
                // Only this command leads to torque.
                if command == Command::Arm && self.disarmed.is_none() {
                    self.disarmed = mail.disarmed.take();
                    if self.disarmed.is_none() {
                        self.busy = Some(id);
                        return None;
                    }
                }
                self.asked = Some(id);
                Some(command)
            }
            Some((id, LoopRequest::Show(show))) => {
                self.show_hz = show.as_ref().map(|show| show.show().rate().hz());
                self.controller.put_show(show);
                // There is room: at most one command is in progress, and a stop.
                let _ = mail.answers.push_back((id, LoopReply::Shown));
                None
            }
            Some((id, LoopRequest::Pass(pass))) => {
                self.service = Some((id, ServiceRequest::Pass(pass)));
                None
            }
            Some((id, LoopRequest::Health)) => {
                self.service = Some((id, ServiceRequest::Health));
                None
            }
            None => mail.enable.take().map(Command::Enable),
        }
    }

    /// Returns this tick's measurements and commands if the background task has requested them.
    fn snapshot(&mut self, board: &impl Safety) -> Option<Tick<DOFS, SERVOS, COORDS>> {
        if !core::mem::take(&mut self.wants_snapshot) {
            return None;
        }
        let times = core::mem::take(&mut self.times);
        self.times = times.go_on();
        let live_age_ms = self.live.as_ref().and_then(Live::age_ms);
        let stack_free = board.stack_free();
        let more = snapshot::More { times, stack_free, live_age_ms, show_hz: self.show_hz };
        Some(snapshot::of(&self.controller, self.rig, &more))
    }

    fn put(
        &mut self,
        mail: &mut Mail<'a, DOFS, SERVOS, COORDS>,
        snapshot: Option<Tick<DOFS, SERVOS, COORDS>>,
    ) {
        let report = self.controller.report();
        mail.state = report.state;
        if !report.state.is_on()
            && let Some(disarmed) = self.disarmed.take()
        {
            mail.disarmed = Some(disarmed);
        }
        if let (Some(id), Some(answer)) = (self.asked.take(), report.answer) {
            let _ = mail.answers.push_back((id, LoopReply::Supervised(answer)));
        }
        if let Some(id) = self.busy.take() {
            let _ = mail.answers.push_back((id, LoopReply::Busy));
        }
        let log = self.controller.supervisor().log();
        if *log != self.reported_faults {
            let room = mail.faults.capacity().saturating_sub(mail.faults.len());
            // All records are moved or none, so that none is reported twice. An empty mail has room for all.
            if log.news(&self.reported_faults).count() <= room {
                for news in log.news(&self.reported_faults) {
                    let _ = mail.faults.push_back(news);
                }
                self.reported_faults = *log;
            }
        }
        if snapshot.is_some() {
            mail.snapshot = snapshot;
        }
    }
}
