//! `sinew evaluate robustness`: the methods on rigs that differ from their models.

use std::process::ExitCode;

use anyhow::ensure;
use sinew_evaluation::report::robustness_tables;
use sinew_evaluation::robustness::RobustnessProtocol;
use sinew_evaluation::{Disturbance, EvaluatedMotion as _};
use sinew_figure::Dimensions;
use sinew_host_util::command::{ThreadArgs, print, with_progress};
use sinew_performance::rig::LoadedRig;

use super::clips::{ClipArgs, dimensions, seconds, tell, what};
use super::evaluate::{ensure_different, scale};
use super::methods::{MethodArg, check_fixed, methods};
use super::performance::PerformanceArgs;
use super::setup::SetupArgs;

/// Track the clips on many rigs that have errors of construction, and print a row for each rig, and the median.
///
/// Every rig has masses that are wrong by up to 15 %, each body differently; joint sensors of 12 bits; and drives that
/// act one step late. Control and plant run at 500 Hz; the clips have 100 frames per second, and the controller
/// interpolates smoothly. Default plant: the exact one. With `--rig`, the rigs are your own rig with different errors,
/// and its motions have a frame for every step.
///
/// The table has means over all bodies and frames: degrees, centimetres, and the centimetres of the error weighted by
/// importance. `lost`: the figure flew apart. The last method is compared with each other method: on how many rigs its
/// angular and its linear error are smaller.
///
/// `--projection-weights` adds rows for `recommended` with other weights of angle against distance than the default
/// weight.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    clips: ClipArgs,

    /// Factor on the figure's dimensions. The clips are not scaled.
    #[arg(long, value_name = "FACTOR", default_value = "1.1", value_parser = scale, allow_negative_numbers = true, conflicts_with = "rig")]
    scale: f64,

    /// Methods to compare.
    #[arg(
        long,
        value_name = "METHOD,..",
        value_delimiter = ',',
        default_value = "local,world,linear_compensation,manifold_projection,recommended"
    )]
    methods: Vec<MethodArg>,

    /// Number of rigs with random errors.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=1000), allow_negative_numbers = true)]
    rigs: u64,

    /// Also track with `recommended` and each of these projection weights: 1 rad costs as much as this many metres
    /// (100: nearly World with the observer). A second table has medians, and the number of rigs on which the errors of
    /// angle and distance are smaller than with every method without projection.
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

/// Runs the subcommand. A lost figure is a result, not an error.
pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    args.clips.in_pool(&args.threads, &PerformanceArgs::default(), |rig| run_on(args, rig))
}

fn run_on(args: &Args, rig: Option<&LoadedRig>) -> anyhow::Result<ExitCode> {
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
    let protocol = RobustnessProtocol {
        setup,
        methods,
        projection_weights: args.projection_weights.clone(),
        rigs: args.rigs,
        seconds: args.seconds,
    };
    protocol.check()?;
    let (motions, lines) = args.clips.at(500.0, 100.0).takes(rig)?;
    tell(&lines);
    let result = with_progress(protocol.count_all_steps(&motions), |progress| {
        protocol.run(&motions, progress)
    })?;
    print(&format!(
        "{}, {} steps of {:.0} Hz on each of {} rigs{}; plant: {}\n\
         masses off by up to 15 %, joint sensors of 12 bits, torques one step late\n\
         angular / linear / importance-weighted error, means over all bodies: deg / cm / cm\n\n{}",
        what(rig, motions.len()),
        protocol.count_trial_steps(&motions),
        motions.first().map_or(0.0, |motion| motion.dt_s().recip()),
        args.rigs,
        dimensions(rig, args.scale),
        protocol.setup.plant.description(),
        robustness_tables(&result),
    ))?;
    Ok(ExitCode::SUCCESS)
}
