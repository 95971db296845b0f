//! `sinew servo simulate`: simulated servos on a serial port of this machine.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, bail};
use sinew_host_util::command::{note, print};
use sinew_performance::rig::LoadedRig;
use sinew_servo_sim::fault::FaultOrder;
use sinew_servo_sim::fleet::{self, Memory, Setup, Wanted};
use sinew_servo_sim::kind::Kind;
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::port::{Port, serve};
use sinew_servo_sim::rig;
use sinew_servo_sim::supply::Supply;

use super::output::OutputPlace;
use super::rig::read;
use super::stop::flag;

/// Simulate servos on a serial port of this machine, for any program that talks to servos.
///
/// It creates LINK, prints `ready`, and serves in real time until it is ended (Ctrl-C, SIGTERM, SIGHUP); then it
/// removes LINK. Programs open LINK as a serial port, at the rate of --baud: the servos answer at no other rate.
/// Programs may close LINK and open it again. Except for that rate, the servos have factory settings. Torque is off at
/// the start.
///
/// With --rig the servos move the rig: the motion of one joint loads the servos of others, and gravity depends on the
/// pose. Hobby servos, which are driven by pulses, are left out, and their joints stay at home. If the rig has several
/// buses, each has its own link, LINK.BUS; the servos of all buses move one rig.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("which").required(true).args(["rig", "kind"]))]
pub(super) struct ServosArgs {
    /// Rig whose servos are simulated: a rig.toml, a URDF or an MJCF file.
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,

    /// Kind of the servos, by the beginning of its name: xl330, xl430, xm430, mx-28, mx-64, sts3215, ... For other
    /// kinds, such as scs0009 or xc330, only the registers are known: these servos reach a goal at once.
    #[arg(long, value_name = "KIND")]
    kind: Option<String>,

    /// Ids of the servos of --kind.
    #[arg(
        long,
        value_name = "ID,..",
        value_delimiter = ',',
        default_value = "1",
        conflicts_with = "rig"
    )]
    ids: Vec<u8>,

    /// Path of the link that programs open as a serial port. An existing link is replaced.
    #[arg(long, value_name = "LINK")]
    pty: OutputPlace,

    /// Rate that all servos are set to, in bit/s. The factory setting of a Dynamixel is 57600.
    #[arg(long, value_name = "RATE", default_value_t = 1_000_000)]
    baud: u32,

    /// Load that each servo moves. Default: `arm`; with --rig the rig.
    #[arg(long, value_enum, value_name = "LOAD")]
    load: Option<LoadArg>,

    /// Simulate registers only, without motor, gear and load: each servo reaches a goal at once.
    #[arg(long, conflicts_with = "load")]
    ideal: bool,

    /// Supply of all servos: voltage in V, resistance of supply and cable in ohm, and largest current in A, such as
    /// 5,0.2,3. Default: the supply in the rig's file; else one supply for each bus, with the voltage of its first
    /// servo and almost no resistance.
    #[arg(long, value_name = "V[,OHM[,A]]", conflicts_with = "ideal")]
    supply: Option<Supply>,

    /// A fault: `SERVO:WHAT[=HOW MUCH][@WHEN][+HOW LONG]`, such as 2:silent@3s or elbow:late=5ms@1s+500ms. SERVO is an
    /// id, or the name of a servo or joint of the rig. WHAT: silent, late=TIME, wrong-crc, short=BYTES, wrong-id=ID,
    /// stuck, hot=CELSIUS, brown-out, rebooted, torque-lost, encoder-jump=DEGREES, torque-stuck. WHEN counts from the
    /// start. May be repeated.
    #[arg(long, value_name = "FAULT")]
    fault: Vec<FaultOrder>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum LoadArg {
    /// A weight on an arm of 10 cm, which hangs down at the middle of the range. Held horizontally, it needs a tenth of
    /// the stall torque.
    Arm,
    /// Only a horn, without a load.
    None,
}

/// Simulates the servos until a signal ends it.
pub(super) fn run(args: &ServosArgs) -> anyhow::Result<ExitCode> {
    let rig = args.rig.as_deref().map(read).transpose()?;
    let wanted = args.wanted(rig.as_ref())?;
    let setup = Setup {
        baud: args.baud,
        faults: args.fault.clone(),
        rig: rig
            .as_ref()
            .filter(|_| args.load.is_none() && !args.ideal)
            .map(|rig| (&rig.description, &rig.mechanism)),
        supply: args.supply(rig.as_ref()),
    };
    let stop = flag()?;
    let mut memories: Vec<Memory> = vec![[0; size_of::<Memory>()]; wanted.len()];
    let mut lines = fleet::lines(&wanted, &setup, &mut memories)?;
    let ports = args.ports(&fleet::buses(&wanted))?;
    print("ready\n")?;
    serve(&ports, &mut lines, &stop)?;
    Ok(ExitCode::SUCCESS)
}

impl ServosArgs {
    /// Returns the supply of the servos: the option, else the supply in the rig's file; `None` if there is neither.
    fn supply(&self, rig: Option<&LoadedRig>) -> Option<Supply> {
        let of_rig = || {
            let supply = rig?.description.supply?;
            Some(Supply::limited(supply.voltage_v, supply.current_a))
        };
        self.supply.clone().or_else(of_rig)
    }

    fn wanted(&self, rig: Option<&LoadedRig>) -> anyhow::Result<Vec<Wanted>> {
        let mut wanted = match (rig, &self.kind) {
            (Some(rig), _) => of_rig(rig, self.rig.as_deref().unwrap_or(Path::new("")))?,
            (None, Some(kind)) => self.of_kind(kind)?,
            (None, None) => bail!("expected --rig RIG or --kind KIND"),
        };
        for servo in &mut wanted {
            if self.ideal {
                servo.kind =
                    servo.kind.registers().map_or_else(|| servo.kind.clone(), Kind::Registers);
            }
            match (self.load, &servo.kind) {
                (Some(LoadArg::Arm), Kind::Servo(kind)) => servo.load = Arm::small(kind),
                (Some(LoadArg::None), _) => servo.load = Arm::default(),
                _ => {}
            }
        }
        Ok(wanted)
    }

    fn of_kind(&self, name: &str) -> anyhow::Result<Vec<Wanted>> {
        let kind = Kind::named(name).context("--kind")?;
        note(format_args!(
            "{}{}",
            kind.name(),
            match &kind {
                Kind::Servo(_) => "",
                Kind::Registers(_) => ": registers only, its motor has not been measured",
            }
        ));
        let load = match &kind {
            Kind::Servo(kind) => Arm::small(kind),
            Kind::Registers(_) => Arm::default(),
        };
        let servo = |id: &u8| Wanted {
            bus: String::new(),
            id: *id,
            name: String::new(),
            kind: kind.clone(),
            load,
            home_rad: None,
        };
        Ok(self.ids.iter().map(servo).collect())
    }

    fn ports(&self, buses: &[&str]) -> anyhow::Result<Vec<Port>> {
        let mut ports = Vec::new();
        for bus in buses {
            let mut link = self.pty.as_os_str().to_owned();
            if buses.len() > 1 {
                link.push(format!(".{bus}"));
                note(format_args!("bus {bus:?}: {}", Path::new(&link).display()));
            }
            ports.push(Port::open(Path::new(&link), self.baud).context("--pty")?);
        }
        Ok(ports)
    }
}

fn of_rig(loaded: &LoadedRig, path: &Path) -> anyhow::Result<Vec<Wanted>> {
    let servos = rig::servos(&loaded.description, &loaded.mechanism)
        .with_context(|| path.display().to_string())?;
    let mut wanted = Vec::new();
    for servo in servos {
        let Some(id) = servo.id() else {
            note(format_args!("servo {:?} is driven by pulses: it is left out", servo.name));
            continue;
        };
        wanted.push(Wanted {
            bus: servo.bus,
            id,
            name: servo.name,
            load: servo.load,
            home_rad: Some(servo.home_rad),
            kind: Kind::Servo(Box::new(servo.kind)),
        });
    }
    if wanted.is_empty() {
        bail!("{}: expected a servo with an `id`, found none", path.display());
    }
    Ok(wanted)
}
