//! The command line: its help, and its tasks.

pub(crate) const HELP: &str = "\
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

/// A task for a developer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Task<'a> {
    Help,
    Setup,
    /// The gate, or all checks.
    Test {
        all: bool,
    },
    Soak,
    /// All boards, or the board with a name.
    Firmware {
        board: Option<&'a str>,
    },
    Budget {
        accept: bool,
    },
    Parity,
    Node,
    Emulate,
    Limits,
    Clients,
    Retargeting {
        accept: bool,
    },
    Peers,
    Deny,
    Semver {
        revision: &'a str,
    },
    Audit {
        self_test: bool,
    },
    Docs,
}

impl<'a> Task<'a> {
    /// Returns the task of a command line; `None` if it is not one.
    pub(crate) fn parse(words: &[&'a str]) -> Option<Self> {
        Some(match *words {
            [] | ["help" | "--help" | "-h"] => Self::Help,
            ["setup"] => Self::Setup,
            ["test"] => Self::Test { all: false },
            ["test", "--all"] => Self::Test { all: true },
            ["soak"] => Self::Soak,
            ["firmware"] => Self::Firmware { board: None },
            ["firmware", board] => Self::Firmware { board: Some(board) },
            ["budget"] => Self::Budget { accept: false },
            ["budget", "--accept"] => Self::Budget { accept: true },
            ["parity"] => Self::Parity,
            ["node"] => Self::Node,
            ["emulate"] => Self::Emulate,
            ["limits"] => Self::Limits,
            ["clients"] => Self::Clients,
            ["retargeting"] => Self::Retargeting { accept: false },
            ["retargeting", "--accept"] => Self::Retargeting { accept: true },
            ["peers"] => Self::Peers,
            ["deny"] => Self::Deny,
            ["semver", revision] => Self::Semver { revision },
            ["audit"] => Self::Audit { self_test: false },
            ["audit", "--self-test"] => Self::Audit { self_test: true },
            ["docs"] => Self::Docs,
            _ => return None,
        })
    }
}
