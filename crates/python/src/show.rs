//! Clips on a rig: mapping, motion, and show.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use sinew_performance::{
    MotionChoices, OwnMotion, PreparedClip, RetargetedClip, RigPerformance, ShowChoices,
    propose_mapping, read_mapping, retarget_clip, rig_hash,
};
use sinew_retarget::feasibility::RigMotion;
use sinew_retarget::mapping::Mapping;
use sinew_show::write::Settings;
use sinew_show::{Player, Show};

use crate::arrays::{Rows, array};
use crate::clip::NativeClip;
use crate::error::value;
use crate::rig::NativeRig;
use crate::work::{in_background, in_pieces};

/// Number of channels of the largest rig.
const CHANNELS: usize = 256;

/// Returns a proposed mapping of a clip's joints to a rig's joints, as TOML.
#[pyfunction]
pub(crate) fn map(
    py: Python<'_>,
    clip: PyRef<'_, NativeClip>,
    rig: PyRef<'_, NativeRig>,
) -> PyResult<String> {
    let (clip, rig) = (Arc::clone(&clip.prepared), Arc::clone(&rig.loaded));
    in_background(py, None, move |_| {
        let (mapping, _) = propose_mapping(&rig, &clip)?;
        Ok(mapping.text())
    })
}

/// Reads a mapping from TOML text, or from a file. Text with more than one line is TOML.
fn mapping_of(mapping: Option<&str>) -> anyhow::Result<Option<Mapping>> {
    let read = |text: &str| {
        if text.contains('\n') { Ok(Mapping::read(text)?) } else { read_mapping(Path::new(text)) }
    };
    mapping.map(read).transpose()
}

/// Returns the motion of a rig that follows a clip, row by row, and the mean and largest angle between corresponding
/// limbs, rad; NaN if no limbs are compared.
#[pyfunction]
pub(crate) fn retarget<'py>(
    py: Python<'py>,
    clip: PyRef<'py, NativeClip>,
    rig: PyRef<'py, NativeRig>,
    mapping: Option<String>,
    mirror: bool,
) -> PyResult<(Bound<'py, PyArray2<f64>>, f64, f64)> {
    let width = rig.loaded.mechanism.coordinate_count();
    let (clip, rig) = (Arc::clone(&clip.prepared), Arc::clone(&rig.loaded));
    let taken = in_background(py, None, move |_| {
        let mapping = mapping_of(mapping.as_deref())?;
        Ok(retarget_clip(&rig.mechanism, &clip, mapping.as_ref(), mirror)?)
    })?;
    let rows = taken.motion.rows.len();
    let numbers = taken.motion.rows.into_iter().flatten().collect();
    let angle = |deg: f64| if taken.limbs > 0 { deg.to_radians() } else { f64::NAN };
    let (mean, most) = (angle(taken.limbs_mean_deg), angle(taken.limbs_max_deg));
    Ok((array(py, [rows, width], numbers)?, mean, most))
}

/// Source of a show's motion.
#[derive(FromPyObject)]
pub(crate) enum MotionSource<'py> {
    Clip(PyRef<'py, NativeClip>),
    Rows(PyReadonlyArray2<'py, f64>),
    File(PathBuf),
}

/// A motion that can be sent to another thread.
enum Motion {
    Clip(Arc<PreparedClip>),
    Own { name: String, motion: RigMotion },
    File(PathBuf),
}

/// A violation of a rig's limit by a show: joint, quantity, first, last and worst time, value, limit.
type ExcessRow = (String, &'static str, f64, f64, f64, f64, f64);

/// Bakes a motion into a show for a rig.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the function of Python has names for them")]
pub(crate) fn bake(
    py: Python<'_>,
    source: MotionSource<'_>,
    rig: PyRef<'_, NativeRig>,
    rate_hz: Option<f64>,
    mapping: Option<String>,
    mirror: bool,
    fit: bool,
    keep_time: bool,
    loop_blend_s: Option<f64>,
    tolerance_rad: f64,
    cues: Vec<(String, f64)>,
) -> PyResult<NativeShow> {
    let least = 0.001_f64.to_radians();
    if !(least..=10.0_f64.to_radians()).contains(&tolerance_rad) {
        return Err(value(format!(
            "tolerance_rad: expected an angle from {least:.2e} to 0.1745, found {tolerance_rad}"
        )));
    }
    if let Some(found) = loop_blend_s.filter(|s| !(*s > 0.0 && s.is_finite())) {
        return Err(value(format!("loop_blend_s: expected a number of s above 0, found {found}")));
    }
    if let Some((name, found)) = cues.iter().find(|(_, s)| !(0.0..=1e6).contains(s)) {
        return Err(value(format!("cues: expected a time in s from 0, found {name} at {found}")));
    }
    let motion = match source {
        MotionSource::Clip(clip) => Motion::Clip(Arc::clone(&clip.prepared)),
        MotionSource::File(path) => Motion::File(path),
        MotionSource::Rows(rows) => {
            let rows = Rows::of("q", &rows, rig.loaded.mechanism.coordinate_count())?;
            let rate_hz = rate_hz.filter(|hz| (1.0..=10_000.0).contains(hz)).ok_or_else(|| {
                value("rate_hz: expected the rate of the rows of q, in Hz from 1 to 10000")
            })?;
            if let Some(bad) = rows.numbers.iter().position(|x| !(-1e6..=1e6).contains(x)) {
                let (row, column) = (bad / rows.width, bad % rows.width);
                return Err(value(format!(
                    "q[{row}, {column}]: expected a number from -1e6 to 1e6, found {}",
                    rows.numbers[bad]
                )));
            }
            let rows = (0..rows.count).map(|row| rows.row(row).to_vec()).collect();
            let motion = RigMotion { dt_s: rate_hz.recip(), rows };
            Motion::Own { name: "motion".to_owned(), motion }
        }
    };
    let rig = Arc::clone(&rig.loaded);
    let choices = MotionChoices {
        fit: fit || keep_time,
        keep_time,
        loop_blend_s,
        ..MotionChoices::default()
    };
    let settings = Settings { angle_rad: tolerance_rad, ..Settings::default() };
    in_background(py, None, move |_| {
        let mapping = mapping_of(mapping.as_deref())?;
        let mut performance = match motion {
            Motion::Clip(clip) => {
                let taken = retarget_clip(&rig.mechanism, &clip, mapping.as_ref(), mirror)?;
                RigPerformance::new(&rig, &clip.clip.name, clip.start_s, taken, choices)?
            }
            Motion::Own { name, motion } => {
                RigPerformance::new(&rig, &name, 0.0, RetargetedClip::own(motion), choices)?
            }
            Motion::File(path) => {
                let kind = OwnMotion::of(&path);
                let kind = kind.ok_or_else(|| {
                    anyhow::anyhow!(
                        "{}: expected a CSV or JSON of the rig's own motion; `read_clip` reads clips",
                        path.display()
                    )
                })?;
                let mut read = kind.read(&rig, &path, None)?;
                read.motion.follow(&rig.mechanism.ties());
                let taken = RetargetedClip::own(read.motion);
                let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                RigPerformance::new(&rig, &name, read.start_s, taken, choices)?
            }
        };
        let (rig_crc, _) = rig_hash(&rig.description, &rig.mechanism);
        let choices = ShowChoices { rig_crc, settings, cues: &cues, time_code: None };
        let (baked, report) = performance.bake(&rig.mechanism, &choices)?;
        let excesses = report.excesses.iter().map(|excess| {
            let dof = &performance.limits.dofs[excess.dof];
            let joint = dof.name.clone();
            let (from, to) = (excess.from_s, excess.to_s);
            (joint, excess.kind.name(), from, to, excess.worst_s, excess.value, excess.limit)
        });
        let excesses = excesses.collect();
        let fitted = performance.fit_summary(&rig.mechanism);
        Ok(NativeShow { bytes: baked.written.bytes, excesses, fitted })
    })
}

/// A valid show, and the findings of its baking.
#[pyclass(frozen, module = "sinew_motion._sinew_motion")]
pub(crate) struct NativeShow {
    pub(crate) bytes: Vec<u8>,
    excesses: Vec<ExcessRow>,
    fitted: Option<String>,
}

/// Checks the bytes of a show, and returns the show.
#[pyfunction]
pub(crate) fn open_show(bytes: &[u8]) -> PyResult<NativeShow> {
    let show = Show::open(bytes).map_err(value)?;
    show.check_blocks().map_err(value)?;
    Player::<CHANNELS>::new(show).map_err(value)?;
    Ok(NativeShow { bytes: bytes.to_vec(), excesses: Vec::new(), fitted: None })
}

impl NativeShow {
    fn show(&self) -> PyResult<Show<'_>> {
        Show::open(&self.bytes).map_err(value)
    }
}

/// Rows of positions, speeds and accelerations.
type SampledRows<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

#[pymethods]
impl NativeShow {
    #[getter]
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    #[getter]
    fn excesses(&self) -> Vec<ExcessRow> {
        self.excesses.clone()
    }

    #[getter]
    fn fitted(&self) -> Option<&str> {
        self.fitted.as_deref()
    }

    #[getter]
    fn duration_s(&self) -> PyResult<f64> {
        let show = self.show()?;
        let rate = show.rate();
        Ok(f64::from(show.length()) * f64::from(rate.seconds) / f64::from(rate.samples))
    }

    #[getter]
    fn rate_hz(&self) -> PyResult<f64> {
        let rate = self.show()?.rate();
        Ok(f64::from(rate.samples) / f64::from(rate.seconds))
    }

    #[getter]
    fn is_loop(&self) -> PyResult<bool> {
        Ok(self.show()?.is_loop())
    }

    #[getter]
    fn rig_crc(&self) -> PyResult<u32> {
        Ok(self.show()?.rig())
    }

    #[getter]
    fn cues(&self) -> PyResult<Vec<(String, f64)>> {
        let show = self.show()?;
        let rate = show.rate();
        let period_s = f64::from(rate.seconds) / f64::from(rate.samples);
        let cue =
            |cue: sinew_show::Cue<'_>| (cue.name.to_owned(), f64::from(cue.sample) * period_s);
        Ok(show.cues().map(cue).collect())
    }

    fn sample<'py>(&self, py: Python<'py>, times_s: Vec<f64>) -> PyResult<SampledRows<'py>> {
        if let Some(bad) = times_s.iter().find(|s| !(0.0..=1e9).contains(*s)) {
            return Err(value(format!("t: expected times in s from 0 to 1e9, found {bad}")));
        }
        let show = self.show()?;
        let (nq, nv) = (show.channel_count(), show.dof_count());
        let mut player = Player::<CHANNELS>::new(show).map_err(value)?;
        let (mut q, mut qd, mut qdd) = (vec![0.0; nq], vec![0.0; nv], vec![0.0; nv]);
        let mut out = [(); 3].map(|()| Vec::new());
        in_pieces(py, times_s.len(), |rows| {
            for time_s in &times_s[rows] {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "from 0 to 1e15"
                )]
                let position = player.show().position_at_us((time_s * 1e6).round() as u64);
                player.state_at(position, &mut q, &mut qd, &mut qdd).map_err(value)?;
                for (out, numbers) in out.iter_mut().zip([&q, &qd, &qdd]) {
                    out.extend(numbers.iter().copied().map(f64::from));
                }
            }
            Ok(())
        })?;
        let count = times_s.len();
        let [q, qd, qdd] = out;
        Ok((array(py, [count, nq], q)?, array(py, [count, nv], qd)?, array(py, [count, nv], qdd)?))
    }
}
