//! Recording of a console's session: its rows are computed from the board's telemetry.

use std::time::Duration;

use sinew_board_client::TelemetryLog;
use sinew_firmware::supervisor::Fault;
use sinew_link::message::{FaultRecord, State};
use sinew_performance::play::{Recorder, Tick, TickOfJoint};

use crate::scene::Scene;
use sinew_board_client::pose;

/// Number of rows per second, as many as pages get pictures. If less telemetry arrives, rows are repeated.
pub const RECORD_HZ: f64 = 30.0;

/// A recording in progress.
pub(super) struct SessionRecord {
    recorder: Recorder,
    /// Time of the first row, and number of rows so far.
    begun: Option<Duration>,
    rows: u32,
    faults: Vec<String>,
}

impl std::fmt::Debug for SessionRecord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SessionRecord").field("rows", &self.rows).finish_non_exhaustive()
    }
}

impl SessionRecord {
    pub(super) fn new(recorder: Recorder) -> Self {
        Self { recorder, begun: None, rows: 0, faults: Vec::new() }
    }

    pub(super) fn hear(&mut self, faults: &[FaultRecord]) {
        let name = |record: &FaultRecord| {
            let fault = Fault::ALL.into_iter().find(|fault| fault.number() == record.fault);
            fault.map_or_else(|| format!("fault {}", record.fault), |fault| fault.to_string())
        };
        self.faults.extend(faults.iter().map(name));
    }

    /// Adds all rows that are due. `runs`: whether the clock of a show runs.
    pub(super) fn go_on(
        &mut self,
        scene: &Scene,
        log: &TelemetryLog,
        (now, runs): (Duration, bool),
    ) -> Result<(), String> {
        let Some(summary) = log.summary else { return Ok(()) };
        let since = now.saturating_sub(*self.begun.get_or_insert(now));
        while f64::from(self.rows) <= since.as_secs_f64() * RECORD_HZ {
            let faults = std::mem::take(&mut self.faults);
            let servo = |servo: &sinew_link::message::Servo| {
                let voltage = Some(summary.supply_v).filter(|v| *v > 0.0);
                [None, servo.temperature_c.map(f32::from), voltage]
            };
            let tick = Tick {
                time_s: f64::from(self.rows) / RECORD_HZ,
                state: summary.state.to_string(),
                runs: runs && summary.state == State::Playing,
                faults: (!faults.is_empty()).then(|| faults.join(", ")),
                joints: joints(scene, log),
                servos: log.servos.iter().map(servo).collect(),
            };
            self.recorder.put(&tick).map_err(|error| error.to_string())?;
            self.rows += 1;
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
