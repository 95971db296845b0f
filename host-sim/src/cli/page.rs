//! The report that `sinew evaluate --output` writes beside its tables.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::ValueEnum as _;
use sinew_evaluation::exercise::Exercise;
use sinew_evaluation::optimum::{Optimum, optimum};
use sinew_evaluation::{BodySource, EvaluatedMotion, Evaluation, Protocol, Setup};
use sinew_figure::FigureMotion;
use sinew_host_util::command::note;
use sinew_performance::RigClip;
use sinew_report::scene::Mannequin;
use sinew_report::{Comparison, Playback, Report, Sweep};

/// Options of the report.
#[derive(Debug, clap::Args)]
pub(super) struct PageArgs {
    /// Clip, or motion of the rig, that the report plays back. Default: the first clip; with --rig the last motion: the
    /// last clip, or the fastest of the rig's own motions of all joints.
    #[arg(long, value_name = "CLIP", requires = "output")]
    playback: Option<String>,

    /// CSV file of `sinew evaluate sweep`. The report shows its rows as heat maps, and as Pareto fronts of methods and
    /// weights.
    #[arg(long, value_name = "FILE", requires = "output")]
    sweep: Option<PathBuf>,
}

/// Checked inputs of the report. The check is done before the evaluation, so that errors appear early.
#[derive(Debug)]
pub(super) struct Plan {
    /// Index of the clip or motion to play back, among all evaluated ones.
    take: usize,
    sweep: Option<Sweep>,
    /// Notes on changes that were made to the clips or the rig.
    notices: Vec<String>,
}

impl PageArgs {
    /// Returns the file of a sweep.
    pub(super) fn sweep(&self) -> Option<&Path> {
        self.sweep.as_deref()
    }

    /// Finds the clip or motion and reads the sweep.
    pub(super) fn plan(
        &self,
        takes: &[impl EvaluatedMotion],
        notices: Vec<String>,
    ) -> anyhow::Result<Plan> {
        let of_rig = takes.first().is_some_and(|take| take.rig_name().is_some());
        let default = if of_rig { takes.len() - 1 } else { 0 };
        let take = self.playback.as_deref().map_or(Ok(default), |wanted| {
            let place = takes.iter().position(|take| take.name() == wanted);
            place.with_context(|| {
                let names: Vec<&str> = takes.iter().map(EvaluatedMotion::name).collect();
                format!("--playback: expected one of {}, found `{wanted}`", names.join(", "))
            })
        })?;
        let sweep = self.sweep.as_deref().map(Sweep::read).transpose()?;
        Ok(Plan { take, sweep, notices })
    }
}

/// Supplies the parts of a report that depend on the kind of evaluated motion (of the figure or of a rig): all parts
/// except the tracking errors.
pub(super) trait Shown: EvaluatedMotion + Sized {
    /// Returns the shape of the rig or figure that performs the motion, to be drawn.
    fn mannequin(&self, setup: &Setup) -> anyhow::Result<Mannequin>;

    /// Returns the settings that depend on the kind of motion: name and value.
    fn settings(&self, setup: &Setup) -> Vec<(&'static str, String)>;

    /// Returns the references that the motions are compared with. `self` is the motion that is played back.
    fn compared(&self, takes: &[Self], protocol: &Protocol) -> anyhow::Result<Compared>;
}

/// References with which results are compared.
#[derive(Debug, Default)]
pub(super) struct Compared {
    comparison: Option<Comparison>,
    optimum: Option<Optimum>,
}

/// The scale of the paper's Figure 4.
const COMPARED_SCALE: f64 = 1.1;

impl Shown for FigureMotion {
    fn mannequin(&self, _: &Setup) -> anyhow::Result<Mannequin> {
        Ok(Mannequin::of_figure(self))
    }

    fn settings(&self, setup: &Setup) -> Vec<(&'static str, String)> {
        vec![
            ("Masses", body(setup.body)),
            ("Sampling", format!("{:.0} Hz, low-pass 6 Hz", self.dt_s.recip())),
        ]
    }

    fn compared(&self, takes: &[Self], protocol: &Protocol) -> anyhow::Result<Compared> {
        let comparison = match Comparison::new(self, protocol, COMPARED_SCALE) {
            Ok(comparison) => Some(comparison),
            // A setup may be unable to hold a posture. That is no reason to discard its evaluation.
            Err(error) => {
                note(format_args!("the report has no Figure 4: {error}"));
                None
            }
        };
        Ok(Compared { comparison, optimum: Some(optimum(takes, protocol)?) })
    }
}

impl Shown for RigClip {
    fn mannequin(&self, setup: &Setup) -> anyhow::Result<Mannequin> {
        Ok(Mannequin::of_rig(&EvaluatedMotion::mechanism(self, setup)?))
    }

    fn settings(&self, _: &Setup) -> Vec<(&'static str, String)> {
        vec![("Rate of control and plant", format!("{:.0} Hz", self.dt_s().recip()))]
    }

    fn compared(&self, _: &[Self], _: &Protocol) -> anyhow::Result<Compared> {
        Ok(Compared::default())
    }
}

impl Shown for Exercise {
    fn mannequin(&self, setup: &Setup) -> anyhow::Result<Mannequin> {
        Ok(Mannequin::of_rig(&EvaluatedMotion::mechanism(self, setup)?))
    }

    fn settings(&self, _: &Setup) -> Vec<(&'static str, String)> {
        vec![("Rate of control and plant", format!("{:.0} Hz", self.dt_s().recip()))]
    }

    fn compared(&self, _: &[Self], _: &Protocol) -> anyhow::Result<Compared> {
        Ok(Compared::default())
    }
}

impl Plan {
    /// Tracks the motion that is played back, and writes the page and its pictures.
    pub(super) fn write<T: Shown>(
        &self,
        folder: &Path,
        takes: &[T],
        protocol: &Protocol,
        evaluation: &Evaluation,
    ) -> anyhow::Result<()> {
        let take = &takes[self.take];
        let setup = &evaluation.setup;
        let playback = Playback::record(take, take.mannequin(setup)?, protocol, self.take as u64)
            .with_context(|| format!("playback of {}", take.name()))?;
        let compared = take.compared(takes, protocol)?;
        let mut settings = vec![("Plant", setup.plant.description().to_string())];
        settings.extend(take.settings(setup));
        let differences = setup.differences();
        if !differences.is_empty() {
            settings.push(("Setup, where not the default", differences.join(", ")));
        }
        let report = Report {
            command: &command(std::env::args_os()),
            settings: &settings,
            notices: &self.notices,
            evaluation,
            dt_s: take.dt_s(),
            comparison: compared.comparison.as_ref(),
            optimum: compared.optimum.as_ref(),
            playback: Some(&playback),
            sweep: self.sweep.as_ref(),
        };
        report.write(folder).with_context(|| format!("{}", folder.display()))
    }
}

/// Returns the source of the masses in the words of `--help`.
fn body(source: BodySource) -> String {
    let value = source.to_possible_value().expect("no source is hidden");
    value.get_help().map_or_else(|| value.get_name().to_owned(), ToString::to_string)
}

/// Returns the command line as a user would type it, without the options that do not change the result: output and
/// threads.
fn command(arguments: impl Iterator<Item = OsString>) -> String {
    let arguments = arguments.map(|argument| argument.to_string_lossy().into_owned());
    let mut words = vec!["sinew".to_owned()];
    let mut arguments = arguments.skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--output" | "--threads" => _ = arguments.next(),
            other if other.starts_with("--output=") || other.starts_with("--threads=") => {}
            other
                if other
                    .contains(|c: char| c.is_whitespace() || "'\"\\$`*?&|;<>()#".contains(c)) =>
            {
                words.push(format!("'{}'", other.replace('\'', r"'\''")));
            }
            _ => words.push(argument),
        }
    }
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_shown_without_threads_and_folder() {
        let shown = |words: &[&str]| command(words.iter().map(OsString::from));
        assert_eq!(
            shown(&[
                "/usr/bin/sinew",
                "evaluate",
                "--output",
                "a",
                "--scale",
                "1.1",
                "--threads=2"
            ]),
            "sinew evaluate --scale 1.1"
        );
        assert_eq!(shown(&["sinew", "--clips", "my clip.bvh"]), "sinew --clips 'my clip.bvh'");
    }
}
