//! Evaluations and sweeps. Their results are the CSV tables that `sinew` writes.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context as _, bail, ensure};
use pyo3::prelude::*;
use sinew_evaluation::sweep::{
    Journal, Plan, Shard, SweepFile, count_missing_steps, sweep as run_cells,
};
use sinew_evaluation::{
    EvaluatedMotion, Evaluation, MethodName, Protocol, Setup, count_all_steps, count_steps, report,
};
use sinew_rig::Mechanism;

use crate::error::value;
use crate::motions::{MotionArgs, Watched, watched};
use crate::rig::NativeRig;
use crate::work::in_background;

/// Returns the names and descriptions of the methods.
#[pyfunction]
pub(crate) fn methods() -> Vec<(&'static str, &'static str)> {
    MethodName::EVERY.iter().map(|method| (method.as_str(), method.summary())).collect()
}

/// CSV tables of an evaluation: over all clips, by clip, and over time.
type Tables = (String, String, String);

/// Evaluates methods on motions.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the function of Python has names for them")]
pub(crate) fn evaluate(
    py: Python<'_>,
    clips: Vec<PathBuf>,
    rig: Option<PyRef<'_, NativeRig>>,
    methods: Option<Vec<String>>,
    scales: Vec<f64>,
    setup: &str,
    seconds: Option<f64>,
    rate_hz: Option<f64>,
    mapping: Option<String>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Tables> {
    let named = |name: &String| {
        MethodName::from_name(name).ok_or_else(|| {
            let names = MethodName::EVERY.map(MethodName::as_str).join(", ");
            value(format!("methods: expected some of {names}, found `{name}`"))
        })
    };
    let methods = methods
        .map(|names| names.iter().map(named).collect::<PyResult<Vec<MethodName>>>())
        .transpose()?;
    check_numbers(seconds, rate_hz)?;
    if let Some(found) = scales.iter().find(|scale| !(0.1..=10.0).contains(*scale)) {
        return Err(value(format!("scales: expected numbers from 0.1 to 10, found {found}")));
    }
    let table: toml::Table = table(setup).map_err(value)?;
    let rig = rig.map(|rig| Arc::clone(&rig.loaded));
    let args = MotionArgs { clips, rig: rig.clone(), mapping, rate_hz, in_turn: true };
    in_background(py, progress.as_ref(), move |progress| {
        let mechanism = rig.as_ref().map(|rig| &rig.mechanism);
        let protocol = Protocol {
            setup: setup_of(table, mechanism)?,
            scales: if rig.is_some() { vec![1.0] } else { scales },
            methods: methods.unwrap_or_else(|| match rig {
                Some(_) => MethodName::ALL.to_vec(),
                None => MethodName::PAPER.to_vec(),
            }),
            seconds,
        };
        let motions = watched(args.read()?, progress);
        progress.expect(count_all_steps(&motions, &protocol));
        let done = sinew_evaluation::evaluate(&motions, &protocol, |steps| progress.add(steps))?;
        Ok((report::result_csv(&done), report::clips_csv(&done), trace_csv(&done, &motions)?))
    })
}

/// Parses a setup in JSON as a table.
fn table(setup: &str) -> anyhow::Result<toml::Table> {
    let setup: serde_json::Value = serde_json::from_str(setup).context("setup")?;
    match toml::Value::try_from(setup).context("setup")? {
        toml::Value::Table(table) => Ok(table),
        _ => bail!("setup: expected a dict"),
    }
}

/// Returns the setup in a table, for a rig or for the figure.
fn setup_of(mut table: toml::Table, rig: Option<&Mechanism>) -> anyhow::Result<Setup> {
    if rig.is_some() {
        Setup::prefer_exact_plant(&mut table);
    }
    let setup = Setup::from_table(table).context("setup")?;
    setup.check_for(rig).context("setup")?;
    Ok(setup)
}

fn check_numbers(seconds: Option<f64>, rate_hz: Option<f64>) -> PyResult<()> {
    if let Some(found) = seconds.filter(|s| !(*s > 0.0 && s.is_finite())) {
        return Err(value(format!("seconds: expected a number above 0, found {found}")));
    }
    if let Some(found) = rate_hz.filter(|hz| !(10.0..=10_000.0).contains(hz)) {
        return Err(value(format!(
            "rate_hz: expected a number of Hz from 10 to 10000, found {found}"
        )));
    }
    Ok(())
}

/// Returns the mean errors over time as CSV, with a row for each stretch of a clip.
fn trace_csv(done: &Evaluation, motions: &[Watched]) -> anyhow::Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = ["clip", "scale", "method", "time_s", "angular_mean_deg", "linear_mean_cm"];
    writer.write_record(head)?;
    for figure in &done.figures {
        for result in &figure.methods {
            for ((clip, detail), motion) in done.clips.iter().zip(&result.details).zip(motions) {
                let each_s = detail.trace.steps_each() as f64 * motion.dt_s();
                for (index, stretch) in detail.trace.stretches().iter().enumerate() {
                    writer.write_record([
                        clip.name.clone(),
                        figure.scale.to_string(),
                        result.method.to_string(),
                        (index as f64 * each_s).to_string(),
                        stretch.angular_mean_deg().to_string(),
                        stretch.linear_mean_cm().to_string(),
                    ])?;
                }
            }
        }
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

/// Runs a sweep. Returns its table by cell, and its table by clip.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the function of Python has names for them")]
pub(crate) fn sweep(
    py: Python<'_>,
    file: PathBuf,
    clips: Vec<PathBuf>,
    rig: Option<PyRef<'_, NativeRig>>,
    seconds: Option<f64>,
    rate_hz: Option<f64>,
    mapping: Option<String>,
    output: Option<PathBuf>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(String, String)> {
    check_numbers(seconds, rate_hz)?;
    let rig = rig.map(|rig| Arc::clone(&rig.loaded));
    let args = MotionArgs { clips, rig: rig.clone(), mapping, rate_hz, in_turn: false };
    in_background(py, progress.as_ref(), move |progress| {
        let read = SweepFile::read(&file, rig.as_ref().map(|rig| &rig.mechanism))?;
        let motions = watched(args.read()?, progress);
        for motion in &motions {
            let steps = count_steps(motion, seconds);
            ensure!(steps > 0, "clip {}: at least 3 frames are needed", motion.name());
        }
        let plan = Plan::new(read, &motions, seconds, Shard::WHOLE);
        // Without a folder of the user, the tables are read back and removed.
        let (folder, _own) = if let Some(folder) = output {
            (folder, None)
        } else {
            let own = tempfile::tempdir()?;
            (own.path().to_path_buf(), Some(own))
        };
        let (journal, _) = Journal::open(&folder, &plan)?;
        progress.expect(count_missing_steps(&plan, &journal, &motions));
        run_cells(&plan, journal, &motions, |steps| progress.add(steps))?;
        let read = |name: &str| {
            let path = folder.join(name);
            std::fs::read_to_string(&path).with_context(|| path.display().to_string())
        };
        Ok((read("sweep.csv")?, read("sweep_clips.csv")?))
    })
}
