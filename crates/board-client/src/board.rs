//! A session with a controller.

use std::time::{Duration, SystemTime};

use sinew_link::message::{
    ACKNOWLEDGED_SINCE, About, Applied, Command, FaultRecord, Hello, Limit, Misfit, Outcome,
    Refusal, SnapshotPart, State, Stream, TELEMETRY_LEAST_HZ, TelemetryParts, TelemetrySetting,
    ToController, ToHost, Value, Version, Welcome,
};
use sinew_link::{Decoder, FRAME_MAX, Next, Sender, encode};

use crate::{ClientError, Line, TelemetryLog};

/// Interval between greetings while there is no session.
const HELLO_EVERY: Duration = Duration::from_millis(100);
/// Interval between heartbeats: a quarter of the time without a message after which the board holds the rig.
const BEAT_EVERY: Duration = Duration::from_millis(50);

/// Default time without a valid message after which a host that drives a rig counts as deaf.
pub const SILENCE: Duration = Duration::from_secs(1);
/// Shortest such time while torque is off: a board that erases flash sends nothing for up to 4 s.
const SILENCE_LIMP: Duration = Duration::from_secs(6);
/// Number of `Stop` commands that a deaf host sends, because a frame may be lost; and the wait after each.
const LAST_WORDS: (u32, Duration) = (3, Duration::from_millis(30));

/// A session with a controller.
#[derive(Debug)]
pub struct Board<L> {
    line: L,
    decoder: Decoder<ToHost>,
    sender: Sender,
    nonce: u32,
    welcome: Option<Welcome>,
    outcome: Option<Outcome>,
    beat_due: Duration,
    /// Time of the last valid message.
    heard: Duration,
    silence: Duration,
    /// Whether the host received nothing for too long. It then sends nothing more, except an e-stop.
    is_deaf: bool,
    /// Whether the rig is neither off nor limp nor faulted, by the latest message.
    is_driven: bool,
    /// Requested snapshots per second, Hz.
    telemetry_hz: f32,
    /// Telemetry and faults that the controller has sent on its own.
    pub log: TelemetryLog,
}

/// Returns a number for greetings that differs in each run of a program.
pub fn nonce() -> u32 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    since.subsec_nanos() ^ std::process::id().rotate_left(16)
}

impl<L: Line> Board<L> {
    /// Sends greetings until there is a session. If another program uses the rig, waits until the rig is free. `nonce`:
    /// see [`nonce()`].
    ///
    /// # Errors
    /// [`ClientError::NoController`] if nothing answers within `patience`; [`ClientError::Misfit`] if the versions
    /// differ, or another program still uses the rig after `patience`; [`ClientError::Line`].
    pub fn connect(line: L, nonce: u32, patience: Duration) -> Result<Self, ClientError> {
        match Self::connect_any(line, nonce, patience)? {
            (board, false) => Ok(board),
            (_, true) => Err(ClientError::Misfit(Misfit::Busy)),
        }
    }

    /// Sends greetings like [`Self::connect`]. Returns the board, and whether its rig belongs to another program. In
    /// this case there is no session, and the board executes only [`Command::Stop`] and [`Command::EStop`].
    ///
    /// # Errors
    /// As in [`Self::connect`], except that a rig of another program is not an error.
    pub fn connect_any(
        line: L,
        nonce: u32,
        patience: Duration,
    ) -> Result<(Self, bool), ClientError> {
        let mut board = Self {
            beat_due: line.now(),
            heard: line.now(),
            silence: SILENCE,
            is_deaf: false,
            is_driven: false,
            telemetry_hz: 0.0,
            line,
            decoder: Decoder::new(),
            sender: Sender::new(0),
            nonce: nonce.wrapping_sub(1),
            welcome: None,
            outcome: None,
            log: TelemetryLog::default(),
        };
        match board.reconnect(patience) {
            Err(ClientError::Misfit(Misfit::Busy)) => Ok((board, true)),
            greeted => greeted.map(|()| (board, false)),
        }
    }

    /// Starts a new session, for example after a restart of the board.
    ///
    /// # Errors
    /// As in [`Self::connect`].
    pub fn reconnect(&mut self, patience: Duration) -> Result<(), ClientError> {
        self.nonce = self.nonce.wrapping_add(1);
        (self.welcome, self.outcome, self.is_deaf) = (None, None, false);
        let end = self.line.now() + patience;
        let mut busy = false;
        while self.line.now() < end {
            let hello = Hello { protocol: Version::CURRENT, nonce: self.nonce };
            self.send(&ToController::Hello(hello))?;
            let again = (self.line.now() + HELLO_EVERY).min(end);
            while self.welcome.is_none() && self.line.now() < again {
                self.listen(again.saturating_sub(self.line.now()))?;
            }
            match self.welcome.map(|welcome| welcome.verdict) {
                Some(Ok(_)) => return Ok(()),
                Some(Err(Misfit::Busy)) => {
                    (busy, self.welcome) = (true, None);
                    self.listen(again.saturating_sub(self.line.now()))?;
                }
                Some(Err(misfit)) => return Err(ClientError::Misfit(misfit)),
                None => {}
            }
        }
        Err(if busy { ClientError::Misfit(Misfit::Busy) } else { ClientError::NoController })
    }

    /// Sets the time without a valid message after which the rig is stopped while it is driven; by default [`SILENCE`].
    /// While torque is off, the time is at least 6 s.
    pub fn set_silence(&mut self, silence: Duration) {
        self.silence = silence;
    }

    /// Returns the description of the controller from its answer to the greeting.
    pub fn about(&self) -> About {
        const NOBODY: About = About {
            protocol: Version::CURRENT,
            firmware: sinew_link::message::Release { major: 0, minor: 0, patch: 0 },
            rig: 0,
            capacities: sinew_link::message::Capacities {
                bodies: 0,
                coordinates: 0,
                dofs: 0,
                servos: 0,
                slots: 0,
                slot_bytes: 0,
            },
        };
        self.welcome.map_or(NOBODY, |welcome| welcome.about)
    }

    /// Returns the version of messages that both ends know.
    pub fn version(&self) -> Version {
        let minor = self.welcome.and_then(|welcome| welcome.verdict.ok()).unwrap_or(0);
        Version { major: Version::CURRENT.major, minor }
    }

    /// Checks that both ends know the messages of this minor version.
    ///
    /// # Errors
    /// [`ClientError::Old`] with both versions.
    pub fn needs(&self, minor: u8) -> Result<(), ClientError> {
        let has = self.version();
        let needs = Version { minor, ..has };
        if has.minor >= minor { Ok(()) } else { Err(ClientError::Old { needs, has }) }
    }

    /// Returns the line.
    pub fn line_mut(&mut self) -> &mut L {
        &mut self.line
    }

    /// Returns the time of the line's clock.
    pub fn now(&self) -> Duration {
        self.line.now()
    }

    /// Sends a command, repeatedly if necessary, until it is answered. Returns its result.
    ///
    /// # Errors
    /// [`ClientError::Refused`] if the board did not execute it; [`ClientError::SessionOver`];
    /// [`ClientError::Unexpected`] if the previous command has no answer yet; others as in [`Self::step`].
    pub fn ask(&mut self, command: Command) -> Result<Applied, ClientError> {
        self.ask_limited(command).map(|(applied, _)| applied)
    }

    /// Sends a command like [`Self::ask`]. Returns its result, and the limit that reduced it, if any.
    ///
    /// # Errors
    /// As in [`Self::ask`].
    pub fn ask_limited(
        &mut self,
        command: Command,
    ) -> Result<(Applied, Option<Limit>), ClientError> {
        // An emergency stop comes from a person, and is always sent.
        if self.is_deaf && command != Command::EStop {
            return Err(ClientError::Deaf(self.silence));
        }
        self.outcome = None;
        let busy = |_| ClientError::Unexpected("the command before");
        let command = self.sender.send(command, self.now_ms()).map_err(busy)?;
        self.send(&ToController::Command(command))?;
        loop {
            if let Some(outcome) = self.outcome.take() {
                return match outcome {
                    Outcome::Applied(applied) => Ok((applied, None)),
                    Outcome::Limited(applied, limit) => Ok((applied, Some(limit))),
                    Outcome::Refused(Refusal::Session) => Err(ClientError::SessionOver),
                    Outcome::Refused(refusal) => Err(ClientError::Refused(refusal)),
                    Outcome::Working => Err(ClientError::Unexpected("a command")),
                };
            }
            self.step(BEAT_EVERY)?;
        }
    }

    /// Receives messages for at most `wait`. Before it, sends what is due: a heartbeat, or a command that is not
    /// answered yet.
    ///
    /// # Errors
    /// [`ClientError::Line`], [`ClientError::NoAnswer`]; [`ClientError::Deaf`] if no valid message arrived for too
    /// long.
    pub fn step(&mut self, wait: Duration) -> Result<(), ClientError> {
        if self.is_deaf {
            return Err(ClientError::Deaf(self.silence));
        }
        if self.line.now() >= self.beat_due {
            self.beat()?;
        }
        match self.sender.poll(self.now_ms()) {
            Next::Send(command) => self.send(&ToController::Command(command))?,
            Next::GaveUp(command) => return Err(ClientError::NoAnswer(Box::new(command.item))),
            Next::Idle | Next::Wait => {}
        }
        self.listen(wait.min(self.beat_due.saturating_sub(self.line.now())))?;
        self.watch()
    }

    /// Sends a heartbeat. It contains the number of the newest telemetry frame if the controller supports this.
    fn beat(&mut self) -> Result<(), ClientError> {
        self.beat_due = self.line.now() + BEAT_EVERY;
        let heard = self.log.heard().filter(|_| self.acknowledges());
        let beat = self.sender.stream(heard.map_or(Stream::Heartbeat, Stream::Heard));
        self.send(&ToController::Stream(beat))
    }

    fn acknowledges(&self) -> bool {
        self.version().minor >= ACKNOWLEDGED_SINCE
    }

    /// Ends the session if telemetry is on and nothing was received for too long: sends `Stop`, and then nothing more
    /// except an emergency stop. The board then moves its rig to the rest pose, or holds, and lowers it on its own.
    fn watch(&mut self) -> Result<(), ClientError> {
        let told_hz = if self.is_driven && self.acknowledges() {
            self.telemetry_hz.max(TELEMETRY_LEAST_HZ)
        } else {
            self.telemetry_hz
        };
        let silence = if self.is_driven { self.silence } else { self.silence.max(SILENCE_LIMP) };
        let silent = self.line.now().saturating_sub(self.heard);
        // At a low telemetry rate, three successive snapshots must be missing.
        if told_hz <= 0.0 || silent < silence || silent.as_secs_f32() < 3.0 / told_hz {
            return Ok(());
        }
        let (times, pause) = LAST_WORDS;
        for _ in 0..times {
            if let Ok(stop) = self.sender.send(Command::Stop, self.now_ms()) {
                self.send(&ToController::Command(stop))?;
            }
            self.listen(pause)?;
        }
        self.is_deaf = true;
        Err(ClientError::Deaf(self.silence))
    }

    /// Receives messages for a time, like [`Self::step`].
    ///
    /// # Errors
    /// As in [`Self::step`].
    pub fn run(&mut self, time: Duration) -> Result<(), ClientError> {
        let end = self.line.now() + time;
        while self.line.now() < end {
            self.step(end.saturating_sub(self.line.now()))?;
        }
        Ok(())
    }

    /// Sends an item of the stream once; it has no answer.
    ///
    /// # Errors
    /// [`ClientError::Line`], [`ClientError::Deaf`]; [`ClientError::Refused`] if a number is not finite.
    pub fn stream(&mut self, stream: Stream) -> Result<(), ClientError> {
        if self.is_deaf {
            return Err(ClientError::Deaf(self.silence));
        }
        let numbered = self.sender.stream(stream);
        self.send(&ToController::Stream(numbered))
    }

    /// Requests telemetry. Returns the rate and the parts that the controller sends.
    ///
    /// # Errors
    /// As in [`Self::ask`].
    pub fn telemetry(
        &mut self,
        rate_hz: f32,
        parts: TelemetryParts,
    ) -> Result<TelemetrySetting, ClientError> {
        match self.ask(Command::SetTelemetry(TelemetrySetting { rate_hz, parts }))? {
            Applied::Telemetry(setting) => {
                self.telemetry_hz = setting.rate_hz;
                Ok(setting)
            }
            _ => Err(ClientError::Unexpected("the telemetry")),
        }
    }

    /// Returns the state from the newest summary; `None` before the first.
    pub fn state(&self) -> Option<State> {
        self.log.summary.map(|summary| summary.state)
    }

    /// Waits for a summary that is newer than this call, and returns its state. Telemetry must be on.
    ///
    /// # Errors
    /// As in [`Self::step`]; [`ClientError::Impatient`] if no summary arrives within `patience`.
    pub fn fresh_state(&mut self, patience: Duration) -> Result<State, ClientError> {
        let (before, end) = (self.log.summaries, self.line.now() + patience);
        while self.line.now() < end {
            self.step(BEAT_EVERY)?;
            if self.log.summaries != before
                && let Some(state) = self.state()
            {
                return Ok(state);
            }
        }
        Err(ClientError::Impatient("the controller sends no telemetry".to_owned()))
    }

    /// Reads the log of faults: the first fault since faults were cleared, then the stored faults from the latest to
    /// the earliest, then the last warning. If no fault has occurred since then, the log contains only the warning, if
    /// there is one.
    ///
    /// # Errors
    /// As in [`Self::ask`].
    pub fn fault_log(&mut self) -> Result<Vec<FaultRecord>, ClientError> {
        let mut records = Vec::new();
        for index in 0..u16::MAX {
            let Applied::Fault(report) = self.ask(Command::ReadFault { index })? else {
                return Err(ClientError::Unexpected("the log of faults"));
            };
            let Some(record) = report.record else { break };
            records.push(record);
            if index + 1 >= report.count {
                break;
            }
        }
        Ok(records)
    }

    /// Reads a setting by its key.
    ///
    /// # Errors
    /// As in [`Self::ask`].
    pub fn setting(&mut self, key: u16) -> Result<f32, ClientError> {
        number(&self.ask(Command::ReadSetting { key })?)
    }

    /// Writes a setting. Returns the value that the board has stored. The board then restarts: see [`Self::reconnect`].
    ///
    /// # Errors
    /// As in [`Self::ask`].
    pub fn set_setting(&mut self, key: u16, value: f32) -> Result<f32, ClientError> {
        number(&self.ask(Command::WriteSetting { key, value: Value::Number(value) })?)
    }

    fn now_ms(&self) -> u32 {
        // The clock may wrap to 0: only differences matter.
        (self.line.now().as_millis() & u128::from(u32::MAX)).try_into().unwrap_or(0)
    }

    fn send(&mut self, message: &ToController) -> Result<(), ClientError> {
        let mut out = [0; FRAME_MAX];
        // If a number is not finite, nothing may be sent.
        let frame = encode(message, &mut out).map_err(|_| ClientError::Refused(Refusal::Value))?;
        self.line.send(frame).map_err(ClientError::Line)
    }

    fn listen(&mut self, wait: Duration) -> Result<(), ClientError> {
        let mut bytes = [0; 1024];
        let count = self.line.receive(&mut bytes, wait).map_err(ClientError::Line)?;
        let mut messages = Vec::new();
        self.decoder.feed(bytes.get(..count).unwrap_or_default(), |message| messages.push(message));
        for message in messages {
            self.take(message);
        }
        Ok(())
    }

    fn take(&mut self, message: ToHost) {
        self.heard = self.line.now();
        match message {
            ToHost::Welcome(welcome) if welcome.nonce == self.nonce => {
                if self.welcome.is_none() && welcome.verdict.is_ok() {
                    self.sender = Sender::new(welcome.session);
                    self.log = TelemetryLog::default();
                    (self.is_driven, self.telemetry_hz) = (false, 0.0);
                }
                self.welcome = self.welcome.or(Some(welcome));
            }
            ToHost::Answer(answer) => {
                if let Some(outcome) = self.sender.take(&answer) {
                    if let Outcome::Applied(Applied::State(state)) = outcome {
                        self.is_driven = is_driven(state);
                    }
                    self.outcome = Some(outcome);
                }
            }
            ToHost::Telemetry(telemetry) => {
                if let SnapshotPart::Summary(summary) = &telemetry.part {
                    self.is_driven = is_driven(summary.state);
                }
                self.log.take(telemetry);
            }
            ToHost::Fault(fault) => self.log.faults.push(fault),
            ToHost::Welcome(_) => {}
        }
    }
}

/// Returns `true` unless the rig is off, limp or faulted.
fn is_driven(state: State) -> bool {
    !matches!(state, State::Off | State::Limp | State::Faulted)
}

fn number(applied: &Applied) -> Result<f32, ClientError> {
    match *applied {
        Applied::Setting(Value::Number(value)) => Ok(value),
        _ => Err(ClientError::Unexpected("a setting")),
    }
}
