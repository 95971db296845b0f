//! `sinew study`: what articles claim, tried again.

mod autoencoder;
mod data;

use clap::Subcommand;

/// Try again what an article claims, on other data.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    study: Study,
}

#[derive(Debug, Subcommand)]
enum Study {
    Autoencoder(autoencoder::Args),
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    match &args.study {
        Study::Autoencoder(args) => autoencoder::run(args),
    }
}
