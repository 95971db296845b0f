//! Recorded clips, in metres and with y up.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;
use sinew_figure::measured::UnitOverrides;
use sinew_mocap::files::ClipFile;
use sinew_mocap::{Clip, JointSample, Up};
use sinew_performance::{ClipSettings, PreparedClip};

use crate::arrays::array;
use crate::error::value;

/// A clip, which is shared by all objects that are made from it.
#[pyclass(frozen, module = "sinew_motion._sinew_motion")]
pub(crate) struct NativeClip {
    pub(crate) prepared: Arc<PreparedClip>,
}

impl NativeClip {
    /// Returns the motion.
    pub(crate) fn clip(&self) -> &Clip {
        &self.prepared.clip
    }
}

/// Reads a clip from a file, or a built-in clip.
#[pyfunction]
pub(crate) fn read_clip(
    py: Python<'_>,
    path: PathBuf,
    cutoff_hz: Option<f64>,
    seconds: Option<f64>,
    metres_per_unit: Option<f64>,
    up: Option<&str>,
) -> PyResult<NativeClip> {
    let up = up.map(|axis| axis.parse::<Up>().map_err(value)).transpose()?;
    if let Some(found) = cutoff_hz.filter(|hz| !(0.0..=1000.0).contains(hz)) {
        return Err(value(format!(
            "cutoff_hz: expected a number of Hz from 0 to 1000, found {found}"
        )));
    }
    if let Some(found) = seconds.filter(|s| !(*s > 0.0 && s.is_finite())) {
        return Err(value(format!("seconds: expected a number above 0, found {found}")));
    }
    check_unit(metres_per_unit)?;
    let settings = ClipSettings {
        cutoff_hz: cutoff_hz.filter(|hz| *hz > 0.0),
        units: UnitOverrides { metres_per_unit, up },
    };
    py.detach(|| {
        let mut prepared = PreparedClip::read(&ClipFile::new(&path), settings).map_err(value)?;
        if let Some(seconds) = seconds {
            prepared.cut(seconds);
        }
        Ok(NativeClip { prepared: Arc::new(prepared) })
    })
}

/// Refuses units of length that no file can have.
pub(crate) fn check_unit(metres_per_unit: Option<f64>) -> PyResult<()> {
    match metres_per_unit.filter(|metres| !(1e-6..=1e3).contains(metres)) {
        None => Ok(()),
        Some(found) => Err(value(format!(
            "metres_per_unit: expected a length in m from 1e-6 to 1000, found {found}"
        ))),
    }
}

#[pymethods]
impl NativeClip {
    #[getter]
    fn name(&self) -> &str {
        &self.clip().name
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.prepared.notes.clone()
    }

    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.clip().skeleton.joints.iter().map(|joint| joint.name.clone()).collect()
    }

    #[getter]
    fn parents(&self) -> Vec<Option<usize>> {
        self.clip().skeleton.joints.iter().map(|joint| joint.parent).collect()
    }

    #[getter]
    fn rate_hz(&self) -> f64 {
        self.clip().rate_hz()
    }

    #[getter]
    fn frame_count(&self) -> usize {
        self.clip().frames.len()
    }

    #[getter]
    fn start_s(&self) -> f64 {
        self.prepared.start_s
    }

    fn offsets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let joints = &self.clip().skeleton.joints;
        let numbers = joints.iter().flat_map(|joint| joint.offset_m.to_array()).collect();
        array(py, [joints.len(), 3], numbers)
    }

    fn local<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        self.samples(py, |frame| self.clip().frames[frame].clone())
    }

    fn world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        self.samples(py, |frame| self.clip().world_poses(frame))
    }
}

impl NativeClip {
    fn samples<'py>(
        &self,
        py: Python<'py>,
        of_frame: impl Fn(usize) -> Vec<JointSample> + Sync,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let (frames, joints) = (self.clip().frames.len(), self.clip().skeleton.joints.len());
        let numbers = py.detach(|| {
            let mut numbers = Vec::with_capacity(7 * frames * joints);
            for JointSample { rotation, position_m } in (0..frames).flat_map(&of_frame) {
                numbers.extend(DVec3::to_array(&position_m));
                numbers.extend(rotation.to_array());
            }
            numbers
        });
        array(py, [frames, joints, 7], numbers)
    }
}
