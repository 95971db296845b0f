//! Records a rig on a controller that a person leads by hand, until Ctrl-C.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use sinew_board_client::{ClientError, SerialBoard};
use sinew_console::{Hosted, Owner, Scene, Source};
use sinew_host_util::command::note;
use sinew_link::message::{Command, FaultRecord, Refusal, State, TelemetryParts};
use sinew_performance::play::RigParts;
use sinew_performance::rig::LoadedRig;
use sinew_performance::teach::{Mode, ReceivedError, check_servos, rows};
use sinew_retarget::feasibility::RigMotion;

use crate::cli::board::{
    PortBoard, READY, arm, check_rig, clear_lost_link, end_by_hand, open, tell_faults,
};
use crate::cli::stop::Stop;

/// Poses per second. Motion by hand has almost no parts above 6 Hz.
const RATE_HZ: f32 = 100.0;
/// Time between two checks of the state.
const LOOK: Duration = Duration::from_millis(20);

/// Returns the motion that was measured from the start of `teaching` or `floating` to Ctrl-C, or for `seconds`; and the
/// error that ended it early, if any.
pub(super) fn led(
    port: &Path,
    silence: Duration,
    rig: &LoadedRig,
    parts: &RigParts,
    mode: Mode,
    seconds: Option<f64>,
) -> anyhow::Result<(RigMotion, anyhow::Result<()>)> {
    check_servos(parts, mode)?;
    let (mut board, name) = open(Some(port), "--target")?;
    board.set_silence(silence);
    check_rig(&board, parts)?;
    // Asks for telemetry at every tick: only the board knows the length of a tick.
    let tick_s = f64::from(board.telemetry(f32::MAX, TelemetryParts::SUMMARY)?.rate_hz).recip();
    // Commands that watch show the servos.
    let of_watchers = TelemetryParts::SUMMARY.and(TelemetryParts::SERVOS);
    let told = board.telemetry(RATE_HZ, of_watchers.and(TelemetryParts::POSE))?;
    ensure!(told.rate_hz > 0.0, "the controller sends no poses");
    if board.fresh_state(READY)? == State::Faulted {
        clear_lost_link(&mut board)?;
    }
    let scene = Scene::new(&rig.description.name, &rig.mechanism, parts, Source::Board);
    let hosted = Hosted::open(&mut board, &scene, Owner::Drives("record"), Some(&name));
    let hosted = hosted.context("the socket for other commands")?;
    let mut session = TeachSession { hosted, stop: Stop::new()?, state: None, bar: bar()? };
    let led = session.run(mode, seconds);
    session.bar.finish_and_clear();
    // Also after an error, the rig is stopped, and this function waits until it is limp. A second Ctrl-C ends the wait.
    let stopped = session.limp();
    let ended = led.and(stopped);
    let mut poses = session.hosted.board_mut().log.poses.take().unwrap_or_default();
    let dt_s = f64::from(told.rate_hz).recip();
    let why = match rows(&rig.mechanism, &poses, tick_s, dt_s) {
        Ok(motion) => return Ok((motion, ended)),
        Err(why) => why,
    };
    // Motion in a gap is unknown. The motion before the gap is kept.
    let first = poses.first().map_or(0, |pose| pose.tick);
    let until_s = if let ReceivedError::Gap { at_s, .. } = why { at_s } else { 0.0 };
    poses.retain(|pose| f64::from(pose.tick.wrapping_sub(first)) * tick_s <= until_s);
    let why = ended.err().unwrap_or_else(|| why.into());
    match rows(&rig.mechanism, &poses, tick_s, dt_s) {
        Ok(motion) => Ok((motion, Err(why))),
        Err(_) => Err(why),
    }
}

fn bar() -> anyhow::Result<ProgressBar> {
    Ok(ProgressBar::new_spinner().with_style(ProgressStyle::with_template("{msg}")?))
}

struct TeachSession<'a> {
    hosted: Hosted<'a, SerialBoard>,
    stop: Stop,
    state: Option<State>,
    bar: ProgressBar,
}

impl TeachSession<'_> {
    fn board(&mut self) -> &mut PortBoard {
        self.hosted.board_mut()
    }

    fn run(&mut self, mode: Mode, seconds: Option<f64>) -> anyhow::Result<()> {
        let taught = if mode == Mode::Float { State::Floating } else { State::Teaching };
        let begun = self.board().now();
        while self.look()? != Some(taught) {
            if self.stop.times() > 0 || self.hosted.is_stopped() {
                bail!("ended before the rig could be led");
            }
            let waits = self.board().now().saturating_sub(begun) < READY;
            match (mode, self.state) {
                (Mode::Limp, Some(State::Limp)) => self.ask(Command::Teach, waits)?,
                (_, Some(state @ (State::Calibrating | State::Teaching))) => {
                    end_by_hand(self.board(), state)?;
                }
                (Mode::Float, Some(State::Limp)) => {
                    arm(self.board(), waits)?;
                }
                (Mode::Float, Some(State::Holding)) => self.ask(Command::Float, false)?,
                (_, state) if !waits => bail!(
                    "the rig is still {} after {} s",
                    state.map_or_else(|| "silent".to_owned(), |state| state.to_string()),
                    READY.as_secs()
                ),
                _ => {}
            }
        }
        let until = seconds.map_or_else(String::new, |seconds| format!(", or {seconds} s"));
        note(format_args!("lead it; Ctrl-C ends it{until}"));
        let begun = self.board().now();
        self.board().log.poses = Some(Vec::new());
        loop {
            let state = self.look()?;
            if self.hosted.is_stopped() {
                return Ok(());
            }
            if state != Some(taught) {
                bail!("the rig is not led any more");
            }
            let since_s = self.board().now().saturating_sub(begun).as_secs_f64();
            if !self.bar.is_hidden() {
                self.bar.set_message(format!("{taught}, {since_s:.1} s"));
            }
            if self.stop.times() > 0 || seconds.is_some_and(|seconds| since_s >= seconds) {
                return Ok(());
            }
        }
    }

    /// Brings the rig to rest, and waits until it is limp. The motion does not contain poses from this time.
    fn limp(&mut self) -> anyhow::Result<()> {
        let poses = self.board().log.poses.take();
        let limp = self.stop_and_wait();
        self.board().log.poses = poses;
        limp
    }

    fn stop_and_wait(&mut self) -> anyhow::Result<()> {
        if !matches!(self.state, Some(State::Limp | State::Off | State::Faulted) | None) {
            if !self.hosted.is_stopped() {
                self.board().ask(Command::Stop)?;
            }
            // A first signal ends the leading, or comes on the way down; a second one ends the program.
            let times = self.stop.times().max(1);
            while !matches!(self.look()?, Some(State::Limp | State::Off | State::Faulted)) {
                if self.stop.times() > times {
                    bail!(
                        "ended at once: the board holds the pose; after 2 s it lowers the rig, then torque is off"
                    );
                }
            }
        }
        Ok(())
    }

    fn ask(&mut self, command: Command, waits: bool) -> anyhow::Result<()> {
        match self.board().ask(command) {
            Err(ClientError::Refused(Refusal::RegistersUnread | Refusal::NotMeasured)) if waits => {
                Ok(())
            }
            Err(ClientError::Refused(why)) => bail!("the controller refused: {why}"),
            done => Ok(done.map(|_| ())?),
        }
    }

    /// Receives messages until there is a summary that is newer than this call, or until a second signal asks this
    /// program to end. Returns the last known state. Fails if the board reports a fault other than a warning.
    fn look(&mut self) -> anyhow::Result<Option<State>> {
        let before = self.board().log.summaries;
        while self.board().log.summaries < before + 2 {
            self.hosted.step(LOOK)?;
            if self.stop.times() > 1 {
                break;
            }
        }
        let state = self.board().state();
        if self.state != state {
            self.state = state;
            if let Some(state) = state {
                self.bar.suspend(|| note(format_args!("{state}")));
            }
        }
        if state == Some(State::Faulted)
            || !self.board().log.faults.iter().all(FaultRecord::is_warning)
        {
            tell_faults(self.board());
            bail!("a fault has ended it");
        }
        Ok(state)
    }
}
