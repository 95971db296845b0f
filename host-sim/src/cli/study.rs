//! `sinew study`: where the studies went. They have a command of their own, so that `sinew` needs no training
//! framework.

use std::ffi::OsString;

use anyhow::bail;

/// The studies are a command of their own: `cargo run --release -p sinew-studies`.
#[derive(Debug, clap::Args)]
#[command(disable_help_flag = true)]
pub(super) struct Args {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// Says what to run instead.
pub(super) fn run(args: &Args) -> anyhow::Result<std::process::ExitCode> {
    let given: Vec<_> = args.arguments.iter().map(|argument| argument.to_string_lossy()).collect();
    let given = if given.is_empty() { "--help".into() } else { given.join(" ") };
    bail!(
        "the studies are a command of their own: run `cargo run --release --manifest-path dev/studies/Cargo.toml -- {given}`"
    )
}
