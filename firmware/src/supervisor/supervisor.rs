//! The supervisor: modes, with their clocks and the log of faults.

use super::fault::{FaultLog, FaultRecord, Findings, reacting};
use super::permission::Permission;
use super::{
    Answer, Command, Event, Fault, FaultSet, Feeds, LOWER_MOST, Mode, Moving, Overload, Registers,
    Settings, State,
};
use crate::SettingError;

/// Number of the last faults that are kept.
pub const LOGGED: usize = 8;

/// Inputs of a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
pub struct Inputs {
    /// Time since the board's start, µs. It never decreases.
    pub now_us: u64,
    /// Whether a valid and *new* message of the host arrived since the last tick.
    pub heard: bool,
    /// A command, if one arrived. Only one command is handled in a tick.
    pub command: Option<Command>,
    /// Faults that detectors found. The supervisor itself detects faults of the link.
    pub findings: Findings,
    /// Faults that a valid upload has cleared: [`FaultSet::OF_SHOW`]. Valid settings, or a valid rig, take effect
    /// after a restart.
    pub uploaded: FaultSet,
    /// Whether every servo that reports has a valid reading that is new enough.
    pub measured: bool,
    /// Result of comparing the servos' registers. Used only by arming.
    pub registers: Registers,
    /// Whether the way to stop was tested since the rig became limp.
    pub stop_tested: bool,
    /// A joint that moves too fast for arming. Used only by arming.
    pub moving: Option<Moving>,
    /// A load that servos or supply cannot hold. Used only by arming.
    pub overload: Option<Overload>,
    /// Feeds that have poses.
    pub feeds: Feeds,
    /// Whether every servo accepts an effort, so that the rig can carry itself. Used only by floating.
    pub carries: bool,
    /// Whether the commanded pose has reached the source of the last [`Permission`]. While the rig is lowered:
    /// whether it rests, and nothing is carried any more.
    pub is_there: bool,
}

/// Result of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Outcome {
    /// State after the tick.
    pub state: State,
    /// Permission for the drives after the tick.
    pub permission: Permission,
    /// Answer to the command.
    pub answer: Option<Answer>,
    /// Faults whose condition is present.
    pub present: FaultSet,
    /// Faults with a reaction that they did not have in the tick before, and warnings that begin. They are in the
    /// log, for storage to keep.
    pub raised: FaultSet,
    /// Faults that must be cleared.
    pub latched: FaultSet,
}

/// Decides whether anything may move, how fast, and how faults are handled. Begins in [`State::Off`]; only
/// [`Command::Arm`] leads to torque.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Supervisor {
    settings: Settings,
    start: u32,
    mode: Mode,
    clocks: Clocks,
    reacting: FaultSet,
    log: FaultLog<LOGGED>,
}

/// Times of the last events, µs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Clocks {
    heard: Option<u64>,
    enabled: Option<u64>,
    state: u64,
    source: u64,
}

impl Supervisor {
    /// Creates a supervisor at the board's start. `start` is the number of the start; `log` contains the stored
    /// faults, or is [`FaultLog::default`].
    ///
    /// # Errors
    /// [`SettingError`] names the invalid setting and its bounds.
    pub fn new(
        settings: Settings,
        start: u32,
        log: FaultLog<LOGGED>,
    ) -> Result<Self, SettingError> {
        settings.check()?;
        Ok(Self { settings, start, log, ..Self::default() })
    }

    /// Advances by a tick. Equal inputs give equal outcomes on every machine. O(1).
    pub fn step(&mut self, inputs: &Inputs) -> Outcome {
        let now_us = inputs.now_us;
        if inputs.heard {
            self.clocks.heard = Some(now_us);
        }
        let event = self.event(inputs);
        let before = self.mode;
        let (mode, answer) = before.next(&event);
        self.mode = mode;
        self.set_clocks(&before, &event, answer, now_us);

        let present = before.present(&event);
        let reacting = reacting(present, before.state).union(present.and(FaultSet::WARNINGS));
        let raised = reacting.minus(self.reacting);
        self.reacting = reacting;
        if let (Some(Command::ClearFaults), Some(Ok(_))) = (event.command, answer) {
            self.log.clear();
        }
        for fault in raised.iter() {
            self.log.note(FaultRecord {
                fault,
                state: before.state,
                servo: inputs.findings.servo(fault),
                start: self.start,
                time_us: now_us,
                times: 1,
            });
        }
        let permission = self.permission(now_us);
        Outcome { state: mode.state, permission, answer, present, raised, latched: mode.latched }
    }

    /// Returns the current mode.
    pub fn mode(&self) -> &Mode {
        &self.mode
    }

    /// Returns the log of the first fault and the last ones.
    pub fn log(&self) -> &FaultLog<LOGGED> {
        &self.log
    }

    /// Returns the settings of the supervisor.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    fn event(&self, inputs: &Inputs) -> Event {
        let (settings, clocks, now_us) = (&self.settings, &self.clocks, inputs.now_us);
        let over = |since: u64, limit_s: f32| seconds(now_us, since) >= limit_s;
        let time_s = match self.mode.state {
            State::Arming => settings.arming_s,
            State::Stopping => settings.stop_s,
            State::Lowering => self.lower_most_s(),
            _ => f32::INFINITY,
        };
        let mut present = inputs.findings.present();
        // A link from which no message ever arrived counts as lost.
        if clocks.heard.is_none_or(|heard| over(heard, settings.link_limp_s)) {
            present = present.with(Fault::LinkLost);
        } else if clocks.heard.is_some_and(|heard| over(heard, settings.link_hold_s)) {
            present = present.with(Fault::LinkLate);
        }
        Event {
            command: inputs.command,
            present,
            uploaded: inputs.uploaded,
            measured: inputs.measured,
            registers: inputs.registers,
            stop_tested: inputs.stop_tested,
            moving: inputs.moving,
            overload: inputs.overload,
            feeds: inputs.feeds,
            carries: inputs.carries,
            enabled: clocks.enabled.is_some_and(|enabled| !over(enabled, settings.enable_s)),
            arrived: inputs.is_there
                && (self.mode.state == State::Lowering || over(clocks.source, settings.blend_s)),
            time_over: over(clocks.state, time_s),
        }
    }

    fn set_clocks(&mut self, before: &Mode, event: &Event, answer: Option<Answer>, now_us: u64) {
        if before.state != self.mode.state {
            self.clocks.state = now_us;
            self.clocks.enabled = None;
        }
        if before.source() != self.mode.source() {
            self.clocks.source = now_us;
        }
        if let (Some(Command::Enable(_)), Some(Ok(_))) = (event.command, answer) {
            self.clocks.enabled = Some(now_us);
        }
    }

    fn permission(&self, now_us: u64) -> Permission {
        let in_source = seconds(now_us, self.clocks.source) / self.settings.blend_s;
        // The last part of the maximum time fades the remaining effort. Lowering in zero seconds ends at once.
        let left_s = self.lower_most_s() - seconds(now_us, self.clocks.state);
        let effort = (left_s / self.settings.lower_s.max(1e-3)).clamp(0.0, 1.0);
        Permission::of(&self.mode, &self.settings, in_source.min(1.0), effort)
    }

    /// Returns the time after which lowering ends even if the rig still moves, s.
    fn lower_most_s(&self) -> f32 {
        let short =
            FaultSet::EMPTY.with(Fault::HotMeasured).with(Fault::HotWinding).with(Fault::SupplyLow);
        let [most, least] = LOWER_MOST;
        let times = if self.mode.latched.and(short).is_empty() { most } else { least };
        times * self.settings.lower_s
    }
}

/// Returns the seconds from one time to another; 0 if time went back.
fn seconds(now_us: u64, since_us: u64) -> f32 {
    now_us.saturating_sub(since_us) as f32 * 1e-6
}
