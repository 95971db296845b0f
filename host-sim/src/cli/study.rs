//! `sinew study`: what articles claim, tried again.

mod autoencoder;
mod classify;
mod cluster;
mod data;
mod distances;
mod geodesic_ratio;
mod mds;
mod results;
mod two_classes;

use clap::Subcommand;

/// Repeat the experiments of articles on other data.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    study: Study,
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

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    match &args.study {
        Study::Autoencoder(args) => autoencoder::run(args),
        Study::Classify(args) => classify::run(args),
        Study::Cluster(args) => cluster::run(args),
        Study::Distances(args) => distances::run(args),
        Study::GeodesicRatio(args) => geodesic_ratio::run(args),
        Study::Mds(args) => mds::run(args),
    }
}
