//! Developer commands of Sinew: `cargo xtask COMMAND`.

mod clients;
mod deny;
mod docs;
mod emulate;
mod firmware;
mod limits;
mod measure;
mod nextest;
mod node;
mod package;
mod parity;
mod peers;
mod python;
mod retargeting;
mod semver;
mod setup;
mod studies;
mod test;

use std::env;
use std::process::ExitCode;

use anyhow::Result;

use test::Scope;

const HELP: &str = "\
Developer commands of Sinew

Usage: cargo xtask <COMMAND>

Commands:
  setup     Installs what is missing: the Arm target, QEMU, Chromium, Python's venv, rustfmt and clippy
  test      Sets up, then runs the gate: the checks and tests that every change must pass. With --all: all checks and
            tests, before an issue is called resolved; of what QEMU can run, a part: `parity` and `node` run more
  soak      Runs what takes an hour: each property on 4,096 new random cases, `limits`, `parity`, `node`, `emulate`, and
            with SINEW_DATA and SINEW_REFERENCE `retargeting`
  firmware  Builds the image of every board, runs those that QEMU has, and compares their torques with the host's;
            with a board's name, only that board's
  budget    Builds all images, measures instructions, stack, flash and RAM, compares them with the promises of
            budget.toml, and prints what has changed; with --accept, writes the measurement there
  parity    Runs the built-in evaluation on every machine there is, emulated ones too, and names the first number that
            has other bits
  node      Runs a whole node in QEMU, from a blank board to a performance and an emergency stop, and compares all bytes
            of its bus and its line, and all that it commands, with the same in process; then it performs
            shows, compared with the same in process: on an arm, and with SINEW_DATA on two robots
  emulate   Builds the emulator of the NUCLEO-F446RE, which needs a newer Rust by rustup, and tries its peripherals with
            an image, the NUCLEO's own one, and `sinew play --target nucleo`; says `ignored` where there is none
  limits    Compares the core with its formulas in f64 on 10,000 random rigs, each number by the limit that follows from
            its rounding, and prints the smallest mistakes that are noticed: 10 minutes on two cores
  clients   Lets programs from PyPI talk to simulated servos, 1,000 random exchanges each, and our side to servos of
            feetech-cli; compares control tables with those of dynamixel-sdk
  retargeting
            Puts clips on robots, scores them beside GMR's, and compares with docs/retargeting.csv; with --accept,
            writes it
  peers     Times four kernels of the core beside those of Pinocchio and MuJoCo, which it takes from PyPI and compiles
            against, and inverse dynamics beside other crates; all must find the same first
  deny      Checks licences, sources and versions of other people's crates, and known faults where their database can be
            reached, with cargo-deny by deny.toml
  semver REV
            Names what breaks users of the core's interface since revision REV, with cargo-semver-checks
  audit     Links all that boards may call without a panic handler, and looks in it for panics, f64, fused
            multiply-add, formatting, allocation, recursion and indirect calls; --self-test: whether it finds them
  docs      Checks links and commands of the documentation, and builds the book from docs/
  help      Prints this

Environment:
  SINEW_ARM   The compiler for boards: `rustup` or `debian`. Default: rustup's, if it has the target
  SINEW_DATA  A folder of mocap, for tests on it. Default: these tests are left out
  SINEW_REFERENCE
              A folder with the script, robots and results that `retargeting` needs
";

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let Some(action) = action(&words) else {
        eprint!("error: unknown command `{}`\n\n{HELP}", words.join(" "));
        return ExitCode::from(2);
    };
    match action() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// What a command line asks for, if it is one.
fn action(words: &[&str]) -> Option<Box<dyn FnOnce() -> Result<()>>> {
    Some(match words {
        [] | ["help" | "--help" | "-h"] => Box::new(|| {
            print!("{HELP}");
            Ok(())
        }),
        ["setup"] => Box::new(setup::run),
        ["budget"] => Box::new(|| firmware::all().and_then(|()| measure::run(&["budget"]))),
        ["budget", "--accept"] => {
            Box::new(|| firmware::all().and_then(|()| measure::run(&["budget", "--accept"])))
        }
        ["test"] => Box::new(|| test::run(Scope::Gate)),
        ["test", "--all"] => Box::new(|| test::run(Scope::All)),
        ["soak"] => Box::new(test::soak),
        ["parity"] => Box::new(parity::run),
        ["node"] => Box::new(node::run),
        ["emulate"] => Box::new(emulate::run),
        ["limits"] => Box::new(limits::run),
        ["clients"] => Box::new(clients::run),
        ["retargeting"] => Box::new(|| retargeting::run(false)),
        ["retargeting", "--accept"] => Box::new(|| retargeting::run(true)),
        ["peers"] => Box::new(peers::run),
        ["deny"] => Box::new(deny::run),
        ["semver", revision] => {
            let revision = (*revision).to_owned();
            Box::new(move || semver::run(&revision))
        }
        ["audit"] => Box::new(|| measure::run(&["audit"])),
        ["audit", "--self-test"] => Box::new(|| measure::run(&["audit", "--self-test"])),
        ["docs"] => Box::new(docs::run),
        ["firmware", name @ ..] if name.len() <= 1 => {
            let name = name.first().map(|name| (*name).to_owned());
            Box::new(move || firmware::run(name.as_deref()))
        }
        _ => return None,
    })
}
