//! `sinew play --target PORT`: plays a show on a controller at a serial port.

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::bail;
use indicatif::{ProgressBar, ProgressStyle};
use sinew_board_client::{Board, ClientError, Line};
use sinew_host_util::command::note;
use sinew_link::message::{Command, FaultRecord, Feed, State, Summary, TelemetryParts};
use sinew_performance::play::RigParts;
use sinew_show::Show;

use super::live::approach_text;
use crate::cli::board::{READY, arm, check_rig, end_by_hand, named, open, put_show, tell_faults};
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
    /// Time from the armed rig to the start of the show, s; `None`: as soon as the rig is at the first pose.
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
    board: &'b mut Board<L>,
    phase: Phase,
    /// Number of summaries received before the last command was done. They no longer count.
    before: u32,
    begun: Duration,
    show: &'b [u8],
    parts: &'b RigParts,
    preroll_s: Option<f64>,
    /// Time of the command to play.
    play_at: Option<Duration>,
    /// Time when the show's clock started, and its longest duration.
    played: Option<Duration>,
    most: Option<Duration>,
    state: Option<State>,
    faults: usize,
    bar: ProgressBar,
}

/// Uploads a show if the board lacks it, arms the rig, plays, and stops it.
pub(super) fn perform(
    path: &Path,
    silence: Duration,
    parts: &RigParts,
    bytes: &[u8],
    timing: Timing,
) -> anyhow::Result<ExitCode> {
    let mut board = open(Some(path), "--target")?;
    board.set_silence(silence);
    perform_on(&mut board, parts, bytes, timing)
}

/// Plays a show on a board with an open session.
pub(super) fn perform_on<L: Line>(
    board: &mut Board<L>,
    parts: &RigParts,
    bytes: &[u8],
    timing: Timing,
) -> anyhow::Result<ExitCode> {
    let show = Show::open(bytes)?;
    check_rig(board, parts)?;
    let stop = Stop::new()?;
    let slot = put_show(board, bytes, "sinew play")?;
    board.ask(Command::LoadShow { slot })?;
    board.telemetry(RATE_HZ, TelemetryParts::SUMMARY.and(TelemetryParts::POSE))?;
    let style = ProgressStyle::with_template("{msg}")?;
    let most =
        timing.rounds.map(|rounds| Duration::from_secs_f32(show.duration_s() * rounds as f32));
    let mut performance = Performance {
        begun: board.now(),
        board,
        phase: Phase::Ready,
        before: 0,
        show: bytes,
        parts,
        preroll_s: timing.preroll_s,
        play_at: None,
        played: None,
        most: most.filter(|_| show.is_loop()),
        state: None,
        faults: 0,
        bar: ProgressBar::new_spinner().with_style(style),
    };
    let ended = performance.run(&stop);
    performance.bar.finish_and_clear();
    ended
}

impl<L: Line> Performance<'_, L> {
    fn run(&mut self, stop: &Stop) -> anyhow::Result<ExitCode> {
        loop {
            self.board.step(LOOK)?;
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
                .is_some_and(|(most, played)| self.board.now().saturating_sub(played) >= most);
            if (times > 0 || is_over) && self.phase != Phase::Stopping {
                if self.phase == Phase::Ready {
                    return Ok(ExitCode::SUCCESS);
                }
                self.command(Command::Stop, Phase::Stopping)?;
            }
            // Ignores summaries from before the last command.
            if self.board.log.summaries < self.before + 2 {
                continue;
            }
            if let Some(ended) = self.go_on()? {
                return Ok(ended);
            }
        }
    }

    fn command(&mut self, command: Command, phase: Phase) -> Result<(), ClientError> {
        self.board.ask(command)?;
        (self.phase, self.before) = (phase, self.board.log.summaries);
        Ok(())
    }

    /// Sends the next command for the present state. Returns the exit code if the performance has ended, otherwise
    /// `None`.
    fn go_on(&mut self) -> anyhow::Result<Option<ExitCode>> {
        let Some(state) = self.board.state() else { return Ok(None) };
        match (self.phase, state) {
            (_, State::Faulted) => return Ok(Some(self.faulted())),
            (Phase::Ready, State::Calibrating | State::Teaching) => {
                end_by_hand(self.board, state)?;
                self.before = self.board.log.summaries;
            }
            (Phase::Ready, _) => self.arm(state)?,
            (Phase::Arming, State::Holding) => self.play()?,
            // The show has ended, or a fault makes the rig hold.
            (Phase::Playing, State::Holding) => self.command(Command::Stop, Phase::Stopping)?,
            (Phase::Arming | Phase::Playing, State::Stopping | State::Lowering | State::Limp) => {
                self.phase = Phase::Stopping;
            }
            (Phase::Stopping, State::Limp | State::Off) => {
                let is_well = self.board.log.faults.iter().all(FaultRecord::is_warning);
                return Ok(Some(if is_well { ExitCode::SUCCESS } else { self.faulted() }));
            }
            _ => {}
        }
        Ok(None)
    }

    /// Arms the rig as soon as the board allows it.
    fn arm(&mut self, state: State) -> anyhow::Result<()> {
        let waits = self.board.now().saturating_sub(self.begun) < READY;
        if state != State::Limp && waits {
            return Ok(());
        }
        if arm(self.board, waits)? {
            (self.phase, self.before) = (Phase::Arming, self.board.log.summaries);
        }
        Ok(())
    }

    /// Plays when the time has come: the way to the first pose then ends with the preroll.
    fn play(&mut self) -> anyhow::Result<()> {
        let now = self.board.now();
        let at = if let Some(at) = self.play_at {
            at
        } else {
            let approach = self.parts.approach(self.show, &self.board.log.q);
            if let Some(approach) = approach {
                let since_s = now.saturating_sub(self.begun).as_secs_f64();
                note(format_args!("{since_s:7.2} s  {}", approach_text(approach)));
            }
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
        tell_faults(self.board);
        ExitCode::FAILURE
    }

    /// Prints new states and faults; on a terminal also a live status.
    fn tell(&mut self) {
        let since_s = self.board.now().saturating_sub(self.begun).as_secs_f64();
        let Some(summary) = self.board.log.summary else { return };
        if self.state.replace(summary.state) != Some(summary.state) {
            self.bar.suspend(|| note(format_args!("{since_s:7.2} s  {}", summary.state)));
        }
        if self.phase == Phase::Playing && summary.show_ms > 0 && self.played.is_none() {
            // The clock started that long ago.
            let clock = Duration::from_millis(summary.show_ms.into());
            self.played = Some(self.board.now().saturating_sub(clock));
            let begun_s = since_s - clock.as_secs_f64();
            self.bar.suspend(|| note(format_args!("{begun_s:7.2} s  the show began")));
        }
        for fault in self.board.log.faults.iter().skip(self.faults) {
            self.bar.suspend(|| note(format_args!("{since_s:7.2} s  {}", named(fault.fault))));
        }
        self.faults = self.board.log.faults.len();
        if !self.bar.is_hidden() {
            self.bar.set_message(live(&summary));
        }
    }
}

fn live(summary: &Summary) -> String {
    let errors = summary.errors.map_or_else(String::new, |errors| {
        format!(", error {:.2} deg on average, {:.2} at most", errors.mean_deg, errors.largest_deg)
    });
    let supply = match summary.supply_v {
        0.0 => String::new(),
        v => format!(", supply {v:.2} V"),
    };
    let show_s = f64::from(summary.show_ms) * 1e-3;
    format!("{}, show {show_s:.2} s{errors}{supply}, tick {} us", summary.state, summary.tick_us)
}
