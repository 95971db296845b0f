//! The tick of the controller: computes limited efforts from targets and measurements.

use std::sync::{Mutex, PoisonError};

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use sinew_core::Workspace;
use sinew_core::control::{LimitReason, TorqueLimit};
use sinew_core::coordinates::DofCommand;
use sinew_core::tracker::{
    Frame, FrameSource, Measured, ResolvedTracker, Settings, Timing, Tracker, TrackerError,
};
use sinew_evaluation::CAPACITY;
use sinew_rig::mechanism::{JointModel, Link};

use crate::arrays::single;
use crate::error::value;
use crate::rig::NativeRig;

/// A tracker of a rig, and the number of its next tick.
#[pyclass(frozen, module = "sinew_motion._sinew_motion")]
pub(crate) struct NativeTracker {
    state: Mutex<(Box<ResolvedTracker<CAPACITY>>, i32)>,
    nq: usize,
    nv: usize,
}

/// Targets of a tick, at the time when its efforts act.
struct Given {
    q: Vec<f32>,
    qd: Vec<f32>,
    qdd: Vec<f32>,
}

impl FrameSource for Given {
    fn frame(&mut self, _index: i32) -> Frame<'_> {
        Frame::Coordinates { q: &self.q, qd: &self.qd, qdd: &self.qdd }
    }

    fn has_coordinates_alone(&self) -> bool {
        true
    }
}

/// Returns the limit of a joint's drive according to the rig's file.
fn limit(link: &Link) -> TorqueLimit {
    let effort = single(link.effort);
    let limit = match link.joint {
        JointModel::Prismatic(_) => TorqueLimit::new(f32::INFINITY, effort),
        JointModel::Fixed | JointModel::Free => Ok(TorqueLimit::NONE),
        _ => TorqueLimit::new(effort, f32::INFINITY),
    };
    // Efforts in a rig are above zero. A joint without an effort has no limit.
    limit.unwrap_or(TorqueLimit::NONE)
}

fn reason(reason: LimitReason) -> &'static str {
    match reason {
        LimitReason::Torque => "torque",
        LimitReason::Force => "force",
        LimitReason::NotFinite => "not_finite",
        LimitReason::NoRoom => "no_room",
        LimitReason::Supply => "supply",
        _ => "limited",
    }
}

/// Commands of a tick for each dof: efforts, their feed-forward parts, and the limits that acted on them.
type Applied = (Vec<f64>, Vec<f64>, Vec<Option<&'static str>>);

#[pymethods]
impl NativeTracker {
    #[new]
    fn new(
        rig: PyRef<'_, NativeRig>,
        settings: &str,
        rate_hz: f64,
        latency_ticks: usize,
    ) -> PyResult<Self> {
        // The negation also refuses NaN.
        if !(1.0..=100_000.0).contains(&rate_hz) {
            return Err(value(format!("rate_hz: expected 1 to 100000 Hz, found {rate_hz}")));
        }
        let settings: Settings =
            serde_json::from_str(settings).map_err(|error| value(format!("settings: {error}")))?;
        let mechanism = &rig.loaded.mechanism;
        if mechanism.bodies.len() > CAPACITY {
            let found = mechanism.bodies.len();
            return Err(value(format!(
                "expected a rig of at most {CAPACITY} bodies, found {found}"
            )));
        }
        let limits: Vec<TorqueLimit> = mechanism.bodies.iter().map(limit).collect();
        let timing = Timing { dt_s: single(rate_hz.recip()), latency_ticks };
        let tree = mechanism.tree::<CAPACITY>().map_err(value)?;
        let (nq, nv) = (tree.coordinate_count(), tree.dof_count());
        settings.check().map_err(|error| value(TrackerError::from(error)))?;
        let tracker = Tracker::with_workspace(tree, &settings, timing, Workspace::resolving())
            .map_err(value)?
            .with_limits(&limits)
            .map_err(value)?;
        Ok(Self { state: Mutex::new((Box::new(tracker), 0)), nq, nv })
    }

    fn step(
        &self,
        q_desired: PyReadonlyArray1<'_, f64>,
        qd_desired: PyReadonlyArray1<'_, f64>,
        qdd_desired: PyReadonlyArray1<'_, f64>,
        q: PyReadonlyArray1<'_, f64>,
        qd: Option<PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<Applied> {
        let row = |name: &str, array: &PyReadonlyArray1<'_, f64>, expected: usize| {
            let numbers: Vec<f32> = array.as_array().iter().copied().map(single).collect();
            if numbers.len() == expected {
                return Ok(numbers);
            }
            let found = numbers.len();
            Err(value(format!("{name}: expected {expected} numbers, found {found}")))
        };
        let mut given = Given {
            q: row("q_desired", &q_desired, self.nq)?,
            qd: row("qd_desired", &qd_desired, self.nv)?,
            qdd: row("qdd_desired", &qdd_desired, self.nv)?,
        };
        let q = row("q", &q, self.nq)?;
        let qd = qd.map(|qd| row("qd", &qd, self.nv)).transpose()?;
        let measured = match &qd {
            Some(qd) => Measured::Coordinates { q: &q, qd },
            None => Measured::Positions { q: &q },
        };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let (tracker, index) = &mut *state;
        let mut tick = tracker.step(&mut given, *index, measured).map_err(value)?;
        *index = index.saturating_add(1);
        let mut commands = vec![DofCommand::default(); self.nv];
        tick.dof_commands(&mut commands).map_err(value)?;
        let mut efforts = vec![0.0; self.nv];
        tick.efforts(&mut efforts).map_err(value)?;
        let feedforward = commands.iter().map(|of| f64::from(of.feedforward_effort)).collect();
        let limited = commands.iter().map(|of| of.limited.map(reason)).collect();
        Ok((efforts.into_iter().map(f64::from).collect(), feedforward, limited))
    }

    fn skip(&self, ticks: u16) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.0.skip(ticks);
        state.1 = state.1.saturating_add(i32::from(ticks));
    }
}
