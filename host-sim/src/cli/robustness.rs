//! `sinew evaluate robustness`: the methods on rigs as they are built.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::{bail, ensure};
use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use sinew_evaluation::pareto::on_front;
use sinew_evaluation::robustness::{Trial, as_built, median, trial};
use sinew_evaluation::{Disturbance, Errors, EvaluatedMotion as _, MethodName, Setup, count_steps};
use sinew_figure::Dimensions;
use sinew_host_util::command::{ThreadArgs, print, with_progress};

use super::clips::{ClipArgs, dimensions, seconds, tell, what};
use super::evaluate::{ensure_different, scale};
use super::methods::{MethodArg, check_fixed, methods};
use super::performance::PerformanceArgs;
use super::setup::SetupArgs;

/// Track the clips on many rigs as built, and print a row for each rig, and the median.
///
/// Every rig has masses off by up to 15 %, each body its own; joint sensors of 12 bits; and drives that come one step
/// late. Control and plant run at 500 Hz; the clips have 100 frames per second, and the controller interpolates
/// smoothly. Default plant: the exact one. `--rig` is your own rig, built many times; its motions have a frame for
/// every step.
///
/// Means over all bodies and frames: degrees, centimetres, and the centimetres of the error weighted by importance.
/// `lost` is a figure that fell apart. The last method is compared with each other one: on how many rigs its angular
/// and its linear error are smaller.
///
/// `--projection-weights` gives angle against distance: `recommended` with other weights than its own, beside the
/// methods.
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

    /// Number of rigs.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=1000), allow_negative_numbers = true)]
    rigs: u64,

    /// Also track with `recommended` and each of these projection weights: 1 rad costs as much as this many metres
    /// (100: nearly World with the observer). A second table has medians, and on how many rigs angle and distance are
    /// below all methods without projection.
    #[arg(long, value_name = "M,..", value_delimiter = ',', allow_negative_numbers = true)]
    projection_weights: Vec<f32>,

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
    let rig = args.clips.rig(&PerformanceArgs::default())?;
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
    ensure_different(&args.projection_weights, "--projection-weights")?;
    check_fixed(&setup, &methods)?;
    let variants = variants(&setup, &methods, &args.projection_weights);
    for Variant { setup, .. } in &variants {
        setup.check()?;
    }
    let (motions, lines) = args.clips.at(500.0, 100.0).takes(rig)?;
    tell(&lines);
    let steps: usize = motions.iter().map(|motion| count_steps(motion, args.seconds)).sum();
    let seeds: Vec<u64> = (1..=args.rigs).collect();
    let trials: Vec<Vec<Trial>> = with_progress(steps * variants.len() * seeds.len(), |progress| {
        let of_seed = |seed: &u64| {
            let of_variant = |variant: &Variant| {
                let result = trial(&motions, &variant.of_rig(*seed), args.seconds);
                progress(steps);
                result
            };
            variants.iter().map(of_variant).collect()
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
    if !args.projection_weights.is_empty() {
        writeln!(
            text,
            "\nmedians over the rigs, and on how many of them an error is below those of all methods without projection\n"
        )?;
        writeln!(text, "{}", front(&variants, &trials))?;
    }
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// A method, or the recommended one with a weight of its own.
struct Variant {
    name: String,
    /// Of the first rig.
    setup: Setup,
}

impl Variant {
    fn of_rig(&self, seed: u64) -> Setup {
        let mut setup = self.setup.clone();
        setup.disturbance.seed = seed;
        setup
    }

    /// Whether its targets are poses of the rig itself, found for angle and distance together.
    fn projects(&self) -> bool {
        use MethodName::{ManifoldProjection, Recommended};
        matches!(self.setup.controller.method, ManifoldProjection | Recommended)
    }
}

fn variants(setup: &Setup, methods: &[MethodName], weights: &[f32]) -> Vec<Variant> {
    let of_method = |method: &MethodName| Variant {
        name: method.to_string(),
        setup: as_built(setup, *method, 1),
    };
    let of_weight = |rotation_m: &f32| {
        let mut setup = as_built(setup, MethodName::Recommended, 1);
        setup.controller.projection.rotation_m = *rotation_m;
        Variant { name: format!("recommended, {rotation_m} m"), setup }
    };
    methods.iter().map(of_method).chain(weights.iter().map(of_weight)).collect()
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
        let cells = trials.iter().take(methods.len()).map(|trial| match trial {
            Ok(errors) => shown(means(errors)),
            Err(_) => "lost".to_owned(),
        });
        table.add_row([seed.to_string()].into_iter().chain(cells));
    }
    let medians = (0..methods.len())
        .map(|method| shown([0, 1, 2].map(|error| middle(trials, method, error))));
    table.add_row(["median".to_owned()].into_iter().chain(medians));
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// An error of a trial. A rig that is lost is worse than any that is not.
fn error(trial: &Trial, error: usize) -> f64 {
    trial.as_ref().map_or(f64::INFINITY, |errors| means(errors)[error])
}

/// The median over the rigs of an error of a variant.
fn middle(trials: &[Vec<Trial>], variant: usize, of: usize) -> f64 {
    median(trials.iter().map(|trials| error(&trials[variant], of)).collect()).unwrap_or(f64::NAN)
}

/// Angle against distance.
fn front(variants: &[Variant], trials: &[Vec<Trial>]) -> Table {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(["", "deg", "cm", "Pareto-optimal", "angle below", "distance below", "both"]);
    let others: Vec<usize> =
        (0..variants.len()).filter(|variant| !variants[*variant].projects()).collect();
    let is_below = |trials: &Vec<Trial>, variant: usize, of: usize| {
        others.iter().all(|other| error(&trials[variant], of) < error(&trials[*other], of))
    };
    let medians: Vec<[f64; 2]> = (0..variants.len())
        .map(|variant| [0, 1].map(|error| middle(trials, variant, error)))
        .collect();
    for (index, (variant, on_front)) in variants.iter().zip(on_front(&medians)).enumerate() {
        let count = |errors: &[usize]| {
            if !variant.projects() || others.is_empty() {
                return String::new();
            }
            let all = |trials: &&Vec<Trial>| errors.iter().all(|of| is_below(trials, index, *of));
            format!("{} of {}", trials.iter().filter(all).count(), trials.len())
        };
        let [angular_deg, linear_cm] = medians[index];
        table.add_row([
            variant.name.clone(),
            format!("{angular_deg:.3}"),
            format!("{linear_cm:.3}"),
            if on_front { "yes" } else { "" }.to_owned(),
            count(&[0]),
            count(&[1]),
            count(&[0, 1]),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
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
