//! `sinew evaluate latency`: the latency that each method tolerates.

use std::process::ExitCode;

use anyhow::ensure;
use sinew_evaluation::latency::LatencyProtocol;
use sinew_evaluation::report::latency_table;
use sinew_evaluation::{EvaluatedMotion, TRACKS_BELOW_DEG};
use sinew_figure::Dimensions;
use sinew_host_util::command::{ThreadArgs, print, with_progress};
use sinew_performance::rig::LoadedRig;

use super::clips::{ClipArgs, dimensions, rate, seconds, tell, what};
use super::evaluate::{ensure_different, scale};
use super::methods::{MethodArg, check_fixed, methods};
use super::performance::PerformanceArgs;
use super::setup::SetupArgs;

/// Find the largest latency that each method tolerates, at each control rate.
///
/// A torque acts a number of steps after its measurement. The table shows the largest latency, in steps and in ms, for
/// which no figure is lost (flies apart) and the mean angular error stays below 10 degrees. Each method is tried with
/// and without prediction: a controller that predicts knows the latency, and uses the commands that are not yet active
/// to compute the state in which its command will act. `-`: the method fails even without latency. Default plant:
/// `articulated`. The clips have 100 frames per second.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    clips: ClipArgs,

    /// Rates of control and plant, in Hz.
    #[arg(long, value_name = "HZ,..", value_delimiter = ',', default_value = "100,500,1000", value_parser = rate, allow_negative_numbers = true)]
    rates_hz: Vec<f64>,

    /// Factor on the figure's dimensions. The clips are not scaled.
    #[arg(long, value_name = "FACTOR", default_value = "1.1", value_parser = scale, allow_negative_numbers = true, conflicts_with = "rig")]
    scale: f64,

    /// Methods to try.
    #[arg(long, value_name = "METHOD,..", value_delimiter = ',', default_value = "all")]
    methods: Vec<MethodArg>,

    #[command(flatten)]
    pub(super) setup: SetupArgs,

    /// Use only the first S seconds of every clip: whole clips take long.
    #[arg(long, value_name = "S", default_value = "3", value_parser = seconds, allow_negative_numbers = true)]
    seconds: f64,

    #[command(flatten)]
    threads: ThreadArgs,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    args.clips.in_pool(&args.threads, &PerformanceArgs::default(), |rig| run_on(args, rig))
}

fn run_on(args: &Args, rig: Option<&LoadedRig>) -> anyhow::Result<ExitCode> {
    let mut setup = args.setup.setup_on_exact(rig.map(|rig| &rig.mechanism))?;
    ensure!(
        setup.disturbance.latency_steps == 0 && !setup.controller.observer.predict,
        "disturbance.latency_steps, controller.observer.predict: expected to be left out, the table varies them"
    );
    ensure!(!args.clips.has_rate(), "--rate-hz: expected --rates-hz instead, the table varies it");
    let scale = rig.map_or(args.scale, |_| 1.0);
    setup.dimensions = Dimensions { scale, ..setup.dimensions };
    let methods = methods(&args.methods);
    ensure_different(&methods, "--methods")?;
    check_fixed(&setup, &methods)?;
    ensure_different(&args.rates_hz, "--rates-hz")?;
    let protocol = LatencyProtocol { setup, methods, seconds: args.seconds };
    protocol.check()?;
    let mut motions: Vec<(f64, Vec<Box<dyn EvaluatedMotion>>)> = Vec::new();
    for rate in &args.rates_hz {
        let (of_rate, lines) = args.clips.with_rate(*rate).at(*rate, 100.0).takes(rig)?;
        // The notes are the same for every rate.
        if motions.is_empty() {
            tell(&lines);
        }
        motions.push((*rate, of_rate));
    }

    let limits = with_progress(protocol.count_cells(motions.len()), |progress| {
        protocol.run(&motions, progress)
    })?;
    let (_, first) = &motions[0];
    print(&format!(
        "{}, their first {} s{}; plant: {}\n\
         the largest latency at which no figure is lost and the mean angular error is below {TRACKS_BELOW_DEG} deg\n\n{}\n",
        what(rig, first.len()),
        args.seconds,
        dimensions(rig, args.scale),
        protocol.setup.plant.description(),
        latency_table(&limits),
    ))?;
    Ok(ExitCode::SUCCESS)
}
