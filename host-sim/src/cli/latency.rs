//! `sinew evaluate latency`: how late a drive may come.

use std::process::ExitCode;

use anyhow::ensure;
use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use rayon::prelude::*;
use sinew_evaluation::robustness::{TRACKS_BELOW_DEG, largest_latency};
use sinew_evaluation::{EvaluatedMotion, MAX_LATENCY_STEPS, Setup};
use sinew_figure::Dimensions;
use sinew_host_util::command::{ThreadArgs, print, with_progress};

use super::clips::{ClipArgs, dimensions, rate, seconds, tell, what};
use super::evaluate::{ensure_different, scale};
use super::methods::{MethodArg, check_fixed, methods};
use super::performance::PerformanceArgs;
use super::setup::SetupArgs;

/// Find the largest latency that each method tolerates, by rate of control.
///
/// A torque comes some steps after its measurement. The table shows the largest number of steps, and the time in
/// ms, up to which no figure is lost and the mean angular error stays below 10 degrees. Each method is tried with and
/// without looking ahead: a controller that looks ahead knows the latency, and predicts the state that its command
/// will meet from the commands on their way. `-`: the method fails without any latency. Default plant: `articulated`.
/// The clips have 100 frames a second.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    clips: ClipArgs,

    /// Rates of control and plant, in Hz.
    #[arg(long, value_name = "HZ,..", value_delimiter = ',', default_value = "100,500,1000", value_parser = rate, allow_negative_numbers = true)]
    rates_hz: Vec<f64>,

    /// Factor on the figure's dimensions. The clips keep theirs.
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
    args.threads.install(|| run_in_pool(args))
}

fn run_in_pool(args: &Args) -> anyhow::Result<ExitCode> {
    let rig = args.clips.rig(&PerformanceArgs::default())?;
    let rig = rig.as_ref();
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
    let setups: Vec<Setup> = methods
        .iter()
        .map(|method| {
            let mut setup = setup.clone();
            setup.controller = setup.controller.with_method(*method);
            setup
        })
        .collect();
    for setup in &setups {
        setup.check()?;
    }
    let mut motions: Vec<(f64, Vec<Box<dyn EvaluatedMotion>>)> = Vec::new();
    for rate in &args.rates_hz {
        let (of_rate, lines) = args.clips.with_rate(*rate).at(*rate, 100.0).takes(rig)?;
        // Every rate has the same to tell.
        if motions.is_empty() {
            tell(&lines);
        }
        motions.push((*rate, of_rate));
    }

    let mut cells = Vec::new();
    for method in 0..methods.len() {
        for look_ahead in [false, true] {
            for rate in 0..motions.len() {
                cells.push((method, look_ahead, rate));
            }
        }
    }
    let largest: Vec<_> = with_progress(cells.len(), |progress| {
        let cell = |(method, look_ahead, rate): &(usize, bool, usize)| {
            let (_, motions) = &motions[*rate];
            let steps = largest_latency(motions, &setups[*method], *look_ahead, Some(args.seconds));
            progress(1);
            steps
        };
        cells.par_iter().map(cell).collect()
    });
    let largest = largest.into_iter().collect::<Result<Vec<Option<usize>>, _>>()?;
    let mut largest = largest.into_iter();
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    let heading = ["method", "looks ahead"].map(str::to_owned).into_iter();
    table.set_header(heading.chain(args.rates_hz.iter().map(|rate| format!("{rate:.0} Hz"))));
    for method in &methods {
        for look_ahead in ["no", "yes"] {
            let cells: Vec<String> = args
                .rates_hz
                .iter()
                .zip(&mut largest)
                .map(|(rate, steps)| shown(*rate, steps))
                .collect();
            table.add_row([method.to_string(), look_ahead.to_owned()].into_iter().chain(cells));
        }
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let (_, first) = &motions[0];
    print(&format!(
        "{}, their first {} s{}; plant: {}\n\
         the largest latency at which no figure is lost and the mean angular error is below {TRACKS_BELOW_DEG} deg\n\n{table}\n",
        what(rig, first.len()),
        args.seconds,
        dimensions(rig, args.scale),
        setup.plant.description(),
    ))?;
    Ok(ExitCode::SUCCESS)
}

fn shown(rate_hz: f64, steps: Option<usize>) -> String {
    match steps {
        None => "-".to_owned(),
        Some(1) => format!("1 step, {:.0} ms", 1e3 / rate_hz),
        Some(MAX_LATENCY_STEPS) => format!("{MAX_LATENCY_STEPS} steps or more"),
        Some(steps) => format!("{steps} steps, {:.0} ms", steps as f64 * 1e3 / rate_hz),
    }
}
