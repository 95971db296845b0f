//! `sinew evaluate`: the paper's tables.

use std::fmt::Display;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context as _, ensure};
use clap::ValueEnum;
use sinew_evaluation::{
    EvaluateError, EvaluatedMotion, Evaluation, MethodName, Protocol, TRACKS_BELOW_DEG,
    count_all_steps, evaluate, report,
};
use sinew_host_util::command::{ThreadArgs, note, print, with_progress};
use sinew_host_util::output::{self, Folder};
use sinew_performance::rig::{LoadedRig, review};
use sinew_rig::Mechanism;
use sinew_rig::review::{Finding, Loop, Severity};

use super::clips::{ClipArgs, RIG_RATE_HZ, seconds, tell};
use super::methods::{MethodArg, check_fixed, methods};
use super::output::OutputPlace;
use super::page::PageArgs;
use super::performance::PerformanceArgs;
use super::setup::SetupArgs;

/// Options of the paper's tables.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    clips: ClipArgs,

    #[command(flatten)]
    on_rig: PerformanceArgs,

    /// Factors on the figure's dimensions, 0.1 to 10. The clips are not scaled.
    #[arg(long, value_name = "FACTOR,..", value_delimiter = ',', default_value = "1.0,1.1", value_parser = scale, allow_negative_numbers = true, conflicts_with = "rig")]
    scale: Vec<f64>,

    /// Methods. `all`: every method except `accumulated`, which equals `egocentric` unless `--set
    /// controller.reference=BODY` names another reference body. Default: the paper's methods `local`, `world` and
    /// `linear_compensation`; with `--rig`: all.
    #[arg(long, value_name = "METHOD,..", value_delimiter = ',')]
    methods: Option<Vec<MethodArg>>,

    #[command(flatten)]
    pub(super) setup: SetupArgs,

    /// Use only the first S seconds of every clip, for a quick look.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,

    /// Format of the output.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,

    /// Also write into this folder: the report (index.html, for a browser), its pictures, table.txt, result.json,
    /// result.csv and clips.csv (a row per clip).
    #[arg(long, value_name = "DIR")]
    output: Option<OutputPlace>,

    #[command(flatten)]
    page: PageArgs,

    #[command(flatten)]
    threads: ThreadArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Aligned tables, with the paper's numbers.
    Table,
    /// One JSON object, schema `sinew-evaluate/1`.
    Json,
    /// One row per scale, method and group of joints.
    Csv,
}

pub(super) fn scale(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(factor) if (0.1..=10.0).contains(&factor) => Ok(factor),
        _ => Err("expected a number from 0.1 to 10".into()),
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    ensure_different(&args.scale, "--scale")?;
    ensure_different(&methods(args.methods.as_deref().unwrap_or_default()), "--methods")?;
    args.clips.in_pool(&args.threads, &args.on_rig, |rig| run_on(args, rig))
}

pub(super) fn ensure_different<T: PartialEq + Display>(
    values: &[T],
    option: &str,
) -> anyhow::Result<()> {
    for (index, value) in values.iter().enumerate() {
        ensure!(!values[..index].contains(value), "{option}: {value} is given twice");
    }
    Ok(())
}

fn run_on(args: &Args, rig: Option<&LoadedRig>) -> anyhow::Result<ExitCode> {
    let protocol = args.protocol(rig.map(|rig| &rig.mechanism))?;
    check_fixed(&protocol.setup, &protocol.methods)?;
    // Checked before the work, so that no result is lost.
    let folder = args.output.as_deref().map(|folder| args.folder(folder)).transpose()?;
    if let Some(rig) = rig {
        tell_faults(rig)?;
        if args.clips.of_rig() {
            let takes = args.clips.performances(rig, &args.on_rig)?;
            let plan = args.page.plan(&takes, rig.notes.clone())?;
            return args.evaluate(&takes, &protocol, folder, |folder, evaluation| {
                plan.write(folder, &takes, &protocol, evaluation)
            });
        }
        args.clips.ensure_no_clips(&args.on_rig)?;
        let takes = args.clips.exercises(rig, true)?;
        let plan = args.page.plan(&takes, rig.notes.clone())?;
        return args.evaluate(&takes, &protocol, folder, |folder, evaluation| {
            plan.write(folder, &takes, &protocol, evaluation)
        });
    }
    let (motions, notices) = args.clips.read()?;
    tell(&notices);
    let plan = args.page.plan(&motions, notices)?;
    args.evaluate(&motions, &protocol, folder, |folder, evaluation| {
        plan.write(folder, &motions, &protocol, evaluation)
    })
}

impl Args {
    fn protocol(&self, rig: Option<&Mechanism>) -> anyhow::Result<Protocol> {
        let methods = self.methods.as_deref().map(methods);
        let seconds = self.seconds;
        Ok(match rig {
            None => Protocol {
                setup: self.setup.setup(None)?,
                scales: self.scale.clone(),
                methods: methods.unwrap_or_else(|| MethodName::PAPER.to_vec()),
                seconds,
            },
            Some(_) => Protocol {
                setup: self.setup.setup_on_exact(rig)?,
                scales: vec![1.0],
                methods: methods.unwrap_or_else(|| MethodName::ALL.to_vec()),
                seconds,
            },
        })
    }

    /// Opens and locks the folder of results. Refuses a folder in which a result would overwrite an input file.
    fn folder(&self, folder: &Path) -> anyhow::Result<Folder> {
        let mut inputs = self.setup.files();
        inputs.extend(self.clips.files());
        inputs.push(("sweep", self.page.sweep()));
        for (what, file) in inputs.iter().filter_map(|(what, file)| Some((*what, (*file)?))) {
            for name in RESULTS {
                output::distinct(&[&folder.join(name)], &[(what, Some(file))])?;
            }
        }
        Ok(Folder::open(folder, "evaluate", &inputs)?)
    }

    /// Evaluates, prints, and writes the files and `page` if a folder is given.
    fn evaluate<T: EvaluatedMotion>(
        &self,
        takes: &[T],
        protocol: &Protocol,
        folder: Option<Folder>,
        page: impl FnOnce(&Path, &Evaluation) -> anyhow::Result<()>,
    ) -> anyhow::Result<ExitCode> {
        let result = with_progress(count_all_steps(takes, protocol), |progress| {
            evaluate(takes, protocol, progress)
        });
        let evaluation = match result {
            Ok(evaluation) => evaluation,
            // A lost figure is a result, and a bad one: exit code 1.
            Err(error @ EvaluateError::Run { .. }) if error.is_loss() => {
                note(format_args!("error: {error}"));
                return Ok(ExitCode::FAILURE);
            }
            Err(error) => return Err(error.into()),
        };
        if let Some(folder) = folder {
            let stage = folder.stage();
            write_files(&stage, &evaluation)?;
            page(&stage, &evaluation)?;
            folder.finish()?;
        }
        if let Some(folder) = &self.output
            && evaluation.rig.is_some()
        {
            note(format_args!("wrote {}", folder.join("index.html").display()));
        }
        print(&match self.format {
            Format::Table => report::tables(&evaluation),
            Format::Json => report::json(&evaluation),
            Format::Csv => report::result_csv(&evaluation),
        })?;
        Ok(told_flailing(&evaluation))
    }
}

/// Prints the faults of a rig, such as a servo that is too weak for the rig's weight, as `sinew rig check` finds
/// them.
fn tell_faults(rig: &LoadedRig) -> anyhow::Result<()> {
    let control = Loop { rate_hz: RIG_RATE_HZ, latency_ticks: 1, bandwidth_rad_s: None };
    let review = review(rig, control)?;
    for Finding { about, text, .. } in
        review.findings.iter().filter(|finding| finding.severity == Severity::Fault)
    {
        note(format_args!("FAULT: {about}: {text}"));
    }
    Ok(())
}

/// Prints the motions that a rig did not follow, and returns the exit code. A rig on a stand cannot fall, so it is
/// never lost: if it does not follow, its error is large.
fn told_flailing(evaluation: &Evaluation) -> ExitCode {
    let mut code = ExitCode::SUCCESS;
    let results = evaluation.figures.iter().flat_map(|figure| &figure.methods);
    for result in results.filter(|_| evaluation.rig.is_some()) {
        for (clip, errors) in evaluation.clips.iter().zip(&result.clips) {
            let mean_deg = errors.all.angular_mean_deg();
            if mean_deg > TRACKS_BELOW_DEG {
                let (method, motion) = (result.method, &clip.name);
                note(format_args!(
                    "error: motion {motion}, method {method}: not followed, the mean error is {mean_deg:.1} deg"
                ));
                code = ExitCode::FAILURE;
            }
        }
    }
    code
}

/// Files of every evaluation. Pictures have other names.
const RESULTS: [&str; 5] = ["index.html", "table.txt", "result.json", "result.csv", "clips.csv"];

fn write_files(folder: &Path, evaluation: &Evaluation) -> anyhow::Result<()> {
    for (name, text) in [
        ("table.txt", report::tables(evaluation)),
        ("result.json", report::json(evaluation)),
        ("result.csv", report::result_csv(evaluation)),
        ("clips.csv", report::clips_csv(evaluation)),
    ] {
        let path = folder.join(name);
        fs::write(&path, text).with_context(|| format!("{}", path.display()))?;
    }
    Ok(())
}
