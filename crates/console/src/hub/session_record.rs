//! Recording of a console's session: its rows are computed from the board's telemetry.

use std::time::Duration;

use sinew_board_client::{Line, TelemetryLog};
use sinew_firmware::supervisor::Fault;
use sinew_link::message::{FaultRecord, State};
use sinew_performance::play::{Recorder, Tick, TickOfJoint};

use super::{Act, Hub, Refused};
use crate::message::{Level, ToPage};
use crate::scene::Scene;
use sinew_board_client::pose;

/// Number of rows per second, as many as pages get pictures. If less telemetry arrives, rows are repeated.
pub const RECORD_HZ: f64 = 30.0;

/// Longest time between a row and the newest summary of the board. Otherwise the state at the time of the row is
/// unknown.
const FRESH: Duration = Duration::from_millis(500);
/// Maximum number of rows in a turn of the hub. After a pause of the program many rows are due.
const ROWS: usize = 32;

/// A recording without rows.
pub struct NewRecord {
    /// Writer of the file.
    pub recorder: Recorder,
    /// Path of the file, for pages.
    pub file: String,
}

/// Creates a recording in a new file, or returns the reason why it cannot.
pub type BeginRecord<'a> = Box<dyn FnMut() -> Result<NewRecord, String> + 'a>;

/// Recordings of a session.
#[derive(Default)]
pub struct Records<'a> {
    /// Recording that begins with the session.
    pub first: Option<NewRecord>,
    /// Begins a recording that a page asks for; `None`: pages cannot record.
    pub begin: Option<BeginRecord<'a>>,
}

/// A recording in progress.
pub(super) struct SessionRecord {
    recorder: Recorder,
    file: String,
    rows: Rows,
    faults: Vec<String>,
}

/// Times of the rows of a recording.
#[derive(Debug, Default)]
struct Rows {
    /// Time of the first row, and number of rows so far.
    begun: Option<Duration>,
    count: u32,
    /// Number of summaries, and the time when it has changed.
    summaries: u32,
    heard: Duration,
}

impl Rows {
    /// Returns the rows that are due: the time since the first row, s, and whether the state of the rig is known then.
    fn due(&mut self, now: Duration, summaries: u32, is_lost: bool) -> Vec<(f64, bool)> {
        if std::mem::replace(&mut self.summaries, summaries) != summaries {
            self.heard = now;
        }
        let begun = *self.begun.get_or_insert(now);
        let since_s = now.saturating_sub(begun).as_secs_f64();
        let mut rows = Vec::new();
        while f64::from(self.count) <= since_s * RECORD_HZ && rows.len() < ROWS {
            let time_s = f64::from(self.count) / RECORD_HZ;
            let at = begun + Duration::from_secs_f64(time_s);
            rows.push((time_s, !is_lost && at.abs_diff(self.heard) <= FRESH));
            self.count += 1;
        }
        rows
    }
}

impl<L: Line> Hub<'_, L> {
    /// Begins a recording in a new file.
    pub(super) fn begin_record(&mut self) -> Result<String, Refused> {
        if let Some(record) = &self.record {
            return Err(Refused::Other(format!("{} is being recorded: end it first", record.file)));
        }
        if self.closing.is_some() {
            return Err(Refused::because("the program ends"));
        }
        let Some(begin) = &mut self.records.begin else {
            return Err(Refused::because("this console cannot record"));
        };
        let record = SessionRecord::new(begin().map_err(Refused::Other)?);
        let text = format!("recording into {}", record.file);
        self.record = Some(record);
        self.event(Level::Info, &text);
        self.tell_record();
        Ok(text)
    }

    /// Adds all rows that are due to the recording of the session. Ends the recording after an error.
    pub(super) fn go_on_record(&mut self) {
        let shows = matches!(self.act, Some(Act::Show(_)));
        let (now, log) = (self.board.now(), &self.board.log);
        let is_lost = self.lost.is_some();
        let Some(record) = &mut self.record else { return };
        let runs = shows && log.summary.is_some_and(|summary| summary.show_ms > 0);
        if let Err(error) = record.go_on(self.scene, log, (now, runs, is_lost)) {
            let _ = self.end_record(Some(error));
        }
    }

    /// Ends the recording. `error`: reason why the recording ends early. Reports the file, or the error, to all pages.
    /// Returns the text of this report.
    ///
    /// # Errors
    /// The text if the recording is not complete, or if there is no recording.
    pub(super) fn end_record(&mut self, error: Option<String>) -> Result<String, String> {
        let record = self.record.take().ok_or_else(|| "nothing is being recorded".to_owned())?;
        let (file, rows) = (record.file.clone(), record.rows.count);
        let ended = match error.or(record.end().err()) {
            None => {
                Ok(format!("the recording has ended: {file}, {:.1} s", f64::from(rows) / RECORD_HZ))
            }
            Some(error) => Err(format!("the recording {file} has ended: {error}")),
        };
        let (Ok(text) | Err(text)) = &ended;
        self.event(if ended.is_ok() { Level::Info } else { Level::Error }, text);
        self.tell_record();
        ended
    }

    /// Returns the file into which the session is recorded.
    pub(super) fn recorded(&self) -> Option<&str> {
        self.record.as_ref().map(|record| record.file.as_str())
    }

    fn tell_record(&self) {
        self.tell_all(&ToPage::Record { file: self.recorded() }.json());
    }
}

impl std::fmt::Debug for NewRecord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NewRecord").field("file", &self.file).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for Records<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Records").field("first", &self.first).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for SessionRecord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SessionRecord").field("rows", &self.rows.count).finish_non_exhaustive()
    }
}

impl SessionRecord {
    pub(super) fn new(NewRecord { recorder, file }: NewRecord) -> Self {
        Self { recorder, file, rows: Rows::default(), faults: Vec::new() }
    }

    pub(super) fn hear(&mut self, faults: &[FaultRecord]) {
        let name = |record: &FaultRecord| {
            let fault = Fault::ALL.into_iter().find(|fault| fault.number() == record.fault);
            fault.map_or_else(|| format!("fault {}", record.fault), |fault| fault.to_string())
        };
        self.faults.extend(faults.iter().map(name));
    }

    /// Adds the rows that are due. `runs`: whether the clock of a show runs; `is_lost`: whether the board does not
    /// answer. Values of a time without messages of the board are unknown.
    pub(super) fn go_on(
        &mut self,
        scene: &Scene,
        log: &TelemetryLog,
        (now, runs, is_lost): (Duration, bool, bool),
    ) -> Result<(), String> {
        let Some(summary) = log.summary else { return Ok(()) };
        for (time_s, is_known) in self.rows.due(now, log.summaries, is_lost) {
            let faults = std::mem::take(&mut self.faults);
            let faults = (!faults.is_empty()).then(|| faults.join(", "));
            let servo = |(index, servo): (usize, &sinew_link::message::Servo)| {
                // An older board reports only the lowest voltage of all servos.
                let own = log.supplies.get(index).copied();
                let voltage = Some(own.unwrap_or(summary.supply_v)).filter(|v| *v > 0.0);
                [None, servo.temperature_c.map(f32::from), voltage]
            };
            let tick = if is_known {
                Tick {
                    time_s,
                    state: Some(summary.state.to_string()),
                    runs: runs && summary.state == State::Playing,
                    faults,
                    joints: joints(scene, log),
                    servos: log.servos.iter().enumerate().map(servo).collect(),
                }
            } else {
                Tick { time_s, faults, ..Tick::default() }
            };
            self.recorder.put(&tick).map_err(|error| error.to_string())?;
        }
        Ok(())
    }

    /// Writes the end of the file.
    pub(super) fn end(self) -> Result<(), String> {
        self.recorder.end().map_err(|error| error.to_string())
    }
}

/// Returns the state of all dofs. Commands and errors are unknown while torque is off.
fn joints(scene: &Scene, log: &TelemetryLog) -> Vec<TickOfJoint> {
    if log.q.len() != scene.home.len() {
        return Vec::new();
    }
    let measured = pose::of_dofs(&scene.blocks, &log.q);
    let wanted = scene.commanded(log).map(|wanted| pose::of_dofs(&scene.blocks, &wanted));
    let joint = |(index, measured): (usize, &f32)| {
        let dof = log.dofs.get(index);
        let error = log.targets.get(index).copied().filter(|_| wanted.is_some());
        let commanded = wanted.as_ref().and_then(|wanted| wanted.get(index).copied());
        TickOfJoint {
            numbers: [commanded, Some(*measured), error, dof.map(|dof| dof.effort)],
            limiter: dof.and_then(|dof| dof.limiter).map(|limit| limit.name().to_owned()),
            swings: None,
        }
    };
    measured.iter().enumerate().map(joint).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_without_the_board_is_unknown() {
        let (mut rows, ms) = (Rows::default(), Duration::from_millis);
        let mut all = Vec::new();
        // The board speaks for 1 s, is silent, and is lost after 2 s.
        for turn in 0..300 {
            let summaries = 1 + u32::try_from(turn / 4).unwrap().min(25);
            all.extend(rows.due(ms(10 * turn), summaries, turn >= 200));
        }
        assert!((88..=91).contains(&all.len()), "{}", all.len());
        assert!(all.iter().all(|(time_s, is_known)| *is_known == (*time_s <= 1.501)), "{all:?}");
        // The program stands still for 10 s: its next turns are short, and nothing of the pause is known.
        let mut turns = 0;
        loop {
            turns += 1;
            let due = rows.due(ms(13_000 + 4 * turns), 100 + u32::try_from(turns).unwrap(), false);
            assert!(due.len() <= ROWS);
            assert!(due.iter().all(|(time_s, is_known)| !is_known || *time_s > 12.4), "{due:?}");
            if due.len() < ROWS {
                break;
            }
        }
        assert_eq!(turns, 10);
    }
}
