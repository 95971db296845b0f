//! Developer commands of Sinew: `cargo xtask COMMAND`.

mod arm;
mod audit;
mod budget;
mod elf;
mod features;
mod firmware;
mod package;
mod parity;
mod semver;
mod setup;
mod step;
mod test;

use std::env;
use std::path::Path;
use std::process::ExitCode;

const HELP: &str = "\
Developer commands of Sinew

Usage: cargo xtask <COMMAND>

Commands:
  setup     Installs what is missing: the Arm target, QEMU, Chromium, rustfmt and clippy
  test      Sets up, then runs all checks and tests; with SINEW_DATA set, those on real mocap too
  firmware  Builds the boards' images, runs one in QEMU, and compares its torques with the host's. With SINEW_SHOW set,
            that show is performed
  budget    Does the same and measures instructions, stack, flash and RAM, and compares them with budget.toml; with
            --accept, puts them there
  parity    Runs the built-in evaluation on every machine there is, emulated ones too, and names the first number that
            has other bits
  semver REV
            Names what breaks users of the core's interface since revision REV, with cargo-semver-checks
  audit     Links all that boards may call without a panic handler, and looks in it for panics, f64, fused
            multiply-add, formatting, allocation, recursion and indirect calls; --self-test: whether it finds them
  help      Prints this
";

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let command: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match command.as_slice() {
        [] | ["help" | "--help" | "-h"] => {
            print!("{HELP}");
            Ok(())
        }
        ["setup"] => setup::run(),
        ["budget"] => budget::run(false),
        ["budget", "--accept"] => budget::run(true),
        ["test"] => test::run(),
        ["parity"] => parity::run(),
        ["semver", revision] => semver::run(revision),
        ["audit"] => audit::run(),
        ["audit", "--self-test"] => audit::self_test(),
        ["firmware"] => firmware::show(env::var_os("SINEW_SHOW").as_deref().map(Path::new)),
        other => {
            eprint!("error: unknown command `{}`\n\n{HELP}", other.join(" "));
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
