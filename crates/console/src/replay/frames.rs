//! Rows of a recording as the binary frames that pages show.

use sinew_link::message::{Dof, Servo, State};
use sinew_performance::play::{Part, Recording, RecordingError, RigParts};
use thiserror::Error;

use crate::frame::{Frame, PLAYS};
use crate::hub::RATE_HZ;
use crate::scene::{LIMITS, Scene};
use sinew_board_client::pose;

/// Reason why a recording cannot be shown.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording does not contain its rate.
    #[error("does not say at what rate it was made")]
    Rate,
    /// The rig has a joint that was not recorded.
    #[error("the rig has a joint {0:?}, which was not recorded: it is another rig")]
    NotRecorded(String),
}

/// A recording that pages can show; it keeps at most 30 rows a second.
#[derive(Debug)]
pub struct Replay {
    pub(super) rate_hz: f32,
    pub(super) duration_s: f64,
    rows: Vec<Row>,
    /// Faults and changes of the state, with their times, s.
    pub(super) events: Vec<(f64, String)>,
}

/// State of the rig at a moment.
#[derive(Debug)]
struct Row {
    state: u8,
    measured: Vec<f32>,
    wanted: Vec<f32>,
    dofs: Vec<Dof>,
    servos: Vec<Servo>,
    /// Supply voltages of servos, V; 0 if not known.
    supplies: Vec<f32>,
    supply_v: f32,
}

/// Index of the recording's column for each dof and for each servo of the rig.
struct Columns {
    dofs: Vec<usize>,
    servos: Vec<Option<usize>>,
}

impl Replay {
    /// Reads a recording of a rig. O(rows · joints).
    ///
    /// # Errors
    /// [`ReplayError`].
    pub fn new(
        recording: &Recording,
        scene: &Scene,
        parts: &RigParts,
    ) -> Result<Self, ReplayError> {
        let rate_hz: Option<f64> = recording.note("rate_hz").and_then(|text| text.parse().ok());
        let rate_hz = rate_hz.filter(|hz| hz.is_finite() && *hz > 0.0).ok_or(ReplayError::Rate)?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
        let every = (rate_hz / f64::from(RATE_HZ)).round().max(1.0) as usize;
        let columns = Columns::of(recording, scene, parts)?;
        #[expect(clippy::cast_possible_truncation, reason = "a frame has f32")]
        let mut replay = Self {
            rate_hz: (rate_hz / every as f64) as f32,
            duration_s: recording.rows() as f64 / rate_hz,
            rows: Vec::new(),
            events: Vec::new(),
        };
        let (mut row, mut state) = (0_usize, None);
        for part in recording.parts() {
            let part = part?;
            for at in 0..part.time_s.len() {
                let t_s = row as f64 / rate_hz;
                if part.states[at] != state {
                    state.clone_from(&part.states[at]);
                    replay.events.extend(state.clone().map(|state| (t_s, state)));
                }
                replay.events.extend(part.faults[at].clone().map(|fault| (t_s, fault)));
                if row.is_multiple_of(every) {
                    replay.rows.push(columns.row(&part, at, scene));
                }
                row += 1;
            }
        }
        Ok(replay)
    }

    /// Returns the binary frame of a moment. `t_s`: time on the hub's clock; `place_s`: time in the recording.
    pub(super) fn frame(&self, scene: &Scene, t_s: f32, place_s: f64, is_running: bool) -> Vec<u8> {
        let none = Row {
            state: 0,
            measured: Vec::new(),
            wanted: Vec::new(),
            dofs: Vec::new(),
            servos: Vec::new(),
            supplies: Vec::new(),
            supply_v: 0.0,
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within it")]
        let at = (place_s * f64::from(self.rate_hz)) as usize;
        let row = self.rows.get(at.min(self.rows.len().saturating_sub(1))).unwrap_or(&none);
        #[expect(clippy::cast_possible_truncation, reason = "a frame has f32")]
        let place_s = Some(place_s as f32);
        Frame {
            state: row.state,
            fault: None,
            flags: if is_running { PLAYS } else { 0 },
            t_s,
            place_s,
            supply_v: row.supply_v,
            tick_us: 0,
            counts: scene.counts(),
            measured: &row.measured,
            wanted: &row.wanted,
            ghost: None,
            dofs: &row.dofs,
            servos: &row.servos,
            supplies: &row.supplies,
        }
        .bytes()
    }
}

impl Columns {
    fn of(recording: &Recording, scene: &Scene, parts: &RigParts) -> Result<Self, ReplayError> {
        let find = |names: &[String], name: &str| names.iter().position(|own| own == name);
        let dofs = scene.dofs.iter().map(|dof| {
            let column = find(recording.joints(), &dof.name);
            column.ok_or_else(|| ReplayError::NotRecorded(dof.name.clone()))
        });
        let servos = parts.servos.iter().map(|part| {
            // A servo that has the name of a joint is recorded as `NAME.servo`.
            let own = format!("{}.servo", part.own.name);
            find(recording.servos(), &own).or_else(|| find(recording.servos(), &part.own.name))
        });
        Ok(Self { dofs: dofs.collect::<Result<_, _>>()?, servos: servos.collect() })
    }

    fn row(&self, part: &Part, at: usize, scene: &Scene) -> Row {
        let state = part.states[at].as_deref();
        let state = State::ALL.into_iter().find(|own| Some(own.to_string().as_str()) == state);
        let joints = || self.dofs.iter().map(|column| &part.joints[*column]);
        let commanded: Vec<f32> = joints().map(|rows| rows.commanded[at]).collect();
        // Hobby servos report no position: the page shows their commanded position.
        let measured = joints().zip(&commanded).map(|(rows, commanded)| {
            let measured = rows.measured[at];
            if measured.is_nan() { *commanded } else { measured }
        });
        let measured: Vec<f32> = measured.collect();
        let dofs = joints().map(|rows| {
            let limiter = rows.limiter[at].as_deref();
            let limiter = LIMITS.into_iter().find(|limit| Some(limit.name()) == limiter);
            Dof { effort: rows.effort[at], limiter, target: 0 }
        });
        let servos = self.servos.iter().map(|column| {
            let celsius = column.map_or(f32::NAN, |column| part.servos[column].temperature[at]);
            #[expect(clippy::cast_possible_truncation, reason = "it saturates")]
            let temperature_c = celsius.is_finite().then_some(celsius as i8);
            Servo { temperature_c, heat_percent: 0, bus_errors: 0, hardware_error: 0, supply: 0 }
        });
        let volts = |column: &Option<usize>| {
            let volts = column.map_or(0.0, |column| part.servos[column].voltage[at]);
            if volts.is_finite() { volts } else { 0.0 }
        };
        let supplies: Vec<f32> = self.servos.iter().map(volts).collect();
        let is_on = !matches!(state, None | Some(State::Off | State::Limp | State::Faulted));
        Row {
            state: state.map_or(0, State::number),
            wanted: if is_on { positions(scene, &commanded) } else { Vec::new() },
            measured: positions(scene, &measured),
            dofs: dofs.collect(),
            servos: servos.collect(),
            supply_v: supplies.iter().copied().filter(|v| *v > 0.0).reduce(f32::min).unwrap_or(0.0),
            supplies,
        }
    }
}

/// Returns the coordinates of a pose from the positions of its dofs. The positions of a ball joint are a rotation
/// vector.
fn positions(scene: &Scene, dofs: &[f32]) -> Vec<f32> {
    let mut rest = vec![0.0; scene.home.len()];
    for (first, _) in scene.blocks.iter().filter(|(_, count)| *count == 4) {
        rest[first + 3] = 1.0;
    }
    pose::with_offsets(&scene.blocks, &rest, dofs)
}
