//! Tests foreign programs with our simulated servos, and our side of a rig with foreign simulated servos. Each test
//! is described in `crates/servo-bus/tests/clients/README.md`.

use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use anyhow::{Context as _, Result, bail};

use crate::nextest;
use crate::python::Venv;
use sinew_steps::step;

/// Packages that pip installs together, in tested versions.
const PACKAGES: [&str; 7] = [
    "pyserial==3.5",
    "numpy>=2,<3",
    "deepdiff==9.1.0",
    "tqdm==4.70.1",
    "dynamixel-sdk==4.1.0",
    "rustypot==1.13.1",
    "feetech-cli==0.1.8",
];
/// These packages have a module of the same name, so PYTHONPATH selects one of them.
const FEETECH_SDKS: [&str; 3] =
    ["feetech-servo-sdk==1.0.0", "ftservo-python-sdk==2.0.1", "vassar-feetech-servo-sdk==1.5.0"];
/// The package of `LeRobot`. Only its motor buses are used, without torch, so it is installed without dependencies.
const LEROBOT: &str = "lerobot==0.4.4";
/// Number of random exchanges of each program.
const EXCHANGES: &str = "1000";

pub(crate) fn run() -> Result<()> {
    let clients = Clients::install()?;
    nextest::build()?;
    let start = Instant::now();
    clients.compare_tables()?;
    clients.talk_to_dynamixels()?;
    clients.talk_to_feetechs()?;
    clients.be_talked_to()?;
    eprintln!("\n== real clients: done in {:.0} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// Paths of the environment, the scripts and our programs.
struct Clients {
    venv: Venv,
    scripts: PathBuf,
    programs: PathBuf,
}

impl Clients {
    /// Installs what is missing. The list of installed packages shows whether the environment is up to date.
    fn install() -> Result<Self> {
        let own = std::env::current_exe()?;
        let list = [&PACKAGES[..], &FEETECH_SDKS, &[LEROBOT]].concat().join("\n");
        let venv = Venv::install("clients", &PACKAGES, &list, |venv| {
            for sdk in FEETECH_SDKS {
                venv.pip(&["install", "--no-deps", "--target", &package(venv, sdk), sdk])?;
            }
            let lerobot = package(venv, LEROBOT);
            let apart = ["install", "--no-deps", "--ignore-requires-python", "--target", &lerobot];
            venv.pip(&[&apart[..], &[LEROBOT]].concat())
        })?;
        Ok(Self {
            venv,
            scripts: step::root().join("crates/servo-bus/tests/clients"),
            // Cargo puts the other programs beside this one.
            programs: own.parent().context("xtask lies in a folder")?.to_owned(),
        })
    }

    fn python(&self, script: &str) -> Command {
        self.venv.python(&self.scripts.join(script))
    }

    /// Compares our control tables with those in dynamixel-sdk.
    fn compare_tables(&self) -> Result<()> {
        let ours = step::output(&mut Command::new(self.programs.join("examples/tables")));
        let tables = self.venv.folder.join("tables.tsv");
        std::fs::write(&tables, ours.context("the example `tables` of sinew-servo-bus fails")?)?;
        step::run("control tables", self.python("tables.py").stdin(File::open(tables)?))
    }

    fn talk_to_dynamixels(&self) -> Result<()> {
        let servos = ["xl330", "--ids", "1,2,3,11,12,13"];
        self.talk("dynamixel-sdk", &servos, "dynamixel.py", &[], None)?;
        self.talk("rustypot, Dynamixel", &servos, "rustypot_bus.py", &["dxl"], None)?;
        let lerobot = package(&self.venv, LEROBOT);
        self.talk("lerobot, Dynamixel", &servos, "lerobot_bus.py", &["dxl", &lerobot], None)?;
        let hot = ["xl330", "--ids", "11,12", "--fault", "12:hot=90"];
        self.talk("dynamixel-sdk, errors", &hot, "dynamixel_errors.py", &[], None)
    }

    fn talk_to_feetechs(&self) -> Result<()> {
        for (family, kind) in [("sts", "sts3215"), ("scs", "scs0009")] {
            for sdk in FEETECH_SDKS {
                let title = format!("{sdk}, {family}");
                self.talk(&title, &[kind, "--ids", "1,2,3"], "feetech.py", &[family], Some(sdk))?;
            }
        }
        let hot = ["sts3215", "--ids", "1,2", "--fault", "2:hot=90"];
        for sdk in FEETECH_SDKS {
            self.talk(&format!("{sdk}, errors"), &hot, "feetech_errors.py", &[], Some(sdk))?;
        }
        let servos = ["sts3215", "--ids", "1,2,3"];
        self.talk("rustypot, STS", &servos, "rustypot_bus.py", &["sts"], None)?;
        let (lerobot, sdk) = (package(&self.venv, LEROBOT), Some(FEETECH_SDKS[0]));
        self.talk("lerobot, STS", &servos, "lerobot_bus.py", &["sts", &lerobot], sdk)?;
        self.calibrate(&lerobot)?;
        self.talk("feetech-cli", &servos, "feetech_cli_bus.py", &[], None)
    }

    /// Calibrates a simulated SO-101 with `LeRobot`, and converts the calibration file to a rig file and back.
    fn calibrate(&self, lerobot: &str) -> Result<()> {
        let link = self.venv.folder.join("port").display().to_string();
        let sinew = self.programs.join("sinew");
        let mut server = Command::new(&sinew);
        server.args(["servo", "simulate", "--pty", &link]);
        server.args(["--kind", "sts3215", "--ids", "1,2,3,4,5,6", "--load", "none"]);
        let _server = Server::start("sinew servo simulate", server, &link)?;
        let mut client = self.python("lerobot_calibration.py");
        client.arg(&link).arg(&sinew).arg(lerobot);
        client.env("PYTHONPATH", package(&self.venv, FEETECH_SDKS[0]));
        step::run("lerobot, calibration", &mut client)
    }

    /// Runs a program with new simulated servos of a kind, and more options of `sinew servo simulate`. New servos are
    /// needed because a program's registers would move them in the next test.
    fn talk(
        &self,
        title: &str,
        servos: &[&str],
        script: &str,
        arguments: &[&str],
        sdk: Option<&str>,
    ) -> Result<()> {
        let link = self.venv.folder.join("port").display().to_string();
        let mut server = Command::new(self.programs.join("sinew"));
        server.args(["servo", "simulate", "--pty", &link, "--kind"]).args(servos);
        let _server = Server::start("sinew servo simulate", server, &link)?;
        let mut client = self.python(script);
        client.args([&link, EXCHANGES]).args(arguments);
        client.envs(sdk.map(|sdk| ("PYTHONPATH", package(&self.venv, sdk))));
        step::run(title, &mut client)
    }

    /// Tests our side of a rig with feetech-cli's own simulated servos.
    fn be_talked_to(&self) -> Result<()> {
        let link = self.venv.folder.join("device").display().to_string();
        let mut device = self.python("device.py");
        device.args([&link, "1,2,3"]);
        let _device = Server::start("feetech-cli's servos", device, &link)?;
        let mut master = Command::new(self.programs.join("examples/master"));
        step::run("our side, feetech-cli's servos", master.args(["sts", &link, "1,2,3", EXCHANGES]))
    }
}

/// Returns the separate folder of a package.
fn package(venv: &Venv, package: &str) -> String {
    let name = package.split("==").next().unwrap_or(package);
    venv.folder.join("packages").join(name).display().to_string()
}

/// A program that serves a port until this value is dropped.
struct Server {
    child: Child,
    link: PathBuf,
}

impl Server {
    /// Starts the program, and waits until it reports that it is ready.
    fn start(what: &str, mut command: Command, link: &str) -> Result<Self> {
        let mut child = command.stdout(Stdio::piped()).spawn().with_context(|| what.to_owned())?;
        let output = child.stdout.take().context("its output is piped")?;
        let server = Self { child, link: link.into() };
        let mut line = String::new();
        BufReader::new(output).read_line(&mut line)?;
        if line.trim_end() != "ready" {
            bail!("{what}: expected `ready`, found `{}`", line.trim_end());
        }
        Ok(server)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        // A killed program does not remove its link.
        let _ = std::fs::remove_file(&self.link);
    }
}
