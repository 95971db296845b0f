//! `sinew play --target PORT`: plays a show on a controller at a serial port.

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context as _, bail};
use sinew_board_client::{Board, ClientError, Line, TelemetryLog};
use sinew_console::{Hosted, Owner, Scene, Source};
use sinew_firmware::controller::Approach;
use sinew_host_util::command::note;
use sinew_link::message::{Command, FaultRecord, Feed, State, TelemetryParts};
use sinew_performance::play::RigParts;
use sinew_performance::rig::LoadedRig;
use sinew_show::Show;

use super::live::{Live, Moment, Row};
use crate::cli::board::{
    READY, arm, check_rig, clear_lost_link, end_by_hand, named, open, put_show, tell_faults,
};
use crate::cli::sound::Player;
use crate::cli::stop::Stop;

/// Time between two checks of the state.
const LOOK: Duration = Duration::from_millis(50);
/// Telemetry rate, Hz.
const RATE_HZ: f32 = 20.0;

/// Timing of a performance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Timing {
    /// Number of rounds of a loop; with `None` it plays until Ctrl-C.
    pub(super) rounds: Option<u32>,
    /// Time from arming to the start of the show, s. `None`: the show starts when the rig reaches the first pose.
    pub(super) preroll_s: Option<f64>,
}

/// Step of the performance that is in progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Ready,
    Arming,
    Playing,
    Stopping,
}

struct Performance<'b, L> {
    hosted: Hosted<'b, L>,
    parts: &'b RigParts,
    phase: Phase,
    /// Number of summaries received before the last command was executed. Only newer ones count.
    before: u32,
    begun: Duration,
    show: &'b [u8],
    preroll_s: Option<f64>,
    /// Way to the first pose of the show, from the armed pose; `None` before the rig is armed.
    approach: Option<Approach>,
    /// Planned time of the command to play; `None` before the rig is armed.
    play_at: Option<Duration>,
    /// Time when the show's clock started; `None` before the start.
    played: Option<Duration>,
    /// Time after which a loop is stopped; `None` for a loop that plays until Ctrl-C, and for a show that ends by
    /// itself.
    most: Option<Duration>,
    faults: usize,
    live: Live,
    player: Option<Player>,
}

/// Uploads a show if the board lacks it, arms the rig, plays, and stops it.
pub(super) fn perform(
    path: &Path,
    silence: Duration,
    (rig, parts): (&LoadedRig, &RigParts),
    bytes: &[u8],
    timing: Timing,
    player: Option<Player>,
) -> anyhow::Result<ExitCode> {
    let (mut board, name) = open(Some(path), "--target")?;
    board.set_silence(silence);
    perform_on((&mut board, &name), (rig, parts), bytes, timing, player)
}

/// Plays a show on a board with an open session. Other commands reach the board by `name`.
pub(super) fn perform_on<L: Line>(
    (board, name): (&mut Board<L>, &str),
    (rig, parts): (&LoadedRig, &RigParts),
    bytes: &[u8],
    timing: Timing,
    player: Option<Player>,
) -> anyhow::Result<ExitCode> {
    let show = Show::open(bytes)?;
    check_rig(board, parts)?;
    let stop = Stop::new()?;
    let scene = Scene::new(&rig.description.name, &rig.mechanism, parts, Source::Board);
    let mut hosted = Hosted::open(board, &scene, Owner::Drives("play"), Some(name))
        .context("the socket for other commands")?;
    let board = hosted.board_mut();
    let slot = put_show(board, bytes, "sinew play")?;
    board.ask(Command::LoadShow { slot })?;
    // Only the board knows its rate.
    let ticks_hz = board.telemetry(f32::MAX, TelemetryParts::SUMMARY)?.rate_hz;
    note(format_args!("the board runs {ticks_hz:.0} ticks a second"));
    let live = Live::new(&show);
    let of_table = TelemetryParts::ALL.and(TelemetryParts::TARGETS);
    // The pose is needed for the way to the first pose; other terminals show the servos.
    let of_watchers = TelemetryParts::SUMMARY.and(TelemetryParts::POSE).and(TelemetryParts::SERVOS);
    board.telemetry(RATE_HZ, if live.is_watched() { of_table } else { of_watchers })?;
    let most =
        timing.rounds.map(|rounds| Duration::from_secs_f32(show.duration_s() * rounds as f32));
    let mut performance = Performance {
        begun: board.now(),
        hosted,
        parts,
        phase: Phase::Ready,
        before: 0,
        show: bytes,
        preroll_s: timing.preroll_s,
        approach: None,
        play_at: None,
        played: None,
        most: most.filter(|_| show.is_loop()),
        faults: 0,
        live,
        player,
    };
    let ended = performance.run(&stop);
    performance.live.end();
    ended
}

impl<L: Line> Performance<'_, L> {
    fn run(&mut self, stop: &Stop) -> anyhow::Result<ExitCode> {
        loop {
            self.hosted.step(LOOK)?;
            self.tell();
            let times = stop.times();
            if times > 1 {
                note(format_args!(
                    "ended at once: the board holds the pose; after 2 s it lowers the rig, then torque is off"
                ));
                return Ok(ExitCode::FAILURE);
            }
            let is_over = self
                .most
                .zip(self.played)
                .is_some_and(|(most, played)| self.now().saturating_sub(played) >= most);
            let is_stopped = self.hosted.is_stopped();
            if (times > 0 || is_over || is_stopped) && self.phase != Phase::Stopping {
                if self.phase == Phase::Ready {
                    return Ok(ExitCode::SUCCESS);
                }
                if is_stopped {
                    // The hub has already sent the stop to the board.
                    self.begin(Phase::Stopping);
                } else {
                    self.command(Command::Stop, Phase::Stopping)?;
                }
            }
            // Ignores summaries from before the last command.
            if self.log().summaries < self.before + 2 {
                continue;
            }
            if let Some(ended) = self.go_on()? {
                return Ok(ended);
            }
        }
    }

    fn now(&self) -> Duration {
        self.hosted.board().now()
    }

    fn log(&self) -> &TelemetryLog {
        &self.hosted.board().log
    }

    fn begin(&mut self, phase: Phase) {
        (self.phase, self.before) = (phase, self.log().summaries);
    }

    fn command(&mut self, command: Command, phase: Phase) -> Result<(), ClientError> {
        self.hosted.board_mut().ask(command)?;
        self.begin(phase);
        Ok(())
    }

    /// Sends the next command, which depends on the present state. Returns the exit code if the performance has ended,
    /// otherwise `None`.
    fn go_on(&mut self) -> anyhow::Result<Option<ExitCode>> {
        let Some(state) = self.hosted.board().state() else { return Ok(None) };
        match (self.phase, state) {
            (Phase::Ready, State::Faulted) if clear_lost_link(self.hosted.board_mut())? => {
                self.begin(Phase::Ready);
            }
            (_, State::Faulted) => return Ok(Some(self.faulted())),
            (Phase::Ready, State::Calibrating | State::Teaching) => {
                end_by_hand(self.hosted.board_mut(), state)?;
                self.begin(Phase::Ready);
            }
            (Phase::Ready, _) => self.arm(state)?,
            (Phase::Arming, State::Holding) => self.play()?,
            // The show has ended, or a fault makes the rig hold.
            (Phase::Playing, State::Holding) => self.command(Command::Stop, Phase::Stopping)?,
            (Phase::Arming | Phase::Playing, State::Stopping | State::Lowering | State::Limp) => {
                self.phase = Phase::Stopping;
            }
            (Phase::Stopping, State::Limp | State::Off) => {
                let is_well = self.log().faults.iter().all(FaultRecord::is_warning);
                return Ok(Some(if is_well { ExitCode::SUCCESS } else { self.faulted() }));
            }
            _ => {}
        }
        Ok(None)
    }

    /// Arms the rig as soon as the board allows it.
    fn arm(&mut self, state: State) -> anyhow::Result<()> {
        let waits = self.now().saturating_sub(self.begun) < READY;
        if state != State::Limp && waits {
            return Ok(());
        }
        if arm(self.hosted.board_mut(), waits)? {
            self.begin(Phase::Arming);
        }
        Ok(())
    }

    /// Sends the command to play when its time has come, so that the way to the first pose ends together with the
    /// preroll.
    fn play(&mut self) -> anyhow::Result<()> {
        let now = self.now();
        let at = if let Some(at) = self.play_at {
            at
        } else {
            let approach = self.parts.approach(self.show, &self.log().q);
            self.approach = approach;
            let way_s = approach.map_or(0.0, |approach| f64::from(approach.way_s));
            let preroll_s = self.preroll_s.unwrap_or(way_s);
            if way_s > preroll_s {
                self.command(Command::Stop, Phase::Stopping)?;
                bail!(
                    "--preroll: expected at least {way_s:.2} s, which the way to the first pose takes; the rig stops"
                );
            }
            now + Duration::from_secs_f64(preroll_s - way_s)
        };
        self.play_at = Some(at);
        if now >= at {
            self.command(Command::Play(Feed::Show), Phase::Playing)?;
        }
        Ok(())
    }

    fn faulted(&self) -> ExitCode {
        tell_faults(self.hosted.board());
        ExitCode::FAILURE
    }

    /// Prints new states and faults; on a terminal also the table of joints.
    fn tell(&mut self) {
        let time_s = self.now().saturating_sub(self.begun).as_secs_f64();
        let Some(summary) = self.log().summary else { return };
        let log = &self.hosted.board().log;
        let (state, parts) = (summary.state, self.parts);
        let moment = Moment {
            time_s,
            state: state.to_string(),
            is_playing: state == State::Playing,
            runs: summary.show_ms > 0,
            approach: self.approach,
            show_s: 1e-3 * f64::from(summary.show_ms),
            errors_deg: summary.errors.map(|errors| [errors.mean_deg, errors.largest_deg]),
            supply_v: Some(summary.supply_v).filter(|v| *v > 0.0),
            tick_us: Some(summary.tick_us),
        };
        if let Some(player) = &mut self.player {
            player.note((moment.is_playing && moment.runs).then_some(moment.show_s));
        }
        if self.phase == Phase::Playing && moment.runs && self.played.is_none() {
            // The show's clock has run for this time.
            let clock = Duration::from_millis(summary.show_ms.into());
            self.played = Some(self.hosted.board().now().saturating_sub(clock));
        }
        self.live.show(&moment, || rows(parts, log));
        for fault in log.faults.iter().skip(self.faults) {
            self.live.tell(format_args!("{time_s:7.2} s  {}", named(fault.fault)));
        }
        self.faults = log.faults.len();
    }
}

/// Returns the rows of the table: the joints with servos.
fn rows(parts: &RigParts, log: &TelemetryLog) -> Vec<Row> {
    let Some(summary) = log.summary else { return Vec::new() };
    let has_effort = !matches!(summary.state, State::Off | State::Limp | State::Lowering);
    let row = |joint: usize| {
        let dof = log.dofs.get(joint);
        let told = parts.first_servo[joint].and_then(|servo| log.servos.get(servo));
        Row {
            joint: parts.names[joint].clone(),
            slides: parts.slides[joint],
            error: log.targets.get(joint).copied().filter(|_| summary.errors.is_some()),
            effort: dof.map(|dof| dof.effort).filter(|_| has_effort),
            heat_percent: told.map(|servo| servo.heat_percent.into()),
            celsius: told.and_then(|servo| servo.temperature_c).map(f32::from),
            limiter: dof.and_then(|dof| dof.limiter).map(|limit| limit.name().to_owned()),
        }
    };
    let joints = (0..parts.names.len()).filter(|joint| parts.drives[*joint].is_some());
    joints.map(row).collect()
}
