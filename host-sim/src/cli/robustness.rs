//! `sinew robustness`: the methods on rigs as they are built.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::{bail, ensure};
use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use sinew_sim::command::{ThreadArgs, print, with_progress};
use sinew_sim::evaluate::robustness::{Trial, as_built, median, trial};
use sinew_sim::evaluate::{Disturbance, Errors, MethodName, Take as _, step_count};
use sinew_sim::figure::Dimensions;

use super::clips::{ClipArgs, dimensions, seconds, tell, what};
use super::evaluate::{ensure_different, scale};
use super::methods::{MethodArg, check_fixed, methods};
use super::performance::OnRig;
use super::setup::SetupArgs;

/// Track the clips on rigs as they are built: a row for each of many, and the median.
///
/// Every rig has masses off by up to 15 %, each body its own; joint sensors of 12 bits; and drives that come
/// one step late. Control and plant run at 500 Hz, the clips have 100 frames a second and the controller goes
/// smoothly between them. Without `--plant`, the exact one. `--rig` is your own rig, built many times; its motions have
/// a frame for every step.
///
/// Means over all bodies and frames: degrees, centimetres, and the centimetres of the error weighted by importance.
/// `lost` is a figure that fell apart. The last method is compared with each other one: on how many rigs its angular
/// and its linear error are smaller.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    clips: ClipArgs,

    /// Factor on the figure's dimensions. The clips keep theirs.
    #[arg(long, value_name = "FACTOR", default_value = "1.1", value_parser = scale, allow_negative_numbers = true, conflicts_with = "rig")]
    scale: f64,

    /// Methods.
    #[arg(
        long,
        value_name = "METHOD,..",
        value_delimiter = ',',
        default_value = "local,world,linear_compensation,manifold_projection,recommended"
    )]
    methods: Vec<MethodArg>,

    /// How many rigs.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=1000), allow_negative_numbers = true)]
    seeds: u64,

    #[command(flatten)]
    pub(super) setup: SetupArgs,

    /// Use only the first S seconds of every clip, for a quick look.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,

    #[command(flatten)]
    threads: ThreadArgs,
}

/// Runs the subcommand. Lost figures are results: they do not make it fail.
pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    args.threads.install(|| run_in_pool(args))
}

fn run_in_pool(args: &Args) -> anyhow::Result<ExitCode> {
    let rig = args.clips.rig(&OnRig::default())?;
    let rig = rig.as_ref();
    let mut setup = args.setup.setup_on_exact(rig.map(|rig| &rig.mechanism))?;
    let disturbance = &setup.disturbance;
    ensure!(
        *disturbance
            == Disturbance {
                masses: 0.0,
                sensor_bits: 0,
                latency_steps: 0,
                seed: 0,
                ..*disturbance
            },
        "disturbance: expected masses, sensor_bits, latency_steps and seed to be left out, a rig has its own"
    );
    let scale = rig.map_or(args.scale, |_| 1.0);
    setup.dimensions = Dimensions { scale, ..setup.dimensions };
    let methods = methods(&args.methods);
    ensure_different(&methods, "--methods")?;
    check_fixed(&setup, &methods)?;
    for method in &methods {
        as_built(&setup, *method, 0).check()?;
    }
    let (motions, lines) = args.clips.at(500.0, 100.0).takes(rig)?;
    tell(&lines);
    let steps: usize = motions.iter().map(|motion| step_count(motion, args.seconds)).sum();
    let seeds: Vec<u64> = (1..=args.seeds).collect();
    let trials: Vec<Vec<Trial>> = with_progress(steps * methods.len() * seeds.len(), |progress| {
        let of_seed = |seed: &u64| {
            let of_method = |method: &MethodName| {
                let result = trial(&motions, &as_built(&setup, *method, *seed), args.seconds);
                progress(steps);
                result
            };
            methods.iter().map(of_method).collect()
        };
        seeds.iter().map(of_seed).collect()
    });
    for trial in trials.iter().flatten() {
        if let Err(error) = trial
            && !error.kind.is_loss()
        {
            bail!("{error}");
        }
    }
    let mut text = format!(
        "{}, {steps} steps of {:.0} Hz on each of {} rigs{}; plant: {}\n\
         masses off by up to 15 %, joint sensors of 12 bits, torques one step late\n\
         angular / linear / importance-weighted error, means over all bodies: deg / cm / cm\n\n",
        what(rig, motions.len()),
        motions.first().map_or(0.0, |motion| motion.dt_s().recip()),
        seeds.len(),
        dimensions(rig, args.scale),
        setup.plant.description(),
    );
    writeln!(text, "{}", table(&seeds, &methods, &trials))?;
    for line in wins(&methods, &trials) {
        writeln!(text, "{line}")?;
    }
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Mean angular, linear and importance-weighted error.
fn means(errors: &Errors) -> [f64; 3] {
    let all = &errors.all;
    [all.angular_mean_deg(), all.linear_mean_cm(), errors.weighted.mean_cm()]
}

fn shown([angular_deg, linear_cm, weighted_cm]: [f64; 3]) -> String {
    format!("{angular_deg:.3} / {linear_cm:.3} / {weighted_cm:.3}")
}

fn table(seeds: &[u64], methods: &[MethodName], trials: &[Vec<Trial>]) -> Table {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    let heading = ["rig".to_owned()].into_iter();
    table.set_header(heading.chain(methods.iter().map(ToString::to_string)));
    for (seed, trials) in seeds.iter().zip(trials) {
        let cells = trials.iter().map(|trial| match trial {
            Ok(errors) => shown(means(errors)),
            Err(_) => "lost".to_owned(),
        });
        table.add_row([seed.to_string()].into_iter().chain(cells));
    }
    // A rig that is lost is worse than any that is not.
    let of_method = |method: usize, error: usize| {
        let of = |trials: &Vec<Trial>| {
            trials[method].as_ref().map_or(f64::INFINITY, |errors| means(errors)[error])
        };
        median(trials.iter().map(of).collect()).unwrap_or(f64::NAN)
    };
    let medians =
        (0..methods.len()).map(|method| shown([0, 1, 2].map(|error| of_method(method, error))));
    table.add_row(["median".to_owned()].into_iter().chain(medians));
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// On how many rigs the last method is better than each other one.
fn wins(methods: &[MethodName], trials: &[Vec<Trial>]) -> Vec<String> {
    let Some((last, others)) = methods.split_last() else { return Vec::new() };
    let better = |trials: &[Trial], other: usize| match (&trials[others.len()], &trials[other]) {
        (Ok(ours), Ok(theirs)) => {
            let [ours, theirs] = [means(ours), means(theirs)];
            ours[0] < theirs[0] && ours[1] < theirs[1]
        }
        (Ok(_), Err(_)) => true,
        (Err(_), _) => false,
    };
    others
        .iter()
        .enumerate()
        .map(|(index, other)| {
            let count = trials.iter().filter(|trials| better(trials, index)).count();
            format!(
                "{last} is below {other} in mean angular and linear error on {count} of {} rigs",
                trials.len()
            )
        })
        .collect()
}
