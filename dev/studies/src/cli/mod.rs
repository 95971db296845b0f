//! The command line: one file per study.

mod autoencoder;
mod classify;
mod cluster;
mod data;
mod distances;
mod geodesic_ratio;
mod mds;
mod results;
mod two_classes;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use sinew_host_util::command::exit_code;

/// Repeat studies of articles with other data.
#[derive(Debug, Parser)]
#[command(name = "sinew-studies", version)]
struct Cli {
    #[command(subcommand)]
    study: Study,
    /// Only read the command line. `cargo xtask docs` uses this to check the commands in the documentation.
    #[arg(long, global = true, hide = true)]
    parse_only: bool,
}

#[derive(Debug, Subcommand)]
enum Study {
    Autoencoder(autoencoder::Args),
    Classify(classify::Args),
    Cluster(cluster::Args),
    Distances(distances::Args),
    GeodesicRatio(geodesic_ratio::Args),
    Mds(mds::Args),
}

/// Parses the command line and runs it.
pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    if cli.parse_only {
        return ExitCode::SUCCESS;
    }
    let result = match &cli.study {
        Study::Autoencoder(args) => autoencoder::run(args),
        Study::Classify(args) => classify::run(args),
        Study::Cluster(args) => cluster::run(args),
        Study::Distances(args) => distances::run(args),
        Study::GeodesicRatio(args) => geodesic_ratio::run(args),
        Study::Mds(args) => mds::run(args),
    };
    exit_code(result.map(|()| ExitCode::SUCCESS))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }
}
