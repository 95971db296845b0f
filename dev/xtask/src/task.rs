//! The command line: its help, and its tasks.

pub(crate) const HELP: &str = "\
Developer commands of Sinew

Usage: cargo xtask <COMMAND>

Commands:
  setup     Installs what is missing: the Arm target, QEMU, Chromium, Python's venv, rustfmt and clippy
  test      Sets up, then runs the gate: the checks and tests that every change must pass. With --all: all checks and
            tests, before an issue is called resolved, but only a part of the runs in QEMU: `parity` and `node` run more
  soak      Runs the checks that take an hour: each property on 4,096 new random cases, a console with many
            servos for an hour, idle life with shows between for an hour of simulated time, `limits`, `parity`, `node`,
            `emulate`, with a browser the sound of a show of 10 minutes, and with SINEW_DATA and SINEW_REFERENCE
            `retargeting`
  firmware  Builds the image of every board, runs those that QEMU can emulate, and compares their torques with the
            host's; with a board's name, builds only that board's image
  budget    Builds all images, measures instructions, stack, flash and RAM, compares them with the promises of
            budget.toml, and prints what has changed; with --accept, writes the measurement there
  parity    Runs the built-in evaluation on every available machine, emulated ones too, and names the first number with
            different bits
  node      Runs a whole node in QEMU, from a blank board to a performance and an emergency stop, and compares all bytes
            of its bus and its host link, and all its commands, with those of a node in the test's own process; then
            plays shows, compared in the same way: on an arm, and with SINEW_DATA on two robots
  emulate   Builds the emulator of the NUCLEO-F446RE, which needs a newer Rust by rustup, and tries its peripherals with
            an image, the NUCLEO's own one, and `sinew play --target nucleo`; reports `ignored` without that Rust
  limits    Compares the core with its formulas in f64 on 10,000 random rigs, each number within the limit that follows
            from its rounding, and prints the smallest errors that are detected: 10 minutes on two cores
  clients   Tests simulated servos with programs from PyPI, 1,000 random exchanges each, and our programs with the
            servos of feetech-cli; compares control tables with those of dynamixel-sdk
  retargeting
            Retargets clips to robots, scores the motions beside GMR's, and compares the scores with
            docs/retargeting.csv; with --accept, writes that file
  peers     Checks that four kernels of the core agree with those of Pinocchio and MuJoCo (from PyPI), and inverse
            dynamics with other crates; then compares their times
  python    Builds the wheel `sinew-motion`, and tests it in fresh environments of every Python from 3.10 to 3.13 that is
            installed: tests, examples, types, the notebook, and torques beside Pinocchio's (from PyPI); then records
            ten episodes with LeRobot (from PyPI, 4 GB). With --bench: instead of the tests, measures inverse dynamics
            beside pin, a loop of Pinocchio in C++, mujoco and dynibo
  deny      Checks lock files, licences, sources and versions of dependencies, and known vulnerabilities if their
            database can be reached, with cargo-deny and deny.toml
  semver REV
            Lists the changes of the core's interface since revision REV that break its users, with
            cargo-semver-checks
  audit     Links everything that boards may call without a panic handler, and searches it for panics, f64, fused
            multiply-add, formatting, allocation, recursion and indirect calls; --self-test checks the search itself
  docs      Checks links and commands of the documentation, and builds the book from docs/
  help      Prints this help

Environment:
  SINEW_ARM   The compiler for boards: `rustup` or `debian`. Default: rustup's, if it has the target
  SINEW_DATA  A folder of mocap, for tests on it. Default: these tests are skipped
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
    Python {
        bench: bool,
    },
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
            ["python"] => Self::Python { bench: false },
            ["python", "--bench"] => Self::Python { bench: true },
            ["deny"] => Self::Deny,
            ["semver", revision] => Self::Semver { revision },
            ["audit"] => Self::Audit { self_test: false },
            ["audit", "--self-test"] => Self::Audit { self_test: true },
            ["docs"] => Self::Docs,
            _ => return None,
        })
    }
}
